/* Exact counts of 8- and 16-bit samples by bit pattern, near memory speed: the whole of their statistics follows. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/slabs.h"
#include "grid/statistics.h"

#include <stdatomic.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 20)
#define FLUSH_AFTER ((uint64_t)1 << 31) /* before a 32-bit count can wrap */

/* One worker's tables: neighbours go to different ones, since equal values in a row would wait for each other. */
#define TABLES_8 4
#define TABLES_16 2

typedef struct worker {
    uint64_t pending;
    uint32_t count[TABLES_16 * 65536];
} worker;

typedef struct shared {
    const vv_field *field;
    vv_job *job;
    vvi_slabs slabs;
    int component;
    size_t n_patterns;
    _Atomic uint64_t *total;
} shared;

int32_t vvi_pattern_value(uint32_t pattern, vv_type type)
{
    if (type == VV_TYPE_I8)
        return pattern < 128 ? (int32_t)pattern : (int32_t)pattern - 256;
    if (type == VV_TYPE_I16)
        return pattern < 32768 ? (int32_t)pattern : (int32_t)pattern - 65536;
    return (int32_t)pattern;
}

/* Background is counted 32 bytes at once: one table entry that waits for itself is slow. */
static bool all_equal(const uint64_t w[4])
{
    return ((w[0] ^ w[1]) | (w[0] ^ w[2]) | (w[0] ^ w[3])) == 0;
}

static void count_8(uint32_t *count, const uint8_t *p, size_t n)
{
    uint32_t(*t)[256] = (uint32_t(*)[256])count;
    size_t i = 0;
    for (; i + 32 <= n; i += 32) {
        uint64_t w[4];
        memcpy(w, p + i, sizeof w);
        if (all_equal(w) && w[0] == (w[0] << 8 | w[0] >> 56)) {
            t[0][w[0] & 255] += 32;
            continue;
        }
        for (int q = 0; q < 4; q++)
            for (int b = 0; b < 8; b++)
                t[b % TABLES_8][w[q] >> (8 * b) & 255]++;
    }
    for (; i < n; i++)
        t[0][p[i]]++;
}

static void count_16(uint32_t *count, const char *p, size_t n)
{
    uint32_t(*t)[65536] = (uint32_t(*)[65536])count;
    size_t i = 0;
    for (; i + 16 <= n; i += 16) {
        uint64_t w[4];
        memcpy(w, p + 2 * i, sizeof w);
        if (all_equal(w) && w[0] == (w[0] << 16 | w[0] >> 48)) {
            t[0][w[0] & 65535] += 16;
            continue;
        }
        for (int q = 0; q < 4; q++)
            for (int b = 0; b < 4; b++)
                t[b % TABLES_16][w[q] >> (16 * b) & 65535]++;
    }
    for (; i < n; i++) {
        uint16_t v;
        memcpy(&v, p + 2 * i, 2);
        t[0][v]++;
    }
}

static void count_apart(uint32_t *count, const char *p, size_t n, int64_t stride, bool wide)
{
    for (size_t i = 0; i < n; i++, p += stride) {
        uint16_t v = 0;
        if (wide)
            memcpy(&v, p, 2);
        else
            v = *(const uint8_t *)p;
        count[v]++;
    }
}

static void flush(worker *w, shared *s)
{
    const size_t all = s->n_patterns * (s->n_patterns == 256 ? TABLES_8 : TABLES_16);
    for (size_t i = 0; i < all; i++)
        if (w->count[i])
            atomic_fetch_add_explicit(&s->total[i % s->n_patterns], w->count[i], memory_order_relaxed);
    memset(w->count, 0, all * sizeof *w->count);
    w->pending = 0;
}

static vv_status start(void **scratch_out, void *user, int number)
{
    (void)number;
    const shared *s = user;
    worker *w = vvi_alloc_zeroed(s->job, sizeof *w, VVI_MEM_SCRATCH);
    *scratch_out = w;
    return w ? VV_OK : vv_fail_memory(sizeof *w);
}

static vv_status item(void *scratch, void *user, size_t index)
{
    worker *w = scratch;
    shared *s = user;
    const vv_box box = vvi_slabs_item(&s->slabs, index);
    vv_brick brick;
    const vv_status st = vv_field_brick(&brick, s->field, &box, s->job);
    if (st != VV_OK)
        return st;
    const bool wide = s->n_patterns > 256;
    const int64_t bytes = wide ? 2 : 1;
    const char *first = (const char *)brick.data + s->component * bytes;
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            const char *row = first + j * brick.stride[1] + k * brick.stride[2];
            if (brick.stride[0] != bytes)
                count_apart(w->count, row, (size_t)box.n[0], brick.stride[0], wide);
            else if (wide)
                count_16(w->count, row, (size_t)box.n[0]);
            else
                count_8(w->count, (const uint8_t *)row, (size_t)box.n[0]);
        }
    vv_brick_release(&brick);
    w->pending += (uint64_t)(box.n[0] * box.n[1] * box.n[2]);
    if (w->pending > FLUSH_AFTER)
        flush(w, s);
    return VV_OK;
}

static void finish(void *scratch, void *user)
{
    if (scratch)
        flush(scratch, user);
    vvi_free(scratch);
}

vv_status vvi_count_patterns(uint64_t *counts, const vv_field *field, int component, vv_job *job)
{
    static const vvi_work work = {.stage = "statistics", .start = start, .item = item, .finish = finish};
    const vv_box all = vv_field_box(field);
    shared s = {.field = field, .job = job, .slabs = vvi_slabs_of(&all, ITEM_SAMPLES), .component = component};
    s.n_patterns = vv_type_bytes(vv_field_get_info(field)->type) == 1 ? 256 : 65536;
    s.total = vvi_alloc_zeroed(job, s.n_patterns * sizeof *s.total, VVI_MEM_SCRATCH);
    if (!s.total)
        return vv_fail_memory(s.n_patterns * sizeof *s.total);
    const vv_status st = vvi_parallel_for(job, &work, &s, s.slabs.n);
    for (size_t i = 0; i < s.n_patterns; i++)
        counts[i] = atomic_load_explicit(&s.total[i], memory_order_relaxed);
    vvi_free(s.total);
    return st;
}
