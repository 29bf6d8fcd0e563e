/* A radix selection; see selection.h. */
#include "grid/selection.h"

#include "core/memory.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define DIGITS VVI_SELECTION_DIGITS
#define NOT_A_KEY UINT64_MAX            /* no finite sample has it */
#define FLUSH_AFTER ((uint64_t)1 << 31) /* before a 32-bit count can wrap */

/* Bits of the key: those of the samples, as integers of 64 bits come as doubles. */
static int key_bits(vv_type type)
{
    const int bits = 8 * (int)vv_type_bytes(type);
    return bits < 16 ? 16 : bits;
}

/* Bits of floats rise with them once the sign is turned round, and of negative ones all other bits too. */
static uint64_t key_of_f64(double v)
{
    int64_t bits;
    memcpy(&bits, &v, sizeof bits);
    return (uint64_t)bits ^ ((uint64_t)(bits >> 63) | (uint64_t)1 << 63);
}

static uint32_t key_of_f32(float v)
{
    int32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return (uint32_t)bits ^ ((uint32_t)(bits >> 31) | (uint32_t)1 << 31);
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

void vvi_selection_keys(uint64_t *keys, const double *v, size_t n, vv_type type)
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

double vvi_selection_value(uint64_t key, vv_type type)
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

/* A worker's own counts. */
typedef struct counts {
    uint64_t pending;
    uint32_t count[];
} counts;

static void flush(const vvi_selection *s, counts *c)
{
    const size_t n = (size_t)s->n_prefixes * DIGITS;
    for (size_t i = 0; i < n; i++)
        if (c->count[i])
            atomic_fetch_add_explicit(&s->total[i], c->count[i], memory_order_relaxed);
    memset(c->count, 0, n * sizeof *c->count);
    c->pending = 0;
}

static void count_first(counts *c, const uint64_t *keys, size_t n, int shift)
{
    for (size_t i = 0; i < n; i++)
        if (keys[i] != NOT_A_KEY)
            c->count[keys[i] >> shift]++;
}

/* Most samples begin with a digit that nobody asks for. */
static void count_next(const vvi_selection *s, counts *c, const uint64_t *keys, size_t n, int top)
{
    for (size_t i = 0; i < n; i++) {
        const int first = keys[i] != NOT_A_KEY ? s->first[keys[i] >> top] : 0;
        if (!first)
            continue;
        const uint64_t prefix = keys[i] >> (s->shift + 16);
        for (int p = first - 1; p < s->n_prefixes && s->prefix[p] <= prefix; p++)
            if (s->prefix[p] == prefix)
                c->count[(size_t)p * DIGITS + (keys[i] >> s->shift & (DIGITS - 1))]++;
    }
}

static void take(void *user, void *scratch, size_t item, const double *values, size_t n)
{
    (void)item;
    const vvi_selection *s = user;
    counts *c = scratch;
    uint64_t keys[VVI_PASS_RUN];
    const int top = key_bits(s->type) - 16;
    vvi_selection_keys(keys, values, n, s->type);
    if (s->shift == top)
        count_first(c, keys, n, top);
    else
        count_next(s, c, keys, n, top);
    c->pending += n;
    if (c->pending > FLUSH_AFTER)
        flush(s, c);
}

static void finish(void *user, void *scratch)
{
    if (scratch)
        flush(user, scratch);
}

static vv_status new_totals(vvi_selection *s, vv_job *job)
{
    const size_t bytes = (size_t)s->n_prefixes * DIGITS * sizeof *s->total;
    vvi_free(s->total);
    s->total = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH);
    return s->total ? VV_OK : vv_fail_memory(bytes);
}

vv_status vvi_selection_begin(vvi_selection *s, vv_type type, vv_job *job)
{
    *s = (vvi_selection){.type = type, .shift = key_bits(type) - 16, .n_prefixes = 1};
    s->first = vvi_alloc_zeroed(job, DIGITS, VVI_MEM_SCRATCH);
    return s->first ? new_totals(s, job) : vv_fail_memory(DIGITS);
}

vvi_pass vvi_selection_pass(vvi_selection *s)
{
    const size_t bytes = sizeof(counts) + (size_t)s->n_prefixes * DIGITS * sizeof(uint32_t);
    return (vvi_pass){.stage = "percentiles", .scratch_bytes = bytes, .take = take, .finish = finish, .user = s};
}

uint64_t vvi_selection_count(const vvi_selection *s)
{
    uint64_t count = 0;
    for (size_t i = 0; i < DIGITS; i++)
        count += atomic_load_explicit(&s->total[i], memory_order_relaxed);
    return count;
}

void vvi_selection_set_ranks(vvi_selection *s, const uint64_t *ranks, int n)
{
    s->n = n;
    memcpy(s->rank, ranks, (size_t)n * sizeof *ranks);
}

static int rising(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Heads that several ranks share are counted once. */
static void set_prefixes(vvi_selection *s)
{
    const int top = key_bits(s->type) - 16 - (s->shift + 16);
    uint64_t all[VVI_RANKS_MOST];
    memcpy(all, s->head, sizeof all);
    qsort(all, (size_t)s->n, sizeof *all, rising);
    memset(s->first, 0, DIGITS);
    s->n_prefixes = 0;
    for (int r = 0; r < s->n; r++) {
        if (s->n_prefixes && s->prefix[s->n_prefixes - 1] == all[r])
            continue;
        uint8_t *const first = &s->first[all[r] >> top];
        s->prefix[s->n_prefixes++] = all[r];
        *first = *first ? *first : (uint8_t)s->n_prefixes;
    }
}

static vv_status descend_one(vvi_selection *s, int r)
{
    int p = 0;
    while (s->prefix[p] != s->head[r])
        p++;
    const _Atomic uint64_t *total = s->total + (size_t)p * DIGITS;
    uint32_t digit = 0;
    uint64_t below = 0, here;
    while ((here = atomic_load_explicit(&total[digit], memory_order_relaxed)) + below <= s->rank[r]) {
        below += here;
        if (++digit == DIGITS) /* samples changed between two passes */
            return vv_fail(VV_E_READ, "samples changed while they were being read");
    }
    s->rank[r] -= below;
    s->head[r] = s->head[r] << 16 | digit;
    return VV_OK;
}

vv_status vvi_selection_descend(vvi_selection *s, bool *done, vv_job *job)
{
    vv_status st = VV_OK;
    for (int r = 0; r < s->n && st == VV_OK; r++)
        st = descend_one(s, r);
    *done = st != VV_OK || s->shift == 0;
    if (*done)
        return st;
    s->shift -= 16;
    set_prefixes(s);
    return new_totals(s, job);
}

double vvi_selection_number(const vvi_selection *s, int r)
{
    return vvi_selection_value(s->head[r], s->type);
}

void vvi_selection_end(vvi_selection *s)
{
    vvi_free(s->total);
    vvi_free(s->first);
    s->total = NULL;
    s->first = NULL;
}
