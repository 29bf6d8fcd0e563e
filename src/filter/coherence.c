#include "filter/coherence.h"
#include "core/memory.h"
#include "core/symmetric.h"
#include "core/vec.h"
#include "filter/real_samples.h"
#include "filter/smoothed_samples.h"
#include "grid/slabs.h"
#include "registry.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define ITEM_SAMPLES 4096
#define BLOCK_LEAST ((int64_t)4096)
#define BLOCK_MOST ((int64_t)1 << 18)
enum { TENSORS = VVI_SYMMETRIC };

/* By index axes: rows of the inverse of the grid's map, in units of the smallest spacing. 0 along axes of one sample.
 */
static void find_rows(vv_vec3 row[3], const vv_grid *grid)
{
    const double voxel = vv_grid_voxel(grid);
    vv_affine inverse = vv_affine_identity();
    vv_affine_invert(&inverse, grid->index_to_world);
    const vv_vec3 *c = inverse.axis;
    row[0] = vvi_scaled(vvi_vec(c[0].x, c[1].x, c[2].x), voxel);
    row[1] = vvi_scaled(vvi_vec(c[0].y, c[1].y, c[2].y), voxel);
    row[2] = vvi_scaled(vvi_vec(c[0].z, c[1].z, c[2].z), voxel);
    for (int a = 0; a < 3; a++)
        if (grid->dims[a] == 1)
            row[a] = vvi_vec(0, 0, 0);
}

double vvi_coherence_rate(const vv_grid *grid)
{
    vv_vec3 row[3];
    double sum = 0;
    find_rows(row, grid);
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
            const double d = fabs(vvi_dot(row[a], row[b]));
            sum += a == b || d > 1e-12 * vvi_length(row[a]) * vvi_length(row[b]) ? d : 0;
        }
    return sum;
}

static size_t samples_of(const vv_field_info *info)
{
    return (size_t)(info->grid.dims[0] * info->grid.dims[1] * info->grid.dims[2]);
}

static int64_t block_samples(const vv_field_info *info)
{
    const int64_t share = (int64_t)(samples_of(info) / 16);
    return share < BLOCK_LEAST ? BLOCK_LEAST : share > BLOCK_MOST ? BLOCK_MOST : share;
}

/* Numbers before and behind a step, three slopes, six entries of the tensor, one of them before and behind smoothing.
 */
static size_t each_bytes(const vv_field_info *info)
{
    return 2 * vvi_reals_bytes(vvi_reals_wide(info->type)) + (3 + TENSORS + 2) * sizeof(float);
}

uint64_t vvi_coherence_memory(const vv_field_info *info)
{
    return (uint64_t)samples_of(info) * each_bytes(info);
}

vv_status vvi_coherence_plan(const vv_field_info *info, vv_job *job)
{
    size_t bytes;
    const vv_status st = vvi_mul_size(&bytes, samples_of(info), each_bytes(info));
    return st == VV_OK ? vvi_memory_plan(job, bytes, "diffuse") : st;
}

typedef struct shared {
    const vvi_coherence *c;
    const vv_field_info *info;
    vv_field *numbers[2]; /* of one component, as stored; of the step before, and of this one */
    void *data[2];
    bool wide;
    vvi_slabs slabs, blocks; /* blocks: of the step, of several slices where there is work for all threads */
    vv_vec3 row[3], normal;  /* of the plane, where there are two axes */
    int axes;
    double voxel;
    vv_brick samples; /* of the input */
    vv_brick slopes, smooth;
    int entry;               /* of the tensor, that is made */
    float *product, *tensor; /* one entry; all, by entry, and then the diffusion's, by index axes */
    char *out;
    int component;
    vv_job *job;
} shared;

static int64_t at_of(const shared *s, int64_t i, int64_t j, int64_t k)
{
    const int64_t *n = s->info->grid.dims;
    return (k * n[1] + j) * n[0] + i;
}

