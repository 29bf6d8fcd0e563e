#include "segment/runs.h"
#include "core/cpu.h"
#include "core/job.h"
#include "core/memory.h"
#include "filter/sample_keys.h"
#include "segment/runs_kernel.h"

#include <math.h>
#include <string.h>

#define BLOCKS_MOST 64
#define POLL_EVERY 64 /* rows */

typedef struct shared {
    vvi_runs *runs;
    const vvi_run_source *source;
    vvi_touch touch;
    size_t block; /* rows */
    size_t words; /* of a row of bits */
    uint64_t *inside, *starts;
    vvi_key_range all;
    const vvi_runs_kernels *kernels;
    vv_job *job;
} shared;

typedef struct scratch {
    char *keys;
    uint64_t *bits;
    vvi_run_pairs pairs;
} scratch;

static void finish(void *scratch_in, void *user)
{
    scratch *s = scratch_in;
    (void)user;
    if (!s)
        return;
    vvi_free(s->keys);
    vvi_free(s->bits);
    vvi_free(s->pairs.a);
    vvi_free(s->pairs.b);
    vvi_free(s);
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    (void)worker;
    const shared *s = user;
    const size_t n = (size_t)s->runs->n[0], keys = n * vv_type_bytes(s->source->brick->type) + VVI_RUNS_GUARD;
    const size_t pairs = (2 * n + 64) * sizeof(uint32_t);
    scratch *own = vvi_alloc_zeroed(s->job, sizeof *own, VVI_MEM_SCRATCH);
    if (!own)
        return vv_fail_memory(sizeof *own);
    own->keys = vvi_alloc_zeroed(s->job, keys, VVI_MEM_SCRATCH);
    own->bits = vvi_alloc(s->job, s->words * sizeof(uint64_t), VVI_MEM_SCRATCH);
    own->pairs.a = vvi_alloc(s->job, pairs, VVI_MEM_SCRATCH);
    own->pairs.b = vvi_alloc(s->job, pairs, VVI_MEM_SCRATCH);
    if (!own->keys || !own->bits || !own->pairs.a || !own->pairs.b) {
        finish(own, user);
        return vv_fail_memory(2 * pairs + keys);
    }
    *scratch_out = own;
    return VV_OK;
}

/* Rows to bits ---------------------------------------------------------------------------------------------------- */

static const char *row_of(const shared *s, size_t row)
{
    const vv_brick *b = s->source->brick;
    const int64_t ny = s->runs->n[1];
    return (const char *)b->data + (int64_t)row % ny * b->stride[1] + (int64_t)row / ny * b->stride[2];
}

/* How many runs the row has. */
static uint32_t find_bits(scratch *own, const shared *s, size_t row)
{
    const vvi_run_source *from = s->source;
    const size_t each = vv_type_bytes(from->brick->type), width = each == 8 ? 3 : each / 2;
    const int64_t n = s->runs->n[0];
    uint64_t *inside = s->inside + row * s->words;
    vvi_keys_of_samples(own->keys, row_of(s, row), from->brick->stride[0], from->brick->type, n);
    if (from->range.lo <= from->range.hi)
        s->kernels->inside[width](inside, own->keys, n, from->range.lo, from->range.hi);
    else
        memset(inside, 0, s->words * sizeof *inside);
    if (from->other) {
        s->kernels->inside[width](own->bits, own->keys, n, s->all.lo, s->all.hi);
        for (size_t w = 0; w < s->words; w++)
            inside[w] = own->bits[w] & ~inside[w];
    }
    if (from->each)
        s->kernels->differ[width](own->bits, own->keys, n);
    return s->kernels->starts(s->starts + row * s->words, inside, from->each ? own->bits : NULL, s->words);
}

static size_t block_end(const shared *s, size_t index)
{
    const size_t end = (index + 1) * s->block;
    return end < s->runs->n_rows ? end : s->runs->n_rows;
}

