/* Exact percentiles: a radix selection. Passes count the samples by 16 bits of their key; after each, a rank knows 16
 * bits more of its sample, and the next pass counts only samples that begin with them. */
#include "grid/percentile.h"

#include "core/cache.h"
#include "core/memory.h"
#include "grid/pass.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

#define DIGITS 65536
#define NOT_A_KEY UINT64_MAX            /* no finite sample has it */
#define FLUSH_AFTER ((uint64_t)1 << 31) /* before a 32-bit count can wrap */

/* Bits of the key: those of the samples, as integers of 64 bits come as doubles. */
static int key_bits(vv_type type)
{
    const int bits = 8 * (int)vv_type_bytes(type);
    return bits < 16 ? 16 : bits;
}

static uint64_t key_of_f64(double v)
{
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    return bits >> 63 ? ~bits : bits | (uint64_t)1 << 63;
}

static uint64_t key_of_f32(float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return bits >> 31 ? (uint32_t)~bits : bits | (uint32_t)1 << 31;
}

/* What makes a signed integer of at most 32 bits rise from 0. */
static double lowest(vv_type type)
{
    return vvi_type_min(type);
}

static bool is_short_integer(vv_type type)
{
    return !vv_type_is_float(type) && vv_type_bytes(type) <= 4;
}

static void keys_of(uint64_t *keys, const double *v, size_t n, vv_type type)
{
    if (is_short_integer(type)) {
        const double low = lowest(type);
        for (size_t i = 0; i < n; i++)
            keys[i] = (uint64_t)(int64_t)(v[i] - low);
    } else if (type == VV_TYPE_F32) {
        for (size_t i = 0; i < n; i++)
            keys[i] = v[i] - v[i] == 0 ? key_of_f32((float)v[i]) : NOT_A_KEY;
    } else {
        for (size_t i = 0; i < n; i++)
            keys[i] = v[i] - v[i] == 0 ? key_of_f64(v[i]) : NOT_A_KEY;
    }
}

