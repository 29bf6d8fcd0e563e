/* Statistics and histogram of all samples, or of those of an object. Everything here is in stored numbers until the
 * last step. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/pass.h"
#include "grid/statistics.h"
#include "measure/sums.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

#define FINE 65536 /* bins of samples of more than 16 bits: their percentiles are within one */
#define AUTOMATIC 1024
#define OUTSIDE 2 /* counts behind those of the bins: what is below, and above them */
#define N_PERCENTS ((int)(sizeof percents / sizeof *percents))

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

/* Samples of an object, slice by slice ------------------------------------------------------------------------------
 */

typedef struct shared {
    const vv_field *field;
    int component;
    const vvi_object *object;
    const vvi_region *region;
    vv_job *job;
    bool moments;      /* else counts */
    vvi_moments *part; /* of each slice */
    bool patterns;     /* counts by bit pattern, else by bins */
    vvi_bins bins;
    size_t n_counts;
    _Atomic uint64_t *total;
} shared;

typedef struct worker {
    uint64_t *bits, *count;
    double *row;
} worker;

static vv_status start(void **scratch_out, void *user, int number)
{
    (void)number;
    const shared *s = user;
    const size_t bits = (size_t)s->object->n[1] * s->object->words, n = (size_t)s->object->n[0];
    const size_t bytes = sizeof(worker) + bits * 8 + s->n_counts * 8 + n * 8;
    worker *w = vvi_alloc_zeroed(s->job, bytes, VVI_MEM_SCRATCH);
    *scratch_out = w;
    if (!w)
        return vv_fail_memory(bytes);
    w->bits = (uint64_t *)(w + 1);
    w->count = w->bits + bits;
    w->row = (double *)(w->count + s->n_counts);
    return VV_OK;
}

static void finish(void *scratch, void *user)
{
    shared *s = user;
    worker *w = scratch;
    for (size_t i = 0; w && i < s->n_counts; i++)
        if (w->count[i])
            atomic_fetch_add_explicit(&s->total[i], w->count[i], memory_order_relaxed);
    vvi_free(w);
}

static size_t bin_of(const vvi_bins *b, double v)
{
    const double half = b->hi * 0.5 - b->lo * 0.5; /* the range of huge doubles is no double */
    const double at = half > 0 ? (v * 0.5 - b->lo * 0.5) * (b->n / half) : 0;
    return at > 0 ? at < b->n - 1 ? (size_t)at : (size_t)(b->n - 1) : 0;
}

/* Where a number is counted: its bin; behind the bins what is below them, and then what is above. */
static size_t slot_of(const vvi_bins *b, double v)
{
    return v < b->lo ? (size_t)b->n : v > b->hi ? (size_t)b->n + 1 : bin_of(b, v);
}

static void take(const shared *s, worker *w, vvi_moments *m, const char *at, vv_type type, size_t *n)
{
    double v;
    vvi_samples_to_f64(&v, at, type, 1);
    if (m)
        w->row[(*n)++] = v;
    else if (s->patterns)
        w->count[(uint32_t)(int32_t)v & (vv_type_bytes(type) == 1 ? 0xff : 0xffff)]++;
    else if (v - v == 0)
        w->count[slot_of(&s->bins, v)]++;
}

static void take_row(const shared *s, worker *w, vvi_moments *m, const uint64_t *bits, vvi_interval in,
                     const vv_brick *brick, const char *row)
{
    size_t n = 0;
    for (int64_t word = 0; word < (int64_t)s->object->words; word++)
        for (uint64_t left = bits[word] & vvi_interval_bits(in, word); left; left &= left - 1)
            take(s, w, m, row + (64 * word + __builtin_ctzll(left)) * brick->stride[0], brick->type, &n);
    if (m)
        vvi_moments_add(m, w->row, n);
}

