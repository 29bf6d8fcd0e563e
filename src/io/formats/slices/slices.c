/* Folders of numbered pictures as volumes: the row of the table. */
#include "io/formats/slices/slices.h"
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/slices/slices_write.h"
#include "registry.h"
#include <string.h>

static int probe_folder(vv_source *folder, vv_job *job)
{
    vvi_names names;
    size_t any;
    if (vvi_source_list(&names, folder, NULL, false, job) != VV_OK)
        return 0;
    const size_t n = vvi_slices_count(&any, &names, folder, job);
    const int sure = n >= 2 && 2 * n >= names.n ? 2 : n > 0;
    vvi_names_free(&names);
    return sure;
}

/* One picture by itself, in a program that asks for volumes; PNG and JPEG with a scene inside are nobody's volume. */
static int probe(const uint8_t *head, size_t n, const char *path)
{
    static const uint8_t png[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'}, jpeg[3] = {0xff, 0xd8, 0xff};
    (void)path;
    return (n >= 8 && memcmp(head, png, 8) == 0) || (n >= 3 && memcmp(head, jpeg, 3) == 0);
}

/* A picture by itself: a volume of one slice. */
static vv_status open_file(vv_field_info *info, vvi_tiff *t, vv_source *source, vv_notes *notes, vv_job *job)
{
    vv_status st = vvi_source_spool(source, job);
    if (st != VV_OK || (st = vvi_slices_add(t, source, 0, job)) != VV_OK)
        return st;
    t->planes = vvi_alloc_zeroed(job, sizeof *t->planes, VVI_MEM_MODEL);
    if (!t->planes)
        return vv_fail_memory(sizeof *t->planes);
    t->channels = t->slices = t->frames = 1;
    return vvi_tiff_describe(info, t, source, notes, job);
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    *plan_out = NULL;
    vvi_tiff *t = vvi_alloc_zeroed(job, sizeof *t, VVI_MEM_MODEL);
    if (!t)
        return vv_fail_memory(sizeof *t);
    vv_status st = vvi_source_is_folder(source) ? vvi_slices_open(info, t, source, options->part, notes, job)
                                                : open_file(info, t, source, notes, job);
    if (st == VV_OK)
        *plan_out = t;
    else
        vvi_tiff_free(t);
    return st;
}

static vv_status read_samples(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source,
                              int64_t frame, const vv_box *region, vv_job *job)
{
    return vvi_tiff_read(out, info, plan, source, frame, region, job);
}

static const char *const suffixes[] = {"/", NULL}; /* the name of a folder that is written */
static const char *const encodings[] = {"png", "tiff", NULL};

const vv_format vvi_format_slices = {
    .beside = true,
    .api = VV_FORMAT_API,
    .name = "slices",
    .doc = "folders of numbered TIFF, PNG or JPEG files, one slice each; a single picture too; written as PNG where "
           "that can hold the samples, else as TIFF",
    .suffixes = suffixes,
    .encodings = encodings,
    .probe = probe,
    .probe_folder = probe_folder,
    .read_header = read_header,
    .free_plan = vvi_tiff_free,
    .read = read_samples,
    .write = vvi_slices_write,
    .folder_file = vvi_slices_folder_file,
};
