/* The histogram of a field whose range is known. */
#include "core/memory.h"
#include "grid/pass.h"
#include "grid/statistics.h"

#include <math.h>
#include <stdatomic.h>

#define BINS_MOST 1024

vvi_bins vvi_bins_for(double min, double max, bool whole_numbers)
{
    const double range = max - min;
    if (!(range > 0))
        return (vvi_bins){min, max, 1};
    /* Beyond 2^50 whole numbers are as good as reals, and half a unit may not fit beside them. */
    if (!whole_numbers || range > 0x1p50 || fabs(min) > 0x1p50)
        return (vvi_bins){min, max, BINS_MOST};
    const double each = ceil((range + 1) / BINS_MOST);
    const double n = ceil((range + 1) / each);
    return (vvi_bins){min - 0.5, min - 0.5 + n * each, (int)n};
}

typedef struct shared {
    vvi_bins bins;
    double half_lo, per_half; /* halves, as the range of huge doubles is no double */
    _Atomic uint64_t *total;
} shared;

/* A worker's own counts; the last takes what is not finite. Neighbours go to different tables, since equal bins in a
 * row would wait for each other. */
typedef struct counts {
    uint64_t count[2][BINS_MOST + 1];
} counts;

static void take(void *user, void *scratch, size_t item, const double *values, size_t n)
{
    (void)item;
    const shared *s = user;
    counts *c = scratch;
    uint32_t bin[VVI_PASS_RUN];
    const double last = s->bins.n - 1, half_lo = s->half_lo, per_half = s->per_half;
    for (size_t i = 0; i < n; i++) {
        const double at = (values[i] * 0.5 - half_lo) * per_half;
        const double above = at > 0 ? at : 0; /* NaN too: a number that can be cast */
        const double inside = above < last ? above : last;
        bin[i] = values[i] - values[i] == 0 ? (uint32_t)(int32_t)inside : BINS_MOST;
    }
    for (size_t i = 0; i < n; i++)
        c->count[i & 1][bin[i]]++;
}

static void finish(void *user, void *scratch)
{
    const shared *s = user;
    const counts *c = scratch;
    for (int b = 0; b < s->bins.n; b++)
        atomic_fetch_add_explicit(&s->total[b], c->count[0][b] + c->count[1][b], memory_order_relaxed);
}

vv_status vvi_count_bins(uint64_t *histogram, const vvi_bins *bins, const vv_field *field, int component, vv_job *job)
{
    _Atomic uint64_t *total = vvi_alloc_zeroed(job, BINS_MOST * sizeof *total, VVI_MEM_SCRATCH);
    if (!total)
        return vv_fail_memory(BINS_MOST * sizeof *total);
    const double half_range = bins->hi * 0.5 - bins->lo * 0.5;
    shared s = {*bins, bins->lo * 0.5, half_range > 0 ? bins->n / half_range : 0, total};
    const vvi_pass pass = {
        .stage = "histogram", .scratch_bytes = sizeof(counts), .take = take, .finish = finish, .user = &s};
    const vv_status st = vvi_pass_run(&pass, field, component, job);
    for (int b = 0; b < bins->n; b++)
        histogram[b] = atomic_load_explicit(&total[b], memory_order_relaxed);
    vvi_free(total);
    return st;
}
