/* Chunks to files: cut out of a slab, padded to their full size, packed. Chunks of zeros alone are not stored: they are
 * the fill value. */
#include "config.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "io/formats/zarr/zarr_write.h"
#include "io/sample_writer.h"
#include <string.h>
#include <zlib.h>
#if VV_HAVE_ZSTD
#include <zstd.h>
#endif
#if VV_HAVE_BLOSC
#include <blosc.h>
#endif

size_t vvi_zarr_pack_room(size_t n)
{
    return n + n / 64 + 4096; /* what any of them adds to bytes that cannot be compressed */
}

int vvi_zarr_pack_level(vvi_zarr_packing packing, int level)
{
    if (level > 0)
        return level;
    return packing == VVI_ZARR_PACK_ZSTD ? 3 : packing == VVI_ZARR_PACK_GZIP ? 6 : 5;
}

static size_t pack_gzip(uint8_t *out, const uint8_t *in, size_t n, int level)
{
    z_stream z = {0};
    if (deflateInit2(&z, level, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY) != Z_OK)
        return 0;
    z.next_in = (Bytef *)in;
    z.avail_in = (unsigned)n;
    z.next_out = out;
    z.avail_out = (unsigned)vvi_zarr_pack_room(n);
    const size_t packed = deflate(&z, Z_FINISH) == Z_STREAM_END ? z.total_out : 0;
    deflateEnd(&z);
    return packed;
}

size_t vvi_zarr_pack(uint8_t *out, const uint8_t *in, size_t n, vvi_zarr_packing packing, int level, size_t type_bytes)
{
    level = vvi_zarr_pack_level(packing, level);
    if (packing == VVI_ZARR_PACK_GZIP)
        return pack_gzip(out, in, n, level);
#if VV_HAVE_ZSTD
    if (packing == VVI_ZARR_PACK_ZSTD) {
        const size_t packed = ZSTD_compress(out, vvi_zarr_pack_room(n), in, n, level);
        return ZSTD_isError(packed) ? 0 : packed;
    }
#endif
#if VV_HAVE_BLOSC
    if (packing == VVI_ZARR_PACK_BLOSC) {
        const int shuffle = type_bytes > 1 ? BLOSC_SHUFFLE : BLOSC_NOSHUFFLE;
        const int packed =
            blosc_compress_ctx(level, shuffle, type_bytes, n, in, out, vvi_zarr_pack_room(n), "zstd", 0, 1);
        return packed > 0 ? (size_t)packed : 0;
    }
#endif
    memcpy(out, in, n);
    return n;
}

/* Chunks of a slab ----------------------------------------------------------------------------------------------- */

vvi_zarr_cutting vvi_zarr_cut(const vvi_zarr_writing *w, int level)
{
    const vvi_zarr_level *l = &w->level[level];
    vvi_zarr_cutting c = {.w = w, .level = l, .number = level};
    c.n_x = (l->dims[0] + l->chunk[0] - 1) / l->chunk[0];
    c.n_y = (l->dims[1] + l->chunk[1] - 1) / l->chunk[1];
    c.chunk_bytes = (size_t)(l->chunk[0] * l->chunk[1] * l->chunk[2]) * w->type_bytes;
    return c;
}

