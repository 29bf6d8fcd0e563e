/* Gaussian smoothing, separable. A worker has some rows of all slices: x and y are done slice by slice, into a ring
 * that holds as many slices as z needs, so that the volume is read once and written once.
 *
 * Samples that are not finite count as missing: they stay what they are, and their neighbours are the mean of what is
 * there (normalised convolution, Knutsson & Westin 1993): smoothed samples over the smoothed mask. */
#include "core/cpu.h"
#include "core/job.h"
#include "core/memory.h"
#include "filter/gaussian_kernel.h"
#include "filter/sigma.h"
#include "filter/window.h"
#include "grid/making.h"
#include "registry.h"

#include <math.h>
#include <string.h>

#define CUT 4.0           /* sigmas that the kernel reaches: 6e-5 of its weight lies beyond */
#define SIGMA_MOST 1024.0 /* voxels: beyond, the work of one row is no longer done within the time to cancel */

#define PIECE 256                     /* numbers of all slices of a ring that stay in the first-level cache */
#define TILE_BYTES ((int64_t)1 << 15) /* of a slice in the ring: all of them stay in the second-level cache */
#define RING_BYTES ((int64_t)1 << 26) /* of all slices, at most */
#define CHUNK 16                      /* slices that are done at once */

static const vv_property properties[] = {VVI_SIGMA_PROPERTIES, {0}};

static const vv_class gaussian_class = {
    .name = "gaussian",
    .doc = "parameters of gaussian",
    .size = sizeof(vvi_sigma_params),
    .properties = properties,
    .check = vvi_sigma_check,
};

static vv_status sigmas_of(double sigma[3], const vv_field_info *info, const vv_object *params)
{
    if (info->meaning == VV_MEANING_LABEL)
        return vv_fail(VV_E_UNSUPPORTED, "gaussian: labels are names, not amounts, and have no mean");
    return vvi_sigma_voxels(sigma, info, params, "gaussian", SIGMA_MOST);
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    (void)n_inputs;
    double sigma[3];
    *out = inputs[0];
    return sigmas_of(sigma, &inputs[0], params);
}

static vv_status make_weights(vvi_gaussian_weights *out, double sigma, vv_job *job)
{
    out->radius = (int64_t)floor(CUT * sigma + 0.5);
    const size_t bytes = (size_t)(out->radius + 1) * sizeof *out->w;
    out->w = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    if (!out->w)
        return vv_fail_memory(bytes);
    double sum = 1;
    out->w[0] = 1;
    for (int64_t r = 1; r <= out->radius; r++) {
        out->w[r] = exp(-0.5 * ((double)r / sigma) * ((double)r / sigma));
        sum += 2 * out->w[r];
    }
    for (int64_t r = 0; r <= out->radius; r++)
        out->w[r] /= sum;
    return VV_OK;
}

enum { SAMPLES, MASK, PARTS };

typedef struct shared {
    vvi_making making;
    const vv_field_info *info;
    const vvi_gaussian_kernels *kernels;
    bool wide; /* numbers are doubles */
    vvi_gaussian_weights weights[3];
    int64_t slices; /* of the ring */
    vv_job *job;
} shared;

/* A worker's own: numbers of the samples, and of the mask where something is missing. */
typedef struct scratch {
    char *row[PARTS];    /* with a margin along x */
    char *lines[PARTS];  /* rows of a slice that x is done of, with a margin along y */
    char *ring[PARTS];   /* slices that x and y are done of */
    char *result[PARTS]; /* a piece of the result */
    const void **rows;   /* that a sum is made of */
    bool masked;         /* something is missing in this item so far */
} scratch;

/* Some rows of all slices of an item. */
typedef struct tile {
    vv_box box;
    int64_t n; /* numbers of a row */
    char *out; /* of the first */
} tile;

