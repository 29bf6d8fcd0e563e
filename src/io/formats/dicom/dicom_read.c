/* A volume out of its slices: each is read and unpacked by itself, several at a time. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "io/formats/dicom/dicom.h"
#include "io/layout.h"
#include "io/sample_writer.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* GAP: missing in every frame, which was told when the slices were put in order. */
typedef enum outcome { THERE, GAP, MISSING, CUT, DAMAGED } outcome;

typedef struct reading {
    const vvi_dicom_plan *plan;
    const vv_field_info *info; /* of the whole */
    const vvi_dicom_slice *slice;
    vv_source *source;
    vv_job *job;
    vv_box box;
    uint8_t *out;
    size_t slice_bytes; /* of the box */
    outcome *outcome;
    char **why; /* the sentence about a damaged slice */
} reading;

static vv_status start(void **scratch_out, void *shared, int worker)
{
    reading *r = shared;
    *scratch_out = vvi_alloc_zeroed(r->job, sizeof(vvi_dicom_scratch), VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(sizeof(vvi_dicom_scratch));
}

static void finish(void *scratch, void *shared)
{
    vvi_dicom_scratch *s = scratch;
    if (!s)
        return;
    vvi_dicom_scratch_finish(s);
    vvi_free(s);
}

static bool is_whole(const reading *r)
{
    return r->box.n[0] == r->info->grid.dims[0] && r->box.n[1] == r->info->grid.dims[1];
}

/* The slice's own values instead of what is stored. */
static void scale_row(float *out, const uint8_t *in, const vvi_dicom_image *image, const vvi_dicom_values *v, size_t n)
{
    double piece[256];
    const double slope = v && isfinite(v->slope) && v->slope != 0 ? v->slope : 1;
    const double intercept = v && isfinite(v->intercept) ? v->intercept : 0;
    for (size_t i = 0; i < n; i += 256) {
        const size_t m = n - i < 256 ? n - i : 256;
        vvi_samples_to_f64(piece, in + i * vv_type_bytes(image->type), image->type, m);
        for (size_t j = 0; j < m; j++)
            out[i + j] = (float)(piece[j] * slope + intercept);
    }
}

static void copy_box(const reading *r, uint8_t *out, const uint8_t *whole, const vvi_dicom_image *image,
                     const vvi_dicom_values *v)
{
    const size_t sample = vv_type_bytes(image->type) * (size_t)image->components;
    const size_t row = (size_t)r->box.n[0], out_row = r->slice_bytes / (size_t)r->box.n[1];
    for (int64_t j = 0; j < r->box.n[1]; j++) {
        const uint8_t *from =
            whole + ((size_t)(r->box.lo[1] + j) * (size_t)r->info->grid.dims[0] + (size_t)r->box.lo[0]) * sample;
        uint8_t *to = out + (size_t)j * out_row;
        if (r->plan->own_scale)
            scale_row((float *)(void *)to, from, image, v, row);
        else
            memcpy(to, from, row * sample);
    }
}

static void fill_missing(const reading *r, uint8_t *out)
{
    memset(out, vv_type_is_float(r->info->type) ? 0xff : 0, r->slice_bytes);
}

static vv_status read_slice(reading *r, const vvi_dicom_slice *slice, uint8_t *out, vvi_dicom_scratch *scratch,
                            size_t *n_missing)
{
    const vvi_dicom_image *image = &r->plan->image[slice->image];
    const bool direct = is_whole(r) && !r->plan->own_scale;
    const size_t n = (size_t)(r->info->grid.dims[0] * r->info->grid.dims[1]) * (size_t)image->components *
                     vv_type_bytes(image->type);
    vvi_dicom_file file;
    vv_status st = direct ? VV_OK : vvi_dicom_make_room(&scratch->whole, n, r->job);
    if (st == VV_OK)
        st = vvi_dicom_open(&file, image, r->source, r->job);
    if (st != VV_OK)
        return st;
    uint8_t *whole = direct ? out : scratch->whole.data;
    st = vvi_dicom_pixels(whole, image, slice->frame, file.source, scratch, n_missing, r->job);
    vvi_dicom_close(&file);
    if (st == VV_OK && !direct)
        copy_box(r, out, whole, image, vvi_dicom_frame_values(image, slice->frame));
    return st;
}

/* Segments -------------------------------------------------------------------------------------------------------- */

static void paint_row(uint8_t *out, vv_type type, const uint8_t *in, size_t n, uint16_t label)
{
    for (size_t i = 0; i < n; i++) {
        if (in[i] == 0)
            continue;
        if (type == VV_TYPE_U8)
            out[i] = (uint8_t)label;
        else
            memcpy(out + 2 * i, &label, 2);
    }
}

static void paint_box(const reading *r, uint8_t *out, const uint8_t *whole, uint16_t label)
{
    const size_t row = (size_t)r->box.n[0], out_row = r->slice_bytes / (size_t)r->box.n[1];
    for (int64_t j = 0; j < r->box.n[1]; j++) {
        const uint8_t *from = whole + (r->box.lo[1] + j) * r->info->grid.dims[0] + r->box.lo[0];
        paint_row(out + (size_t)j * out_row, r->info->type, from, row, label);
    }
}

/* What lies in slice k of a segmentation: nothing, or the frames of some segments. */
static vv_status paint_slice(reading *r, ptrdiff_t k, uint8_t *out, vvi_dicom_scratch *scratch, size_t *n_missing)
{
    const vvi_dicom_plan *plan = r->plan;
    const size_t from = plan->first_painted[k], end = plan->first_painted[k + 1];
    memset(out, 0, r->slice_bytes);
    if (from == end)
        return VV_OK;
    const vvi_dicom_image *image = vvi_dicom_first(plan, NULL);
    const size_t n = (size_t)(r->info->grid.dims[0] * r->info->grid.dims[1]) * vv_type_bytes(image->type);
    vvi_dicom_file file;
    vv_status st = vvi_dicom_make_room(&scratch->whole, n, r->job);
    if (st != VV_OK || (st = vvi_dicom_open(&file, image, r->source, r->job)) != VV_OK)
        return st;
    for (size_t i = from; i < end && st == VV_OK; i++) {
        const vvi_dicom_painted *p = &plan->painted[i];
        size_t missing = 0;
        st = vvi_dicom_pixels(scratch->whole.data, image, p->frame, file.source, scratch, &missing, r->job);
        *n_missing += missing;
        if (st == VV_OK && vvi_dicom_segmentation_of(image) == VVI_DICOM_BINARY)
            paint_box(r, out, scratch->whole.data, p->label);
        else if (st == VV_OK)
            copy_box(r, out, scratch->whole.data, image, NULL);
    }
    vvi_dicom_close(&file);
    return st;
}

/* Every place has an image in the first frame. */
static outcome kind_of_missing(const reading *r, size_t index)
{
    return r->plan->slice[(size_t)r->box.lo[2] + index].image < 0 ? GAP : MISSING;
}

static vv_status item(void *scratch, void *shared, size_t index)
{
    reading *r = shared;
    const vvi_dicom_slice *slice = &r->slice[(size_t)r->box.lo[2] + index];
    uint8_t *out = r->out + index * r->slice_bytes;
    size_t n_missing = 0;
    const bool painted = r->plan->first_painted != NULL;
    vv_status st = painted            ? paint_slice(r, slice - r->slice, out, scratch, &n_missing)
                   : slice->image < 0 ? VV_OK
                                      : read_slice(r, slice, out, scratch, &n_missing);
    r->outcome[index] = slice->image < 0 && !painted ? kind_of_missing(r, index) : n_missing > 0 ? CUT : THERE;
    if (st == VV_E_FORMAT || st == VV_E_READ) {
        r->outcome[index] = DAMAGED;
        r->why[index] = vvi_strdup(vv_error_last()->message);
        st = VV_OK;
    }
    if (st == VV_OK && r->outcome[index] != THERE && r->outcome[index] != CUT)
        fill_missing(r, out);
    return st;
}

/* "1 missing, 2 damaged" */
static void list_damage(char *out, size_t n_out, const size_t *count)
{
    static const char *const words[] = {[MISSING] = "missing", [CUT] = "cut short", [DAMAGED] = "damaged"};
    size_t n = 0;
    for (int k = MISSING; k <= DAMAGED; k++)
        if (count[k] > 0 && n < n_out)
            n += (size_t)snprintf(out + n, n_out - n, "%s%zu %s", n ? ", " : "", count[k], words[k]);
}

/* One sentence for all that is not there and was not told before; too much of it is no volume. */
static vv_status tell_damage(const reading *r, const char *name)
{
    size_t count[DAMAGED + 1] = {0};
    char damage[96];
    const size_t n = (size_t)r->box.n[2];
    const char *why = NULL;
    for (size_t k = 0; k < n; k++) {
        count[r->outcome[k]]++;
        if (!why && r->why[k])
            why = r->why[k];
    }
    if (count[THERE] == n)
        return VV_OK;
    const char *first = why ? why : count[CUT] ? "the pixels of a file are cut short" : "there is no file for them";
    if (count[DAMAGED] > n / 2)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "%zu of %zu slices are damaged, first: %s", count[DAMAGED], n,
                          first);
    if (count[THERE] + count[GAP] == n) {
        vvi_job_mark_damaged(r->job);
        return VV_OK;
    }
    list_damage(damage, sizeof damage, count);
    vvi_job_damage(r->job, "io", "%s: not all of its %zu slices are complete (%s); what is missing is %s; %s", name, n,
                   damage, vv_type_is_float(r->info->type) ? "NaN" : "0", first);
    return VV_OK;
}

