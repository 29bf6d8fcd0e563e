/* Gaussian smoothing, separable: x and y slice by slice, then z plane by plane.
 *
 * Samples that are not finite count as missing: they stay what they are, and their neighbours are the mean of what is
 * there (normalised convolution, Knutsson & Westin 1993): smoothed samples over the smoothed mask. */
#include "core/job.h"
#include "core/memory.h"
#include "filter/gaussian_lines.h"
#include "filter/sigma.h"
#include "registry.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

#define CUT 4.0           /* sigmas that the kernel reaches: 6e-5 of its weight lies beyond */
#define SIGMA_MOST 1024.0 /* voxels: beyond, the work of one row is no longer done within the time to cancel */

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

typedef struct shared {
    const vv_field *in;
    const vv_field_info *info;
    char *out;
    char *part[2]; /* x and y done: samples, mask (NULL while all are finite) */
    bool wide;     /* numbers are doubles */
    vvi_gaussian_source source;
    vvi_gaussian_weights weights[3];
    _Atomic bool odd;
    int64_t row, plane; /* numbers */
    vv_job *job;
} shared;

static size_t number_bytes(const shared *s)
{
    return s->wide ? sizeof(double) : sizeof(float);
}

static vv_status start_slices(void **scratch_out, void *user, int worker)
{
    (void)worker;
    const shared *s = user;
    const int64_t *d = s->info->grid.dims;
    const size_t bytes = vvi_gaussian_slice_room(d[0], d[1], s->info->components, &s->weights[0]) * number_bytes(s);
    *scratch_out = vvi_alloc(s->job, bytes, VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(bytes);
}

static void finish_any(void *scratch, void *user)
{
    (void)user;
    vvi_free(scratch);
}

static vv_status slice_item(void *scratch, void *user, size_t index)
{
    shared *s = user;
    const int64_t *d = s->info->grid.dims;
    const vv_box box = {{0, 0, (int64_t)index}, {d[0], d[1], 1}};
    char *out = s->part[s->source] + index * (size_t)s->plane * number_bytes(s);
    bool odd = false;
    vv_brick brick;
    vv_status st = vv_field_brick(&brick, s->in, &box, s->job);
    if (st != VV_OK)
        return st;
    if (s->wide)
        st = vvi_gaussian_slice_f64((double *)(void *)out, &odd, scratch, &brick, s->source, &s->weights[0],
                                    &s->weights[1], s->job);
    else
        st = vvi_gaussian_slice_f32((float *)(void *)out, &odd, scratch, &brick, s->source, &s->weights[0],
                                    &s->weights[1], s->job);
    vv_brick_release(&brick);
    if (odd)
        atomic_store_explicit(&s->odd, true, memory_order_relaxed);
    return st;
}

/* Planes of constant y: the samples, the mask and one row of either result. */
static vv_status start_planes(void **scratch_out, void *user, int worker)
{
    (void)worker;
    const shared *s = user;
    const size_t numbers = (size_t)(s->row * (s->info->grid.dims[2] * (s->part[1] ? 2 : 1) + 2));
    *scratch_out = vvi_alloc(s->job, numbers * number_bytes(s), VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(numbers * number_bytes(s));
}

static void gather_plane(char *out, const char *part, const shared *s, size_t j)
{
    const size_t row = (size_t)s->row * number_bytes(s), plane = (size_t)s->plane * number_bytes(s);
    for (int64_t k = 0; k < s->info->grid.dims[2]; k++)
        memcpy(out + (size_t)k * row, part + (size_t)k * plane + j * row, row);
}

static void smooth_row(char *out, const char *plane, int64_t k, const shared *s)
{
    const int64_t n = s->info->grid.dims[2];
    if (s->wide)
        vvi_gaussian_row_f64((double *)(void *)out, (const double *)(const void *)plane, k, n, s->row, s->row,
                             &s->weights[2]);
    else
        vvi_gaussian_row_f32((float *)(void *)out, (const float *)(const void *)plane, k, n, s->row, s->row,
                             &s->weights[2]);
}

#define RUN 1024

static double number_at(const char *row, int64_t i, bool wide)
{
    return wide ? ((const double *)(const void *)row)[i] : (double)((const float *)(const void *)row)[i];
}

static void store_row(char *out, const char *row, const char *mask, const shared *s)
{
    const size_t each = vv_type_bytes(s->info->type);
    double run[RUN];
    for (int64_t at = 0; at < s->row; at += RUN) {
        const int64_t now = s->row - at < RUN ? s->row - at : RUN;
        for (int64_t i = 0; i < now; i++) {
            const double v = number_at(row, at + i, s->wide);
            run[i] = mask ? v / number_at(mask, at + i, s->wide) : v;
        }
        vvi_samples_from_f64(out + (size_t)at * each, run, s->info->type, (size_t)now);
    }
}

/* Missing samples stay as they were. */
static vv_status restore_row(char *out, int64_t j, int64_t k, const shared *s)
{
    const vv_box box = {{0, j, k}, {s->info->grid.dims[0], 1, 1}};
    const size_t each = vv_type_bytes(s->info->type);
    vv_brick brick;
    const vv_status st = vv_field_brick(&brick, s->in, &box, s->job);
    if (st != VV_OK)
        return st;
    for (int64_t i = 0; i < s->row; i++) {
        double v;
        const char *in = (const char *)brick.data + (size_t)i * each;
        vvi_samples_to_f64(&v, in, s->info->type, 1);
        if (!isfinite(v))
            memcpy(out + (size_t)i * each, in, each);
    }
    vv_brick_release(&brick);
    return VV_OK;
}

static vv_status plane_item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const int64_t nz = s->info->grid.dims[2], j = (int64_t)index;
    const size_t row = (size_t)s->row * number_bytes(s);
    char *result = scratch, *mask_result = result + row, *plane = mask_result + row;
    char *mask_plane = plane + (size_t)nz * row;
    gather_plane(plane, s->part[0], s, index);
    if (s->part[1])
        gather_plane(mask_plane, s->part[1], s, index);
    vv_status st = VV_OK;
    for (int64_t k = 0; k < nz && st == VV_OK; k++) {
        char *out = s->out + (size_t)(k * s->plane + j * s->row) * vv_type_bytes(s->info->type);
        smooth_row(result, plane, k, s);
        if (s->part[1])
            smooth_row(mask_result, mask_plane, k, s);
        store_row(out, result, s->part[1] ? mask_result : NULL, s);
        if (s->part[1])
            st = restore_row(out, j, k, s);
        if (st == VV_OK)
            st = vvi_job_poll(s->job);
    }
    return st;
}

/* Floats and doubles have their x and y done in place of the result; others need numbers beside it. */
static bool in_place(const shared *s)
{
    return vv_type_is_float(s->info->type);
}

static vv_status smooth(shared *s)
{
    static const vvi_work slices = {
        .stage = "smooth x, y", .start = start_slices, .item = slice_item, .finish = finish_any};
    static const vvi_work mask = {
        .stage = "smooth mask", .start = start_slices, .item = slice_item, .finish = finish_any};
    static const vvi_work planes = {
        .stage = "smooth z", .start = start_planes, .item = plane_item, .finish = finish_any};
    const int64_t *d = s->info->grid.dims;
    const size_t bytes = (size_t)(s->plane * d[2]) * number_bytes(s);
    vv_status st = VV_OK;
    s->part[0] = in_place(s) ? s->out : vvi_alloc(s->job, bytes, VVI_MEM_SCRATCH);
    if (!s->part[0])
        return vv_fail_memory(bytes);
    if ((st = vvi_parallel_for(s->job, &slices, s, (size_t)d[2])) != VV_OK)
        return st;
    if (atomic_load(&s->odd)) {
        s->source = VVI_GAUSSIAN_MASK;
        s->part[1] = vvi_alloc(s->job, bytes, VVI_MEM_SCRATCH);
        if (!s->part[1])
            return vv_fail_memory(bytes);
        if ((st = vvi_parallel_for(s->job, &mask, s, (size_t)d[2])) != VV_OK)
            return st;
    }
    return vvi_parallel_for(s->job, &planes, s, (size_t)d[1]);
}

static bool needs_double(vv_type type)
{
    return type != VV_TYPE_F32 && vv_type_bytes(type) > 2;
}

static vv_status run_smooth(vv_field *field, void *data, const vv_field *in, const double sigma[3], vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    shared s = {.in = in, .info = info, .out = data, .wide = needs_double(info->type), .job = job};
    s.row = info->grid.dims[0] * info->components;
    s.plane = s.row * info->grid.dims[1];
    vv_status st = VV_OK;
    for (int a = 0; a < 3 && st == VV_OK; a++)
        st = make_weights(&s.weights[a], sigma[a], job);
    if (st == VV_OK)
        st = smooth(&s);
    if (st == VV_OK)
        st = vv_field_health(in);
    if (!in_place(&s))
        vvi_free(s.part[0]);
    vvi_free(s.part[1]);
    for (int a = 0; a < 3; a++)
        vvi_free(s.weights[a].w);
    return st;
}

/* Rows of a box of whole numbers from one field to a new one. */
static vv_status cut_out(vv_field **out, const vv_field *field, const vv_box *box, vv_job *job)
{
    vv_field_info info = *vv_field_get_info(field);
    vv_brick brick;
    void *data;
    info.grid = vv_grid_crop(&info.grid, box);
    vv_status st = vv_field_brick(&brick, field, box, job);
    if (st != VV_OK || (st = vv_field_new_empty(out, &data, &info, job)) != VV_OK) {
        vv_brick_release(&brick);
        return st;
    }
    const size_t row = (size_t)box->n[0] * vv_type_bytes(info.type) * (size_t)info.components;
    char *to = data;
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++, to += row)
            memcpy(to, (const char *)brick.data + j * brick.stride[1] + k * brick.stride[2], row);
    vv_brick_release(&brick);
    return VV_OK;
}