/* Items of each pass are boxes of the volume, row by row. */
typedef void take_row(const shared *s, int64_t i, int64_t j, int64_t k, int64_t n);

static vv_status rows(const shared *s, size_t index, take_row *take)
{
    const vv_box box = vvi_slabs_item(&s->slabs, index);
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++)
            take(s, box.lo[0], box.lo[1] + j, box.lo[2] + k, box.n[0]);
    return vvi_job_poll(s->job);
}

static vv_status pass(shared *s, vv_status (*item)(void *scratch, void *user, size_t index))
{
    const vvi_work work = {.item = item};
    return vvi_parallel_for(s->job, &work, s, s->slabs.n);
}

/* Numbers in and out ---------------------------------------------------------------------------------------------- */

static char *number_at(const shared *s, int which, int64_t at)
{
    return (char *)s->data[which] + (size_t)at * vvi_reals_bytes(s->wide);
}

static void load_row(const shared *s, int64_t i, int64_t j, int64_t k, int64_t n)
{
    const vv_brick *b = &s->samples;
    const char *in = (const char *)b->data + i * b->stride[0] + j * b->stride[1] + k * b->stride[2] +
                     s->component * (int64_t)vv_type_bytes(b->type);
    vvi_reals_of_samples(number_at(s, 0, at_of(s, i, j, k)), s->wide, in, b->stride[0], b->type, n);
}

static vv_status load_item(void *scratch, void *user, size_t index)
{
    return rows(user, index, load_row);
}

static void store_row(const shared *s, int64_t i, int64_t j, int64_t k, int64_t n)
{
    const int64_t each = (int64_t)vv_type_bytes(s->info->type), step = each * s->info->components;
    const int64_t at = at_of(s, i, j, k);
    vvi_samples_of_reals(s->out + at * step + s->component * each, step, s->info->type, number_at(s, 0, at), s->wide,
                         n);
}

static vv_status store_item(void *scratch, void *user, size_t index)
{
    return rows(user, index, store_row);
}

/* Tensors --------------------------------------------------------------------------------------------------------- */

static void product_row(const shared *s, int64_t i, int64_t j, int64_t k, int64_t n)
{
    static const int first[TENSORS] = {0, 1, 2, 0, 0, 1}, other[TENSORS] = {0, 1, 2, 1, 2, 2};
    const vv_brick *b = &s->slopes;
    const float *slope =
        (const float *)(const void *)((const char *)b->data + i * b->stride[0] + j * b->stride[1] + k * b->stride[2]);
    float *out = s->product + at_of(s, i, j, k);
    const float scale = (float)s->voxel;
    for (int64_t x = 0; x < n; x++)
        out[x] = scale * slope[3 * x + first[s->entry]] * (scale * slope[3 * x + other[s->entry]]);
}

static vv_status product_item(void *scratch, void *user, size_t index)
{
    return rows(user, index, product_row);
}

static void keep_row(const shared *s, int64_t i, int64_t j, int64_t k, int64_t n)
{
    const vv_brick *b = &s->smooth;
    const int64_t at = at_of(s, i, j, k);
    const char *row = (const char *)b->data + i * b->stride[0] + j * b->stride[1] + k * b->stride[2];
    memcpy(s->tensor + (size_t)s->entry * samples_of(s->info) + at, row, (size_t)n * sizeof(float));
}

static vv_status keep_item(void *scratch, void *user, size_t index)
{
    return rows(user, index, keep_row);
}

/* One entry of the structure tensor. */
static vv_status make_entry(shared *s, vv_field *product)
{
    const vv_box all = vv_field_box(product);
    vv_field *smooth = NULL;
    vv_status st = pass(s, product_item);
    if (st == VV_OK)
        st = vvi_smoothed(&smooth, product, &all, s->c->rho, s->job);
    if (st == VV_OK && (st = vv_field_brick(&s->smooth, smooth, &all, s->job)) == VV_OK)
        st = pass(s, keep_item);
    vv_brick_release(&s->smooth);
    vv_field_release(smooth);
    return st;
}