static vv_status read_all(reading *r)
{
    const vvi_work work = {.stage = "read", .start = start, .item = item, .finish = finish};
    const size_t n = (size_t)r->box.n[2];
    r->outcome = vvi_alloc_zeroed(r->job, n * sizeof *r->outcome, VVI_MEM_SCRATCH);
    r->why = vvi_alloc_zeroed(r->job, n * sizeof *r->why, VVI_MEM_SCRATCH);
    vv_status st = r->outcome && r->why ? VV_OK : vv_fail_memory(n * sizeof *r->why);
    if (st == VV_OK)
        st = vvi_parallel_for(r->job, &work, r, n);
    if (st == VV_OK)
        st = tell_damage(r, vvi_source_name(r->source));
    for (size_t k = 0; k < n && r->why; k++)
        free(r->why[k]);
    vvi_free(r->why);
    vvi_free(r->outcome);
    return st;
}

/* One file of plain samples -----------------------------------------------------------------------------------------
 */

bool vvi_dicom_is_straight(const vv_field_info *info, const vvi_dicom_plan *plan)
{
    const vvi_dicom_image *image = plan->image;
    const int64_t n = info->grid.dims[2] * info->n_frames;
    if (plan->first_painted || plan->n_images != 1 || image->name || image->coding != VVI_DICOM_PLAIN ||
        image->deflated || plan->own_scale || image->components != 1 ||
        image->number[VVI_DICOM_STORED] != image->number[VVI_DICOM_ALLOCATED] ||
        image->number[VVI_DICOM_ALLOCATED] == 1 || (image->big && vv_type_bytes(image->type) == 1) ||
        image->pixels.at + vvi_dicom_frame_bytes(image) * (uint64_t)n > image->size)
        return false;
    for (int64_t i = 0; i < n; i++)
        if (plan->slice[i].image != 0 || plan->slice[i].frame != i)
            return false;
    return true;
}

