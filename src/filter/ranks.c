#include "filter/ranks.h"
#include "core/cache.h"
#include "core/memory.h"
#include "grid/statistics.h"
#include "grid/value_pass.h"

#include <math.h>

double vvi_line_at(double x, const double *xs, const double *ys, size_t n)
{
    size_t lo = 0, hi = n - 1;
    if (x <= xs[0])
        return ys[0];
    if (x >= xs[hi])
        return ys[hi];
    while (hi - lo > 1) {
        const size_t middle = lo + (hi - lo) / 2;
        if (xs[middle] >= x)
            hi = middle;
        else
            lo = middle;
    }
    return x == xs[hi] ? ys[hi] : ys[lo] + (ys[hi] - ys[lo]) * ((x - xs[lo]) / (xs[hi] - xs[lo]));
}

typedef struct request {
    const vv_field *field;
    int component;
} request;

static vvi_bins bins_of(const vv_statistics *s, const vv_field_info *info, bool *whole)
{
    double a = (s->min - info->value_offset) / info->value_scale, b = (s->max - info->value_offset) / info->value_scale;
    const double lo = fmin(a, b), hi = fmax(a, b);
    *whole = !vv_type_is_float(info->type) && rint(hi) - rint(lo) < VVI_BINS_MOST;
    if (*whole)
        return (vvi_bins){rint(lo) - 0.5, rint(hi) + 0.5, (int)(rint(hi) - rint(lo)) + 1};
    return (vvi_bins){lo, hi, lo < hi ? VVI_BINS_MOST : 1};
}

/* Without room for them they are counted alone. */
static void put(vvi_ranks *r, double at, double up_to)
{
    if (r->at) {
        r->at[r->n] = at;
        r->up_to[r->n] = up_to;
    }
    r->n++;
}

/* Empty bins have no points, but the lower end of the next one has. */
static void find_points(vvi_ranks *r, const vvi_bin_counts *counts, const vvi_bins *bins, bool whole)
{
    double below = 0;
    bool empty = true;
    for (int b = 0; b < bins->n; b++) {
        const double here = (double)vvi_bin_counts_get(counts, b), width = (bins->hi - bins->lo) / bins->n;
        if (here > 0 && whole)
            put(r, rint(bins->lo + 0.5) + b, below + here);
        if (here > 0 && !whole && empty)
            put(r, bins->lo + b * width, below);
        if (here > 0 && !whole)
            put(r, b + 1 == bins->n ? bins->hi : bins->lo + (b + 1) * width, below + here);
        empty = here == 0;
        below += here;
    }
}

static vv_status make_points(vvi_ranks **out, uint64_t *bytes_out, const vvi_bin_counts *counts, const vvi_bins *bins,
                             bool whole, vv_job *job)
{
    vvi_ranks none = {0};
    if (counts)
        find_points(&none, counts, bins, whole);
    const size_t bytes = sizeof(vvi_ranks) + 2 * none.n * sizeof(double);
    vvi_ranks *r = vvi_alloc(job, bytes, VVI_MEM_DERIVED);
    if (!r)
        return vv_fail_memory(bytes);
    *r = (vvi_ranks){0, (double *)(void *)(r + 1), (double *)(void *)(r + 1) + none.n};
    if (counts)
        find_points(r, counts, bins, whole);
    *out = r;
    *bytes_out = bytes;
    return VV_OK;
}

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *q = user;
    vv_statistics s;
    vvi_bin_counts counts = {0};
    bool whole;
    vvi_ranks *r = NULL;
    vv_status st = vv_field_statistics(&s, q->field, q->component, job);
    if (st != VV_OK)
        return st;
    const vvi_bins bins = bins_of(&s, vv_field_get_info(q->field), &whole);
    if (s.count > 0 && (st = vvi_bin_counts_begin(&counts, &bins, job)) == VV_OK) {
        const vvi_pass pass = vvi_bin_counts_pass(&counts);
        st = vvi_pass_run(&pass, q->field, q->component, job);
    }
    if (st == VV_OK)
        st = make_points(&r, bytes_out, s.count > 0 ? &counts : NULL, &bins, whole, job);
    vvi_bin_counts_end(&counts);
    *value_out = r;
    return st;
}

vv_status vvi_ranks_of(vvi_ranks *out, void **held, const vv_field *field, int component, vv_job *job)
{
    request q = {field, component};
    const vvi_cache_key key = {"ranks", vv_field_identity(field), (uint64_t)component};
    vvi_cached *cached;
    *held = NULL;
    const vv_status st = vvi_cache_get(&cached, &key, make, vvi_free, &q, job);
    if (st != VV_OK)
        return st;
    *out = *(const vvi_ranks *)vvi_cached_value(cached);
    *held = cached;
    return VV_OK;
}

void vvi_ranks_release(void *held)
{
    if (held)
        vvi_cache_release(held);
}