/* Products of slopes are made from slopes of the world, of a box that is all. */
static vv_status make_slopes(vv_field **out, const shared *s)
{
    const vv_property_context context = {.length_unit = s->info->grid.unit, .voxel = s->voxel};
    const vv_field *in = s->numbers[0];
    const vv_box all = vv_field_box(in);
    vv_object *params = NULL;
    char sigma[32];
    *out = NULL;
    snprintf(sigma, sizeof sigma, "%.17g", s->c->sigma);
    vv_status st = vv_object_new(&params, vvi_operation_gradient.params, &context);
    if (st == VV_OK && (st = vv_path_set(&params, "sigma", sigma, &context)) == VV_OK &&
        (st = vv_path_set(&params, "vector", "true", &context)) == VV_OK)
        st = vvi_operation_gradient.run_box(out, &in, 1, params, &all, s->job);
    vv_object_release(params);
    return st;
}

static vv_status make_structure(shared *s)
{
    vv_field_info info = *vv_field_get_info(s->numbers[0]);
    vv_field *slopes = NULL, *product = NULL;
    const vv_box all = vv_field_box(s->numbers[0]);
    void *data;
    info.type = VV_TYPE_F32;
    vv_status st = make_slopes(&slopes, s);
    if (st == VV_OK && (st = vv_field_brick(&s->slopes, slopes, &all, s->job)) == VV_OK &&
        (st = vv_field_new_empty(&product, &data, &info, s->job)) == VV_OK) {
        s->product = data;
        for (s->entry = 0; s->entry < TENSORS && st == VV_OK; s->entry++)
            st = make_entry(s, product);
    }
    vv_brick_release(&s->slopes);
    vv_field_release(slopes);
    vv_field_release(product);
    return st;
}

/* Which way a structure goes, and how much its eigenvalues differ: of a plane, in it. */
static double find_direction(vv_vec3 *along, const double m[TENSORS], const shared *s)
{
    double v[3];
    vv_vec3 vector[3];
    vvi_symmetric_eigen(v, vector, m);
    *along = vector[0];
    if (s->axes == 3)
        return (v[0] - v[1]) * (v[0] - v[1]) + (v[1] - v[2]) * (v[1] - v[2]) + (v[2] - v[0]) * (v[2] - v[0]);
    if (s->axes < 2)
        return v[0] * 0;
    *along = vvi_cross(s->normal, vector[2]);
    const double x = along->x, y = along->y, z = along->z;
    const double own = m[VVI_XX] * x * x + m[VVI_YY] * y * y + m[VVI_ZZ] * z * z +
                       2 * (m[VVI_XY] * x * y + m[VVI_XZ] * x * z + m[VVI_YZ] * y * z);
    return (v[2] - own) * (v[2] - own);
}

/* Of a structure, the diffusion by index axes; none where it is not known. */
static void diffusion_of(double d[TENSORS], const double m[TENSORS], const shared *s)
{
    static const int first[TENSORS] = {0, 1, 2, 0, 0, 1}, other[TENSORS] = {0, 1, 2, 1, 2, 2};
    const double alpha = s->c->alpha, least = pow(s->c->edge, 4);
    vv_vec3 v;
    const double coherence = find_direction(&v, m, s);
    const double more = coherence > 0 ? (1 - alpha) * exp(-least / coherence) : 0;
    for (int e = 0; e < TENSORS; e++) {
        const vv_vec3 a = s->row[first[e]], b = s->row[other[e]];
        d[e] = isnan(coherence) ? 0 : alpha * vvi_dot(a, b) + more * vvi_dot(a, v) * vvi_dot(b, v);
    }
}