static vv_status count_block(void *scratch_in, void *user, size_t index)
{
    const shared *s = user;
    vv_status st = VV_OK;
    for (size_t row = index * s->block; row < block_end(s, index) && st == VV_OK; row++) {
        s->runs->first[row + 1] = find_bits(scratch_in, s, row);
        if (row % POLL_EVERY == 0)
            st = vvi_job_poll(s->job);
    }
    return st;
}

/* Runs of rows ---------------------------------------------------------------------------------------------------- */

static vvi_run_bits bits_of(const shared *s, size_t row)
{
    return (vvi_run_bits){s->inside + row * s->words, s->starts + row * s->words, s->runs->first[row]};
}

static void put_row(const shared *s, size_t row)
{
    const vvi_runs *r = s->runs;
    const vv_brick *b = s->source->brick;
    const vvi_run_bits bits = bits_of(s, row);
    const uint32_t end = r->first[row + 1];
    s->kernels->ends(r->lo + bits.first, r->end + bits.first, bits.inside, bits.starts, r->n[0]);
    for (uint32_t i = bits.first; i < end; i++)
        r->part[i] = i;
    for (uint32_t i = bits.first; i < end && r->key; i++) {
        char key[8];
        vvi_keys_of_samples(key, row_of(s, row) + r->lo[i] * b->stride[0], 8, b->type, 1);
        r->key[i] = vvi_key_at(key, 0, b->type);
    }
}

/* Union-find ------------------------------------------------------------------------------------------------------ */

static uint32_t root_of(uint32_t *part, uint32_t run)
{
    while (part[run] != run)
        run = part[run] = part[part[run]];
    return run;
}

static void unite(const vvi_runs *r, uint32_t a, uint32_t b)
{
    if (r->part[a] == r->part[b] || (r->key && r->key[a] != r->key[b]))
        return;
    a = root_of(r->part, a);
    b = root_of(r->part, b);
    if (a < b)
        r->part[b] = a;
    else
        r->part[a] = b;
}

static void unite_rows(scratch *own, const shared *s, size_t row, size_t other, bool corners)
{
    const vvi_run_bits a = bits_of(s, row), b = bits_of(s, other);
    const size_t n = s->kernels->touch[corners](&own->pairs, &a, &b, s->words);
    for (size_t i = 0; i < n; i++)
        unite(s->runs, own->pairs.a[i], own->pairs.b[i]);
}

/* A row with the neighbours before it that lie in rows [from, to). */
static void unite_row(scratch *own, const shared *s, size_t row, size_t from, size_t to)
{
    const size_t ny = (size_t)s->runs->n[1], j = row % ny;
    const int axes = s->touch.axes;
#define UNITE(distance, reach)                                                                                         \
    do {                                                                                                               \
        if (row - (distance) >= from && row - (distance) < to)                                                         \
            unite_rows(own, s, row, row - (distance), reach);                                                          \
    } while (0)
    if (j > 0)
        UNITE(1, axes > 1);
    if (row < ny || s->touch.slices)
        return;
    UNITE(ny, axes > 1);
    if (axes > 1 && j > 0)
        UNITE(ny + 1, axes > 2);
    if (axes > 1 && j + 1 < ny)
        UNITE(ny - 1, axes > 2);
#undef UNITE
}

static vv_status find_block(void *scratch_in, void *user, size_t index)
{
    const shared *s = user;
    const size_t first = index * s->block;
    vv_status st = VV_OK;
    for (size_t row = first; row < block_end(s, index) && st == VV_OK; row++) {
        put_row(s, row);
        unite_row(scratch_in, s, row, first, row);
        if (row % POLL_EVERY == 0)
            st = vvi_job_poll(s->job);
    }
    return st;
}

/* Across the borders of blocks. */
static vv_status unite_blocks(shared *s, size_t n_blocks)
{
    void *own = NULL;
    vv_status st = start(&own, s, 0);
    for (size_t b = 1; b < n_blocks && st == VV_OK; b++) {
        const size_t first = b * s->block, reach = first + (size_t)s->runs->n[1] + 1;
        const size_t end = reach < block_end(s, b) ? reach : block_end(s, b);
        for (size_t row = first; row < end; row++)
            unite_row(own, s, row, 0, first);
        st = vvi_job_poll(s->job);
    }
    finish(own, s);
    return st;
}