static vv_status slice_item(void *scratch, void *user, size_t index)
{
    worker *w = scratch;
    const shared *s = user;
    const vvi_object *o = s->object;
    const vv_box box = {{0, 0, (int64_t)index}, {o->n[0], o->n[1], 1}};
    vvi_moments *m = s->moments ? &s->part[index] : NULL;
    vv_brick brick;
    vv_status st = vvi_object_slice(w->bits, o, (int64_t)index);
    if (st != VV_OK || (st = vv_field_brick(&brick, s->field, &box, s->job)) != VV_OK)
        return st;
    if (m)
        vvi_moments_init(m);
    const char *first = (const char *)brick.data + (size_t)s->component * vv_type_bytes(brick.type);
    for (int64_t j = 0; j < o->n[1]; j++) {
        const vvi_interval in = vvi_region_points(s->region, (vv_vec3){0, 0, 0}, j, (int64_t)index, 0, o->n[0]);
        take_row(s, w, m, w->bits + (size_t)j * o->words, in, &brick, first + j * brick.stride[1]);
    }
    vv_brick_release(&brick);
    return VV_OK;
}

static vv_status object_counts(uint64_t *counts, size_t n, shared *s)
{
    static const vvi_work work = {.stage = "values", .start = start, .item = slice_item, .finish = finish};
    s->n_counts = n;
    s->moments = false;
    s->total = vvi_alloc_zeroed(s->job, n * sizeof *s->total, VVI_MEM_SCRATCH);
    if (!s->total)
        return vv_fail_memory(n * sizeof *s->total);
    const vv_status st = vvi_parallel_for(s->job, &work, s, (size_t)s->object->n[2]);
    for (size_t i = 0; i < n; i++)
        counts[i] = atomic_load_explicit(&s->total[i], memory_order_relaxed);
    vvi_free(s->total);
    return st;
}

static vv_status object_moments(vvi_moments *out, shared *s)
{
    static const vvi_work work = {.stage = "values", .start = start, .item = slice_item, .finish = finish};
    const size_t n = (size_t)s->object->n[2];
    s->n_counts = 0;
    s->moments = true;
    s->part = vvi_alloc_zeroed(s->job, n * sizeof *s->part, VVI_MEM_SCRATCH);
    if (!s->part)
        return vv_fail_memory(n * sizeof *s->part);
    const vv_status st = vvi_parallel_for(s->job, &work, s, n);
    vvi_moments_init(out);
    for (size_t i = 0; i < n && st == VV_OK; i++)
        vvi_moments_join(out, &s->part[i]);
    vvi_free(s->part);
    return st;
}

/* All samples, for which there are faster ways ------------------------------------------------------------------------
 */

typedef struct all_bins {
    vvi_bins bins;
    double half_lo, per_half;
    _Atomic uint64_t *total;
} all_bins;

static void take_all(void *user, void *scratch, size_t item, const double *values, size_t n)
{
    (void)item;
    const all_bins *a = user;
    uint32_t *count = scratch, bin[VVI_PASS_RUN];
    const double last = a->bins.n - 1;
    for (size_t i = 0; i < n; i++) {
        const double at = (values[i] * 0.5 - a->half_lo) * a->per_half;
        const double above = at > 0 ? at : 0, inside = above < last ? above : last;
        const double slot = values[i] < a->bins.lo ? last + 1 : values[i] > a->bins.hi ? last + 2 : inside;
        bin[i] = values[i] - values[i] == 0 ? (uint32_t)(int32_t)slot : FINE + OUTSIDE;
    }
    for (size_t i = 0; i < n; i++)
        if (count[bin[i]]++ == UINT32_MAX) { /* before a 32-bit count can wrap */
            atomic_fetch_add_explicit(&a->total[bin[i]], (uint64_t)1 << 32, memory_order_relaxed);
        }
}

static void finish_all(void *user, void *scratch)
{
    const all_bins *a = user;
    const uint32_t *count = scratch;
    for (int b = 0; count && b < a->bins.n + OUTSIDE; b++)
        if (count[b])
            atomic_fetch_add_explicit(&a->total[b], count[b], memory_order_relaxed);
}