static void diffusion_row(const shared *s, int64_t i, int64_t j, int64_t k, int64_t n)
{
    const size_t all = samples_of(s->info);
    float *at = s->tensor + at_of(s, i, j, k);
    for (int64_t x = 0; x < n; x++) {
        double m[TENSORS], d[TENSORS];
        for (int e = 0; e < TENSORS; e++)
            m[e] = at[(size_t)e * all + (size_t)x];
        diffusion_of(d, m, s);
        for (int e = 0; e < TENSORS; e++)
            at[(size_t)e * all + (size_t)x] = (float)d[e];
    }
}

static vv_status diffusion_item(void *scratch, void *user, size_t index)
{
    return rows(user, index, diffusion_row);
}

/* Steps ----------------------------------------------------------------------------------------------------------- */

static double number(const shared *s, int64_t at)
{
    return s->wide ? ((const double *)s->data[0])[at] : (double)((const float *)s->data[0])[at];
}

/* A neighbour's number; what is missing, or beyond the border, is what is here. */
static double beside(const shared *s, int64_t at, int64_t step, bool inside)
{
    const double here = number(s, at), there = inside ? number(s, at + step) : here;
    return isfinite(there) ? there : here;
}

/* What flows from a sample to the next along an axis, which is there. */
static double flux(const shared *s, const int64_t p[3], int axis)
{
    static const int entry[3][3] = {{VVI_XX, VVI_XY, VVI_XZ}, {VVI_XY, VVI_YY, VVI_YZ}, {VVI_XZ, VVI_YZ, VVI_ZZ}};
    const int64_t *n = s->info->grid.dims, stride[3] = {1, n[0], n[0] * n[1]};
    const int64_t at = at_of(s, p[0], p[1], p[2]), next = at + stride[axis];
    const size_t all = samples_of(s->info);
    const double here = number(s, at), there = number(s, next);
    double sum = 0;
    if (!isfinite(here) || !isfinite(there))
        return 0;
    for (int b = 0; b < 3; b++) {
        const float *d = s->tensor + (size_t)entry[axis][b] * all;
        const double flows = 0.5 * ((double)d[at] + (double)d[next]);
        const bool low = p[b] > 0, high = p[b] + 1 < n[b];
        if (b == axis)
            sum += flows * (there - here);
        else
            sum += flows * 0.25 *
                   ((beside(s, at, stride[b], high) - beside(s, at, -stride[b], low)) +
                    (beside(s, next, stride[b], high) - beside(s, next, -stride[b], low)));
    }
    return sum;
}

/* Into a sample from the one before it. */
static double influx(const shared *s, const int64_t p[3], int axis)
{
    int64_t before[3] = {p[0], p[1], p[2]};
    before[axis]--;
    return before[axis] >= 0 ? flux(s, before, axis) : 0;
}

static void step_sample(const shared *s, const int64_t p[3], const double in[3], double out[3])
{
    const int64_t at = at_of(s, p[0], p[1], p[2]);
    double sum = 0;
    for (int a = 0; a < 3; a++) {
        out[a] = p[a] + 1 < s->info->grid.dims[a] ? flux(s, p, a) : 0;
        sum += out[a] - in[a];
    }
    const double v = number(s, at) + s->c->step * sum;
    if (s->wide)
        ((double *)s->data[1])[at] = v;
    else
        ((float *)s->data[1])[at] = (float)v;
}

/* What flows out of a sample flows into the next: in a block it is worked out once. `into` has what flows into the next
 * row and, behind that, into the next slice. */
static void step_row(const shared *s, const vv_box *box, int64_t j, int64_t k, double *into)
{
    double *row = into, *slice = into + box->n[0] * (1 + j), in[3], out[3] = {0};
    for (int64_t x = 0; x < box->n[0]; x++) {
        const int64_t p[3] = {box->lo[0] + x, box->lo[1] + j, box->lo[2] + k};
        in[0] = x > 0 ? out[0] : influx(s, p, 0);
        in[1] = j > 0 ? row[x] : influx(s, p, 1);
        in[2] = k > 0 ? slice[x] : influx(s, p, 2);
        step_sample(s, p, in, out);
        row[x] = out[1];
        slice[x] = out[2];
    }
}

