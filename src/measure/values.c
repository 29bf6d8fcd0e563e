/* Statistics and histogram of all samples, or of those of an object. Everything here is in stored numbers until the
 * last step. */
#include "core/memory.h"
#include "grid/percentile.h"
#include "grid/statistics.h"
#include "measure/value_samples.h"

#include <math.h>
#include <string.h>

#define FINE VVI_BINS_MOST /* bins of samples of more than 16 bits: the most frequent value is within one */
#define AUTOMATIC 1024
#define N_PERCENTS ((int)(sizeof percents / sizeof *percents))
#define MEDIAN 3 /* of the percentiles */

static const double percents[] = VV_VALUES_PERCENTS;

void vv_values_options_init(vv_values_options *options, size_t size)
{
    const vv_values_options all = {.size = size, .lo = NAN, .hi = NAN};
    memcpy(options, &all, size < sizeof all ? size : sizeof all);
}

void vv_values_free(vv_values *values)
{
    vvi_free(values);
}

/* From counts to numbers ----------------------------------------------------------------------------------------------
 */

/* Counts of numbers that rise by the same step: of the i-th they are at `first + i * step`. */
typedef struct tally {
    const uint64_t *count;
    size_t n;
    double first, step;
    bool exact; /* each is one number; else all numbers up to the next */
} tally;

static double number_at(const tally *t, size_t i)
{
    return t->first + (t->exact ? (double)i : (double)i + 0.5) * t->step;
}

/* Of numbers that are each exact. */
static double number_of_rank(const tally *t, uint64_t rank)
{
    uint64_t below = 0;
    size_t i = 0;
    while (i + 1 < t->n && below + t->count[i] <= rank)
        below += t->count[i++];
    return number_at(t, i);
}

static void set_percentiles(vv_values *v, const tally *t)
{
    for (int p = 0; p < N_PERCENTS; p++) {
        const vvi_quantile q = vvi_quantile_at(percents[p], v->count);
        v->percentile[p] = vvi_quantile_between(&q, number_of_rank(t, q.low), number_of_rank(t, q.high));
    }
    v->median = v->percentile[MEDIAN];
}

static void set_mode(vv_values *v, const tally *t)
{
    size_t most = 0;
    for (size_t i = 0; i < t->n; i++)
        most = t->count[i] > t->count[most] ? i : most;
    v->mode = fmin(fmax(number_at(t, most), v->min), v->max);
    v->exact = t->exact;
    v->within = t->exact ? 0 : t->step;
}

static void set_moments(vv_values *v, const tally *t)
{
    long double sum = 0, m2 = 0;
    bool any = false;
    for (size_t i = 0; i < t->n; i++) {
        if (!t->count[i])
            continue;
        v->min = any ? v->min : number_at(t, i);
        v->max = number_at(t, i);
        any = true;
        v->count += t->count[i];
        sum += (long double)t->count[i] * number_at(t, i);
    }
    v->mean = any ? (double)(sum / (long double)v->count) : NAN;
    for (size_t i = 0; i < t->n; i++) {
        const long double d = number_at(t, i) - v->mean;
        m2 += (long double)t->count[i] * d * d;
    }
    v->deviation = any ? (double)sqrtl(m2 / (long double)v->count) : NAN;
}

static void set_entropy(vv_values *v)
{
    const double all = (double)(v->count - v->below - v->above);
    v->entropy = 0;
    for (size_t i = 0; i < v->n_bins; i++) {
        const double share = (double)v->bins[i] / all;
        v->entropy -= share > 0 ? share * log2(share) : 0;
    }
}

/* At most n bins of equally many whole numbers, of which `unit` are not told apart. */
static vvi_bins whole_bins(double lo, double hi, int n, double unit)
{
    const double numbers = hi - lo + 1, width = unit * ceil(numbers / unit / n);
    const int n_bins = (int)ceil(numbers / width);
    return (vvi_bins){lo - 0.5, lo - 0.5 + n_bins * width, n_bins};
}

