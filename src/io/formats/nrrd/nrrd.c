/* NRRD ("nearly raw raster data"), versions 1 to 5: https://teem.sourceforge.net/nrrd/format.html */
#include "io/formats/nrrd/nrrd.h"
#include "core/memory.h"
#include "registry.h"
#include <string.h>

static int probe(const uint8_t *head, size_t n, const char *path)
{
    return n >= 8 && memcmp(head, "NRRD0", 5) == 0 ? 2 : 0;
}

void vvi_nrrd_free_plan(void *plan)
{
    vvi_nrrd_finish(plan);
    vvi_free(plan);
}

static vv_status read_any(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                          bool segmentation, vv_notes *notes, vv_job *job)
{
    *plan_out = NULL;
    vvi_nrrd *h = vvi_alloc_zeroed(job, sizeof *h, VVI_MEM_MODEL);
    if (!h)
        return vv_fail_memory(sizeof *h);
    h->is_segmentation = segmentation;
    vv_status st = vvi_nrrd_parse(h, source, notes, job);
    if (st == VV_OK)
        st = vvi_nrrd_place(info, h, options->part, notes);
    if (st == VV_OK)
        st = vvi_nrrd_keep_nifti(notes, info);
    if (st == VV_OK)
        st = vvi_nrrd_check_data(h, source, job);
    if (st != VV_OK) {
        vvi_nrrd_free_plan(h);
        return st;
    }
    *plan_out = h;
    return VV_OK;
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    return read_any(info, plan_out, source, options, false, notes, job);
}

vv_status vvi_nrrd_read_segmentation(vv_field_info *info, void **plan_out, vv_source *source,
                                     const vv_read_options *options, vv_notes *notes, vv_job *job)
{
    return read_any(info, plan_out, source, options, true, notes, job);
}

bool vvi_nrrd_mappable(const vv_field_info *info, const void *plan)
{
    return ((const vvi_nrrd *)plan)->mappable;
}

static const char *const suffixes[] = {".nrrd", ".nhdr", NULL};

const vv_format vvi_format_nrrd = {
    .beside = true,
    .api = VV_FORMAT_API,
    .name = "nrrd",
    .doc = "NRRD 1 to 5, attached (.nrrd) or detached (.nhdr) data; raw, gzip, bzip2, ascii and hex",
    .suffixes = suffixes,
    .encodings = vvi_nrrd_encodings,
    .probe = probe,
    .read_header = read_header,
    .free_plan = vvi_nrrd_free_plan,
    .read = vvi_nrrd_read,
    .mappable = vvi_nrrd_mappable,
    .write = vvi_nrrd_write,
    .takes_origin = true,
};