/* Roots come before all that lead to them. */
static void number_parts(vvi_runs *r)
{
    uint32_t n = 0;
    for (size_t i = 0; i < r->n_runs; i++)
        r->part[i] = r->part[i] == i ? n++ : r->part[r->part[i]];
    r->n_parts = n;
}

/* All of it ------------------------------------------------------------------------------------------------------- */

size_t vvi_runs_block(const vvi_runs *runs, size_t *n_blocks_out)
{
    const size_t least = runs->n[2] > 1 ? 8 * (size_t)runs->n[1] : 16;
    const size_t share = (runs->n_rows - 1) / BLOCKS_MOST + 1, block = share > least ? share : least;
    *n_blocks_out = (runs->n_rows - 1) / block + 1;
    return block;
}

static vv_status count_runs(vvi_runs *r, const char *name)
{
    uint64_t n = 0;
    for (size_t row = 0; row < r->n_rows; row++) {
        n += r->first[row + 1];
        if (n >= UINT32_MAX)
            return vv_fail(VV_E_LIMIT, "%s: the parts are in more than 4e9 pieces of rows; crop the volume", name);
        r->first[row + 1] = (uint32_t)n;
    }
    r->n_runs = (size_t)n;
    return VV_OK;
}

#define PIECES 6

uint64_t vvi_runs_memory(const vv_field_info *info, bool keys)
{
    const int64_t *n = info->grid.dims;
    const uint64_t rows = (uint64_t)(n[1] * n[2]);
    return rows * (uint64_t)n[0] / 4 + rows * PIECES * (keys ? 20 : 12);
}

static vv_status make_room(vvi_runs *r, bool each, const char *name, vv_job *job)
{
    const size_t n = r->n_runs + 1;
    const vv_status st = vvi_memory_plan(job, n * (each ? 20 : 12), name);
    if (st != VV_OK)
        return st;
    r->lo = vvi_alloc(job, n * sizeof *r->lo, VVI_MEM_SCRATCH);
    r->end = vvi_alloc(job, n * sizeof *r->end, VVI_MEM_SCRATCH);
    r->part = vvi_alloc(job, n * sizeof *r->part, VVI_MEM_SCRATCH);
    r->key = each ? vvi_alloc(job, n * sizeof *r->key, VVI_MEM_SCRATCH) : NULL;
    return r->lo && r->end && r->part && (r->key || !each) ? VV_OK : vv_fail_memory(n * sizeof *r->key);
}

void vvi_runs_finish(vvi_runs *runs)
{
    vvi_free(runs->first);
    vvi_free(runs->lo);
    vvi_free(runs->end);
    vvi_free(runs->key);
    vvi_free(runs->part);
    *runs = (vvi_runs){0};
}