/* unit: whole numbers that are not told apart; 0: the values are real. Where ends and number of the bins are both given
 * they are what was asked for, though whole numbers may then fall unevenly. */
static vvi_bins choose_bins(const vv_values_options *o, const vv_values *v, double lo, double hi, double unit)
{
    const int n = o->n_bins ? (int)o->n_bins : AUTOMATIC;
    const bool ends = !isnan(lo) || !isnan(hi);
    if (unit > 0 && !(ends && o->n_bins))
        return whole_bins(isnan(lo) ? v->min : ceil(lo), isnan(hi) ? v->max : floor(hi), n, ends ? 1 : unit);
    if (!o->n_bins && !ends)
        return vvi_bins_for(v->min, v->max, false);
    return (vvi_bins){isnan(lo) ? v->min : lo, isnan(hi) ? v->max : hi, n};
}

static size_t bin_of(const vvi_bins *b, double v)
{
    const double half = b->hi * 0.5 - b->lo * 0.5; /* the range of huge doubles is no double */
    const double at = half > 0 ? (v * 0.5 - b->lo * 0.5) * (b->n / half) : 0;
    return at > 0 ? at < b->n - 1 ? (size_t)at : (size_t)(b->n - 1) : 0;
}

/* From the counts of numbers into bins. */
static void fill_bins(vv_values *v, uint64_t *bins, const vvi_bins *b, const tally *t)
{
    v->lo = b->lo;
    v->hi = b->hi;
    v->n_bins = (size_t)b->n;
    for (size_t i = 0; i < t->n; i++) {
        const double number = number_at(t, i);
        uint64_t *const to = number < b->lo ? &v->below : number > b->hi ? &v->above : &bins[bin_of(b, number)];
        *to += t->count[i];
    }
}

/* Stored numbers to values --------------------------------------------------------------------------------------------
 */

static void to_value(double *v, const vv_field_info *info)
{
    *v = *v * info->value_scale + info->value_offset;
}

static void swap(double *a, double *b)
{
    const double t = *a;
    *a = *b;
    *b = t;
}

/* A negative scale turns the order round. */
static void to_values(vv_values *v, uint64_t *bins, const vv_field_info *info)
{
    double *const numbers[] = {&v->min, &v->max, &v->mean, &v->median, &v->mode, &v->lo, &v->hi};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        to_value(numbers[i], info);
    for (int p = 0; p < N_PERCENTS; p++)
        to_value(&v->percentile[p], info);
    v->deviation *= fabs(info->value_scale);
    v->within *= fabs(info->value_scale);
    if (info->value_scale > 0)
        return;
    swap(&v->min, &v->max);
    swap(&v->lo, &v->hi);
    const uint64_t below = v->below;
    v->below = v->above;
    v->above = below;
    for (int p = 0; p < N_PERCENTS / 2; p++)
        swap(&v->percentile[p], &v->percentile[N_PERCENTS - 1 - p]);
    for (size_t i = 0; i < v->n_bins / 2; i++) {
        const uint64_t t = bins[i];
        bins[i] = bins[v->n_bins - 1 - i];
        bins[v->n_bins - 1 - i] = t;
    }
}

/* The two ways
 * ---------------------------------------------------------------------------------------------------------- */

typedef struct request {
    vvi_value_samples samples;
    vv_values_options o;
    double lo, hi; /* stored; NaN: open */
    vv_values *v;
    uint64_t *bins;
    uint64_t *counts; /* room for FINE of them */
    vvi_selection selection;
} request;

