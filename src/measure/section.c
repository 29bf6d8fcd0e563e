/* The piece of an object around a seed: whole rows of bits are filled at once, and what they gain is handed to the four
 * rows beside them. Three bits a sample. */
#include "measure/object.h"

#include "core/job.h"
#include "core/memory.h"

#include <string.h>

typedef struct flood {
    const vvi_object *object;
    size_t rows, words;
    uint64_t *inside, *got, *wanted; /* wanted: reached, but not filled yet */
    uint32_t *queue;                 /* of rows that something is wanted in: a ring */
    bool *queued;
    size_t first, n;
} flood;

static vv_status slice_item(void *scratch, void *user, size_t index)
{
    (void)scratch;
    flood *f = user;
    const size_t per_slice = (size_t)f->object->n[1] * f->words;
    return vvi_object_slice(f->inside + index * per_slice, f->object, (int64_t)index);
}

static void push(flood *f, size_t row)
{
    if (f->queued[row])
        return;
    f->queued[row] = true;
    f->queue[(f->first + f->n++) % f->rows] = (uint32_t)row;
}

/* Of one word: the runs of `inside` upwards or downwards from the seeds in them; each turn doubles the reach. */
static uint64_t fill_up(uint64_t seeds, uint64_t inside)
{
    for (int reach = 1; reach < 64; reach *= 2) {
        seeds |= inside & seeds << reach;
        inside &= inside << reach;
    }
    return seeds;
}

static uint64_t fill_down(uint64_t seeds, uint64_t inside)
{
    for (int reach = 1; reach < 64; reach *= 2) {
        seeds |= inside & seeds >> reach;
        inside &= inside >> reach;
    }
    return seeds;
}

/* All runs of a row that have a seed in them. */
static void fill_row(uint64_t *row, const uint64_t *inside, size_t words)
{
    uint64_t carry = 0;
    for (size_t w = 0; w < words; w++) {
        row[w] = fill_up((row[w] | carry) & inside[w], inside[w]);
        carry = row[w] >> 63;
    }
    carry = 0;
    for (size_t w = words; w-- > 0;) {
        row[w] = fill_down(row[w] | (carry & inside[w]), inside[w]);
        carry = row[w] << 63;
    }
}

/* What a row has gained is wanted in the row beside it. */
static void pass_on(flood *f, const uint64_t *gained, size_t to)
{
    const size_t at = to * f->words;
    uint64_t any = 0;
    for (size_t w = 0; w < f->words; w++) {
        const uint64_t more = gained[w] & f->inside[at + w] & ~f->got[at + w];
        f->wanted[at + w] |= more;
        any |= more;
    }
    if (any)
        push(f, to);
}

static void take_row(flood *f, size_t row)
{
    const size_t at = row * f->words, ny = (size_t)f->object->n[1];
    uint64_t *gained = f->wanted + at, any = 0;
    fill_row(gained, f->inside + at, f->words);
    for (size_t w = 0; w < f->words; w++) {
        gained[w] &= ~f->got[at + w];
        f->got[at + w] |= gained[w];
        any |= gained[w];
    }
    if (any && row % ny > 0)
        pass_on(f, gained, row - 1);
    if (any && row % ny < ny - 1)
        pass_on(f, gained, row + 1);
    if (any && row >= ny)
        pass_on(f, gained, row - ny);
    if (any && row + ny < f->rows)
        pass_on(f, gained, row + ny);
    memset(gained, 0, f->words * sizeof *gained);
}

static vv_status run(flood *f, const int64_t at[3])
{
    const size_t row = (size_t)(at[2] * f->object->n[1] + at[1]);
    f->wanted[row * f->words + (size_t)(at[0] >> 6)] = (uint64_t)1 << (at[0] & 63);
    push(f, row);
    for (size_t turn = 0; f->n; turn++) {
        const size_t next = f->queue[f->first];
        f->first = (f->first + 1) % f->rows;
        f->n--;
        f->queued[next] = false;
        take_row(f, next);
        if ((turn & 4095) == 0 && vvi_job_poll(f->object->job) != VV_OK)
            return VV_E_CANCELLED;
    }
    return VV_OK;
}

static bool is_inside(const flood *f, const int64_t at[3])
{
    for (int a = 0; a < 3; a++)
        if (at[a] < 0 || at[a] >= f->object->n[a])
            return false;
    const size_t row = (size_t)(at[2] * f->object->n[1] + at[1]);
    return f->inside[row * f->words + (size_t)(at[0] >> 6)] >> (at[0] & 63) & 1;
}