/* Mapped where that is possible. */
static vv_status read_straight(vv_field **out, const vv_field_info *info, const vvi_dicom_image *image,
                               vv_source *source, int64_t frame, const vv_box *region, vv_job *job)
{
    vvi_layout layout = {.n_axes = 4, .type = info->type};
    for (int a = 0; a < 3; a++)
        layout.axis[a] = (vvi_layout_axis){info->grid.dims[a], (vvi_role)(VVI_ROLE_X + a)};
    layout.axis[3] = (vvi_layout_axis){info->n_frames, VVI_ROLE_FRAME};
    layout.swap = vv_type_bytes(info->type) > 1 && vvi_order_swapped(image->big);
    return vvi_layout_read_plain(out, info, &layout, source, image->pixels.at, frame, region, job);
}

vv_status vvi_dicom_read(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source, int64_t frame,
                         const vv_box *region, vv_job *job)
{
    const vvi_dicom_plan *p = plan;
    const int64_t *dims = info->grid.dims;
    if (p->straight)
        return read_straight(out, info, p->image, source, frame, region, job);
    reading r = {.plan = p, .info = info, .source = source, .job = job};
    r.box = region ? *region : (vv_box){{0, 0, 0}, {dims[0], dims[1], dims[2]}};
    r.slice = p->slice + frame * dims[2];
    vv_field_info part = *info;
    part.grid = vv_grid_crop(&info->grid, &r.box);
    part.frame = frame;
    uint64_t bytes;
    void *data;
    vv_field *field;
    *out = NULL;
    vv_status st = vv_field_info_bytes(&bytes, &part);
    if (st != VV_OK || (st = vvi_memory_plan(job, bytes, "volume")) != VV_OK ||
        (st = vv_field_new_empty(&field, &data, &part, job)) != VV_OK)
        return st;
    r.out = data;
    r.slice_bytes = (size_t)bytes / (size_t)r.box.n[2];
    if ((st = read_all(&r)) != VV_OK) {
        vv_field_release(field);
        return st;
    }
    *out = field;
    return VV_OK;
}
