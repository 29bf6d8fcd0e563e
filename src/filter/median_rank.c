/* A histogram of ranks in three levels, which follows the window (Huang, Yang and Tang 1979), of samples that have been
 * replaced by their ranks in a tile: so few different ones that a histogram can hold any type exactly. */
#include "filter/median_rank.h"
#include "core/memory.h"
#include "filter/sample_keys.h"

#include <math.h>
#include <string.h>

enum {
    RANKS = 65536,
    MIDDLE = 32,      /* ranks of a bin of the second level */
    COARSE = 32 * 32, /* and of the first */
    NO_RANK = 65535   /* of NaN: a tile has fewer samples */
};

struct vvi_median_ranks {
    vv_type type;
    bool has_missing;
    uint16_t rank[VVI_MEDIAN_TILE_MOST];
    int64_t key[VVI_MEDIAN_TILE_MOST]; /* of each rank */
    uint32_t order[2][VVI_MEDIAN_TILE_MOST];
    uint64_t bits[2][VVI_MEDIAN_TILE_MOST];
    uint16_t fine[RANKS], middle[RANKS / MIDDLE], coarse[RANKS / COARSE];
    int64_t count;
};

vv_status vvi_median_ranks_new(vvi_median_ranks **out, vv_type type, vv_job *job)
{
    *out = vvi_alloc_zeroed(job, sizeof **out, VVI_MEM_SCRATCH);
    if (!*out)
        return vv_fail_memory(sizeof **out);
    (*out)->type = type;
    return VV_OK;
}

void vvi_median_ranks_free(vvi_median_ranks *ranks)
{
    vvi_free(ranks);
}

/* By a byte a time, the lowest first; *order_out: the samples in their order. */
static const uint32_t *sort(vvi_median_ranks *r, int bytes, int64_t n)
{
    int from = 0;
    for (int byte = 0; byte < bytes; byte++, from = !from) {
        uint32_t begin[257] = {0};
        const int shift = 8 * byte;
        for (int64_t i = 0; i < n; i++)
            begin[(r->bits[from][i] >> shift & 0xff) + 1]++;
        for (int b = 0; b < 256; b++)
            begin[b + 1] += begin[b];
        for (int64_t i = 0; i < n; i++) {
            const uint32_t to = begin[r->bits[from][i] >> shift & 0xff]++;
            r->bits[!from][to] = r->bits[from][i];
            r->order[!from][to] = r->order[from][i];
        }
    }
    return r->order[from];
}

static bool is_missing(int64_t key, bool has_bounds, int64_t lo, int64_t hi)
{
    return has_bounds && (key < lo || key > hi);
}

/* Of types of four and eight bytes. */
static void rank_sorted(vvi_median_ranks *r, const void *keys, int64_t n)
{
    const int bytes = (int)vv_type_bytes(r->type);
    const uint64_t sign = (uint64_t)1 << (8 * bytes - 1); /* unsigned numbers sort as signed keys do */
    int64_t lo = 0, hi = 0;
    const bool has_bounds = vvi_keys_bounds(&lo, &hi, r->type);
    for (int64_t i = 0; i < n; i++) {
        r->order[0][i] = (uint32_t)i;
        r->bits[0][i] = (uint64_t)vvi_key_at(keys, i, r->type) ^ sign;
    }
    const uint32_t *order = sort(r, bytes, n);
    int64_t rank = -1;
    for (int64_t i = 0; i < n; i++) {
        const int64_t key = vvi_key_at(keys, order[i], r->type);
        if (is_missing(key, has_bounds, lo, hi)) {
            r->has_missing = true;
            r->rank[order[i]] = NO_RANK;
            continue;
        }
        if (rank < 0 || key != r->key[rank])
            r->key[++rank] = key;
        r->rank[order[i]] = (uint16_t)rank;
    }
}

void vvi_median_ranks_of(vvi_median_ranks *r, const void *keys, int64_t n)
{
    r->has_missing = false;
    if (vv_type_bytes(r->type) == 1)
        for (int64_t i = 0; i < n; i++)
            r->rank[i] = ((const uint8_t *)keys)[i];
    else if (vv_type_bytes(r->type) == 2)
        for (int64_t i = 0; i < n; i++)
            r->rank[i] = (uint16_t)(((const int16_t *)keys)[i] + 0x8000);
    else
        rank_sorted(r, keys, n);
}