vv_status vvi_runs_find(vvi_runs *out, const vvi_run_source *source, const vvi_touch *touch, const char *name,
                        vv_job *job)
{
    static const vvi_value_range anything = {-INFINITY, INFINITY};
    vv_field_info plain = vv_field_info_default();
    const int64_t *n = source->brick->box.n;
    plain.type = source->brick->type;
    *out = (vvi_runs){.n = {n[0], n[1], n[2]}, .n_rows = (size_t)(n[1] * n[2])};
    shared s = {.runs = out,
                .source = source,
                .touch = *touch,
                .words = (size_t)(n[0] + 63) / 64,
                .all = vvi_key_range_of(&anything, &plain),
                .kernels = vvi_runs_kernels_for(vvi_job_cpu(job)),
                .job = job};
    size_t n_blocks;
    if (n[0] >= INT32_MAX - 1)
        return vv_fail(VV_E_LIMIT, "%s: rows of %lld samples are too long; crop the volume", name, (long long)n[0]);
    s.block = vvi_runs_block(out, &n_blocks);
    vvi_work counting = {.stage = name, .start = start, .item = count_block, .finish = finish, .n_after = n_blocks};
    vvi_work finding = {.stage = name, .start = start, .item = find_block, .finish = finish, .n_before = n_blocks};
    const size_t bits = out->n_rows * s.words * sizeof(uint64_t);
    out->first = vvi_alloc_zeroed(job, (out->n_rows + 1) * sizeof *out->first, VVI_MEM_SCRATCH);
    s.inside = vvi_alloc(job, bits, VVI_MEM_SCRATCH);
    s.starts = vvi_alloc(job, bits, VVI_MEM_SCRATCH);
    vv_status st = out->first && s.inside && s.starts ? VV_OK : vv_fail_memory(2 * bits);
    if (st == VV_OK && (st = vvi_parallel_for(job, &counting, &s, n_blocks)) == VV_OK &&
        (st = count_runs(out, name)) == VV_OK && (st = make_room(out, source->each, name, job)) == VV_OK &&
        (st = vvi_parallel_for(job, &finding, &s, n_blocks)) == VV_OK && (st = unite_blocks(&s, n_blocks)) == VV_OK)
        number_parts(out);
    vvi_free(s.inside);
    vvi_free(s.starts);
    if (st != VV_OK)
        vvi_runs_finish(out);
    return st;
}

vv_status vvi_runs_sizes(uint64_t **out, const vvi_runs *runs, vv_job *job)
{
    const size_t bytes = ((size_t)runs->n_parts + 1) * sizeof **out;
    uint64_t *size = *out = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH);
    if (!size)
        return vv_fail_memory(bytes);
    for (size_t i = 0; i < runs->n_runs; i++)
        size[runs->part[i]] += (uint64_t)(runs->end[i] - runs->lo[i]);
    return VV_OK;
}

size_t vvi_runs_at(const vvi_runs *runs, const int64_t index[3])
{
    const size_t row = (size_t)(index[2] * runs->n[1] + index[1]);
    size_t lo = runs->first[row], end = runs->first[row + 1];
    while (lo < end) { /* the first run that ends behind the sample */
        const size_t middle = lo + (end - lo) / 2;
        if (runs->end[middle] > index[0])
            end = middle;
        else
            lo = middle + 1;
    }
    return lo < runs->first[row + 1] && runs->lo[lo] <= index[0] ? lo : runs->n_runs;
}

/* Painting -------------------------------------------------------------------------------------------------------- */

typedef struct painting {
    char *out;
    vv_type type;
    const vvi_runs *runs;
    const uint32_t *label_of_part;
    size_t block;
} painting;

static vv_status paint_block(void *scratch_in, void *user, size_t index)
{
    (void)scratch_in;
    const painting *p = user;
    const vvi_runs *r = p->runs;
    const size_t first = index * p->block, each = vv_type_bytes(p->type), n = (size_t)r->n[0];
    const size_t end = first + p->block < r->n_rows ? first + p->block : r->n_rows;
    for (size_t row = first; row < end; row++) {
        char *out = p->out + row * n * each;
        memset(out, 0, n * each);
        for (uint32_t i = r->first[row]; i < r->first[row + 1]; i++) {
            const uint32_t label = p->label_of_part[r->part[i]];
            uint32_t *wide = (uint32_t *)(void *)out;
            if (each == 1)
                memset(out + r->lo[i], (int)label, (size_t)(r->end[i] - r->lo[i]));
            else
                for (int32_t x = r->lo[i]; x < r->end[i]; x++)
                    wide[x] = label;
        }
    }
    return VV_OK;
}

vv_status vvi_runs_paint(void *out, vv_type type, const vvi_runs *runs, const uint32_t *label_of_part, vv_job *job)
{
    static const vvi_work work = {.stage = "writing labels", .item = paint_block};
    size_t n_blocks;
    painting p = {out, type, runs, label_of_part, vvi_runs_block(runs, &n_blocks)};
    return vvi_parallel_for(job, &work, &p, n_blocks);
}
