/* Mean: each sample becomes the mean of those in the window around it. */
#include "core/cpu.h"
#include "core/job.h"
#include "core/memory.h"
#include "filter/mean_lines.h"
#include "filter/window.h"
#include "grid/making.h"
#include "registry.h"

#include <math.h>
#include <string.h>

#define ROW_MOST 256                   /* samples of a tile along x */
#define SLICE_BYTES ((int64_t)1 << 15) /* of a slice of it: sums of all slices of a window stay in the caches */
#define STACK_BYTES ((int64_t)1 << 26) /* of all of them, at most */
#define WINDOW_MOST ((int64_t)1 << 21) /* samples: their sums are exact as doubles */

static const vv_property properties[] = {VVI_WINDOW_PROPERTIES, {0}};

static const vv_class mean_class = {
    .name = "mean",
    .doc = "parameters of mean",
    .size = sizeof(vvi_window_params),
    .properties = properties,
    .check = vvi_window_check,
};

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    int64_t radius[3];
    *out = inputs[0];
    if (inputs[0].meaning == VV_MEANING_LABEL)
        return vv_fail(VV_E_UNSUPPORTED, "mean: labels are names, not amounts, and have no mean");
    return vvi_window_radius(radius, &inputs[0], params, "mean", WINDOW_MOST);
}

typedef struct shared {
    vvi_making making;
    const vv_field_info *info;
    const vvi_mean_kernels *kernels;
    vvi_mean_number number;
    size_t bytes; /* of one */
    int64_t radius[3];
    int64_t window; /* samples of it */
    vv_job *job;
} shared;

typedef struct scratch {
    vvi_mean_stack sums, mask; /* of samples, and of 1 where there is a number, 0 where it is missing */
    double *row;
    bool masked; /* something is missing in this tile so far */
} scratch;

static void finish(void *scratch_in, void *user)
{
    scratch *own = scratch_in;
    if (!own)
        return;
    vvi_mean_stack_finish(&own->sums);
    vvi_mean_stack_finish(&own->mask);
    vvi_free(own->row);
    vvi_free(own);
}

static vv_status make_stack(vvi_mean_stack *out, vvi_mean_number number, const shared *s)
{
    const int64_t *step = s->making.slabs.step;
    const int64_t dims[2] = {step[0] + 2 * s->radius[0], step[1] + 2 * s->radius[1]};
    return vvi_mean_stack_init(out, number, dims, s->radius, s->kernels, s->job);
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const size_t row = (size_t)s->making.slabs.step[0] * sizeof(double);
    scratch *own = vvi_alloc_zeroed(s->job, sizeof *own, VVI_MEM_SCRATCH);
    if (!own)
        return vv_fail_memory(sizeof *own);
    own->row = vvi_alloc(s->job, row, VVI_MEM_SCRATCH);
    const vv_status st = own->row ? make_stack(&own->sums, s->number, s) : vv_fail_memory(row);
    if (st == VV_OK)
        *scratch_out = own;
    else
        finish(own, user);
    return st;
}

/* A tile, dims[] with its margin. */
typedef struct tile {
    vv_box box;
    int64_t dims[3];
    int64_t component;
} tile;

static int64_t clamp(int64_t v, int64_t lo, int64_t n)
{
    return v < lo ? lo : v >= lo + n ? lo + n - 1 : v;
}

static const char *samples_at(const shared *s, int64_t x, int64_t y, int64_t z, int64_t component)
{
    const vv_brick *b = &s->making.brick;
    return (const char *)b->data + (x - b->box.lo[0]) * b->stride[0] + (y - b->box.lo[1]) * b->stride[1] +
           (z - b->box.lo[2]) * b->stride[2] + component * (int64_t)vv_type_bytes(s->info->type);
}

static int64_t slice_of(const shared *s, const tile *t, int64_t k)
{
    const vv_box *in = &s->making.brick.box;
    return clamp(t->box.lo[2] - s->radius[2] + k, in->lo[2], in->n[2]);
}

/* Row j of slice z of a tile with its margin; beyond the border lie the border's samples. */
static void gather_row(char *out, const shared *s, const tile *t, int64_t j, int64_t z)
{
    const int64_t *lo = s->making.brick.box.lo, *n = s->making.brick.box.n, *r = s->radius;
    const int64_t y = clamp(t->box.lo[1] - r[1] + j, lo[1], n[1]);
    const int64_t x = t->box.lo[0] - r[0], end = x + t->dims[0], bytes = (int64_t)s->bytes;
    const int64_t first = clamp(x, lo[0], n[0]), last = clamp(end - 1, lo[0], n[0]);
    char *inside = out + (first - x) * bytes;
    vvi_mean_load(inside, s->number, samples_at(s, first, y, z, t->component), s->making.brick.stride[0], s->info->type,
                  last - first + 1);
    for (int64_t i = x; i < first; i++)
        memcpy(out + (i - x) * bytes, inside, (size_t)bytes);
    for (int64_t i = last + 1; i < end; i++)
        memcpy(out + (i - x) * bytes, inside + (last - first) * bytes, (size_t)bytes);
}

/* NaN become 0, and the mask says where. */
static vv_status mask_nan(scratch *own, const shared *s, const tile *t, int64_t k)
{
    double *v = (double *)(void *)own->sums.block;
    const int64_t n = t->dims[0] * t->dims[1];
    int64_t missing = 0;
    vv_status st = VV_OK;
    for (int64_t i = 0; i < n; i++)
        missing += v[i] != v[i];
    if (missing == 0 && !own->masked)
        return VV_OK;
    if (!own->mask.block)
        st = make_stack(&own->mask, VVI_MEAN_F64, s);
    if (st != VV_OK)
        return st;
    if (!own->masked) {
        vvi_mean_stack_begin(&own->mask, t->dims);
        vvi_mean_stack_ones(&own->mask, k);
        own->masked = true;
    }
    double *mask = (double *)(void *)own->mask.block;
    for (int64_t i = 0; i < n; i++) {
        mask[i] = !isnan(v[i]);
        v[i] = isnan(v[i]) ? 0 : v[i];
    }
    return VV_OK;
}

