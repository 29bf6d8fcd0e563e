#include "filter/noise.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "filter/real_samples.h"

#include <math.h>

enum { SAMPLES_MOST = 1 << 20, SLICES_MOST = 16 };
#define NORMAL 1.482602218505602 /* of a normal distribution: standard deviation over median size */

typedef struct request {
    const vv_field *field;
    int component;
} request;

typedef struct looker {
    const vv_field *field;
    const vv_field_info *info;
    int component;
    bool along[3]; /* axes with neighbours to both sides */
    int64_t stride[3];
    double *size; /* of the differences that are there */
    size_t n, most;
    double *reals; /* three slices */
} looker;

static void swap(double *a, double *b)
{
    const double t = *a;
    *a = *b;
    *b = t;
}

/* The k-th smallest (Hoare 1961). */
static double select_rank(double *v, size_t n, size_t k)
{
    size_t lo = 0, hi = n - 1;
    while (lo < hi) {
        const double pivot = v[lo + (hi - lo) / 2];
        size_t i = lo, j = hi;
        for (;; i++, j--) {
            while (v[i] < pivot)
                i++;
            while (pivot < v[j])
                j--;
            if (i >= j)
                break;
            swap(&v[i], &v[j]);
        }
        if (k <= j)
            hi = j;
        else
            lo = j + 1;
    }
    return v[k];
}

static void look_at_row(looker *l, const double *row, int64_t n)
{
    const int64_t margin = l->along[0];
    for (int64_t i = margin; i < n - margin && l->n < l->most; i++) {
        double sum = 0;
        int axes = 0;
        for (int a = 0; a < 3; a++)
            if (l->along[a]) {
                sum += 0.5 * row[i - l->stride[a]] + 0.5 * row[i + l->stride[a]];
                axes++;
            }
        const double size = fabs(row[i] - sum / axes);
        if (size > 0 && isfinite(size))
            l->size[l->n++] = size;
    }
}

/* The rows of one slice, or every so many of them. */
static vv_status look_at_slice(looker *l, int64_t k, int64_t rows_apart, vv_job *job)
{
    const int64_t *d = l->info->grid.dims, margin = l->along[2], margin_y = l->along[1];
    const vv_box box = {{0, 0, k - margin}, {d[0], d[1], 1 + 2 * margin}};
    vv_brick brick;
    vv_status st = vv_field_brick(&brick, l->field, &box, job);
    if (st != VV_OK)
        return st;
    vvi_reals_of_box(l->reals, true, &brick, &box, (int64_t[3]){0, 0, 0}, l->component);
    vv_brick_release(&brick);
    for (int64_t j = margin_y; j < d[1] - margin_y && st == VV_OK; j += rows_apart) {
        look_at_row(l, l->reals + margin * l->stride[2] + j * l->stride[1], d[0]);
        st = vvi_job_poll(job);
    }
    return st;
}

static vv_status look(double *out, looker *l, vv_job *job)
{
    const int64_t *d = l->info->grid.dims, margin = l->along[2], inner = d[2] - 2 * margin;
    const int64_t slices = inner < SLICES_MOST ? inner : SLICES_MOST, all = slices * d[0] * d[1];
    int axes = 0;
    vv_status st = VV_OK;
    for (int a = 0; a < 3; a++)
        axes += l->along[a];
    for (int64_t s = 0; s < slices && st == VV_OK && axes > 0; s++)
        st = look_at_slice(l, margin + (2 * s + 1) * inner / (2 * slices), 1 + all / SAMPLES_MOST, job);
    *out = 0;
    if (st == VV_OK && l->n > 0)
        *out = NORMAL * select_rank(l->size, l->n, l->n / 2) * sqrt(2.0 * axes / (2 * axes + 1));
    return st;
}

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    looker l = {.field = r->field, .info = vv_field_get_info(r->field), .component = r->component};
    const int64_t *d = l.info->grid.dims;
    for (int a = 0; a < 3; a++)
        l.along[a] = d[a] > 2;
    l.stride[0] = 1, l.stride[1] = d[0], l.stride[2] = d[0] * d[1];
    l.most = (size_t)SAMPLES_MOST + SLICES_MOST * (size_t)d[0];
    const size_t bytes = (size_t)l.stride[2] * (l.along[2] ? 3 : 1) * sizeof(double);
    double *value = vvi_alloc(job, sizeof *value, VVI_MEM_DERIVED);
    l.size = vvi_alloc(job, l.most * sizeof(double), VVI_MEM_SCRATCH);
    l.reals = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    vv_status st = value && l.size && l.reals ? look(value, &l, job) : vv_fail_memory(bytes);
    vvi_free(l.size);
    vvi_free(l.reals);
    if (st != VV_OK) {
        vvi_free(value);
        return st;
    }
    vvi_log(job, VV_LOG_INFO, "filter", "noise of channel %d: a standard deviation of %.6g", r->component,
            *value * fabs(l.info->value_scale));
    *value_out = value;
    *bytes_out = sizeof *value;
    return VV_OK;
}

vv_status vvi_noise(double *out, const vv_field *field, int component, vv_job *job)
{
    request r = {field, component};
    const vvi_cache_key key = {"noise", vv_field_identity(field), (uint64_t)component};
    vvi_cached *cached;
    const vv_status st = vvi_cache_get(&cached, &key, make, vvi_free, &r, job);
    if (st != VV_OK)
        return st;
    *out = *(const double *)vvi_cached_value(cached);
    vvi_cache_release(cached);
    return VV_OK;
}
