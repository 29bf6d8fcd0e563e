/* The histogram tells whether a fill is possible, a look at all samples whether it is one. */
#include "grid/fill_value.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "grid/value_fit.h"
#include "grid/value_pass.h"
#include <float.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LEAST_OTHERS = 16 };
#define KNOWN_SHARE 1e-3
#define OTHER_SHARE 0.05
#define KNOWN_GAP 2.0 /* times the range of all others */
#define SATURATED_GAP 8.0
#define OTHER_GAP 1000.0
#define DECLARED_GAP 0.02

static bool is_near(double a, double b)
{
    return fabs(a - b) <= 1e-6 * fabs(b);
}

/* Nothing but nines, or with one of them behind the point. */
static bool is_nines(double size)
{
    for (int64_t nines = 99; nines < INT64_C(10000000000); nines = 10 * nines + 9)
        if (is_near(size, (double)nines) || (nines > 99 && is_near(size, (double)nines + 0.9)))
            return true;
    return false;
}

static bool is_power_of_ten(double size)
{
    const double power = round(log10(size));
    return power >= 10 && is_near(size, pow(10, power));
}

/* The ends of types of more than 8 bits, and what netCDF writes for nothing. */
static bool is_end_of_type(double value)
{
    static const double ends[] = {-32768,       -32767,  32767,  65535,  -2147483648.0, -2147483647.0, 2147483647.0,
                                  4294967295.0, -0x1p63, 0x1p63, 0x1p64, FLT_MAX,       DBL_MAX,       0x1.ep122};
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++)
        if (is_near(value, ends[i]) || (fabs(ends[i]) >= FLT_MAX && is_near(-value, ends[i])))
            return true;
    return false;
}

static bool is_known(double value)
{
    const double size = fabs(value);
    return (is_nines(size) && (value < 0 || size > 99)) || is_power_of_ten(size) || is_end_of_type(value) ||
           value == -999.25;
}

/* Where integers end, what is brighter is counted too. */
static bool may_be_saturated(double value, vv_type type, bool upper)
{
    return upper && !vv_type_is_float(type) && is_end_of_type(value);
}

typedef struct fill_rule {
    double share, gap;
} fill_rule;

/* upper: it lies above what is stored of all others. */
static fill_rule rule_of(double stored, const vv_field_info *info, bool upper)
{
    if (!is_known(stored * info->value_scale + info->value_offset) && !is_known(stored))
        return (fill_rule){OTHER_SHARE, OTHER_GAP};
    return (fill_rule){KNOWN_SHARE, may_be_saturated(stored, info->type, upper) ? SATURATED_GAP : KNOWN_GAP};
}

/* Whether the histogram leaves room for a fill in its first or last bin; with another in the bin at the other end.
 * Bins are coarse: others that share one bin may be anywhere in it. */
static bool may_be_fill(const vv_statistics *s, bool upper, bool both, const fill_rule *rule)
{
    const int fill = upper ? s->n_bins - 1 : 0, step = upper ? -1 : 1, end = upper ? 0 : s->n_bins - 1;
    int near = fill + step, far = both ? end - step : end;
    if (s->n_bins < 4 || (double)s->histogram[fill] < rule->share * (double)s->count)
        return false;
    while (near != far && !s->histogram[near])
        near += step;
    while (far != near && !s->histogram[far])
        far -= step;
    const double gap = abs(near - fill), others = abs(far - near) - 1;
    return s->histogram[near] > 0 && gap >= fmin(rule->gap, 0.5 * s->n_bins) * others;
}

/* All samples ------------------------------------------------------------------------------------------------------ */

typedef struct others {
    uint64_t n_fill[VVI_FILLS_MOST], n;
    double lo, hi;
    double some[LEAST_OTHERS]; /* different ones */
    int n_some;
} others;

/* What may be a fill, as it is stored. */
typedef struct candidate {
    double lo, hi;
    bool upper, declared;
} candidate;

typedef struct counting {
    candidate fill[VVI_FILLS_MOST];
    int n_fills;
    others all;
    pthread_mutex_t mutex;
} counting;

static void add_some(others *o, double value)
{
    for (int i = 0; i < o->n_some; i++)
        if (o->some[i] == value)
            return;
    if (o->n_some < LEAST_OTHERS)
        o->some[o->n_some++] = value;
}

static void widen(others *o, double lo, double hi)
{
    o->lo = o->n ? fmin(o->lo, lo) : lo;
    o->hi = o->n ? fmax(o->hi, hi) : hi;
}

static int find_candidate(const counting *c, double v)
{
    for (int i = 0; i < c->n_fills; i++)
        if (v >= c->fill[i].lo && v <= c->fill[i].hi)
            return i;
    return -1;
}

