/* Exact counts of 8- and 16-bit samples by bit pattern, near memory speed: the whole of their statistics follows. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/slabs.h"
#include "grid/statistics.h"

#include <stdatomic.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 17) /* gathered, where they lie in several slabs */
#define FLUSH_AFTER ((uint64_t)1 << 31) /* before a 32-bit count can wrap */

/* One worker's tables, all of 65536 patterns: two samples of 8 bits are counted as one of 16, which halves the work and
 * meets few patterns, as neighbours are alike. Words beside each other go to different tables, since equal patterns in
 * a row would wait for each other; more than two would not fit into the nearest cache. They are not apart by a multiple
 * of 4096 bytes: a processor takes a load from there for one of what was just stored. */
#define PATTERNS 65536
#define APART 272

typedef struct worker {
    uint64_t pending;
    uint32_t even[PATTERNS + APART], odd[PATTERNS + APART];
    uint32_t single[256]; /* samples of 8 bits without a partner */
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
    return w[0] == w[3] && w[0] == w[1] && w[0] == w[2] && w[0] == (w[0] << 16 | w[0] >> 48);
}

/* Patterns of 16 bits; how many bytes of them were taken. */
static size_t count_words(worker *t, const char *p, size_t n_bytes)
{
    size_t at = 0;
    for (; at + 32 <= n_bytes; at += 32) {
        uint64_t w[4];
        memcpy(w, p + at, sizeof w);
        if (all_equal(w)) {
            t->even[w[0] & 65535] += 16;
            continue;
        }
        for (int q = 0; q < 4; q += 2)
            for (int b = 0; b < 64; b += 16) {
                t->even[w[q] >> b & 65535]++;
                t->odd[w[q + 1] >> b & 65535]++;
            }
    }
    return at;
}

static void count_8(worker *w, const uint8_t *p, size_t n)
{
    for (size_t i = count_words(w, (const char *)p, n); i < n; i++)
        w->single[p[i]]++;
}

static void count_16(worker *w, const char *p, size_t n)
{
    for (size_t at = count_words(w, p, 2 * n); at < 2 * n; at += 2) {
        uint16_t v;
        memcpy(&v, p + at, 2);
        w->even[v]++;
    }
}

static void count_apart(worker *w, const char *p, size_t n, int64_t stride, bool wide)
{
    for (size_t i = 0; i < n; i++, p += stride) {
        uint16_t v = 0;
        if (wide)
            memcpy(&v, p, 2);
        if (wide)
            w->even[v]++;
        else
            w->single[*(const uint8_t *)p]++;
    }
}

static void add_total(shared *s, size_t pattern, uint64_t count)
{
    if (count)
        atomic_fetch_add_explicit(&s->total[pattern], count, memory_order_relaxed);
}

static void flush(worker *w, shared *s)
{
    uint64_t narrow[256] = {0};
    for (size_t i = 0; i < PATTERNS; i++) {
        const uint64_t here = (uint64_t)w->even[i] + w->odd[i];
        if (s->n_patterns > 256)
            add_total(s, i, here);
        narrow[i & 255] += here;
        narrow[i >> 8] += here;
    }
    for (size_t i = 0; i < 256 && s->n_patterns == 256; i++)
        add_total(s, i, narrow[i] + w->single[i]);
    memset(w, 0, sizeof *w);
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
                count_apart(w, row, (size_t)box.n[0], brick.stride[0], wide);
            else if (wide)
                count_16(w, row, (size_t)box.n[0]);
            else
                count_8(w, (const uint8_t *)row, (size_t)box.n[0]);
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
