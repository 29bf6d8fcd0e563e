#include "scene/gradient_scale.h"
#include "core/memory.h"
#include "grid/percentile.h"
#include "scene/lens.h"
#include "scene/value_walk.h"
#include <math.h>
#include <stdlib.h>

typedef struct lengths {
    double *length;
    size_t n;
} lengths;

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double high_quantile(double *length, size_t n)
{
    if (!n)
        return 0;
    qsort(length, n, sizeof *length, compare);
    const double least = length[n - 1] / 100;
    size_t first = 0;
    while (first < n && length[first] <= least)
        first++;
    if (first == n)
        return 0;
    const vvi_quantile q = vvi_quantile_at(99, n - first);
    return vvi_quantile_between(&q, length[first + q.low], length[first + q.high]);
}

static void collect(void *user, const vvi_walk *walk, const int64_t at[3])
{
    lengths *l = user;
    const double g = vvi_length(vvi_walk_gradient(walk, at));
    if (isfinite(g))
        l->length[l->n++] = g;
}

static vv_status measure(void *out, const vv_actor *actor, vv_job *job)
{
    const size_t bytes = VVI_WALK_MOST * sizeof(double);
    lengths l = {.length = vvi_alloc(job, bytes, VVI_MEM_SCRATCH)};
    if (!l.length)
        return vv_fail_memory(bytes);
    const vv_status st = vvi_walk_samples(actor, collect, &l, job);
    if (st == VV_OK)
        *(double *)out = high_quantile(l.length, l.n);
    vvi_free(l.length);
    return st;
}

vv_status vvi_gradient_scale(double *out, const vv_actor *actor, vv_job *job)
{
    *out = 0;
    return vvi_walk_once(out, sizeof *out, "gradient scale", measure, actor, job);
}
