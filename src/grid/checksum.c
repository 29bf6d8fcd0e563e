/* CRC-32 of a field's samples: of slabs in parallel, joined in order, kept with the store. */
#include "core/cpu.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/crc.h"
#include "grid/slabs.h"
#include "grid/store.h"

#include <string.h>
#include <zlib.h>

#define ITEM_SAMPLES ((int64_t)1 << 20)
#define KNOWN ((uint64_t)1 << 32)

typedef struct part {
    uint32_t crc;
    uint64_t bytes;
} part;

typedef struct shared {
    const vv_field *field;
    vv_job *job;
    vvi_slabs slabs;
    bool fold;
    part *parts;
} shared;

static bool big_endian(void)
{
    const uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first == 0;
}

static uint32_t crc_bytes(uint32_t crc, const void *data, size_t n, vv_type type, bool fold)
{
    if (!big_endian())
        return vvi_crc32(crc, data, n, fold);
    char piece[4096];
    for (size_t done = 0; done < n; done += sizeof piece) {
        const size_t now = n - done < sizeof piece ? n - done : sizeof piece;
        memcpy(piece, (const char *)data + done, now);
        vvi_swap_bytes(piece, vv_type_bytes(type), now / vv_type_bytes(type));
        crc = vvi_crc32(crc, piece, now, fold);
    }
    return crc;
}

static vv_status sum_item(void *scratch, void *user, size_t index)
{
    (void)scratch;
    shared *s = user;
    const vv_box box = vvi_slabs_item(&s->slabs, index);
    vv_brick brick;
    const vv_status st = vv_field_brick(&brick, s->field, &box, s->job);
    if (st != VV_OK)
        return st;
    const size_t row = (size_t)box.n[0] * vv_type_bytes(brick.type) * (size_t)brick.components;
    part *p = &s->parts[index];
    p->crc = 0;
    /* Where rows follow each other without a gap, a slice is one run. */
    const bool dense = brick.stride[1] == (int64_t)row;
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < (dense ? 1 : box.n[1]); j++)
            p->crc = crc_bytes(p->crc, (const char *)brick.data + j * brick.stride[1] + k * brick.stride[2],
                               dense ? row * (size_t)box.n[1] : row, brick.type, s->fold);
    p->bytes = row * (uint64_t)box.n[1] * (uint64_t)box.n[2];
    vv_brick_release(&brick);
    return VV_OK;
}

static vv_status compute(uint32_t *out, const vv_field *field, vv_job *job)
{
    static const vvi_work work = {.stage = "checksum", .item = sum_item};
    const vv_box all = vv_field_box(field);
    shared s = {.field = field,
                .job = job,
                .slabs = vvi_slabs_of(&all, ITEM_SAMPLES),
                .fold = (vvi_job_cpu(job) & VVI_CPU_AVX2) && vvi_crc_has_fold()};
    s.parts = vvi_alloc_zeroed(job, s.slabs.n * sizeof *s.parts, VVI_MEM_SCRATCH);
    if (!s.parts)
        return vv_fail_memory(s.slabs.n * sizeof *s.parts);
    vv_status st = vvi_parallel_for(job, &work, &s, s.slabs.n);
    if (st == VV_OK)
        st = vv_field_health(field);
    uint32_t crc = 0;
    for (size_t i = 0; st == VV_OK && i < s.slabs.n; i++)
        crc = (uint32_t)crc32_combine(crc, s.parts[i].crc, (z_off_t)s.parts[i].bytes);
    vvi_free(s.parts);
    *out = crc;
    return st;
}

vv_status vv_field_checksum(uint32_t *out, const vv_field *field, vv_job *job)
{
    vvi_sample_store *store = vvi_field_store(field);
    const uint64_t before = atomic_load_explicit(&store->checksum, memory_order_relaxed);
    if (before & KNOWN) {
        *out = (uint32_t)before;
        return VV_OK;
    }
    const vv_status st = compute(out, field, job);
    /* Two threads may both compute it: the same number twice. */
    if (st == VV_OK)
        atomic_store_explicit(&store->checksum, KNOWN | *out, memory_order_relaxed);
    return st;
}