/* By ascending number, as signed ones begin in the middle. */
static vv_status count_field(uint64_t *sorted, size_t n, const vvi_value_samples *s, vv_type type)
{
    const size_t turn = type == VV_TYPE_I8 || type == VV_TYPE_I16 ? n / 2 : 0;
    uint64_t *counts = vvi_alloc_zeroed(s->job, n * sizeof *counts, VVI_MEM_SCRATCH);
    if (!counts)
        return vv_fail_memory(n * sizeof *counts);
    const vv_status st = vvi_count_patterns(counts, s->field, s->component, s->job);
    for (size_t i = 0; i < n; i++)
        sorted[i] = counts[(i + turn) % n];
    vvi_free(counts);
    return st;
}

/* One bin a number. */
static vv_status count_object(uint64_t *sorted, size_t n, const vvi_value_samples *s, vv_type type)
{
    const double first = vvi_type_min(type);
    const vvi_bins bins = {first - 0.5, first - 0.5 + (double)n, (int)n};
    vvi_bin_counts counts;
    vv_status st = vvi_bin_counts_begin(&counts, &bins, s->job);
    if (st == VV_OK) {
        const vvi_pass pass = vvi_bin_counts_pass(&counts);
        st = vvi_value_samples_run(s, &pass, 1);
    }
    for (size_t i = 0; st == VV_OK && i < n; i++)
        sorted[i] = vvi_bin_counts_get(&counts, (int)i);
    vvi_bin_counts_end(&counts);
    return st;
}

/* Samples of 8 and 16 bits. */
static vv_status from_counts(request *r)
{
    const vvi_value_samples *s = &r->samples;
    const vv_type type = vv_field_get_info(s->field)->type;
    const size_t n = vv_type_bytes(type) == 1 ? 256 : 65536;
    const vv_status st = s->object ? count_object(r->counts, n, s, type) : count_field(r->counts, n, s, type);
    if (st != VV_OK)
        return st;
    const tally t = {r->counts, n, vvi_type_min(type), 1, true};
    set_moments(r->v, &t);
    if (r->v->count == 0)
        return VV_OK;
    set_percentiles(r->v, &t);
    set_mode(r->v, &t);
    const vvi_bins bins = choose_bins(&r->o, r->v, r->lo, r->hi, 1);
    fill_bins(r->v, r->bins, &bins, &t);
    return VV_OK;
}

/* The first pass over others: moments, and the first digits of what the percentiles are. */
static vv_status first_pass(request *r)
{
    const vvi_value_samples *s = &r->samples;
    const size_t n = vvi_value_samples_items(s);
    vvi_moments m, *parts;
    vv_status st = vvi_moments_begin(&parts, n, s->job);
    if (st == VV_OK)
        st = vvi_selection_begin(&r->selection, vv_field_get_info(s->field)->type, s->job);
    if (st == VV_OK) {
        const vvi_pass passes[2] = {vvi_moments_pass(parts), vvi_selection_pass(&r->selection)};
        st = vvi_value_samples_run(s, passes, 2);
    }
    vvi_moments_end(&m, parts, n);
    r->v->nan_count = m.nan_count;
    r->v->infinite_count = m.infinite_count;
    r->v->count = m.count;
    if (m.count == 0 || st != VV_OK)
        return st;
    r->v->min = m.min;
    r->v->max = m.max;
    r->v->mean = (double)m.mean;
    r->v->deviation = (double)sqrtl(m.m2 / (long double)m.count);
    return VV_OK;
}

/* Where each number is counted there is no more to look at. */
static vv_status exact_pass(request *r, const vvi_bins *fine)
{
    vvi_bin_counts counts = {0};
    vv_status st = vvi_bin_counts_begin(&counts, fine, r->samples.job);
    if (st == VV_OK) {
        const vvi_pass pass = vvi_bin_counts_pass(&counts);
        st = vvi_value_samples_run(&r->samples, &pass, 1);
    }
    for (int b = 0; st == VV_OK && b < fine->n; b++)
        r->counts[b] = vvi_bin_counts_get(&counts, b);
    vvi_bin_counts_end(&counts);
    if (st != VV_OK)
        return st;
    const tally t = {r->counts, (size_t)fine->n, r->v->min, 1, true};
    const bool whole = !vv_type_is_float(vv_field_get_info(r->samples.field)->type);
    const vvi_bins bins = choose_bins(&r->o, r->v, r->lo, r->hi, whole ? 1 : 0);
    set_percentiles(r->v, &t);
    set_mode(r->v, &t);
    fill_bins(r->v, r->bins, &bins, &t);
    return VV_OK;
}

