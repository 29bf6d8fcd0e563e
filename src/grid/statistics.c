/* What a look at every sample tells: from exact counts where samples have 8 or 16 bits, else from passes. */
#include "grid/statistics.h"

#include "core/cache.h"
#include "core/memory.h"
#include "grid/percentile.h"

#include <math.h>
#include <string.h>

#define FINE 100      /* bins between 0.1 and 99.9 %: fewer are too coarse for percentiles */
#define FEWEST 16     /* bins that all but a few samples should share */
#define APART 1e-5    /* of the samples at either end: those few */
#define PADDING 5e-4  /* of the samples at the lower end: dead pixels, and what a fill value stands for */
#define APART_LEAST 4 /* samples */
#define TRIMMED 1000  /* samples: of fewer none is left apart */

#define N_PERCENTS 5
static const double percents[N_PERCENTS] = {0.1, 1, 50, 99, 99.9};

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

/* Where the samples of the percentiles are met in rising order: their numbers one by one. */
typedef struct finder {
    vvi_quantile at[N_PERCENTS];
    double low[N_PERCENTS], high[N_PERCENTS];
} finder;

static void find(finder *f, uint64_t below, uint64_t here, double number)
{
    for (int q = 0; q < N_PERCENTS; q++) {
        if (f->at[q].low >= below && f->at[q].low - below < here)
            f->low[q] = number;
        if (f->at[q].high >= below && f->at[q].high - below < here)
            f->high[q] = number;
    }
}

/* How many samples at an end may be left apart, where all others would share a few bins. */
static uint64_t apart(uint64_t count, double share)
{
    const uint64_t n = (uint64_t)(share * (double)count);
    return count < TRIMMED ? 0 : n < APART_LEAST ? APART_LEAST : n;
}

/* Bins of all samples, or of all but those few far out. */
static vvi_bins bins_of_counts(const vv_statistics *s, const uint64_t *counts, uint32_t n, vv_type type)
{
    const vvi_bins all = vvi_bins_for(s->min, s->max, true);
    const uint64_t first = apart(s->count, PADDING), last = s->count - 1 - apart(s->count, APART);
    const double each = (all.hi - all.lo) / all.n;
    double lo = s->min, hi = s->max;
    uint64_t below = 0;
    for (uint32_t o = 0; o < n; o++) {
        const uint32_t p = pattern_at(o, n, type);
        if (first >= below && first - below < counts[p])
            lo = vvi_pattern_value(p, type);
        if (last >= below && last - below < counts[p])
            hi = vvi_pattern_value(p, type);
        below += counts[p];
    }
    return each > 1 && lo < hi && hi - lo < FEWEST * each ? vvi_bins_for(lo, hi, true) : all;
}