enum { REACH = 2 }; /* samples around the seed */

static vv_status find(int64_t out[3], const flood *f, const int64_t seed[3])
{
    int64_t best = INT64_MAX;
    for (int i = 0; i < (2 * REACH + 1) * (2 * REACH + 1) * (2 * REACH + 1); i++) {
        const int64_t d[3] = {i % 5 - REACH, i / 5 % 5 - REACH, i / 25 - REACH};
        const int64_t at[3] = {seed[0] + d[0], seed[1] + d[1], seed[2] + d[2]};
        const int64_t far = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        if (far < best && is_inside(f, at)) {
            best = far;
            memcpy(out, at, sizeof at);
        }
    }
    return best < INT64_MAX ? VV_OK
                            : vv_fail(VV_E_ARGUMENT,
                                      "the seed %lld,%lld,%lld is not in the object, nor is any sample within %d of "
                                      "it; give a place inside",
                                      (long long)seed[0], (long long)seed[1], (long long)seed[2], REACH);
}

static vv_status make_room(flood *f, vv_job *job)
{
    size_t bits = 0;
    vv_status st = vvi_mul3_size(&bits, f->rows, f->words, sizeof *f->inside);
    if (st != VV_OK || (st = vvi_memory_plan(job, 3 * (uint64_t)bits, "following the object from its seed")) != VV_OK)
        return st;
    if (f->rows > UINT32_MAX)
        return vv_fail(VV_E_LIMIT, "a volume of more than 2^32 rows cannot be followed from a seed");
    f->inside = vvi_alloc_zeroed(job, bits, VVI_MEM_SCRATCH);
    f->got = vvi_alloc_zeroed(job, bits, VVI_MEM_SCRATCH);
    f->wanted = vvi_alloc_zeroed(job, bits, VVI_MEM_SCRATCH);
    f->queue = vvi_alloc(job, f->rows * sizeof *f->queue, VVI_MEM_SCRATCH);
    f->queued = vvi_alloc_zeroed(job, f->rows * sizeof *f->queued, VVI_MEM_SCRATCH);
    return f->inside && f->got && f->wanted && f->queue && f->queued ? VV_OK : vv_fail_memory(bits);
}

vv_status vvi_object_track(vvi_object *object, const int64_t seed[3])
{
    static const vvi_work work = {.stage = "object", .item = slice_item};
    flood f = {.object = object, .rows = (size_t)(object->n[1] * object->n[2]), .words = object->words};
    int64_t at[3] = {0, 0, 0};
    vv_status st = make_room(&f, object->job);
    if (st == VV_OK && (st = vvi_parallel_for(object->job, &work, &f, (size_t)object->n[2])) == VV_OK &&
        (st = find(at, &f, seed)) == VV_OK && (st = run(&f, at)) == VV_OK) {
        object->section = f.got;
        f.got = NULL;
    }
    vvi_free(f.inside);
    vvi_free(f.got);
    vvi_free(f.wanted);
    vvi_free(f.queue);
    vvi_free(f.queued);
    return st;
}

vv_status vvi_object_coarse(vvi_object *out, const vvi_object *fine, const vv_measure_options *options)
{
    vv_status st = vvi_object_open(out, fine->field, options, 2 * fine->step, fine->job);
    if (st != VV_OK || !fine->section)
        return st;
    const size_t rows = (size_t)(out->n[1] * out->n[2]);
    out->section = vvi_alloc_zeroed(fine->job, rows * out->words * sizeof *out->section, VVI_MEM_SCRATCH);
    if (!out->section)
        return vv_fail_memory(rows * out->words * sizeof *out->section);
    for (int64_t k = 0; k < out->n[2]; k++)
        for (int64_t j = 0; j < out->n[1]; j++) {
            const uint64_t *from = fine->section + (size_t)(2 * k * fine->n[1] + 2 * j) * fine->words;
            uint64_t *to = out->section + (size_t)(k * out->n[1] + j) * out->words;
            for (int64_t i = 0; i < out->n[0]; i++)
                to[i >> 6] |= (from[2 * i >> 6] >> (2 * i & 63) & 1) << (i & 63);
        }
    return VV_OK;
}