static void take(void *user, void *scratch, size_t item, const double *values, size_t n)
{
    const counting *c = user;
    others *o = scratch;
    double lo = INFINITY, hi = -INFINITY;
    uint64_t n_others = 0;
    (void)item;
    for (size_t i = 0; i < n; i++) {
        const double v = values[i];
        const int fill = find_candidate(c, v);
        if (fill >= 0) {
            o->n_fill[fill]++;
        } else if (isfinite(v)) {
            lo = v < lo ? v : lo;
            hi = v > hi ? v : hi;
            n_others++;
            if (o->n_some < LEAST_OTHERS)
                add_some(o, v);
        }
    }
    if (n_others)
        widen(o, lo, hi);
    o->n += n_others;
}

static void finish(void *user, void *scratch)
{
    counting *c = user;
    const others *o = scratch;
    pthread_mutex_lock(&c->mutex);
    if (o->n)
        widen(&c->all, o->lo, o->hi);
    c->all.n += o->n;
    for (int i = 0; i < c->n_fills; i++)
        c->all.n_fill[i] += o->n_fill[i];
    for (int i = 0; i < o->n_some; i++)
        add_some(&c->all, o->some[i]);
    pthread_mutex_unlock(&c->mutex);
}

typedef struct question {
    const vv_field *field;
    int component;
    candidate first[2];
    int n;
} question;

static vv_status count(counting *c, const question *q, vv_job *job)
{
    const vvi_pass pass = {"statistics", sizeof(others), take, finish, c};
    c->all = (others){0};
    pthread_mutex_init(&c->mutex, NULL);
    const vv_status st = vvi_pass_run(&pass, q->field, q->component, job);
    pthread_mutex_destroy(&c->mutex);
    return st;
}

static uint64_t count_all(const counting *c)
{
    uint64_t n = c->all.n;
    for (int i = 0; i < c->n_fills; i++)
        n += c->all.n_fill[i];
    return n;
}

static bool is_fill(const counting *c, int i, const vv_field_info *info)
{
    const candidate *f = &c->fill[i];
    const others *o = &c->all;
    const fill_rule rule = f->declared ? (fill_rule){0, DECLARED_GAP} : rule_of(f->lo, info, f->upper);
    const double gap = f->upper ? f->lo - o->hi : o->lo - f->hi;
    return o->n_some >= LEAST_OTHERS && o->n_fill[i] > 0 && gap > 0 &&
           (double)o->n_fill[i] >= rule.share * (double)count_all(c) && gap / rule.gap >= o->hi - o->lo;
}

/* What is none joins the others. */
static void drop(counting *c, int i)
{
    others *o = &c->all;
    if (o->n_fill[i]) {
        widen(o, c->fill[i].lo, c->fill[i].hi);
        o->n += o->n_fill[i];
        add_some(o, c->fill[i].lo);
    }
    c->n_fills--;
    memmove(&c->fill[i], &c->fill[i + 1], (size_t)(c->n_fills - i) * sizeof *c->fill);
    memmove(&o->n_fill[i], &o->n_fill[i + 1], (size_t)(c->n_fills - i) * sizeof *o->n_fill);
}

/* Those from `first` on were not judged before. */
static void judge(counting *c, int first, const vv_field_info *info)
{
    for (int i = first; i < c->n_fills;)
        if (is_fill(c, i, info)) {
            i++;
        } else {
            drop(c, i);
            i = first; /* the others reach further now */
        }
}

/* Behind one fill there may be another: -999 between -9999 and the values. */
static void add_known(counting *c, const vv_field_info *info)
{
    for (int upper = 0; upper < 2 && c->n_fills < VVI_FILLS_MOST; upper++) {
        const double end = upper ? c->all.hi : c->all.lo, value = end * info->value_scale + info->value_offset;
        if (c->all.n && value != 0 && (is_known(value) || is_known(end)))
            c->fill[c->n_fills++] = (candidate){end, end, upper, false};
    }
}

static void tell(vvi_fills *out, const counting *c, const vv_field_info *info)
{
    const double a = c->all.lo * info->value_scale + info->value_offset;
    const double b = c->all.hi * info->value_scale + info->value_offset;
    out->lo = fmin(a, b);
    out->hi = fmax(a, b);
    out->n = c->n_fills;
    for (int i = 0; i < c->n_fills; i++) {
        const candidate *f = &c->fill[i];
        out->fill[i] = (vvi_fill){.lo = f->lo,
                                  .hi = f->hi,
                                  .value = f->lo * info->value_scale + info->value_offset,
                                  .share = (double)c->all.n_fill[i] / (double)count_all(c),
                                  .declared = f->declared};
    }
}

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const question *q = user;
    const vv_field_info *info = vv_field_get_info(q->field);
    counting c = {.n_fills = q->n};
    vvi_fills *found = vvi_alloc_zeroed(job, sizeof *found, VVI_MEM_DERIVED);
    if (!found)
        return vv_fail_memory(sizeof *found);
    memcpy(c.fill, q->first, sizeof q->first);
    for (int known = 0; c.n_fills > known;) {
        const vv_status st = count(&c, q, job);
        if (st != VV_OK) {
            vvi_free(found);
            return st;
        }
        judge(&c, known, info);
        if (c.n_fills == known)
            break;
        known = c.n_fills;
        tell(found, &c, info);
        add_known(&c, info);
    }
    *value_out = found;
    *bytes_out = sizeof *found;
    return VV_OK;
}

