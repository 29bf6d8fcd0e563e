/* Counts of the samples by equal bins of a range that is known. */
#include "core/memory.h"
#include "grid/statistics.h"
#include "grid/value_pass.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

#define AUTOMATIC 1024
#define BEYOND 3                        /* behind the bins: below, above, not finite */
#define FLUSH_AFTER ((uint64_t)1 << 31) /* before a 32-bit count can wrap */

vvi_bins vvi_bins_for(double min, double max, bool whole_numbers)
{
    const double range = max - min;
    if (!(range > 0))
        return (vvi_bins){min, max, 1};
    /* Beyond 2^50 whole numbers are as good as reals, and half a unit may not fit beside them. */
    if (!whole_numbers || range > 0x1p50 || fabs(min) > 0x1p50)
        return (vvi_bins){min, max, AUTOMATIC};
    const double each = ceil((range + 1) / AUTOMATIC);
    const double n = ceil((range + 1) / each);
    return (vvi_bins){min - 0.5, min - 0.5 + n * each, (int)n};
}

/* A worker's own counts, in two tables: neighbours go to different ones, since equal bins in a row would wait for each
 * other. */
typedef struct worker {
    uint64_t pending;
    uint32_t count[];
} worker;

static void flush(const vvi_bin_counts *c, worker *w)
{
    const size_t n = (size_t)c->bins.n + BEYOND;
    for (size_t b = 0; b < n; b++)
        if (w->count[b] || w->count[n + b])
            atomic_fetch_add_explicit(&c->total[b], (uint64_t)w->count[b] + w->count[n + b], memory_order_relaxed);
    memset(w->count, 0, 2 * n * sizeof *w->count);
    w->pending = 0;
}

static void take(void *user, void *scratch, size_t item, const double *values, size_t n)
{
    (void)item;
    const vvi_bin_counts *c = user;
    worker *w = scratch;
    uint32_t bin[VVI_PASS_RUN], *const other = w->count + c->bins.n + BEYOND;
    const double last = c->bins.n - 1, half_lo = c->half_lo, per_half = c->per_half;
    const double lo = c->bins.lo, hi = c->bins.hi;
    for (size_t i = 0; i < n; i++) {
        const double at = (values[i] * 0.5 - half_lo) * per_half;
        const double above = at > 0 ? at : 0; /* NaN too: a number that can be cast */
        const double inside = above < last ? above : last;
        const double slot = values[i] < lo ? last + 1 : values[i] > hi ? last + 2 : inside;
        bin[i] = (uint32_t)(int32_t)(values[i] - values[i] == 0 ? slot : last + 3);
    }
    size_t i = 0;
    for (; i + 2 <= n; i += 2) {
        w->count[bin[i]]++;
        other[bin[i + 1]]++;
    }
    if (i < n)
        w->count[bin[i]]++;
    w->pending += n;
    if (w->pending > FLUSH_AFTER)
        flush(c, w);
}

static void finish(void *user, void *scratch)
{
    if (scratch)
        flush(user, scratch);
}

vv_status vvi_bin_counts_begin(vvi_bin_counts *counts, const vvi_bins *bins, vv_job *job)
{
    const double half_range = bins->hi * 0.5 - bins->lo * 0.5;
    const size_t bytes = ((size_t)bins->n + BEYOND) * sizeof *counts->total;
    *counts = (vvi_bin_counts){*bins, bins->lo * 0.5, half_range > 0 ? bins->n / half_range : 0, NULL};
    counts->total = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH);
    return counts->total ? VV_OK : vv_fail_memory(bytes);
}

vvi_pass vvi_bin_counts_pass(vvi_bin_counts *counts)
{
    const size_t n = (size_t)counts->bins.n + BEYOND;
    return (vvi_pass){.stage = "histogram",
                      .scratch_bytes = sizeof(worker) + 2 * n * sizeof(uint32_t),
                      .take = take,
                      .finish = finish,
                      .user = counts};
}

uint64_t vvi_bin_counts_get(const vvi_bin_counts *counts, int b)
{
    return atomic_load_explicit(&counts->total[b], memory_order_relaxed);
}

void vvi_bin_counts_end(vvi_bin_counts *counts)
{
    vvi_free(counts->total);
    counts->total = NULL;
}
