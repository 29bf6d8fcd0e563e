/* TIFF 6.0 and BigTIFF: pages are slices, channels or time steps. */
#include "io/formats/tiff/tiff.h"
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/tiff/tiff_write.h"
#include "io/placement.h"
#include "registry.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int probe(const uint8_t *head, size_t n, const char *path)
{
    static const uint8_t starts[4][4] = {{'I', 'I', 42, 0}, {'M', 'M', 0, 42}, {'I', 'I', 43, 0}, {'M', 'M', 0, 43}};
    (void)path;
    for (int i = 0; i < 4 && n >= 8; i++)
        if (memcmp(head, starts[i], 4) == 0)
            return 2;
    return 0;
}

void vvi_tiff_free(void *plan)
{
    vvi_tiff *t = plan;
    if (!t)
        return;
    for (size_t i = 0; i < t->n_files; i++)
        vvi_free(t->files[i]);
    vvi_free(t->files);
    vvi_free(t->pages);
    vvi_free(t->planes);
    vvi_free(t);
}

/* Resolutions that programs write when nothing was measured: of screens and printers, an inch. */
static bool is_for_print(double dpi)
{
    static const double usual[] = {1, 72, 75, 90, 96, 100, 120, 150, 200, 240, 254, 300, 360, 400, 600, 720, 1200};
    for (size_t i = 0; i < sizeof usual / sizeof *usual; i++)
        if (fabs(dpi - usual[i]) < 0.05 * usual[i] / 72)
            return true;
    return false;
}

static void set_spacing(vv_field_info *info, const vvi_tiff_page *p)
{
    const double *r = p->resolution;
    const double mm = p->resolution_unit == 3 ? 10 : 25.4;
    if (!(r[0] > 0 && r[1] > 0) || (p->resolution_unit != 2 && p->resolution_unit != 3) ||
        is_for_print(r[0] * 25.4 / mm) || (p->resolution_unit == 3 && r[0] == 1))
        return;
    const bool small = mm / r[0] < 0.1;
    vv_affine *a = &info->grid.index_to_world;
    a->axis[0].x = mm / r[0] * (small ? 1000 : 1);
    a->axis[1].y = mm / r[1] * (small ? 1000 : 1);
    vvi_complete_axes(a, 2);
    snprintf(info->grid.unit, sizeof info->grid.unit, small ? "um" : "mm");
}

static vv_status add_text(const char *key, const vvi_tiff_reader *r, const vvi_tiff_array *array, vv_notes *notes)
{
    char *text;
    vv_status st = vvi_tiff_text(&text, r, array, 4096);
    if (st != VV_OK || !text)
        return st;
    vvi_text_clean(text);
    if (text[0])
        st = vvi_notes_add(notes, key, text);
    vvi_free(text);
    return st;
}

/* Pages without OME-XML: slices, or what ImageJ says. */
static vv_status stack_pages(vv_field_info *info, vvi_tiff *t, const vvi_tiff_reader *r, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    bool imagej;
    if (options->part)
        return vv_fail_at(VV_E_ARGUMENT, vvi_source_name(r->source), NULL,
                          "has no parts to choose '%.60s' from; only OME-TIFF files have", options->part);
    vv_status st = vvi_tiff_stack(t, r->source, notes, job);
    if (st != VV_OK)
        return st;
    const vvi_tiff_page first = t->pages[t->planes[0]];
    set_spacing(info, &first);
    if ((st = vvi_tiff_imagej(&imagej, info, t, r, notes, job)) == VV_OK && !imagej)
        st = add_text("description", r, &first.description, notes);
    return st;
}

static vv_status fill_plan(vv_field_info *info, vvi_tiff *t, vv_source *source, const vv_read_options *options,
                           vv_notes *notes, vv_job *job)
{
    vvi_tiff_reader r;
    bool ome;
    vv_status st = vvi_tiff_read_pages(t, &r, source, 0, job);
    if (st != VV_OK || (st = vvi_tiff_ome(&ome, info, t, &r, options->part, notes, job)) != VV_OK)
        return st;
    if (!ome && (st = stack_pages(info, t, &r, options, notes, job)) != VV_OK)
        return st;
    if ((st = add_text("software", &r, &t->pages[0].software, notes)) == VV_OK)
        st = add_text("date", &r, &t->pages[0].date, notes);
    if (st == VV_OK && (st = vvi_tiff_describe(info, t, source, notes, job)) == VV_OK)
        vvi_tiff_own_apply(info, &t->own);
    return st;
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    *plan_out = NULL;
    vv_status st = vvi_source_spool(source, job);
    if (st != VV_OK)
        return st;
    vvi_tiff *t = vvi_alloc_zeroed(job, sizeof *t, VVI_MEM_MODEL);
    if (!t)
        return vv_fail_memory(sizeof *t);
    if ((st = fill_plan(info, t, source, options, notes, job)) == VV_OK)
        *plan_out = t;
    else
        vvi_tiff_free(t);
    return st;
}

static vv_status read_samples(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source,
                              int64_t frame, const vv_box *region, vv_job *job)
{
    const vvi_tiff *t = plan;
    vv_status st;
    if (t->plain)
        st = vvi_layout_read_plain(out, info, &t->layout, source, t->offset, frame, region, job);
    else
        st = vvi_tiff_read(out, info, t, source, frame, region, job);
    if (st == VV_OK && t->cut)
        vvi_job_damage(job, "io", "%s: its chain of pages breaks off after page %zu; the pages before are read",
                       vvi_source_name(source), t->n_pages);
    return st;
}

static bool mappable(const vv_field_info *info, const void *plan)
{
    (void)info;
    return ((const vvi_tiff *)plan)->mappable;
}

static const char *const suffixes[] = {".tif", ".tiff", ".btf", NULL};
static const char *const encodings[] = {"raw", "deflate", "lzw", "zstd", NULL};

const vv_format vvi_format_tiff = {
    .beside = true,
    .api = VV_FORMAT_API,
    .name = "tiff",
    .doc = "TIFF and BigTIFF stacks, of ImageJ and OME too",
    .suffixes = suffixes,
    .encodings = encodings,
    .probe = probe,
    .read_header = read_header,
    .free_plan = vvi_tiff_free,
    .read = read_samples,
    .mappable = mappable,
    .write = vvi_tiff_write,
};