static vv_status count_all(uint64_t *counts, const vvi_bins *bins, const vv_field *field, int component, vv_job *job)
{
    const double half = bins->hi * 0.5 - bins->lo * 0.5;
    all_bins a = {*bins, bins->lo * 0.5, half > 0 ? bins->n / half : 0, NULL};
    const vvi_pass pass = {.stage = "histogram",
                           .scratch_bytes = (FINE + OUTSIDE + 1) * sizeof(uint32_t),
                           .take = take_all,
                           .finish = finish_all,
                           .user = &a};
    a.total = vvi_alloc_zeroed(job, (FINE + OUTSIDE + 1) * sizeof *a.total, VVI_MEM_SCRATCH);
    if (!a.total)
        return vv_fail_memory((FINE + OUTSIDE + 1) * sizeof *a.total);
    const vv_status st = vvi_pass_run(&pass, field, component, job);
    for (int b = 0; b < bins->n + OUTSIDE; b++)
        counts[b] = atomic_load_explicit(&a.total[b], memory_order_relaxed);
    vvi_free(a.total);
    return st;
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

/* The sample of a rank, 1 the least; those in a bin are taken as spread evenly. */
static double number_of_rank(const tally *t, double wanted)
{
    uint64_t below = 0;
    for (size_t i = 0; i < t->n; i++) {
        const uint64_t here = t->count[i];
        if (here && (double)(below + here) >= wanted)
            return t->exact ? number_at(t, i)
                            : t->first + ((double)i + (wanted - (double)below) / (double)here) * t->step;
        below += here;
    }
    return NAN;
}

static double clamped(const vv_values *v, double number)
{
    return fmin(fmax(number, v->min), v->max);
}

static void set_ranks(vv_values *v, const tally *t)
{
    const double n = (double)v->count;
    for (int p = 0; p < N_PERCENTS; p++)
        v->percentile[p] = clamped(v, number_of_rank(t, fmax(1, ceil(percents[p] / 100 * n))));
    v->median = clamped(v, (number_of_rank(t, ceil(n / 2)) + number_of_rank(t, floor(n / 2) + 1)) / 2);
    size_t most = 0;
    for (size_t i = 0; i < t->n; i++)
        most = t->count[i] > t->count[most] ? i : most;
    v->mode = number_at(t, most);
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

/* From the counts of numbers, or of fine bins, into coarser ones. */
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
    shared shared;
    vv_values_options o;
    double lo, hi; /* stored; NaN: open */
    vv_values *v;
    uint64_t *bins;
} request;

/* By ascending number, as signed ones begin in the middle. */
static void sort_patterns(uint64_t *out, const uint64_t *counts, size_t n, vv_type type)
{
    const size_t turn = type == VV_TYPE_I8 || type == VV_TYPE_I16 ? n / 2 : 0;
    for (size_t i = 0; i < n; i++)
        out[i] = counts[(i + turn) % n];
}

static vv_status from_patterns(request *r, uint64_t *counts, uint64_t *sorted)
{
    const shared *s = &r->shared;
    const vv_type type = vv_field_get_info(s->field)->type;
    const size_t n = vv_type_bytes(type) == 1 ? 256 : 65536;
    const vv_status st =
        s->object ? object_counts(counts, n, &r->shared) : vvi_count_patterns(counts, s->field, s->component, s->job);
    if (st != VV_OK)
        return st;
    sort_patterns(sorted, counts, n, type);
    const tally t = {sorted, n, vvi_type_min(type), 1, true};
    set_moments(r->v, &t);
    if (r->v->count == 0)
        return VV_OK;
    set_ranks(r->v, &t);
    const vvi_bins bins = choose_bins(&r->o, r->v, r->lo, r->hi, 1);
    fill_bins(r->v, r->bins, &bins, &t);
    return VV_OK;
}

/* counts: of bins, and OUTSIDE behind them. */
static vv_status count_into(uint64_t *counts, shared *s, const vvi_bins *bins)
{
    s->bins = *bins;
    return s->object ? object_counts(counts, (size_t)bins->n + OUTSIDE, s)
                     : count_all(counts, bins, s->field, s->component, s->job);
}

/* Fine bins are too coarse where a few samples lie far away: into what was asked for samples are counted once more. */
static vv_status count_again(request *r, uint64_t *counts, const vvi_bins *bins)
{
    const vv_status st = count_into(counts, &r->shared, bins);
    r->v->lo = bins->lo;
    r->v->hi = bins->hi;
    r->v->n_bins = (size_t)bins->n;
    memcpy(r->bins, counts, r->v->n_bins * sizeof *counts);
    r->v->below = counts[bins->n];
    r->v->above = counts[bins->n + 1];
    return st;
}

static vv_status from_passes(request *r, uint64_t *counts)
{
    shared *s = &r->shared;
    const vv_type type = vv_field_get_info(s->field)->type;
    vvi_moments m;
    vv_status st = s->object ? object_moments(&m, s) : vvi_field_moments(&m, s->field, s->component, s->job);
    if (st != VV_OK)
        return st;
    r->v->nan_count = m.nan_count;
    r->v->infinite_count = m.infinite_count;
    r->v->count = m.count;
    if (m.count == 0)
        return VV_OK;
    r->v->min = m.min;
    r->v->max = m.max;
    r->v->mean = (double)m.mean;
    r->v->deviation = (double)sqrtl(m.m2 / (long double)m.count);
    /* whole numbers have one each, or equally many share one */
    const bool whole = !vv_type_is_float(type) && m.max - m.min < 0x1p50 && fabs(m.min) < 0x1p50;
    vvi_bins fine = whole ? whole_bins(m.min, m.max, FINE, 1) : (vvi_bins){m.min, m.max, FINE};
    if (!(m.max > m.min))
        fine.n = 1;
    if ((st = count_into(counts, s, &fine)) != VV_OK)
        return st;
    const double width = fine.hi / fine.n - fine.lo / fine.n;
    const bool exact = (whole && width < 1.5) || fine.n == 1;
    const tally t = {counts, (size_t)fine.n, exact ? m.min : fine.lo, exact ? 1 : width, exact};
    set_ranks(r->v, &t);
    const vvi_bins bins = choose_bins(&r->o, r->v, r->lo, r->hi, whole ? round(exact ? 1 : width) : 0);
    if (!exact)
        return count_again(r, counts, &bins);
    fill_bins(r->v, r->bins, &bins, &t);
    return VV_OK;
}

static vv_status check(request *r)
{
    const vv_field_info *info = vv_field_get_info(r->shared.field);
    const vv_values_options *o = &r->o;
    if (o->component < 0 || o->component >= info->components)
        return vv_fail(VV_E_ARGUMENT, "component %d does not exist; the field has %d, counted from 0", o->component,
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
    const vv_field_info *info = vv_field_get_info(r->shared.field);
    uint64_t *counts = vvi_alloc_zeroed(r->shared.job, (size_t)(2 * FINE + OUTSIDE) * sizeof *counts, VVI_MEM_SCRATCH);
    if (!counts)
        return vv_fail_memory((size_t)(2 * FINE + OUTSIDE) * sizeof *counts);
    r->shared.patterns = vv_type_bytes(info->type) <= 2;
    vv_status st = r->shared.patterns ? from_patterns(r, counts, counts + FINE) : from_passes(r, counts);
    if (st == VV_OK)
        st = vv_field_health(r->shared.field);
    vvi_free(counts);
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
    vv_status st = vvi_object_open(&object, r->shared.field, of, 1, r->shared.job);
    if (st == VV_OK && of->seeded)
        st = vvi_object_track(&object, of->seed);
    if (st == VV_OK)
        st = vvi_region_init(&region, &vv_field_get_info(r->shared.field)->grid, &of->box, 0.5, of->planes,
                             of->n_planes);
    r->shared.object = &object;
    r->shared.region = &region;
    if (st == VV_OK)
        st = work(r);
    vvi_object_close(&object);
    return st;
}

vv_status vv_measure_values(vv_values **out, const vv_field *field, const vv_values_options *options, vv_job *job)
{
    const size_t bytes = sizeof(vv_values) + FINE * sizeof(uint64_t);
    request r = {.shared = {.field = field, .job = job}};
    *out = NULL;
    vv_values_options_init(&r.o, sizeof r.o);
    if (options)
        memcpy(&r.o, options, options->size < sizeof r.o ? options->size : sizeof r.o);
    r.shared.component = r.o.component;
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