vv_status vvi_zarr_cut_start(void **scratch_out, void *shared, int worker)
{
    const vvi_zarr_cutting *c = shared;
    const size_t n = c->chunk_bytes + vvi_zarr_pack_room(c->chunk_bytes);
    (void)worker;
    *scratch_out = vvi_alloc(c->w->job, n, VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(n);
}

void vvi_zarr_cut_finish(void *scratch, void *shared)
{
    (void)shared;
    vvi_free(scratch);
}

/* One component of the samples at chunk (x, y) of the slab. */
static void cut_out(uint8_t *out, const vvi_zarr_cutting *p, int64_t x, int64_t y, int component)
{
    const vvi_zarr_level *l = p->level;
    const size_t bytes = p->w->type_bytes, sample = p->w->sample_bytes;
    const int64_t x0 = x * l->chunk[0], y0 = y * l->chunk[1];
    const int64_t n_x = l->dims[0] - x0 < l->chunk[0] ? l->dims[0] - x0 : l->chunk[0];
    const int64_t n_y = l->dims[1] - y0 < l->chunk[1] ? l->dims[1] - y0 : l->chunk[1];
    memset(out, 0, p->chunk_bytes);
    for (int64_t k = 0; k < l->n; k++)
        for (int64_t j = 0; j < n_y; j++) {
            const uint8_t *from = l->slab + (size_t)((k * l->dims[1] + y0 + j) * l->dims[0] + x0) * sample;
            uint8_t *to = out + (size_t)((k * l->chunk[1] + j) * l->chunk[0]) * bytes;
            if (sample == bytes) {
                memcpy(to, from, (size_t)n_x * bytes);
                continue;
            }
            for (int64_t i = 0; i < n_x; i++)
                memcpy(to + (size_t)i * bytes, from + (size_t)i * sample + (size_t)component * bytes, bytes);
        }
}

static bool all_zero(const uint8_t *data, size_t n)
{
    return data[0] == 0 && memcmp(data, data + 1, n - 1) == 0;
}

void vvi_zarr_cut_name(char out[160], const vvi_zarr_cutting *c, int64_t x, int64_t y, int component)
{
    const vvi_zarr_writing *w = c->w;
    int n = snprintf(out, 160, "%d/%s", c->number, w->version == 3 ? "c/" : "");
    if (w->n_frames > 1)
        n += snprintf(out + n, (size_t)(160 - n), "%lld/", (long long)w->frame);
    if (w->info->components > 1)
        n += snprintf(out + n, (size_t)(160 - n), "%d/", component);
    snprintf(out + n, (size_t)(160 - n), "%lld/%lld/%lld", (long long)(c->level->at / c->level->chunk[2]), (long long)y,
             (long long)x);
}

vv_status vvi_zarr_cut_chunk(const uint8_t **out, size_t *n_out, void *scratch, const vvi_zarr_cutting *c, int64_t x,
                             int64_t y, int component)
{
    const vvi_zarr_writing *w = c->w;
    uint8_t *plain = scratch, *packed = plain + c->chunk_bytes;
    *out = packed;
    *n_out = 0;
    vv_status st = vvi_job_poll(w->job);
    if (st != VV_OK)
        return st;
    cut_out(plain, c, x, y, component);
    if (all_zero(plain, c->chunk_bytes))
        return VV_OK;
    if (w->type_bytes > 1 && vvi_order_swapped(w->options->big_endian))
        vvi_swap_bytes(plain, w->type_bytes, c->chunk_bytes / w->type_bytes);
    *n_out = vvi_zarr_pack(packed, plain, c->chunk_bytes, w->packing, w->options->level, w->type_bytes);
    return *n_out > 0 ? VV_OK : vv_fail_at(VV_E_WRITE, vvi_sink_name(w->sink), NULL, "a chunk cannot be compressed");
}

static vv_status write_chunk(void *scratch, void *shared, size_t index)
{
    const vvi_zarr_cutting *c = shared;
    const uint8_t *packed;
    size_t n;
    char name[160];
    const int64_t x = (int64_t)index % c->n_x, y = (int64_t)index / c->n_x % c->n_y;
    const int component = (int)((int64_t)index / c->n_x / c->n_y);
    vv_status st = vvi_zarr_cut_chunk(&packed, &n, scratch, c, x, y, component);
    if (st != VV_OK || n == 0)
        return st;
    vvi_zarr_cut_name(name, c, x, y, component);
    return vvi_sink_put(c->w->sink, name, packed, n);
}

vv_status vvi_zarr_write_chunks(const vvi_zarr_writing *w, int level)
{
    vvi_zarr_cutting c = vvi_zarr_cut(w, level);
    const vvi_work work = {.start = vvi_zarr_cut_start, .item = write_chunk, .finish = vvi_zarr_cut_finish};
    return vvi_parallel_for(w->job, &work, &c, (size_t)(c.n_x * c.n_y * w->info->components));
}
