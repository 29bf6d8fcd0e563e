/* Count, range, mean and spread of samples, part by part. Sums are of double over short blocks and joined after Chan,
 * Golub & LeVeque 1979, which loses nothing however long the field is. */
#include "grid/statistics.h"

#include "core/memory.h"
#include "grid/value_pass.h"

#include <math.h>

#define LANES 8

void vvi_moments_init(vvi_moments *m)
{
    *m = (vvi_moments){.min = INFINITY, .max = -INFINITY};
}

void vvi_moments_join(vvi_moments *m, const vvi_moments *other)
{
    m->nan_count += other->nan_count;
    m->infinite_count += other->infinite_count;
    if (other->count == 0)
        return;
    const long double a = (long double)m->count, b = (long double)other->count, n = a + b;
    const long double d = other->mean - m->mean;
    m->mean += d * (b / n);
    m->m2 += other->m2 + d * d * (a * b / n);
    m->count += other->count;
    m->min = fmin(m->min, other->min);
    m->max = fmax(m->max, other->max);
}

static double join_lanes(const double v[LANES])
{
    return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}

/* x - x is 0 for finite x and NaN for all else: one sum tells whether a block has something odd. */
static bool all_finite(const double *v, size_t n)
{
    double lane[LANES] = {0};
    size_t i = 0;
    for (; i + LANES <= n; i += LANES)
        for (int l = 0; l < LANES; l++)
            lane[l] += v[i + l] - v[i + l];
    for (; i < n; i++)
        lane[0] += v[i] - v[i];
    return join_lanes(lane) == 0;
}

static void range(vvi_moments *m, const double *v, size_t n)
{
    double lo[LANES], hi[LANES];
    for (int l = 0; l < LANES; l++)
        lo[l] = hi[l] = v[0];
    size_t i = 0;
    for (; i + LANES <= n; i += LANES)
        for (int l = 0; l < LANES; l++) {
            lo[l] = v[i + l] < lo[l] ? v[i + l] : lo[l];
            hi[l] = v[i + l] > hi[l] ? v[i + l] : hi[l];
        }
    for (; i < n; i++) {
        lo[0] = v[i] < lo[0] ? v[i] : lo[0];
        hi[0] = v[i] > hi[0] ? v[i] : hi[0];
    }
    for (int l = 0; l < LANES; l++) {
        m->min = fmin(m->min, lo[l]);
        m->max = fmax(m->max, hi[l]);
    }
}

/* Huge doubles overflow plain sums of squares: their block is summed again in extended range. */
static void sums_wide(vvi_moments *m, const double *v, size_t n)
{
    long double sum = 0, m2 = 0;
    for (size_t i = 0; i < n; i++)
        sum += v[i];
    m->mean = sum / (long double)n;
    for (size_t i = 0; i < n; i++)
        m2 += (v[i] - m->mean) * (v[i] - m->mean);
    m->m2 = m2;
}

static void sums(vvi_moments *m, const double *v, size_t n)
{
    double sum[LANES] = {0}, m2[LANES] = {0};
    size_t i = 0;
    for (; i + LANES <= n; i += LANES)
        for (int l = 0; l < LANES; l++)
            sum[l] += v[i + l];
    for (; i < n; i++)
        sum[0] += v[i];
    const double mean = join_lanes(sum) / (double)n;
    for (i = 0; i + LANES <= n; i += LANES)
        for (int l = 0; l < LANES; l++)
            m2[l] += (v[i + l] - mean) * (v[i + l] - mean);
    for (; i < n; i++)
        m2[0] += (v[i] - mean) * (v[i] - mean);
    m->mean = mean;
    m->m2 = join_lanes(m2);
    if (!isfinite((double)m->mean) || !isfinite((double)m->m2))
        sums_wide(m, v, n);
}

static void add_finite(vvi_moments *m, const double *v, size_t n)
{
    if (n == 0)
        return;
    vvi_moments block;
    vvi_moments_init(&block);
    block.count = n;
    range(&block, v, n);
    sums(&block, v, n);
    vvi_moments_join(m, &block);
}

#define BLOCK 1024

void vvi_moments_add(vvi_moments *m, const double *values, size_t n)
{
    for (size_t at = 0; at < n; at += BLOCK) {
        const double *v = values + at;
        const size_t now = n - at < BLOCK ? n - at : BLOCK;
        if (all_finite(v, now)) {
            add_finite(m, v, now);
            continue;
        }
        double finite[BLOCK];
        size_t kept = 0;
        for (size_t i = 0; i < now; i++) {
            m->nan_count += isnan(v[i]) != 0;
            m->infinite_count += isinf(v[i]) != 0;
            if (isfinite(v[i]))
                finite[kept++] = v[i];
        }
        add_finite(m, finite, kept);
    }
}

static void take(void *user, void *scratch, size_t item, const double *values, size_t n)
{
    (void)scratch;
    vvi_moments *parts = user;
    vvi_moments_add(&parts[item], values, n);
}

vv_status vvi_moments_begin(vvi_moments **parts_out, size_t n_items, vv_job *job)
{
    vvi_moments *parts = vvi_alloc(job, n_items * sizeof *parts, VVI_MEM_SCRATCH);
    *parts_out = parts;
    if (!parts)
        return vv_fail_memory(n_items * sizeof *parts);
    for (size_t i = 0; i < n_items; i++)
        vvi_moments_init(&parts[i]);
    return VV_OK;
}

vvi_pass vvi_moments_pass(vvi_moments *parts)
{
    return (vvi_pass){.stage = "statistics", .take = take, .user = parts};
}

void vvi_moments_end(vvi_moments *out, vvi_moments *parts, size_t n_items)
{
    vvi_moments_init(out);
    for (size_t i = 0; parts && i < n_items; i++)
        vvi_moments_join(out, &parts[i]);
    vvi_free(parts);
}