static int64_t key_of(const vvi_median_ranks *r, int64_t rank)
{
    switch (vv_type_bytes(r->type)) {
    case 1:
        return rank;
    case 2:
        return rank - 0x8000;
    default:
        return r->key[rank];
    }
}

static inline void put(vvi_median_ranks *r, uint16_t rank, int by)
{
    if (r->has_missing && rank == NO_RANK)
        return;
    r->fine[rank] = (uint16_t)(r->fine[rank] + by);
    r->middle[rank / MIDDLE] = (uint16_t)(r->middle[rank / MIDDLE] + by);
    r->coarse[rank / COARSE] = (uint16_t)(r->coarse[rank / COARSE] + by);
    r->count += by;
}

/* A plane of the window, one sample thick along x. */
static void put_plane(vvi_median_ranks *r, int64_t at, const int64_t stride[2], const int64_t size[3], int by)
{
    for (int64_t k = 0; k < size[2]; k++)
        for (int64_t j = 0; j < size[1]; j++)
            put(r, r->rank[at + k * stride[1] + j * stride[0]], by);
}

/* The rank that `below` samples of the window come before. */
static int64_t find(const vvi_median_ranks *r, int64_t below)
{
    int64_t c = 0;
    for (; below >= r->coarse[c]; c++)
        below -= r->coarse[c];
    int64_t m = c * (COARSE / MIDDLE);
    for (; below >= r->middle[m]; m++)
        below -= r->middle[m];
    int64_t f = m * MIDDLE;
    for (; below >= r->fine[f]; f++)
        below -= r->fine[f];
    return f;
}

static void write_key(void *out, int64_t key, vv_type type)
{
    const uint8_t k1 = (uint8_t)key;
    const int16_t k2 = (int16_t)key;
    const int32_t k4 = (int32_t)key;
    const void *const keys[9] = {[1] = &k1, [2] = &k2, [4] = &k4, [8] = &key};
    vvi_samples_of_keys(out, 1, keys[vv_type_bytes(type)], type, 1);
}

/* Windows have an odd number of samples, so that only floats, some of which are NaN, come here. */
static void write_mean(void *out, int64_t a, int64_t b, vv_type type)
{
    if (type == VV_TYPE_F32) {
        float v[2];
        write_key(&v[0], a, type);
        write_key(&v[1], b, type);
        v[0] = (float)(0.5 * v[0] + 0.5 * v[1]);
        memcpy(out, v, sizeof *v);
    } else {
        double v[2];
        write_key(&v[0], a, type);
        write_key(&v[1], b, type);
        v[0] = 0.5 * v[0] + 0.5 * v[1];
        memcpy(out, v, sizeof *v);
    }
}

static void write_median(void *out, const vvi_median_ranks *r)
{
    const int64_t lower = find(r, (r->count - 1) / 2);
    if (r->count % 2)
        write_key(out, key_of(r, lower), r->type);
    else
        write_mean(out, key_of(r, lower), key_of(r, find(r, r->count / 2)), r->type);
}

static void write_nan(void *out, vv_type type)
{
    const float f = NAN;
    const double d = NAN;
    if (type == VV_TYPE_F32)
        memcpy(out, &f, sizeof f);
    else
        memcpy(out, &d, sizeof d);
}

void vvi_median_ranks_row(void *out, int64_t step, vvi_median_ranks *r, int64_t at, const int64_t stride[2],
                          const int64_t size[3], int64_t n)
{
    const int64_t middle = size[0] / 2 + size[1] / 2 * stride[0] + size[2] / 2 * stride[1];
    for (int64_t i = 0; i < size[0] - 1; i++)
        put_plane(r, at + i, stride, size, 1);
    for (int64_t i = 0; i < n; i++) {
        char *to = (char *)out + i * step;
        put_plane(r, at + i + size[0] - 1, stride, size, 1);
        if (r->has_missing && r->rank[at + i + middle] == NO_RANK)
            write_nan(to, r->type);
        else
            write_median(to, r);
        put_plane(r, at + i, stride, size, -1);
    }
    for (int64_t i = n; i < n + size[0] - 1; i++) /* empty for the next row */
        put_plane(r, at + i, stride, size, -1);
}
