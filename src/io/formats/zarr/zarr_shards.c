/* Shards: files that hold many chunks and an index of where they lie. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "io/formats/zarr/zarr.h"
#include <stdlib.h>
#include <string.h>

vv_status vvi_zarr_key(char out[VVI_ZARR_PATH], const vvi_zarr_array *a, const char *path, const int64_t *place)
{
    char key[VVI_ZARR_AXES * 22 + 4] = "c";
    size_t n = a->key_c ? 1 : 0;
    for (int i = 0; i < a->n_axes; i++) {
        if (n > 0)
            key[n++] = a->separator;
        n += (size_t)snprintf(key + n, sizeof key - n, "%lld", (long long)place[i]);
    }
    return vvi_zarr_join(out, path, key);
}

uint64_t vvi_zarr_per_shard(const vvi_zarr_array *a)
{
    uint64_t n = 1;
    for (int i = 0; i < a->n_axes; i++)
        n *= (uint64_t)(a->shard[i] / a->chunk[i]);
    return n;
}

void vvi_zarr_shard_close(vvi_zarr_shard *shard)
{
    vvi_free(shard->entry);
    *shard = (vvi_zarr_shard){0};
}

static int by_offset(const void *a, const void *b)
{
    const uint64_t *p = a, *q = b;
    return p[0] < q[0] ? -1 : p[0] > q[0];
}

/* Sorted by offset, no chunk reaches into the next one, the index or past the end. */
static vv_status check_places(const uint64_t *entry, size_t n, uint64_t index_at, uint64_t index_bytes, uint64_t size,
                              const char *name)
{
    uint64_t end = 0;
    for (size_t i = 0; i < n && entry[2 * i] != UINT64_MAX; i++) {
        const uint64_t at = entry[2 * i], bytes = entry[2 * i + 1];
        if (at > size || bytes > size - at)
            return vv_fail_at(VV_E_FORMAT, name, NULL, "its index places a chunk at bytes %llu + %llu of %llu",
                              (unsigned long long)at, (unsigned long long)bytes, (unsigned long long)size);
        if (at < end || (bytes > 0 && at < index_at + index_bytes && at + bytes > index_at))
            return vv_fail_at(VV_E_FORMAT, name, NULL, "its index has chunks that overlap");
        end = at + bytes;
    }
    return VV_OK;
}

static vv_status check_entries(const uint64_t *entry, size_t n, uint64_t index_at, uint64_t index_bytes, uint64_t size,
                               const char *name, vv_job *job)
{
    uint64_t *sorted = vvi_alloc(job, n * 16, VVI_MEM_SCRATCH);
    if (!sorted)
        return vv_fail_memory(n * 16);
    memcpy(sorted, entry, n * 16);
    qsort(sorted, n, 16, by_offset);
    vv_status st = check_places(sorted, n, index_at, index_bytes, size, name);
    vvi_free(sorted);
    return st;
}

static vv_status read_index(vvi_zarr_shard *out, const vvi_zarr_array *a, vv_source *source, vv_job *job)
{
    bool exact;
    const char *name = vvi_source_name(source);
    const uint64_t n = vvi_zarr_per_shard(a), size = vvi_source_left(source, &exact);
    const uint64_t bytes = n * 16 + (a->index_crc ? 4 : 0);
    if (bytes > size)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "has %llu bytes, but the index of its chunks takes %llu",
                          (unsigned long long)size, (unsigned long long)bytes);
    const uint64_t at = a->index_first ? 0 : size - bytes;
    uint8_t *index = vvi_alloc(job, (size_t)bytes, VVI_MEM_SCRATCH);
    if (!index)
        return vv_fail_memory((size_t)bytes);
    out->entry = (uint64_t *)(void *)index;
    vv_status st = vvi_source_seek(source, at);
    if (st == VV_OK)
        st = vvi_source_read(source, index, (size_t)bytes, "the index of a shard");
    if (st != VV_OK)
        return st;
    const uint8_t *sum = index + n * 16;
    if (a->index_crc && vvi_crc32c(index, (size_t)n * 16) != ((uint32_t)sum[0] | (uint32_t)sum[1] << 8 |
                                                              (uint32_t)sum[2] << 16 | (uint32_t)sum[3] << 24))
        return vv_fail_at(VV_E_FORMAT, name, NULL, "the checksum crc32c of its index is wrong");
    if (a->index_swap)
        vvi_swap_bytes(index, 8, (size_t)n * 2);
    return check_entries(out->entry, (size_t)n, at, bytes, size, name, job);
}

vv_status vvi_zarr_shard_open(vvi_zarr_shard *out, const vvi_zarr_array *a, const vv_source *folder, const char *key,
                              vv_job *job)
{
    vv_source *source;
    *out = (vvi_zarr_shard){0};
    vv_status st = vvi_source_find_beside(&source, folder, key, job);
    out->refused = st != VV_OK;
    if (st != VV_OK || !source)
        return st;
    st = read_index(out, a, source, job);
    vvi_source_close(source);
    if (st != VV_OK)
        vvi_zarr_shard_close(out);
    out->there = st == VV_OK;
    return st;
}