/* NaN stay. */
static void restore_row(char *out, const shared *s, const tile *t, int64_t j, int64_t k)
{
    const int64_t each = (int64_t)vv_type_bytes(s->info->type), in_step = s->making.brick.stride[0];
    const char *in = samples_at(s, t->box.lo[0], t->box.lo[1] + j, t->box.lo[2] + k, t->component);
    for (int64_t i = 0; i < t->box.n[0]; i++) {
        double v;
        vvi_samples_to_f64(&v, in + i * in_step, s->info->type, 1);
        if (isnan(v))
            memcpy(out + i * each * s->info->components, in + i * in_step, (size_t)each);
    }
}

static void divide(double *row, const double *counts, double window, int64_t n)
{
    if (counts)
        for (int64_t i = 0; i < n; i++)
            row[i] /= counts[i];
    else
        for (int64_t i = 0; i < n; i++)
            row[i] /= window;
}

/* Slice k of the tile, without its margin. */
static void write_slice(scratch *own, const shared *s, const tile *t, int64_t k, const void *sums, const double *counts)
{
    const int64_t each = (int64_t)vv_type_bytes(s->info->type);
    for (int64_t j = 0; j < t->box.n[1]; j++) {
        const int64_t at = j * t->dims[0];
        const int64_t to = vvi_slabs_row(&s->making.slabs, &t->box, j, k) * s->info->components + t->component;
        vvi_mean_give(own->row, sums, s->number, at, t->box.n[0]);
        divide(own->row, counts ? counts + at : NULL, (double)s->window, t->box.n[0]);
        vvi_mean_store(s->making.out + to * each, each * s->info->components, own->row, s->info->type, t->box.n[0]);
        if (counts)
            restore_row(s->making.out + to * each, s, t, j, k);
    }
}

static vv_status write_tile(scratch *own, const shared *s, const tile *t)
{
    const double *counts = NULL;
    vv_status st = VV_OK;
    own->masked = false;
    vvi_mean_stack_begin(&own->sums, t->dims);
    for (int64_t k = 0; k < t->dims[2] && st == VV_OK; k++) {
        const int64_t z = slice_of(s, t, k);
        const bool again = k > 0 && s->radius[2] > 0 && z == slice_of(s, t, k - 1);
        for (int64_t j = 0; j < t->dims[1] && !again; j++)
            gather_row(own->sums.block + (size_t)(j * t->dims[0]) * s->bytes, s, t, j, z);
        if (!again && vv_type_is_float(s->info->type) && (st = mask_nan(own, s, t, k)) != VV_OK)
            return st;
        const void *sums = vvi_mean_stack_add(&own->sums, again);
        if (own->masked)
            counts = vvi_mean_stack_add(&own->mask, again);
        if (sums)
            write_slice(own, s, t, k - 2 * s->radius[2], sums, own->masked ? counts : NULL);
        st = vvi_job_poll(s->job);
    }
    return st;
}

static vv_status item(void *scratch_in, void *user, size_t index)
{
    const shared *s = user;
    tile t = {.box = vvi_slabs_item(&s->making.slabs, index)};
    vv_status st = VV_OK;
    for (int a = 0; a < 3; a++)
        t.dims[a] = t.box.n[a] + 2 * s->radius[a];
    for (; t.component < s->info->components && st == VV_OK; t.component++)
        st = write_tile(scratch_in, s, &t);
    return st;
}

static vvi_slabs find_tiles(const shared *s, const vv_box *box)
{
    const int64_t bytes = (int64_t)s->bytes, slices = 4 * s->radius[2] + 2; /* of all levels, at most */
    const int64_t row = (box->n[0] < ROW_MOST ? box->n[0] : ROW_MOST) + 2 * s->radius[0];
    return vvi_window_columns(box, s->radius, ROW_MOST, SLICE_BYTES / bytes, STACK_BYTES / (row * bytes * slices));
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "mean", .start = start, .item = item, .finish = finish};
    vv_field_info info;
    shared s = {.making = {.in = inputs[0]}, .info = &info, .window = 1, .job = job};
    *out = NULL;
    vv_status st = plan(&info, vv_field_get_info(inputs[0]), n_inputs, params);
    if (st == VV_OK)
        st = vvi_window_radius(s.radius, &info, params, "mean", WINDOW_MOST);
    if (st != VV_OK)
        return st;
    for (int a = 0; a < 3; a++)
        s.window *= 2 * s.radius[a] + 1;
    s.kernels = vvi_mean_kernels_for(vvi_job_cpu(job));
    s.number = vvi_mean_number_for(info.type, s.window);
    s.bytes = vvi_mean_number_bytes(s.number);
    s.making.slabs = find_tiles(&s, box);
    const vv_box needed = vvi_window_reach(box, s.radius, info.grid.dims);
    return vvi_making_run(out, &s.making, &info, box, &needed, &work, &s, job);
}

const vv_operation vvi_operation_mean = {
    .api = VV_OPERATION_API,
    .name = "mean",
    .component = "filter",
    .group = "smoothing",
    .doc = "the mean of a box around each sample; beyond the border are the values of the border; each channel "
           "separately",
    .example = "volvis mean head.nrrd -o smooth.nrrd --radius 1.5mm",
    .params = &mean_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
    .carry = vv_carry_values,
};
