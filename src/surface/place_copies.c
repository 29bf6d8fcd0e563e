#include "surface/place_copies.h"
#include "core/memory.h"

#include <math.h>
#include <string.h>

#define NONE UINT32_MAX

static uint64_t mix(uint64_t x)
{
    x ^= x >> 31;
    x *= 0x9e3779b97f4a7c15u;
    x ^= x >> 29;
    x *= 0xbf58476d1ce4e5b9u;
    return x ^ x >> 32;
}

/* For each vertex 0 when no edge ends its fan: each neighbour then comes once before a triangle and once after one. */
static void sum_borders(uint64_t *out, const uint32_t *indices, size_t n)
{
    for (size_t t = 0; t < n; t += 3)
        for (size_t i = 0; i < 3; i++)
            out[indices[t + i]] += mix(indices[t + (i + 1) % 3]) - mix(indices[t + (i + 2) % 3]);
}

static size_t slot_of(const float p[3], size_t mask)
{
    uint32_t bits[3];
    for (int i = 0; i < 3; i++) {
        const float x = p[i] + 0.F; /* -0 is 0 */
        memcpy(&bits[i], &x, sizeof x);
    }
    return (size_t)mix(mix(bits[0] | (uint64_t)bits[1] << 32) + bits[2]) & mask;
}

/* The slot of a place, or the free one for it. */
static size_t find(const uint32_t *table, size_t mask, const float *positions, const float p[3])
{
    size_t slot = slot_of(p, mask);
    for (; table[slot] != NONE; slot = (slot + 1) & mask) {
        const float *q = positions + 3 * (size_t)table[slot];
        if (p[0] == q[0] && p[1] == q[1] && p[2] == q[2])
            break;
    }
    return slot;
}

vv_status vvi_tell_apart(float *positions, size_t n_vertices, const uint32_t *indices, size_t n_indices, vv_job *job)
{
    size_t n_slots = 16;
    while (n_slots < 2 * n_vertices)
        n_slots *= 2;
    uint32_t *table = vvi_alloc(job, n_slots * sizeof *table, VVI_MEM_SCRATCH);
    uint64_t *border = vvi_alloc_zeroed(job, (n_vertices + 1) * sizeof *border, VVI_MEM_SCRATCH);
    const vv_status st = table && border ? VV_OK : vv_fail_memory(n_slots * sizeof *table);
    if (st == VV_OK) {
        memset(table, 0xff, n_slots * sizeof *table);
        sum_borders(border, indices, n_indices);
    }
    for (size_t v = 0; v < n_vertices && st == VV_OK; v++) {
        float *p = positions + 3 * v;
        size_t slot = find(table, n_slots - 1, positions, p);
        while (table[slot] != NONE && border[v] == 0 && isfinite(p[0])) {
            p[0] = nextafterf(p[0], INFINITY);
            slot = find(table, n_slots - 1, positions, p);
        }
        if (table[slot] == NONE)
            table[slot] = (uint32_t)v;
    }
    vvi_free(table);
    vvi_free(border);
    return st;
}
