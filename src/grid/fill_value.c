/* The histogram tells whether a fill is possible, a look at all samples whether it is one. */
#include "grid/fill_value.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/pass.h"
#include "grid/value_fit.h"
#include <float.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>

enum { LEAST_OTHERS = 16 };
#define KNOWN_SHARE 1e-3
#define OTHER_SHARE 0.05
#define KNOWN_GAP 2.0 /* times the range of all others */
#define SATURATED_GAP 8.0
#define OTHER_GAP 1000.0

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

static fill_rule rule_of(double value, const vv_field_info *info, bool upper)
{
    const double stored = (value - info->value_offset) / info->value_scale;
    if (!is_known(value) && !is_known(stored))
        return (fill_rule){OTHER_SHARE, OTHER_GAP};
    return (fill_rule){KNOWN_SHARE, may_be_saturated(stored, info->type, upper) ? SATURATED_GAP : KNOWN_GAP};
}

/* Whether the histogram leaves room for a fill in its first or last bin. Bins are coarse: others that share one bin may
 * be anywhere in it. */
static bool may_be_fill(const vv_statistics *s, bool upper, const fill_rule *rule)
{
    const int fill = upper ? s->n_bins - 1 : 0, step = upper ? -1 : 1;
    int near = fill + step, far = upper ? 0 : s->n_bins - 1;
    if (s->n_bins < 3 || (double)s->histogram[fill] < rule->share * (double)s->count)
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
    uint64_t n_fill, n;
    double lo, hi;
    double some[LEAST_OTHERS]; /* different ones */
    int n_some;
} others;

typedef struct counting {
    double fill; /* stored */
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

static void take(void *user, void *scratch, size_t item, const double *values, size_t n)
{
    const counting *c = user;
    others *o = scratch;
    (void)item;
    for (size_t i = 0; i < n; i++) {
        const double v = values[i];
        if (v == c->fill) {
            o->n_fill++;
        } else if (isfinite(v)) {
            o->lo = o->n ? fmin(o->lo, v) : v;
            o->hi = o->n ? fmax(o->hi, v) : v;
            o->n++;
            if (o->n_some < LEAST_OTHERS)
                add_some(o, v);
        }
    }
}

static void finish(void *user, void *scratch)
{
    counting *c = user;
    const others *o = scratch;
    pthread_mutex_lock(&c->mutex);
    if (o->n) {
        c->all.lo = c->all.n ? fmin(c->all.lo, o->lo) : o->lo;
        c->all.hi = c->all.n ? fmax(c->all.hi, o->hi) : o->hi;
    }
    c->all.n += o->n;
    c->all.n_fill += o->n_fill;
    for (int i = 0; i < o->n_some; i++)
        add_some(&c->all, o->some[i]);
    pthread_mutex_unlock(&c->mutex);
}

typedef struct question {
    const vv_field *field;
    int component;
    double value;
    bool upper;
} question;

static void judge(vvi_fill_value *out, const question *q, double stored, const others *o)
{
    const vv_field_info *info = vv_field_get_info(q->field);
    const double a = o->lo * info->value_scale + info->value_offset;
    const double b = o->hi * info->value_scale + info->value_offset;
    const fill_rule rule = rule_of(q->value, info, q->upper);
    *out = (vvi_fill_value){.value = q->value, .stored = stored, .lo = fmin(a, b), .hi = fmax(a, b)};
    out->share = (double)o->n_fill / (double)(o->n + o->n_fill);
    const double gap = q->upper ? q->value - out->hi : out->lo - q->value;
    out->found =
        o->n_some >= LEAST_OTHERS && out->share >= rule.share && gap / rule.gap >= out->hi - out->lo && o->n_fill > 0;
}

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const question *q = user;
    const vv_field_info *info = vv_field_get_info(q->field);
    counting c = {.fill = (q->value - info->value_offset) / info->value_scale, .mutex = PTHREAD_MUTEX_INITIALIZER};
    const vvi_pass pass = {"statistics", sizeof(others), take, finish, &c};
    vvi_fill_value *found = vvi_alloc_zeroed(job, sizeof *found, VVI_MEM_DERIVED);
    if (!found)
        return vv_fail_memory(sizeof *found);
    if (!vv_type_is_float(info->type))
        c.fill = round(c.fill);
    const vv_status st = vvi_pass_run(&pass, q->field, q->component, job);
    pthread_mutex_destroy(&c.mutex);
    if (st != VV_OK) {
        vvi_free(found);
        return st;
    }
    judge(found, q, c.fill, &c.all);
    *value_out = found;
    *bytes_out = sizeof *found;
    return VV_OK;
}

vv_status vvi_fill_value_find(vvi_fill_value *out, const vv_field *field, int component, const vv_statistics *s,
                              vv_job *job)
{
    const int n_ends = vvi_job_keeps_fills(job) || s->count == 0 ? 0 : 2;
    *out = (vvi_fill_value){0};
    for (int upper = 0; upper < n_ends && !out->found; upper++) {
        question q = {field, component, upper ? s->max : s->min, upper};
        const fill_rule rule = rule_of(q.value, vv_field_get_info(field), upper);
        const vvi_cache_key key = {upper ? "fill above" : "fill below", vv_field_identity(field), (uint64_t)component};
        vvi_cached *cached;
        if (q.value == 0 || !may_be_fill(s, upper, &rule))
            continue;
        const vv_status st = vvi_cache_get(&cached, &key, make, vvi_free, &q, job);
        if (st != VV_OK)
            return st;
        *out = *(const vvi_fill_value *)vvi_cached_value(cached);
        vvi_cache_release(cached);
    }
    return VV_OK;
}
