/* What a look at every sample tells: from exact counts where samples have 8 or 16 bits, else from two passes. */
#include "grid/statistics.h"

#include "core/cache.h"
#include "core/memory.h"
#include "grid/percentile.h"

#include <math.h>
#include <string.h>

#define FINE 100      /* bins between 0.1 and 99.9 %: fewer are too coarse for percentiles */
#define FEWEST 16     /* bins that all but a few samples should share */
#define APART 1e-5    /* of the samples at either end: those few */
#define APART_LEAST 4 /* samples */
#define TRIMMED 1000  /* samples: of fewer none is left apart */

static const double percents[5] = {0.1, 1, 50, 99, 99.9};

/* How many samples lie at or below a percentile: at least 1. */
static uint64_t rank_of(double percent, uint64_t count)
{
    const double rank = ceil(percent / 100 * (double)count);
    return rank < 1 ? 1 : rank > (double)count ? count : (uint64_t)rank;
}

/* Patterns by ascending value: signed ones begin in the middle. */
static uint32_t pattern_at(uint32_t order, uint32_t n_patterns, vv_type type)
{
    const bool is_signed = type == VV_TYPE_I8 || type == VV_TYPE_I16;
    return is_signed ? (order + n_patterns / 2) % n_patterns : order;
}

static void range_of_counts(vv_statistics *s, const uint64_t *counts, uint32_t n, vv_type type)
{
    int64_t sum = 0;
    bool any = false;
    for (uint32_t o = 0; o < n; o++) {
        const uint32_t p = pattern_at(o, n, type);
        const int32_t v = vvi_pattern_value(p, type);
        if (counts[p] == 0)
            continue;
        if (!any)
            s->min = v;
        any = true;
        s->max = v;
        s->count += counts[p];
        sum += v * (int64_t)counts[p];
    }
    s->mean = (double)((long double)sum / (long double)s->count);
}

static void set_bins(vv_statistics *s, const vvi_bins *bins)
{
    s->histogram_lo = bins->lo;
    s->histogram_hi = bins->hi;
    s->n_bins = bins->n;
}

static void shape_of_counts(vv_statistics *s, const uint64_t *counts, uint32_t n, vv_type type)
{
    const vvi_bins bins = vvi_bins_for(s->min, s->max, true);
    set_bins(s, &bins);
    const int64_t each = bins.n > 1 ? (int64_t)((bins.hi - bins.lo) / bins.n) : 1;
    double m2 = 0;
    uint64_t below = 0;
    int q = 0;
    for (uint32_t o = 0; o < n; o++) {
        const uint32_t p = pattern_at(o, n, type);
        const double v = vvi_pattern_value(p, type);
        if (counts[p] == 0)
            continue;
        s->histogram[(int64_t)(v - s->min) / each] += counts[p];
        m2 += (double)counts[p] * ((v - s->mean) * (v - s->mean));
        below += counts[p];
        for (; q < 5 && below >= rank_of(percents[q], s->count); q++)
            s->percentile[q] = v;
    }
    s->deviation = sqrt(m2 / (double)s->count);
}

static vv_status from_patterns(vv_statistics *s, const vv_field *field, int component, vv_job *job)
{
    const vv_type type = vv_field_get_info(field)->type;
    const uint32_t n = vv_type_bytes(type) == 1 ? 256 : 65536;
    uint64_t *counts = vvi_alloc(job, n * sizeof *counts, VVI_MEM_SCRATCH);
    if (!counts)
        return vv_fail_memory(n * sizeof *counts);
    const vv_status st = vvi_count_patterns(counts, field, component, job);
    if (st == VV_OK) {
        range_of_counts(s, counts, n, type);
        shape_of_counts(s, counts, n, type);
    }
    vvi_free(counts);
    return st;
}

/* Where a bin holds one whole number, a percentile is that number; else samples are taken as evenly spread inside. */
static double percentile_of_bins(const vv_statistics *s, double percent, bool one_number_a_bin)
{
    const uint64_t rank = rank_of(percent, s->count);
    const double width = s->histogram_hi / s->n_bins - s->histogram_lo / s->n_bins;
    uint64_t below = 0;
    for (int b = 0; b < s->n_bins; b++) {
        const uint64_t here = s->histogram[b];
        if (below + here >= rank) {
            const double inside = one_number_a_bin ? 0.5 : (double)(rank - below) / (double)here;
            return fmin(fmax(s->histogram_lo + (b + inside) * width, s->min), s->max);
        }
        below += here;
    }
    return s->max;
}

/* Where nearly all samples share a few bins, since a few lie far out: percentiles exactly, and bins over the many. */
static vv_status look_closer(vv_statistics *s, const vv_field *field, int component, vv_job *job)
{
    const double width = s->histogram_hi / s->n_bins - s->histogram_lo / s->n_bins;
    if (s->n_bins == 1 || s->percentile[4] / FINE - s->percentile[0] / FINE >= width)
        return VV_OK;
    uint64_t ranks[7], apart = (uint64_t)(APART * (double)s->count);
    double stored[7];
    apart = s->count < TRIMMED ? 0 : apart < APART_LEAST ? APART_LEAST : apart;
    for (int q = 0; q < 5; q++)
        ranks[q] = rank_of(percents[q], s->count) - 1;
    ranks[5] = apart;
    ranks[6] = s->count - 1 - apart;
    const vv_status st = vvi_select_ranks(stored, ranks, 7, field, component, job);
    if (st != VV_OK)
        return st;
    memcpy(s->percentile, stored, sizeof s->percentile);
    const double lo = stored[5], hi = stored[6];
    if (!(lo < hi) || hi / FEWEST - lo / FEWEST >= width)
        return VV_OK;
    const vvi_bins bins = vvi_bins_for(lo, hi, !vv_type_is_float(vv_field_get_info(field)->type));
    set_bins(s, &bins);
    memset(s->histogram, 0, sizeof s->histogram);
    return vvi_count_bins(s->histogram, &bins, field, component, job);
}

