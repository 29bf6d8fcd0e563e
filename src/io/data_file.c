#include "io/data_file.h"
#include "core/memory.h"
#include "grid/field_copy.h"
#include <stdlib.h>

static void free_plan(void *plan)
{
    vvi_data_source *source = plan;
    if (source->drop)
        source->drop(source->user);
    free(source);
}

static vv_status read(vv_field **out, const vv_field_info *info, const void *plan, vv_source *none, int64_t frame,
                      const vv_box *region, vv_job *job)
{
    const vvi_data_source *source = plan;
    vv_field *all = NULL;
    const vv_status st = source->read(&all, source->user, frame, job);
    if (st != VV_OK || !region) {
        *out = all;
        return st;
    }
    const vv_status copied = vvi_field_copy_box(out, all, region, job);
    vv_field_release(all);
    return copied;
}

static const vv_format made = {
    .api = VV_FORMAT_API,
    .name = "made",
    .doc = "data that are made of others",
    .read = read,
    .free_plan = free_plan,
};

vv_status vvi_file_of_data(vv_file **out, const char *name, const vv_field_info *info, vv_notes *notes,
                           const vvi_data_source *source, vv_job *job)
{
    vvi_data_source *plan = vvi_calloc(1, sizeof *plan);
    *out = NULL;
    if (plan) {
        *plan = *source;
        return vvi_file_of_plan(out, name, &made, plan, info, notes, job);
    }
    vvi_notes_free(notes);
    source->drop(source->user);
    return vv_fail_memory(sizeof *plan);
}