/* What the file says, else the value at that end itself. */
static candidate candidate_of(const vv_field *field, double value, bool upper)
{
    const vv_field_info *info = vv_field_get_info(field);
    double padding[2], stored = (value - info->value_offset) / info->value_scale;
    if (!vv_type_is_float(info->type))
        stored = round(stored);
    const bool above = upper == (info->value_scale > 0);
    if (vvi_field_padding(padding, field) && stored >= padding[0] && stored <= padding[1])
        return (candidate){padding[0], padding[1], above, true};
    return (candidate){stored, stored, above, false};
}

static void ask(question *q, const vv_statistics *s)
{
    const vv_field_info *info = vv_field_get_info(q->field);
    candidate end[2];
    fill_rule rule[2];
    bool known[2];
    for (int upper = 0; upper < 2; upper++) {
        end[upper] = candidate_of(q->field, upper ? s->max : s->min, upper);
        rule[upper] = rule_of(end[upper].lo, info, end[upper].upper);
        known[upper] = rule[upper].share == KNOWN_SHARE || end[upper].declared;
    }
    for (int upper = 0; upper < 2; upper++) {
        const bool told = end[upper].declared;
        const bool wide = vv_type_bytes(info->type) > 1 && (upper ? s->max : s->min) != 0;
        if (told || (wide && (may_be_fill(s, upper, false, &rule[upper]) ||
                              (known[!upper] && may_be_fill(s, upper, true, &rule[upper])))))
            q->first[q->n++] = end[upper];
    }
}

vv_status vvi_fills_find(vvi_fills *out, const vv_field *field, int component, const vv_statistics *s, vv_job *job)
{
    const vvi_cache_key key = {"fills", vv_field_identity(field), (uint64_t)component};
    question q = {.field = field, .component = component};
    vvi_cached *cached;
    *out = (vvi_fills){0};
    if (vvi_job_keeps_fills(job) || s->count == 0)
        return VV_OK;
    ask(&q, s);
    if (q.n == 0)
        return VV_OK;
    const vv_status st = vvi_cache_get(&cached, &key, make, vvi_free, &q, job);
    if (st != VV_OK)
        return st;
    *out = *(const vvi_fills *)vvi_cached_value(cached);
    vvi_cache_release(cached);
    return VV_OK;
}

/* What was found ------------------------------------------------------------------------------------------------- */

void vvi_fills_keep(vvi_fills *fills, double lo, double hi)
{
    int n = 0;
    for (int i = 0; i < fills->n; i++)
        if (!(fills->fill[i].value >= lo && fills->fill[i].value <= hi))
            fills->fill[n++] = fills->fill[i];
    fills->n = n;
}

bool vvi_fills_above(const vvi_fills *fills)
{
    for (int i = 0; i < fills->n; i++)
        if (fills->fill[i].value > fills->hi)
            return true;
    return false;
}

bool vvi_fills_have(const vvi_fills *fills, double stored)
{
    for (int i = 0; i < fills->n; i++)
        if (stored >= fills->fill[i].lo && stored <= fills->fill[i].hi)
            return true;
    return false;
}

void vvi_fills_print(char out[VVI_FILL_TEXT], const vvi_fills *fills)
{
    bool declared = false;
    size_t at = 0;
    out[0] = 0;
    for (int i = 0; i < fills->n && at < VVI_FILL_TEXT; i++) {
        const vvi_fill *f = &fills->fill[i];
        declared |= f->declared;
        at += (size_t)snprintf(out + at, VVI_FILL_TEXT - at, "%s%.2g %% %sare %.9g%s",
                               i == 0             ? ""
                               : i < fills->n - 1 ? ", "
                                                  : " and ",
                               100 * f->share, i ? "" : "of the samples ", f->value,
                               f->declared ? ", padding as the file says" : "");
    }
    if (at < VVI_FILL_TEXT)
        snprintf(out + at, VVI_FILL_TEXT - at, ", %s from all others (%.6g to %.6g)", declared ? "apart" : "far",
                 fills->lo, fills->hi);
}