static vv_status from_passes(vv_statistics *s, const vv_field *field, int component, vv_job *job)
{
    const vv_type type = vv_field_get_info(field)->type;
    vvi_moments m;
    vv_status st = vvi_field_moments(&m, field, component, job);
    if (st != VV_OK)
        return st;
    s->nan_count = m.nan_count;
    s->infinite_count = m.infinite_count;
    s->count = m.count;
    if (m.count == 0)
        return VV_OK;
    s->min = m.min;
    s->max = m.max;
    s->mean = (double)m.mean;
    s->deviation = (double)sqrtl(m.m2 / (long double)m.count);
    const vvi_bins bins = vvi_bins_for(m.min, m.max, !vv_type_is_float(type));
    set_bins(s, &bins);
    if ((st = vvi_count_bins(s->histogram, &bins, field, component, job)) != VV_OK)
        return st;
    const bool one_number_a_bin = !vv_type_is_float(type) && bins.hi - bins.lo == bins.n;
    for (int q = 0; q < 5; q++)
        s->percentile[q] = percentile_of_bins(s, percents[q], one_number_a_bin);
    return one_number_a_bin ? VV_OK : look_closer(s, field, component, job);
}

static void swap(double *a, double *b)
{
    const double t = *a;
    *a = *b;
    *b = t;
}

/* A negative scale turns the order of values round. */
static void reverse(vv_statistics *s)
{
    swap(&s->min, &s->max);
    swap(&s->histogram_lo, &s->histogram_hi);
    swap(&s->percentile[0], &s->percentile[4]);
    swap(&s->percentile[1], &s->percentile[3]);
    for (int b = 0; b < s->n_bins / 2; b++) {
        const uint64_t t = s->histogram[b];
        s->histogram[b] = s->histogram[s->n_bins - 1 - b];
        s->histogram[s->n_bins - 1 - b] = t;
    }
}

static void to_values(vv_statistics *s, const vv_field_info *info)
{
    if (s->count == 0)
        return;
    double *const numbers[] = {&s->min,           &s->max,           &s->mean,          &s->histogram_lo,
                               &s->histogram_hi,  &s->percentile[0], &s->percentile[1], &s->percentile[2],
                               &s->percentile[3], &s->percentile[4]};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        *numbers[i] = *numbers[i] * info->value_scale + info->value_offset;
    s->deviation *= fabs(info->value_scale);
    if (info->value_scale < 0)
        reverse(s);
}

typedef struct request {
    const vv_field *field;
    int component;
} request;

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    const vv_field_info *info = vv_field_get_info(r->field);
    vv_statistics *s = vvi_alloc_zeroed(job, sizeof *s, VVI_MEM_DERIVED);
    if (!s)
        return vv_fail_memory(sizeof *s);
    vv_status st = vv_type_bytes(info->type) <= 2 ? from_patterns(s, r->field, r->component, job)
                                                  : from_passes(s, r->field, r->component, job);
    if (st == VV_OK)
        st = vv_field_health(r->field);
    if (st != VV_OK) {
        vvi_free(s);
        return st;
    }
    to_values(s, info);
    *value_out = s;
    *bytes_out = sizeof *s;
    return VV_OK;
}

vv_status vv_field_statistics(vv_statistics *out, const vv_field *field, int component, vv_job *job)
{
    const int components = vv_field_get_info(field)->components;
    if (component < 0 || component >= components)
        return vv_fail(VV_E_ARGUMENT, "component %d does not exist; the field has %d, counted from 0", component,
                       components);
    request r = {field, component};
    const vvi_cache_key key = {"statistics", vv_field_identity(field), (uint64_t)component};
    vvi_cached *cached;
    const vv_status st = vvi_cache_get(&cached, &key, make, vvi_free, &r, job);
    if (st != VV_OK)
        return st;
    memcpy(out, vvi_cached_value(cached), sizeof *out);
    vvi_cache_release(cached);
    return VV_OK;
}

vv_status vvi_field_widen_range(double *lo, double *hi, const vv_field *field, vv_job *job)
{
    vv_statistics *s = vvi_alloc(job, sizeof *s, VVI_MEM_SCRATCH);
    if (!s)
        return vv_fail_memory(sizeof *s);
    vv_status st = VV_OK;
    for (int c = 0; c < vv_field_get_info(field)->components; c++) {
        if ((st = vv_field_statistics(s, field, c, job)) != VV_OK)
            break;
        if (!s->count)
            continue;
        *lo = fmin(*lo, s->min);
        *hi = fmax(*hi, s->max);
    }
    vvi_free(s);
    return st;
}