/* Fine bins for the mode, those that were asked for, and the next digits, in one pass. */
static vv_status second_pass(request *r, vvi_bin_counts *fine, vvi_bin_counts *asked)
{
    bool done;
    const vv_status st = vvi_selection_descend(&r->selection, &done, r->samples.job);
    const vvi_pass passes[3] = {vvi_bin_counts_pass(fine), vvi_bin_counts_pass(asked),
                                vvi_selection_pass(&r->selection)};
    return st != VV_OK ? st : vvi_value_samples_run(&r->samples, passes, 3);
}

static vv_status other_passes(request *r)
{
    vvi_selection *s = &r->selection;
    bool done = false;
    vv_status st;
    while ((st = vvi_selection_descend(s, &done, r->samples.job)) == VV_OK && !done) {
        const vvi_pass pass = vvi_selection_pass(s);
        if ((st = vvi_value_samples_run(&r->samples, &pass, 1)) != VV_OK)
            return st;
    }
    for (int p = 0; p < N_PERCENTS && st == VV_OK; p++)
        r->v->percentile[p] = vvi_selection_percentile(s, p, percents[p], r->v->count);
    r->v->median = r->v->percentile[MEDIAN];
    return st;
}

static vv_status many_numbers(request *r, const vvi_bins *fine, double unit)
{
    const double width = fine->hi / fine->n - fine->lo / fine->n;
    const vvi_bins bins = choose_bins(&r->o, r->v, r->lo, r->hi, unit > 0 ? round(width) : 0);
    vvi_bin_counts few = {0}, many = {0};
    uint64_t ranks[2 * N_PERCENTS];
    vvi_quantile_ranks(ranks, percents, N_PERCENTS, r->v->count);
    vvi_selection_set_ranks(&r->selection, ranks, 2 * N_PERCENTS);
    vv_status st = vvi_bin_counts_begin(&few, &bins, r->samples.job);
    if (st == VV_OK && (st = vvi_bin_counts_begin(&many, fine, r->samples.job)) == VV_OK)
        st = second_pass(r, &many, &few);
    for (int b = 0; st == VV_OK && b < fine->n; b++)
        r->counts[b] = vvi_bin_counts_get(&many, b);
    for (int b = 0; st == VV_OK && b < bins.n; b++)
        r->bins[b] = vvi_bin_counts_get(&few, b);
    if (st == VV_OK) {
        const tally t = {r->counts, (size_t)fine->n, fine->lo, width, false};
        set_mode(r->v, &t);
        r->v->lo = bins.lo;
        r->v->hi = bins.hi;
        r->v->n_bins = (size_t)bins.n;
        r->v->below = vvi_bin_counts_get(&few, bins.n);
        r->v->above = vvi_bin_counts_get(&few, bins.n + 1);
    }
    vvi_bin_counts_end(&few);
    vvi_bin_counts_end(&many);
    return st == VV_OK ? other_passes(r) : st;
}

/* Whole numbers have one bin each, or equally many share one. */
static vv_status from_passes(request *r)
{
    const vv_type type = vv_field_get_info(r->samples.field)->type;
    const vv_status st = first_pass(r);
    const double lo = r->v->min, hi = r->v->max;
    if (st != VV_OK || r->v->count == 0)
        return st;
    const bool whole = !vv_type_is_float(type) && hi - lo < 0x1p50 && fabs(lo) < 0x1p50;
    vvi_bins fine = whole ? whole_bins(lo, hi, FINE, 1) : (vvi_bins){lo, hi, FINE};
    if (!(hi > lo))
        fine.n = 1;
    const bool exact = fine.n == 1 || (whole && hi - lo < FINE);
    return exact ? exact_pass(r, &fine) : many_numbers(r, &fine, whole ? 1 : 0);
}

