/* Shards of Zarr 3: files of many chunks, with an index of where they lie at the end. A shard is as deep as a slab, so
 * that it is begun and ended with one: chunks are packed side by side, a few at a time, and appended in their order,
 * which makes the same bytes on any number of threads. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/zarr/zarr_write.h"
#include <string.h>

#define ABSENT UINT64_MAX
#define BATCH_BYTES ((size_t)16 << 20) /* of chunks that are packed at once */
#define BATCH_MOST 64

typedef struct packed_chunk {
    uint8_t *data; /* NULL: not stored */
    size_t n;
} packed_chunk;

typedef struct sharding {
    vvi_zarr_cutting cutting; /* first: vvi_zarr_cut_start() looks for it */
    int64_t x, y;             /* of the shard's first chunk */
    int component;
    int64_t first; /* of the chunks of this batch, in the shard */
    size_t n_batch;
    packed_chunk batch[BATCH_MOST];
    uint64_t written;
    uint8_t *index; /* of the shard: offset and length of each chunk, then the checksum */
    char name[160];
} sharding;

static int64_t per_shard(const sharding *s)
{
    return s->cutting.level->shard[0] * s->cutting.level->shard[1];
}

static void put_little(uint8_t *out, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        out[i] = (uint8_t)(value >> 8 * i);
}

/* Places of a shard that lie past the last chunk are empty, too. */
static vv_status pack_one(void *scratch, void *shared, size_t number)
{
    sharding *s = shared;
    const int64_t place = s->first + (int64_t)number, across = s->cutting.level->shard[0];
    const int64_t x = s->x + place % across, y = s->y + place / across;
    const uint8_t *packed;
    size_t n = 0;
    if (x >= s->cutting.n_x || y >= s->cutting.n_y)
        return VV_OK;
    vv_status st = vvi_zarr_cut_chunk(&packed, &n, scratch, &s->cutting, x, y, s->component);
    if (st != VV_OK || n == 0)
        return st;
    packed_chunk *to = &s->batch[number];
    to->data = vvi_alloc(s->cutting.w->job, n, VVI_MEM_SCRATCH);
    if (!to->data)
        return vv_fail_memory(n);
    memcpy(to->data, packed, n);
    to->n = n;
    return VV_OK;
}

static vv_status append_batch(sharding *s)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < s->n_batch && st == VV_OK; i++) {
        const packed_chunk *p = &s->batch[i];
        uint8_t *entry = s->index + 16 * ((size_t)s->first + i);
        put_little(entry, p->data ? s->written : ABSENT, 8);
        put_little(entry + 8, p->data ? p->n : ABSENT, 8);
        if (!p->data)
            continue;
        st = vvi_sink_append(s->cutting.w->sink, s->name, p->data, p->n);
        s->written += p->n;
    }
    return st;
}

static vv_status write_batch(sharding *s)
{
    const vvi_work work = {.start = vvi_zarr_cut_start, .item = pack_one, .finish = vvi_zarr_cut_finish};
    memset(s->batch, 0, sizeof s->batch);
    vv_status st = vvi_parallel_for(s->cutting.w->job, &work, s, s->n_batch);
    if (st == VV_OK)
        st = append_batch(s);
    for (size_t i = 0; i < s->n_batch; i++)
        vvi_free(s->batch[i].data);
    return st;
}

static size_t batch_size(const sharding *s)
{
    const size_t n = BATCH_BYTES / s->cutting.chunk_bytes;
    return n < 4 ? 4 : n < BATCH_MOST ? n : BATCH_MOST;
}

/* A shard of zeros alone is not stored, as a chunk is not. */
static vv_status write_shard(sharding *s)
{
    const int64_t n = per_shard(s);
    const size_t index_bytes = (size_t)n * 16;
    vv_status st = VV_OK;
    s->written = 0;
    for (s->first = 0; s->first < n && st == VV_OK; s->first += (int64_t)s->n_batch) {
        s->n_batch = batch_size(s);
        if ((int64_t)s->n_batch > n - s->first)
            s->n_batch = (size_t)(n - s->first);
        st = write_batch(s);
    }
    if (st != VV_OK || s->written == 0)
        return st;
    put_little(s->index + index_bytes, vvi_crc32c(s->index, index_bytes), 4);
    return vvi_sink_append(s->cutting.w->sink, s->name, s->index, index_bytes + 4);
}

vv_status vvi_zarr_write_shards(const vvi_zarr_writing *w, int level)
{
    sharding s = {.cutting = vvi_zarr_cut(w, level)};
    const int64_t across = s.cutting.level->shard[0], down = s.cutting.level->shard[1];
    const size_t index_bytes = (size_t)per_shard(&s) * 16 + 4;
    vv_status st = VV_OK;
    s.index = vvi_alloc(w->job, index_bytes, VVI_MEM_SCRATCH);
    if (!s.index)
        return vv_fail_memory(index_bytes);
    for (s.component = 0; s.component < w->info->components && st == VV_OK; s.component++)
        for (s.y = 0; s.y < s.cutting.n_y && st == VV_OK; s.y += down)
            for (s.x = 0; s.x < s.cutting.n_x && st == VV_OK; s.x += across) {
                vvi_zarr_cut_name(s.name, &s.cutting, s.x / across, s.y / down, s.component);
                st = write_shard(&s);
            }
    vvi_free(s.index);
    return st;
}