static vv_status step_item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->blocks, index);
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++)
            step_row(s, &box, j, k, scratch);
    return vvi_job_poll(s->job);
}

static vv_status start_block(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const size_t bytes = (size_t)(s->blocks.step[0] * (1 + s->blocks.step[1])) * sizeof(double);
    *scratch_out = vvi_alloc(s->job, bytes, VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(bytes);
}

static void finish_block(void *scratch, void *user)
{
    vvi_free(scratch);
}

static vv_status step_all(shared *s)
{
    const vvi_work work = {.start = start_block, .item = step_item, .finish = finish_block};
    return vvi_parallel_for(s->job, &work, s, s->blocks.n);
}

static void swap(shared *s)
{
    vv_field *const field = s->numbers[0];
    void *const data = s->data[0];
    s->numbers[0] = s->numbers[1];
    s->numbers[1] = field;
    s->data[0] = s->data[1];
    s->data[1] = data;
}

static vv_status steps(shared *s)
{
    vv_status st = pass(s, load_item);
    for (int64_t i = 0; i < s->c->iterations && st == VV_OK; i++) {
        st = vvi_job_progress(s->job, "diffuse", (uint64_t)i, (uint64_t)s->c->iterations);
        vvi_job_hush(s->job, 1);
        if (st == VV_OK && (st = make_structure(s)) == VV_OK && (st = pass(s, diffusion_item)) == VV_OK)
            st = step_all(s);
        vvi_job_hush(s->job, -1);
        swap(s);
    }
    if (st == VV_OK)
        st = vvi_job_progress(s->job, "diffuse", (uint64_t)s->c->iterations, (uint64_t)s->c->iterations);
    return st == VV_OK ? pass(s, store_item) : st;
}

vv_status vvi_coherence_run(void *out, const vv_field *in, int component, const vvi_coherence *c, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(in);
    const vv_box all = vv_field_box(in);
    shared s = {.c = c,
                .info = info,
                .wide = vvi_reals_wide(info->type),
                .voxel = vv_grid_voxel(&info->grid),
                .slabs = vvi_slabs_of(&all, ITEM_SAMPLES),
                .blocks = vvi_slabs_of(&all, block_samples(info)),
                .out = out,
                .component = component,
                .job = job};
    vv_field_info one = *info;
    const size_t bytes = TENSORS * samples_of(info) * sizeof(float);
    one.type = s.wide ? VV_TYPE_F64 : VV_TYPE_F32;
    one.components = 1;
    one.meaning = VV_MEANING_SCALAR;
    one.value_scale = 1;
    one.value_offset = 0;
    find_rows(s.row, &info->grid);
    for (int a = 0; a < 3; a++) {
        s.axes += info->grid.dims[a] > 1;
        s.normal = vvi_add(s.normal, vvi_cross(s.row[a], s.row[(a + 1) % 3])); /* one of them is not 0 in a plane */
    }
    vvi_unit(&s.normal);
    vv_status st = VV_OK;
    for (int i = 0; i < 2 && st == VV_OK; i++)
        st = vv_field_new_empty(&s.numbers[i], &s.data[i], &one, job);
    if (st == VV_OK && !(s.tensor = vvi_alloc(job, bytes, VVI_MEM_SCRATCH)))
        st = vv_fail_memory(bytes);
    if (st == VV_OK && (st = vv_field_brick(&s.samples, in, &all, job)) == VV_OK)
        st = steps(&s);
    vv_brick_release(&s.samples);
    vv_field_release(s.numbers[0]);
    vv_field_release(s.numbers[1]);
    vvi_free(s.tensor);
    return st;
}