/* Whole slices of the box, and those beside it that the kernel reaches: what is further away has no weight. Where some
 * samples are missing, a box without any may differ from the whole in the last bit: it is divided by no mask. */
static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    (void)n_inputs;
    const vv_field_info *from = vv_field_get_info(inputs[0]);
    const int64_t *d = from->grid.dims;
    double sigma[3] = {0};
    *out = NULL;
    vv_status st = sigmas_of(sigma, from, params);
    if (st != VV_OK)
        return st;
    const int64_t reach = (int64_t)floor(CUT * sigma[2] + 0.5), end = box->lo[2] + box->n[2];
    const int64_t lo = box->lo[2] > reach ? box->lo[2] - reach : 0, hi = end < d[2] - reach ? end + reach : d[2];
    const bool same = sigma[0] == 0 && sigma[1] == 0 && sigma[2] == 0;
    vv_field *part = NULL, *smooth = NULL;
    void *data;
    if ((st = vvi_field_slices(&part, inputs[0], lo, hi - lo, job)) != VV_OK)
        return st;
    if (same)
        smooth = vv_field_retain(part);
    else if ((st = vv_field_new_empty(&smooth, &data, vv_field_get_info(part), job)) == VV_OK)
        st = run_smooth(smooth, data, part, sigma, job);
    const vv_box wanted = {{box->lo[0], box->lo[1], box->lo[2] - lo}, {box->n[0], box->n[1], box->n[2]}};
    const bool whole = box->n[0] == d[0] && box->n[1] == d[1] && box->n[2] == hi - lo;
    if (st == VV_OK && whole) {
        *out = smooth;
        smooth = NULL;
    } else if (st == VV_OK) {
        st = cut_out(out, smooth, &wanted, job);
    }
    vv_field_release(smooth);
    vv_field_release(part);
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
