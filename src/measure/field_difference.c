#include "measure/field_difference.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include <math.h>
#include <string.h>

/* One slice along z: the numbers are summed in slice order, whoever made them. */
typedef struct slice {
    double max, squares, lo, hi;
    uint64_t n_different;
} slice;

typedef struct comparison {
    const vv_field *a, *b;
    slice *slices;
    vv_job *job;
} comparison;

static vv_status start(void **scratch_out, void *shared, int worker)
{
    const comparison *c = shared;
    const vv_field_info *info = vv_field_get_info(c->a);
    size_t bytes;
    vv_status st;
    (void)worker;
    if ((st = vvi_mul3_size(&bytes, (size_t)info->grid.dims[0], (size_t)info->components, 2 * sizeof(double))) != VV_OK)
        return st;
    *scratch_out = vvi_alloc(c->job, bytes, VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(bytes);
}

static void finish(void *scratch, void *shared)
{
    (void)shared;
    vvi_free(scratch);
}

/* Integers of 64 bits that are their own values. */
static bool is_long(const vv_field_info *info)
{
    return (info->type == VV_TYPE_I64 || info->type == VV_TYPE_U64) && info->value_scale == 1 &&
           info->value_offset == 0;
}

/* What doubles do not tell of two integers of 64 bits that are one double: their distance is small, whichever sign. */
static double distance(const char *a, const char *b)
{
    uint64_t x, y;
    memcpy(&x, a, sizeof x);
    memcpy(&y, b, sizeof y);
    return (double)(x - y < y - x ? x - y : y - x);
}

static const char *sample_at(const vv_brick *brick, int64_t j, size_t i)
{
    const size_t components = (size_t)brick->components;
    return (const char *)brick->data + j * brick->stride[1] + (int64_t)(i / components) * brick->stride[0] +
           (int64_t)(i % components * vv_type_bytes(brick->type));
}

/* beyond: how far numbers are apart that are one double. */
static void add(slice *s, double a, double b, double beyond)
{
    const double difference = isnan(a) && isnan(b) ? 0 : a == b ? beyond : fabs(a - b);
    if (isfinite(a)) {
        s->lo = fmin(s->lo, a);
        s->hi = fmax(s->hi, a);
    }
    s->n_different += difference != 0; /* NaN counts too */
    s->max = isnan(difference) ? INFINITY : fmax(s->max, difference);
    s->squares += isnan(difference) ? INFINITY : difference * difference;
}

/* A row of values: samples of one row of a brick may lie apart. */
static void read_row(double *out, const vv_brick *brick, const vv_field_info *info, int64_t j)
{
    const size_t components = (size_t)info->components, each = vv_type_bytes(brick->type);
    const char *row = (const char *)brick->data + j * brick->stride[1];
    const size_t n = (size_t)brick->box.n[0];
    if ((size_t)brick->stride[0] == each * components)
        vvi_samples_to_f64(out, row, brick->type, n * components);
    else
        for (size_t i = 0; i < n; i++)
            vvi_samples_to_f64(out + i * components, row + (int64_t)i * brick->stride[0], brick->type, components);
    for (size_t i = 0; i < n * components; i++)
        out[i] = out[i] * info->value_scale + info->value_offset;
}

static vv_status item(void *scratch, void *shared, size_t index)
{
    comparison *c = shared;
    const vv_field_info *info_a = vv_field_get_info(c->a), *info_b = vv_field_get_info(c->b);
    const size_t n = (size_t)info_a->grid.dims[0] * (size_t)info_a->components;
    const bool exact = is_long(info_a) && is_long(info_b);
    double *row_a = scratch, *row_b = row_a + n;
    vv_box box = vv_field_box(c->a);
    vv_brick a, b;
    vv_status st;
    slice s = {.lo = INFINITY, .hi = -INFINITY};
    box.lo[2] = (int64_t)index;
    box.n[2] = 1;
    if ((st = vv_field_brick(&a, c->a, &box, c->job)) != VV_OK)
        return st;
    if ((st = vv_field_brick(&b, c->b, &box, c->job)) == VV_OK) {
        for (int64_t j = 0; j < box.n[1]; j++) {
            read_row(row_a, &a, info_a, j);
            read_row(row_b, &b, info_b, j);
            for (size_t i = 0; i < n; i++) {
                const bool rounded = exact && row_a[i] == row_b[i] && fabs(row_a[i]) >= 0x1p53;
                add(&s, row_a[i], row_b[i], rounded ? distance(sample_at(&a, j, i), sample_at(&b, j, i)) : 0);
            }
        }
        vv_brick_release(&b);
    }
    vv_brick_release(&a);
    c->slices[index] = s;
    return st;
}

static void sum_up(vvi_field_difference *out, const comparison *c, size_t n)
{
    const vv_field_info *info = vv_field_get_info(c->a);
    double lo = INFINITY, hi = -INFINITY, squares = 0;
    *out = (vvi_field_difference){0};
    for (size_t i = 0; i < n; i++) {
        out->max_difference = fmax(out->max_difference, c->slices[i].max);
        out->n_different += c->slices[i].n_different;
        squares += c->slices[i].squares;
        lo = fmin(lo, c->slices[i].lo);
        hi = fmax(hi, c->slices[i].hi);
    }
    out->n_samples = (uint64_t)info->grid.dims[0] * (uint64_t)info->grid.dims[1] * (uint64_t)info->grid.dims[2] *
                     (uint64_t)info->components;
    out->rms = sqrt(squares / (double)out->n_samples);
    if (out->n_different == 0)
        out->psnr = INFINITY;
    else
        out->psnr = hi > lo && out->rms > 0 && isfinite(out->rms) ? 20 * log10((hi - lo) / out->rms) : NAN;
}

vv_status vvi_field_compare(vvi_field_difference *out, const vv_field *a, const vv_field *b, vv_job *job)
{
    static const vvi_work work = {.stage = "compare", .start = start, .item = item, .finish = finish};
    const size_t n = (size_t)vv_field_get_info(a)->grid.dims[2];
    comparison c = {.a = a, .b = b, .job = job};
    size_t bytes;
    vv_status st;
    if ((st = vvi_mul_size(&bytes, n, sizeof *c.slices)) != VV_OK)
        return st;
    c.slices = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH);
    if (!c.slices)
        return vv_fail_memory(bytes);
    if ((st = vvi_parallel_for(job, &work, &c, n)) == VV_OK)
        sum_up(out, &c, n);
    vvi_free(c.slices);
    return st;
}

double vvi_placement_difference(const vv_grid *a, const vv_grid *b)
{
    double most = 0;
    for (int corner = 0; corner < 8; corner++) {
        const vv_vec3 index = {corner & 1 ? (double)(a->dims[0] - 1) : 0, corner & 2 ? (double)(a->dims[1] - 1) : 0,
                               corner & 4 ? (double)(a->dims[2] - 1) : 0};
        const vv_vec3 p = vv_affine_point(a->index_to_world, index), q = vv_affine_point(b->index_to_world, index);
        most = fmax(most, hypot(hypot(p.x - q.x, p.y - q.y), p.z - q.z));
    }
    return most;
}