static double number_of(uint64_t key, vv_type type)
{
    if (is_short_integer(type))
        return (double)key + lowest(type);
    if (type == VV_TYPE_F32) {
        const uint32_t bits = key >> 31 ? (uint32_t)key & INT32_MAX : ~(uint32_t)key;
        float v;
        memcpy(&v, &bits, sizeof v);
        return (double)v;
    }
    const uint64_t bits = key >> 63 ? key & INT64_MAX : ~key;
    double v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

/* One pass: samples whose key begins with one of the prefixes are counted by the digit that follows. */
typedef struct digits {
    vv_type type;
    int shift; /* of the digit */
    uint64_t prefix[VVI_RANKS_MOST];
    int n_prefixes;
    _Atomic uint64_t *total; /* DIGITS for each prefix */
} digits;

typedef struct counts {
    uint64_t pending;
    uint32_t count[];
} counts;

static uint64_t prefix_of(uint64_t key, int shift)
{
    return shift + 16 < 64 ? key >> (shift + 16) : 0;
}

static void flush(const digits *d, counts *c)
{
    const size_t n = (size_t)d->n_prefixes * DIGITS;
    for (size_t i = 0; i < n; i++)
        if (c->count[i])
            atomic_fetch_add_explicit(&d->total[i], c->count[i], memory_order_relaxed);
    memset(c->count, 0, n * sizeof *c->count);
    c->pending = 0;
}

static void take(void *user, void *scratch, size_t item, const double *values, size_t n)
{
    (void)item;
    const digits *d = user;
    counts *c = scratch;
    uint64_t keys[VVI_PASS_RUN];
    keys_of(keys, values, n, d->type);
    for (size_t i = 0; i < n; i++) {
        const uint64_t prefix = prefix_of(keys[i], d->shift);
        for (int p = 0; p < d->n_prefixes; p++)
            if (prefix == d->prefix[p] && keys[i] != NOT_A_KEY)
                c->count[(size_t)p * DIGITS + (keys[i] >> d->shift & (DIGITS - 1))]++;
    }
    c->pending += n;
    if (c->pending > FLUSH_AFTER)
        flush(d, c);
}

static void finish(void *user, void *scratch)
{
    if (scratch)
        flush(user, scratch);
}

/* What is known of each wanted sample: the head of its key, and its rank among the samples with that head. */
typedef struct selection {
    const vvi_field_series *series;
    int component, n;
    uint64_t head[VVI_RANKS_MOST], rank[VVI_RANKS_MOST];
    digits digits;
    double scale, offset; /* of the first field */
} selection;

static vv_status check_alike(selection *s, const vv_field_info *info, size_t index)
{
    if (index == 0) {
        s->scale = info->value_scale;
        s->offset = info->value_offset;
        s->digits.type = info->type;
    } else if (info->type != s->digits.type || info->value_scale != s->scale || info->value_offset != s->offset) {
        return vv_fail(VV_E_UNSUPPORTED, "time steps differ in type or scale; percentiles of all cannot be taken");
    }
    return VV_OK;
}

static vv_status count_field(selection *s, size_t index, vv_job *job)
{
    vv_field *field = NULL;
    vv_status st = s->series->open(&field, s->series->user, index, job);
    if (st == VV_OK && (st = check_alike(s, vv_field_get_info(field), index)) == VV_OK) {
        if (s->digits.shift < 0) /* the first pass of all */
            s->digits.shift = key_bits(s->digits.type) - 16;
        const size_t bytes = sizeof(counts) + (size_t)s->digits.n_prefixes * DIGITS * sizeof(uint32_t);
        const vvi_pass pass = {
            .stage = "percentiles", .scratch_bytes = bytes, .take = take, .finish = finish, .user = &s->digits};
        if ((st = vvi_pass_run(&pass, field, s->component, job)) == VV_OK)
            st = vv_field_health(field);
    }
    vv_field_release(field);
    return st;
}

/* Counts of the next digit; total is to be freed also when it fails. */
static vv_status count_digits(selection *s, vv_job *job)
{
    const size_t bytes = (size_t)s->digits.n_prefixes * DIGITS * sizeof *s->digits.total;
    vv_status st = VV_OK;
    s->digits.total = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH);
    if (!s->digits.total)
        return vv_fail_memory(bytes);
    for (size_t f = 0; f < s->series->n && st == VV_OK; f++)
        st = count_field(s, f, job);
    return st;
}

static void free_counts(selection *s)
{
    vvi_free(s->digits.total);
    s->digits.total = NULL;
}

/* Heads that several ranks share are counted once. */
static void set_prefixes(selection *s)
{
    digits *d = &s->digits;
    d->n_prefixes = 0;
    for (int r = 0; r < s->n; r++) {
        int p = 0;
        while (p < d->n_prefixes && d->prefix[p] != s->head[r])
            p++;
        d->prefix[p] = s->head[r];
        d->n_prefixes += p == d->n_prefixes;
    }
}

static vv_status descend(selection *s)
{
    const digits *d = &s->digits;
    for (int r = 0; r < s->n; r++) {
        int p = 0;
        while (d->prefix[p] != s->head[r])
            p++;
        const _Atomic uint64_t *total = d->total + (size_t)p * DIGITS;
        uint32_t digit = 0;
        uint64_t below = 0, here;
        while ((here = atomic_load_explicit(&total[digit], memory_order_relaxed)) + below <= s->rank[r]) {
            below += here;
            if (++digit == DIGITS) /* samples changed between two passes */
                return vv_fail(VV_E_READ, "samples changed while they were read");
        }
        s->rank[r] -= below;
        s->head[r] = s->head[r] << 16 | digit;
    }
    return VV_OK;
}

static vv_status first_pass(selection *s, const vvi_field_series *series, int component, uint64_t *count, vv_job *job)
{
    *s = (selection){.series = series, .component = component, .digits = {.shift = -1, .n_prefixes = 1}};
    const vv_status st = count_digits(s, job);
    *count = 0;
    for (size_t i = 0; st == VV_OK && i < DIGITS; i++)
        *count += atomic_load_explicit(&s->digits.total[i], memory_order_relaxed);
    if (st != VV_OK)
        free_counts(s);
    return st;
}