static int64_t larger(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

static int64_t smaller(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

static int64_t number_bytes(const shared *s)
{
    return s->wide ? (int64_t)sizeof(double) : (int64_t)sizeof(float);
}

static int64_t row_numbers(const shared *s)
{
    return (s->making.slabs.step[0] + 2 * s->weights[0].radius) * s->info->components;
}

static int64_t line_numbers(const shared *s)
{
    return s->making.slabs.step[0] * s->info->components * (s->making.slabs.step[1] + 2 * s->weights[1].radius);
}

static int64_t slice_numbers(const shared *s)
{
    return s->making.slabs.step[0] * s->info->components * s->making.slabs.step[1] + VVI_GAUSSIAN_GUARD;
}

static void finish(void *scratch_in, void *user)
{
    scratch *own = scratch_in;
    if (!own)
        return;
    for (int p = 0; p < PARTS; p++) {
        vvi_free(own->row[p]);
        vvi_free(own->lines[p]);
        vvi_free(own->ring[p]);
        vvi_free(own->result[p]);
    }
    vvi_free(own->rows);
    vvi_free(own);
}

static vv_status make_numbers(char **out, const shared *s, int64_t n)
{
    const size_t bytes = (size_t)((n + VVI_GAUSSIAN_GUARD) * number_bytes(s));
    if (!*out)
        *out = vvi_alloc_zeroed(s->job, bytes, VVI_MEM_SCRATCH);
    return *out ? VV_OK : vv_fail_memory(bytes);
}

static vv_status make_part(scratch *own, const shared *s, int part)
{
    vv_status st = make_numbers(&own->lines[part], s, line_numbers(s));
    if (st == VV_OK)
        st = make_numbers(&own->ring[part], s, slice_numbers(s) * s->slices);
    return st == VV_OK
               ? make_numbers(&own->result[part], s, larger(PIECE, s->making.slabs.step[0] * s->info->components))
               : st;
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const size_t rows =
        (size_t)(2 * larger(s->weights[0].radius, larger(s->weights[1].radius, s->weights[2].radius)) + 1) *
        sizeof(void *);
    scratch *own = vvi_alloc_zeroed(s->job, sizeof *own, VVI_MEM_SCRATCH);
    if (!own)
        return vv_fail_memory(sizeof *own);
    own->rows = vvi_alloc(s->job, rows, VVI_MEM_SCRATCH);
    vv_status st = own->rows ? make_part(own, s, SAMPLES) : vv_fail_memory(rows);
    for (int p = 0; p < PARTS && st == VV_OK; p++)
        st = make_numbers(&own->row[p], s, row_numbers(s));
    if (st == VV_OK)
        *scratch_out = own;
    else
        finish(own, user);
    return st;
}

static void fill_ones(char *out, const shared *s, int64_t n)
{
    for (int64_t i = 0; i < n; i++)
        if (s->wide)
            ((double *)(void *)out)[i] = 1;
        else
            ((float *)(void *)out)[i] = 1;
}

/* Up to here nothing was missing: what a mask of ones comes to is exactly 1. */
static vv_status begin_mask(scratch *own, const shared *s)
{
    const vv_status st = make_part(own, s, MASK);
    if (st != VV_OK)
        return st;
    own->masked = true;
    fill_ones(own->lines[MASK], s, line_numbers(s));
    fill_ones(own->ring[MASK], s, slice_numbers(s) * s->slices);
    return VV_OK;
}

/* n numbers of the result along an axis whose rows are `step` numbers apart, the first of them at `rows`. */
static void sum_rows(char *out, scratch *own, const shared *s, const char *rows, int axis, int64_t step, int64_t n)
{
    for (int64_t r = 0; r <= 2 * s->weights[axis].radius; r++)
        own->rows[r] = rows + r * step * number_bytes(s);
    s->kernels->sum[s->wide](out, own->rows, &s->weights[axis], n);
}

/* Margins repeat the samples at the ends: `before` numbers and those behind, of `step` components. */
static void repeat_ends(char *row, int64_t before, int64_t n, int64_t behind, int64_t step, int64_t bytes)
{
    char *first = row + before * bytes, *last = first + (n - step) * bytes;
    for (int64_t i = 0; i < before; i += step)
        memcpy(row + i * bytes, first, (size_t)(step * bytes));
    for (int64_t i = 0; i < behind; i += step)
        memcpy(last + (i + step) * bytes, last, (size_t)(step * bytes));
}

/* Row (y, z) of the input, smoothed along x, as line number `line`. */
static vv_status smooth_row(scratch *own, const shared *s, const tile *t, int64_t y, int64_t z, int64_t line)
{
    const vv_brick *b = &s->making.brick;
    const int64_t step = s->info->components, bytes = number_bytes(s), reach = s->weights[0].radius;
    const int64_t from = t->box.lo[0] - reach, to = t->box.lo[0] + t->box.n[0] + reach;
    const int64_t lo = larger(from, b->box.lo[0]), hi = smaller(to, b->box.lo[0] + b->box.n[0]);
    const int64_t before = (lo - from) * step, n = (hi - lo) * step, behind = (to - hi) * step;
    const char *in = (const char *)b->data + (lo - b->box.lo[0]) * b->stride[0] + (y - b->box.lo[1]) * b->stride[1] +
                     (z - b->box.lo[2]) * b->stride[2];
    bool all = true;
    s->kernels->load[s->wide](own->row[SAMPLES] + before * bytes, in, b->type, n);
    if (vv_type_is_float(b->type))
        all = s->kernels->finite[s->wide](own->row[SAMPLES] + before * bytes, own->row[MASK] + before * bytes, n);
    vv_status st = all || own->masked ? VV_OK : begin_mask(own, s);
    for (int p = 0; p <= own->masked && st == VV_OK; p++) {
        char *out = own->lines[p] + line * t->n * bytes;
        repeat_ends(own->row[p], before, n, behind, step, bytes);
        if (p == MASK && all)
            fill_ones(out, s, t->n);
        else
            sum_rows(out, own, s, own->row[p], 0, step, t->n);
    }
    return st;
}

static char *ring_at(const scratch *own, const shared *s, int part, int64_t z)
{
    return own->ring[part] + (z - s->making.brick.box.lo[2]) % s->slices * slice_numbers(s) * number_bytes(s);
}

/* Slice z of the input, smoothed along x and y, comes to its place in the ring. */
static vv_status smooth_slice(scratch *own, const shared *s, const tile *t, int64_t z)
{
    const vv_brick *b = &s->making.brick;
    const int64_t reach = s->weights[1].radius, bytes = number_bytes(s), all = t->box.n[1] * t->n;
    const int64_t from = t->box.lo[1] - reach, to = t->box.lo[1] + t->box.n[1] + reach;
    const int64_t lo = larger(from, b->box.lo[1]), hi = smaller(to, b->box.lo[1] + b->box.n[1]);
    vv_status st = VV_OK;
    for (int64_t y = lo; y < hi && st == VV_OK; y++)
        if ((st = smooth_row(own, s, t, y, z, y - from)) == VV_OK)
            st = vvi_job_poll(s->job);
    for (int p = 0; p <= own->masked && st == VV_OK; p++) {
        char *slice = ring_at(own, s, p, z);
        repeat_ends(own->lines[p], (lo - from) * t->n, (hi - lo) * t->n, (to - hi) * t->n, t->n, bytes);
        for (int64_t at = 0; at < all && st == VV_OK; at += PIECE) {
            sum_rows(slice + at * bytes, own, s, own->lines[p] + at * bytes, 1, t->n, smaller(all - at, PIECE));
            st = vvi_job_poll(s->job);
        }
    }
    return st;
}

/* Missing samples stay as they were. */
static void restore(char *out, const shared *s, const tile *t, int64_t row, int64_t rows, int64_t z)
{
    const vv_brick *b = &s->making.brick;
    const size_t each = vv_type_bytes(s->info->type);
    for (int64_t j = row; j < row + rows; j++) {
        const char *in = (const char *)b->data + (t->box.lo[0] - b->box.lo[0]) * b->stride[0] +
                         (t->box.lo[1] + j - b->box.lo[1]) * b->stride[1] + (z - b->box.lo[2]) * b->stride[2];
        for (int64_t i = 0; i < t->n; i++, in += each, out += each) {
            double v;
            vvi_samples_to_f64(&v, in, s->info->type, 1);
            if (!isfinite(v))
                memcpy(out, in, each);
        }
    }
}

static void store(char *out, char *result, const shared *s, int64_t n)
{
    if (s->wide)
        vvi_samples_from_f64(out, (const double *)(const void *)result, s->info->type, (size_t)n);
    else
        s->kernels->store(out, (const float *)(const void *)result, s->info->type, n);
}

/* Some rows of slice z of the result, all in one piece. */
static void smooth_piece(scratch *own, const shared *s, const tile *t, int64_t row, int64_t rows, int64_t z)
{
    const vv_box *in = &s->making.brick.box;
    const int64_t reach = s->weights[2].radius, n = rows * t->n;
    char *out = s->making.out + vvi_slabs_row(&s->making.slabs, &t->box, row, z - t->box.lo[2]) * s->info->components *
                                    (int64_t)vv_type_bytes(s->info->type);
    for (int p = 0; p <= own->masked; p++) {
        for (int64_t r = -reach; r <= reach; r++) {
            const int64_t at = larger(in->lo[2], smaller(z + r, in->lo[2] + in->n[2] - 1));
            own->rows[reach + r] = ring_at(own, s, p, at) + row * t->n * number_bytes(s);
        }
        s->kernels->sum[s->wide](own->result[p], own->rows, &s->weights[2], n);
    }
    if (own->masked)
        s->kernels->divide[s->wide](own->result[SAMPLES], own->result[MASK], n);
    store(out, own->result[SAMPLES], s, n);
    if (own->masked)
        restore(out, s, t, row, rows, z);
}

static vv_status item(void *scratch_in, void *user, size_t index)
{
    const shared *s = user;
    scratch *own = scratch_in;
    tile t = {.box = vvi_slabs_item(&s->making.slabs, index)};
    t.n = t.box.n[0] * s->info->components;
    const vv_box *in = &s->making.brick.box;
    const int64_t reach = s->weights[2].radius, end = t.box.lo[2] + t.box.n[2];
    const int64_t rows = t.box.n[0] == s->making.slabs.box.n[0] ? larger(1, PIECE / t.n) : 1;
    int64_t next = larger(t.box.lo[2] - reach, in->lo[2]);
    vv_status st = VV_OK;
    own->masked = false;
    for (int64_t z = t.box.lo[2]; z < end && st == VV_OK; z += CHUNK) {
        const int64_t now = smaller(end, z + CHUNK), needed = smaller(now + reach, in->lo[2] + in->n[2]);
        for (; next < needed && st == VV_OK; next++)
            st = smooth_slice(own, s, &t, next);
        for (int64_t j = 0; j < t.box.n[1]; j += rows)
            for (int64_t k = z; k < now && st == VV_OK; k++) {
                smooth_piece(own, s, &t, j, smaller(rows, t.box.n[1] - j), k);
                st = vvi_job_poll(s->job);
            }
    }
    return st;
}

static vvi_slabs find_tiles(const shared *s, const vv_box *box, const int64_t radius[3])
{
    const int64_t components = s->info->components, each = components * number_bytes(s);
    const int64_t row = larger(1, smaller(box->n[0], PIECE / components));
    return vvi_window_columns(box, radius, row, TILE_BYTES / each, RING_BYTES / (row * each * s->slices));
}

/* Without an axis to smooth along samples are as they were. */
static vv_status copy_item(void *scratch_in, void *user, size_t index)
{
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const vv_brick in = vvi_brick_part(&s->making.brick, &box);
    const int64_t each = s->info->components * (int64_t)vv_type_bytes(s->info->type);
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++)
            memcpy(s->making.out + vvi_slabs_row(&s->making.slabs, &box, j, k) * each,
                   (const char *)in.data + j * in.stride[1] + k * in.stride[2], (size_t)(box.n[0] * each));
    return VV_OK;
}

static bool needs_double(vv_type type)
{
    return type != VV_TYPE_F32 && vv_type_bytes(type) > 2;
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "smooth", .start = start, .item = item, .finish = finish};
    static const vvi_work copy = {.stage = "smooth", .item = copy_item};
    const vv_field_info *info = vv_field_get_info(inputs[0]);
    shared s = {.making = {.in = inputs[0]}, .info = info, .wide = needs_double(info->type), .job = job};
    double sigma[3] = {0};
    int64_t radius[3] = {0};
    *out = NULL;
    vv_status st = sigmas_of(sigma, info, params);
    for (int a = 0; a < 3 && st == VV_OK; a++) {
        st = make_weights(&s.weights[a], sigma[a], job);
        radius[a] = s.weights[a].radius;
    }
    if (st == VV_OK) {
        const bool same = radius[0] == 0 && radius[1] == 0 && radius[2] == 0;
        const vv_box needed = vvi_window_reach(box, radius, info->grid.dims);
        s.kernels = vvi_gaussian_kernels_for(vvi_job_cpu(job));
        s.slices = smaller(CHUNK + 2 * radius[2], needed.n[2]);
        s.making.slabs = find_tiles(&s, box, radius);
        st = vvi_making_run(out, &s.making, info, box, &needed, same ? &copy : &work, &s, job);
    }
    for (int a = 0; a < 3; a++)
        vvi_free(s.weights[a].w);
    return st;
}

const vv_operation vvi_operation_gaussian = {
    .api = VV_OPERATION_API,
    .name = "gaussian",
    .component = "filter",
    .group = "smoothing",
    .doc = "smooth with a Gaussian, sampled at the voxels and cut off at 4 sigma; each channel separately, as stored",
    .example = "volvis gaussian head.nrrd -o smooth.nrrd --sigma 1.5mm",
    .params = &gaussian_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
    .carry = vv_carry_values,
};