static vv_status check(request *r)
{
    const vv_field_info *info = vv_field_get_info(r->samples.field);
    const vv_values_options *o = &r->o;
    if (o->component < 0 || o->component >= info->components)
        return vv_fail(VV_E_ARGUMENT, "channel %d does not exist; the field has %d, counted from 0", o->component,
                       info->components);
    if (o->n_bins && (o->n_bins < 2 || o->n_bins > FINE))
        return vv_fail(VV_E_ARGUMENT, "%lld bins: expected 2 to %d", (long long)o->n_bins, FINE);
    if (o->lo >= o->hi)
        return vv_fail(VV_E_ARGUMENT, "bins from %g to %g: the end must be above the beginning", o->lo, o->hi);
    r->lo = (o->lo - info->value_offset) / info->value_scale;
    r->hi = (o->hi - info->value_offset) / info->value_scale;
    if (info->value_scale < 0)
        swap(&r->lo, &r->hi);
    return VV_OK;
}

static vv_status work(request *r)
{
    const vv_field_info *info = vv_field_get_info(r->samples.field);
    r->counts = vvi_alloc_zeroed(r->samples.job, FINE * sizeof *r->counts, VVI_MEM_SCRATCH);
    if (!r->counts)
        return vv_fail_memory(FINE * sizeof *r->counts);
    vv_status st = vv_type_bytes(info->type) <= 2 ? from_counts(r) : from_passes(r);
    if (st == VV_OK)
        st = vv_field_health(r->samples.field);
    vvi_selection_end(&r->selection);
    vvi_free(r->counts);
    if (st == VV_OK && r->v->count) {
        to_values(r->v, r->bins, info);
        set_entropy(r->v);
    }
    return st;
}

static vv_status with_object(request *r)
{
    const vv_measure_options *of = r->o.of;
    vvi_object object;
    vvi_region region;
    vv_status st = vvi_object_open(&object, r->samples.field, of, 1, r->samples.job);
    if (st == VV_OK && of->seeded)
        st = vvi_object_track(&object, of->seed);
    if (st == VV_OK)
        st = vvi_region_init(&region, &vv_field_get_info(r->samples.field)->grid, &of->box, 0.5, of->planes,
                             of->n_planes);
    r->samples.object = &object;
    r->samples.region = &region;
    if (st == VV_OK)
        st = work(r);
    vvi_object_close(&object);
    return st;
}

vv_status vv_measure_values(vv_values **out, const vv_field *field, const vv_values_options *options, vv_job *job)
{
    const size_t bytes = sizeof(vv_values) + FINE * sizeof(uint64_t);
    request r = {.samples = {.field = field, .job = job}};
    *out = NULL;
    vv_values_options_init(&r.o, sizeof r.o);
    if (options)
        memcpy(&r.o, options, options->size < sizeof r.o ? options->size : sizeof r.o);
    r.samples.component = r.o.component;
    vv_status st = check(&r);
    if (st != VV_OK)
        return st;
    r.v = vvi_alloc_zeroed(job, bytes, VVI_MEM_DERIVED);
    if (!r.v)
        return vv_fail_memory(bytes);
    r.bins = (uint64_t *)(r.v + 1);
    *r.v = (vv_values){.size = sizeof *r.v,
                       .min = NAN,
                       .max = NAN,
                       .mean = NAN,
                       .deviation = NAN,
                       .median = NAN,
                       .mode = NAN,
                       .bins = r.bins};
    for (int p = 0; p < N_PERCENTS; p++)
        r.v->percentile[p] = NAN;
    if ((st = r.o.of ? with_object(&r) : work(&r)) == VV_OK)
        *out = r.v;
    else
        vv_values_free(r.v);
    return st;
}