/* After the first pass, with ranks set: the numbers. */
static vv_status other_passes(double *stored, selection *s, vv_job *job)
{
    vv_status st = descend(s);
    free_counts(s);
    while (st == VV_OK && s->digits.shift > 0) {
        s->digits.shift -= 16;
        set_prefixes(s);
        if ((st = count_digits(s, job)) == VV_OK)
            st = descend(s);
        free_counts(s);
    }
    for (int r = 0; r < s->n && st == VV_OK; r++)
        stored[r] = number_of(s->head[r], s->digits.type);
    return st;
}

static vv_status open_alone(vv_field **out, void *user, size_t index, vv_job *job)
{
    (void)index;
    (void)job;
    *out = vv_field_retain(user);
    return VV_OK;
}

vvi_field_series vvi_field_alone(const vv_field *field)
{
    return (vvi_field_series){open_alone, (void *)(uintptr_t)field, 1};
}

vv_status vvi_select_ranks(double *stored, const uint64_t *ranks, int n, const vv_field *field, int component,
                           vv_job *job)
{
    const vvi_field_series alone = vvi_field_alone(field);
    selection s;
    uint64_t count;
    const vv_status st = first_pass(&s, &alone, component, &count, job);
    if (st != VV_OK)
        return st;
    s.n = n;
    memcpy(s.rank, ranks, (size_t)n * sizeof *ranks);
    return other_passes(stored, &s, job);
}

static double between(double a, double b, double part)
{
    return a == b ? a : a * (1 - part) + b * part; /* the difference of huge doubles is no double */
}

vv_status vvi_percentiles(double *values, const double *percents, int n, const vvi_field_series *series, int component,
                          vv_job *job)
{
    selection s;
    uint64_t count;
    double stored[VVI_RANKS_MOST] = {0}, part[VVI_RANKS_MOST];
    vv_status st = first_pass(&s, series, component, &count, job);
    if (st != VV_OK)
        return st;
    if (count == 0) {
        free_counts(&s);
        for (int i = 0; i < n; i++)
            values[i] = NAN;
        return VV_OK;
    }
    s.n = 2 * n;
    for (int i = 0; i < n; i++) {
        /* a negative scale turns the order of values round */
        const double percent = s.scale < 0 ? 100 - percents[i] : percents[i];
        const double at = percent / 100 * (double)(count - 1), last = (double)(count - 1);
        const uint64_t low = at >= last ? count - 1 : (uint64_t)at;
        s.rank[2 * i] = low;
        s.rank[2 * i + 1] = low + (low + 1 < count);
        part[i] = at >= last ? 0 : at - floor(at);
    }
    if ((st = other_passes(stored, &s, job)) != VV_OK)
        return st;
    for (int i = 0; i < n; i++)
        values[i] = between(stored[2 * i], stored[2 * i + 1], part[i]) * s.scale + s.offset;
    return VV_OK;
}

typedef struct request {
    const vv_field *field;
    int component;
    double percents[2];
} request;

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    const vvi_field_series alone = vvi_field_alone(r->field);
    double *values = vvi_alloc(job, 2 * sizeof *values, VVI_MEM_DERIVED);
    if (!values)
        return vv_fail_memory(2 * sizeof *values);
    const vv_status st = vvi_percentiles(values, r->percents, 2, &alone, r->component, job);
    if (st != VV_OK) {
        vvi_free(values);
        return st;
    }
    *value_out = values;
    *bytes_out = 2 * sizeof *values;
    return VV_OK;
}

vv_status vvi_field_percentiles(double values[2], const double percents[2], const vv_field *field, int component,
                                vv_job *job)
{
    request r = {field, component, {percents[0], percents[1]}};
    const uint64_t hash = vvi_hash(r.percents, sizeof r.percents, (uint64_t)component);
    const vvi_cache_key key = {"percentiles", vv_field_identity(field), hash};
    vvi_cached *cached;
    const vv_status st = vvi_cache_get(&cached, &key, make, vvi_free, &r, job);
    if (st != VV_OK)
        return st;
    memcpy(values, vvi_cached_value(cached), 2 * sizeof *values);
    vvi_cache_release(cached);
    return VV_OK;
}
