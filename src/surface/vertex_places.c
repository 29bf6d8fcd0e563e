#include "surface/vertex_places.h"
#include "core/job.h"
#include "core/memory.h"

#include <string.h>

/* The first vertices of all places by the hash of the place: open addressing, UINT32_MAX where there is none. */
typedef struct table {
    const float *positions;
    uint32_t *first;
    size_t mask;
} table;

static uint64_t hash_place(const float *p)
{
    uint32_t bits[3];
    const float clean[3] = {p[0] + 0.0f, p[1] + 0.0f, p[2] + 0.0f}; /* -0 becomes 0 */
    memcpy(bits, clean, sizeof bits);
    uint64_t z = ((uint64_t)bits[0] << 32 | bits[1]) * 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 29 ^ bits[2]) * 0xbf58476d1ce4e5b9u;
    return z ^ z >> 32;
}

static uint32_t find_or_add(table *t, uint32_t vertex)
{
    const float *at = t->positions + 3 * (size_t)vertex;
    for (size_t i = hash_place(at) & t->mask;; i = (i + 1) & t->mask) {
        if (t->first[i] == UINT32_MAX)
            return t->first[i] = vertex;
        const float *other = t->positions + 3 * (size_t)t->first[i];
        if (other[0] == at[0] && other[1] == at[1] && other[2] == at[2])
            return t->first[i];
    }
}

vv_status vvi_number_places(uint32_t **out, const float *positions, size_t n_vertices, vv_job *job)
{
    enum { OFTEN = 1 << 16 };
    table t = {.positions = positions, .mask = 15};
    vv_status st = VV_OK;
    while (t.mask + 1 < 2 * n_vertices)
        t.mask = 2 * t.mask + 1;
    const size_t bytes = (t.mask + 1) * sizeof *t.first;
    *out = vvi_alloc(job, (n_vertices + 1) * sizeof **out, VVI_MEM_SCRATCH);
    t.first = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    if (!*out || !t.first)
        st = vv_fail_memory(bytes);
    else
        memset(t.first, 0xff, bytes);
    for (size_t v = 0; v < n_vertices && st == VV_OK; v++) {
        (*out)[v] = find_or_add(&t, (uint32_t)v);
        if (v % OFTEN == 0)
            st = vvi_job_poll(job);
    }
    vvi_free(t.first);
    if (st == VV_OK)
        return VV_OK;
    vvi_free(*out);
    *out = NULL;
    return st;
}
