/* Sizes are sorted by counting; the few that are larger than most by comparing. */
#include "segment/part_sizes.h"
#include "core/memory.h"

#include <stdlib.h>

#define COUNTED 65536 /* smaller sizes than this */

typedef struct part {
    uint64_t size;
    uint32_t number;
} part;

static int larger_first(const void *a, const void *b)
{
    const part *x = a, *y = b;
    if (x->size != y->size)
        return x->size > y->size ? -1 : 1;
    return (x->number > y->number) - (x->number < y->number);
}

static uint32_t rank_large(uint32_t *rank, const uint64_t *size, uint32_t n, part *large)
{
    uint32_t n_large = 0;
    for (uint32_t i = 0; i < n; i++)
        if (size[i] >= COUNTED)
            large[n_large++] = (part){size[i], i};
    qsort(large, n_large, sizeof *large, larger_first);
    for (uint32_t i = 0; i < n_large; i++)
        rank[large[i].number] = i + 1;
    return n_large;
}

static void rank_small(uint32_t *rank, const uint64_t *size, uint32_t n, uint32_t n_large, uint32_t *before)
{
    for (uint32_t i = 0; i < n; i++)
        if (size[i] < COUNTED)
            before[size[i]]++;
    uint32_t all = n_large;
    for (size_t s = COUNTED; s-- > 0;) {
        const uint32_t here = before[s];
        before[s] = all;
        all += here;
    }
    for (uint32_t i = 0; i < n; i++)
        if (size[i] < COUNTED)
            rank[i] = ++before[size[i]];
}

static void keep(vvi_part_sizes *out, const uint64_t *size, double least, uint32_t most)
{
    for (uint32_t i = 0; i < out->n_parts; i++) {
        const uint32_t rank = out->rank[i];
        if (rank > most || (double)size[i] < least) {
            out->rank[i] = 0;
            continue;
        }
        out->n_kept++;
        if (rank <= VVI_PARTS_TOLD)
            out->largest[rank - 1] = size[i];
    }
}

static uint32_t count_large(const uint64_t *size, uint32_t n)
{
    uint32_t large = 0;
    for (uint32_t i = 0; i < n; i++)
        large += size[i] >= COUNTED;
    return large;
}

vv_status vvi_part_sizes_rank(vvi_part_sizes *out, const uint64_t *size, uint32_t n, double least, uint32_t most,
                              vv_job *job)
{
    *out = (vvi_part_sizes){.n_parts = n, .rank = out->rank};
    vv_status st = VV_OK;
    const size_t large_bytes = ((size_t)count_large(size, n) + 1) * sizeof(part);
    part *large = vvi_alloc(job, large_bytes, VVI_MEM_SCRATCH);
    uint32_t *before = vvi_alloc_zeroed(job, COUNTED * sizeof *before, VVI_MEM_SCRATCH);
    if (!out->rank)
        out->rank = vvi_alloc(job, ((size_t)n + 1) * sizeof *out->rank, VVI_MEM_SCRATCH);
    if (large && before && out->rank) {
        rank_small(out->rank, size, n, rank_large(out->rank, size, n, large), before);
        keep(out, size, least, most);
    } else
        st = vv_fail_memory(((size_t)n + 1) * sizeof *out->rank);
    vvi_free(large);
    vvi_free(before);
    return st;
}

vv_status vvi_part_sizes_find(vvi_part_sizes *out, const vvi_runs *runs, double least, uint32_t most, vv_job *job)
{
    uint64_t *size = NULL;
    *out = (vvi_part_sizes){.n_parts = runs->n_parts};
    vv_status st = vvi_runs_sizes(&size, runs, job);
    if (st == VV_OK)
        st = vvi_part_sizes_rank(out, size, runs->n_parts, least, most, job);
    vvi_free(size);
    return st;
}

void vvi_part_sizes_finish(vvi_part_sizes *sizes)
{
    vvi_free(sizes->rank);
    *sizes = (vvi_part_sizes){0};
}