static void shape_of_counts(vv_statistics *s, const uint64_t *counts, uint32_t n, vv_type type)
{
    const vvi_bins bins = bins_of_counts(s, counts, n, type);
    set_bins(s, &bins);
    const double each = bins.n > 1 ? (bins.hi - bins.lo) / bins.n : 1;
    double m2 = 0;
    uint64_t below = 0;
    finder f;
    for (int q = 0; q < N_PERCENTS; q++)
        f.at[q] = vvi_quantile_at(percents[q], s->count);
    for (uint32_t o = 0; o < n; o++) {
        const uint32_t p = pattern_at(o, n, type);
        const double v = vvi_pattern_value(p, type);
        if (counts[p] == 0)
            continue;
        s->histogram[(int)fmin(fmax((v - bins.lo) / each, 0), bins.n - 1)] += counts[p];
        m2 += (double)counts[p] * ((v - s->mean) * (v - s->mean));
        find(&f, below, counts[p], v);
        below += counts[p];
    }
    for (int q = 0; q < N_PERCENTS; q++)
        s->percentile[q] = vvi_quantile_between(&f.at[q], f.low[q], f.high[q]);
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

/* Where a bin holds one whole number, a sample is that number; else those of a bin are taken as evenly spread. */
static double number_of_rank(const vv_statistics *s, uint64_t rank, bool one_number_a_bin)
{
    const double width = s->histogram_hi / s->n_bins - s->histogram_lo / s->n_bins;
    uint64_t below = 0;
    for (int b = 0; b < s->n_bins; b++) {
        const uint64_t here = s->histogram[b];
        if (rank < below + here) {
            const double inside = one_number_a_bin ? 0.5 : ((double)(rank - below) + 0.5) / (double)here;
            return fmin(fmax(s->histogram_lo + (b + inside) * width, s->min), s->max);
        }
        below += here;
    }
    return s->max;
}

static void percentiles_of_bins(vv_statistics *s, bool one_number_a_bin)
{
    for (int q = 0; q < N_PERCENTS; q++) {
        const vvi_quantile at = vvi_quantile_at(percents[q], s->count);
        s->percentile[q] = vvi_quantile_between(&at, number_of_rank(s, at.low, one_number_a_bin),
                                                number_of_rank(s, at.high, one_number_a_bin));
    }
}

/* Passes over one field, with what they count. */
typedef struct looker {
    const vv_field *field;
    int component;
    vv_job *job;
    vvi_selection selection;
    bool selected; /* the percentiles, and the ends of what is not left apart */
} looker;

static vv_status run(const looker *l, const vvi_pass *passes, int n)
{
    vvi_pass_group group = {.n = n};
    memcpy(group.pass, passes, (size_t)n * sizeof *passes);
    const vvi_pass pass = n > 1 ? vvi_pass_of_group(&group) : passes[0];
    return vvi_pass_run(&pass, l->field, l->component, l->job);
}

/* The first pass; of the selection too where there is one. */
static vv_status look_moments(vvi_moments *out, looker *l, bool select)
{
    const size_t n = vvi_pass_slabs(l->field).n;
    vvi_moments *parts;
    vv_status st = vvi_moments_begin(&parts, n, l->job);
    if (st == VV_OK && select)
        st = vvi_selection_begin(&l->selection, vv_field_get_info(l->field)->type, l->job);
    if (st == VV_OK) {
        const vvi_pass passes[2] = {vvi_moments_pass(parts), vvi_selection_pass(&l->selection)};
        st = run(l, passes, select ? 2 : 1);
    }
    vvi_moments_end(out, parts, n);
    return st;
}

/* What lies beyond the bins is counted in those at the ends. */
static vv_status look_bins(vv_statistics *s, looker *l, const vvi_bins *bins, bool select)
{
    vvi_bin_counts counts;
    set_bins(s, bins);
    vv_status st = vvi_bin_counts_begin(&counts, bins, l->job);
    if (st == VV_OK) {
        const vvi_pass passes[2] = {vvi_bin_counts_pass(&counts), vvi_selection_pass(&l->selection)};
        st = run(l, passes, select ? 2 : 1);
    }
    for (int b = 0; st == VV_OK && b < bins->n; b++)
        s->histogram[b] = vvi_bin_counts_get(&counts, b);
    if (st == VV_OK) {
        s->histogram[0] += vvi_bin_counts_get(&counts, bins->n);
        s->histogram[bins->n - 1] += vvi_bin_counts_get(&counts, bins->n + 1);
    }
    vvi_bin_counts_end(&counts);
    return st;
}

/* After the first pass of the selection: percentiles, and the ends without the samples that are left apart. */
static void ask_ranks(looker *l, uint64_t count)
{
    uint64_t ranks[2 * N_PERCENTS + 2];
    vvi_quantile_ranks(ranks, percents, N_PERCENTS, count);
    ranks[2 * N_PERCENTS] = apart(count, PADDING);
    ranks[2 * N_PERCENTS + 1] = count - 1 - apart(count, APART);
    vvi_selection_set_ranks(&l->selection, ranks, 2 * N_PERCENTS + 2);
}

/* The other passes of the selection; `counted`: its second one is made. */
static vv_status finish_selection(vv_statistics *s, looker *l, bool counted)
{
    vv_status st = VV_OK;
    bool done = false;
    if (!counted)
        ask_ranks(l, s->count);
    while (st == VV_OK && (st = vvi_selection_descend(&l->selection, &done, l->job)) == VV_OK && !done) {
        const vvi_pass pass = vvi_selection_pass(&l->selection);
        st = run(l, &pass, 1);
    }
    for (int q = 0; q < N_PERCENTS && st == VV_OK; q++)
        s->percentile[q] = vvi_selection_percentile(&l->selection, q, percents[q], s->count);
    l->selected = true;
    return st;
}

/* Where nearly all samples share a few bins, since a few lie far out: percentiles exactly, and bins over the many. */
static vv_status look_closer(vv_statistics *s, looker *l)
{
    const double width = s->histogram_hi / s->n_bins - s->histogram_lo / s->n_bins;
    vv_status st = VV_OK;
    if (s->n_bins == 1 || s->percentile[4] / FINE - s->percentile[0] / FINE >= width)
        return VV_OK;
    if (!l->selected) {
        const vv_type type = vv_field_get_info(l->field)->type;
        if ((st = vvi_selection_begin(&l->selection, type, l->job)) != VV_OK)
            return st;
        const vvi_pass first = vvi_selection_pass(&l->selection);
        if ((st = run(l, &first, 1)) != VV_OK || (st = finish_selection(s, l, false)) != VV_OK)
            return st;
    }
    const double lo = vvi_selection_number(&l->selection, 2 * N_PERCENTS);
    const double hi = vvi_selection_number(&l->selection, 2 * N_PERCENTS + 1);
    if (!(lo < hi) || hi / FEWEST - lo / FEWEST >= width)
        return VV_OK;
    const vvi_bins bins = vvi_bins_for(lo, hi, !vv_type_is_float(vv_field_get_info(l->field)->type));
    memset(s->histogram, 0, sizeof s->histogram);
    return look_bins(s, l, &bins, false);
}

static vv_status from_passes(vv_statistics *s, looker *l, bool exact)
{
    const vv_type type = vv_field_get_info(l->field)->type;
    vvi_moments m;
    vv_status st = look_moments(&m, l, exact);
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
    const bool one_number_a_bin = !vv_type_is_float(type) && bins.hi - bins.lo == bins.n;
    const bool select = exact && !one_number_a_bin && bins.n > 1;
    bool done = false;
    if (select) {
        ask_ranks(l, s->count);
        st = vvi_selection_descend(&l->selection, &done, l->job);
    }
    if (st != VV_OK || (st = look_bins(s, l, &bins, select)) != VV_OK)
        return st;
    percentiles_of_bins(s, one_number_a_bin);
    if (select && (st = finish_selection(s, l, true)) != VV_OK)
        return st;
    return one_number_a_bin ? VV_OK : look_closer(s, l);
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
    bool exact;
} request;

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    const vv_field_info *info = vv_field_get_info(r->field);
    vv_statistics *s = vvi_alloc_zeroed(job, sizeof *s, VVI_MEM_DERIVED);
    if (!s)
        return vv_fail_memory(sizeof *s);
    looker l = {.field = r->field, .component = r->component, .job = job};
    vv_status st =
        vv_type_bytes(info->type) <= 2 ? from_patterns(s, r->field, r->component, job) : from_passes(s, &l, r->exact);
    vvi_selection_end(&l.selection);
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

static vv_status cached_statistics(vv_statistics *out, const vv_field *field, int component, bool exact, vv_job *job)
{
    const int components = vv_field_get_info(field)->components;
    if (component < 0 || component >= components)
        return vv_fail(VV_E_ARGUMENT, "channel %d does not exist; the field has %d, counted from 0", component,
                       components);
    request r = {field, component, exact && vv_type_bytes(vv_field_get_info(field)->type) > 2};
    const vvi_cache_key key = {r.exact ? "exact statistics" : "statistics", vv_field_identity(field),
                               (uint64_t)component};
    vvi_cached *cached;
    const vv_status st = vvi_cache_get(&cached, &key, make, vvi_free, &r, job);
    if (st != VV_OK)
        return st;
    memcpy(out, vvi_cached_value(cached), sizeof *out);
    vvi_cache_release(cached);
    return VV_OK;
}

vv_status vv_field_statistics(vv_statistics *out, const vv_field *field, int component, vv_job *job)
{
    return cached_statistics(out, field, component, false, job);
}

vv_status vvi_field_statistics_exact(vv_statistics *out, const vv_field *field, int component, vv_job *job)
{
    return cached_statistics(out, field, component, true, job);
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
