#include "render/common/minmax_spread.h"
#include "core/memory.h"
#include <string.h>

/* A line of `n` blocks, `stride` apart: to[i] = the least (sign 1) or largest (sign -1) of from[i - reach .. i +
 * reach]. */
static void spread_line(float *restrict to, const float *restrict from, int32_t n, size_t stride, int32_t reach,
                        float sign)
{
    for (int32_t i = 0; i < n; i++) {
        const int32_t first = i < reach ? 0 : i - reach, last = i + reach < n ? i + reach : n - 1;
        float best = from[(size_t)first * stride] * sign;
        for (int32_t k = first + 1; k <= last; k++) {
            const float v = from[(size_t)k * stride] * sign;
            best = v < best ? v : best;
        }
        to[(size_t)i * stride] = best * sign;
    }
}

static void spread_axis(float *to, const float *from, const int32_t n[3], int axis, int32_t reach, float sign)
{
    const size_t stride[3] = {1, (size_t)n[0], (size_t)n[0] * (size_t)n[1]};
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int32_t j = 0; j < n[v]; j++)
        for (int32_t i = 0; i < n[u]; i++) {
            const size_t at = (size_t)i * stride[u] + (size_t)j * stride[v];
            spread_line(to + at, from + at, n[axis], stride[axis], reach, sign);
        }
}

/* One bound, in place: `other` is room of the same size. */
static void spread_bound(float *bound, float *other, const vvi_minmax *from, int32_t reach, float sign)
{
    const size_t n = (size_t)from->n[0] * (size_t)from->n[1] * (size_t)from->n[2];
    for (int axis = 0; axis < 3; axis++) {
        memcpy(other, bound, n * sizeof *bound);
        spread_axis(bound, other, from->n, axis, reach, sign);
    }
}

vv_status vvi_minmax_spread(vvi_minmax **out, const vvi_minmax *from, int reach, vv_job *job)
{
    const size_t n = (size_t)from->n[0] * (size_t)from->n[1] * (size_t)from->n[2], bytes = n * sizeof(float);
    *out = NULL;
    vvi_minmax *m = vvi_alloc_zeroed(job, sizeof *m, VVI_MEM_DERIVED);
    if (!m)
        return vv_fail_memory(sizeof *m);
    memcpy(m->n, from->n, sizeof m->n);
    m->shift = from->shift;
    m->lo = vvi_alloc(job, bytes, VVI_MEM_DERIVED);
    m->hi = vvi_alloc(job, bytes, VVI_MEM_DERIVED);
    float *other = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    if (!m->lo || !m->hi || !other) {
        vvi_free(other);
        vvi_minmax_free(m);
        return vv_fail_memory(3 * bytes);
    }
    memcpy(m->lo, from->lo, bytes);
    memcpy(m->hi, from->hi, bytes);
    spread_bound(m->lo, other, from, reach, 1);
    spread_bound(m->hi, other, from, reach, -1);
    vvi_free(other);
    *out = m;
    return VV_OK;
}
