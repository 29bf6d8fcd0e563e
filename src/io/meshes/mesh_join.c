/* A hash table with open addressing whose slots hold vertices. Corners go through it in batches, so that what a corner
 * needs of slots and places is on its way from memory while others are looked at. */
#include "io/meshes/mesh_join.h"
#include "core/memory.h"

#include <string.h>

enum { BATCH = 48 };

typedef struct place {
    uint32_t bits[3];
} place;

static size_t hash(const place *p)
{
    uint64_t h = ((uint64_t)p->bits[0] << 32 | p->bits[1]) * UINT64_C(0x9e3779b97f4a7c15);
    h = (h ^ h >> 29 ^ p->bits[2]) * UINT64_C(0xbf58476d1ce4e5b9);
    return (size_t)(h ^ h >> 31);
}

/* Zero has two signs and one place. */
static place place_of(const float *v)
{
    place p;
    memcpy(p.bits, v, sizeof p.bits);
    for (int a = 0; a < 3; a++)
        p.bits[a] = p.bits[a] == UINT32_C(0x80000000) ? 0 : p.bits[a];
    return p;
}

static bool is_at(const vvi_mesh_builder *b, uint32_t vertex, const place *p)
{
    uint32_t bits[3];
    memcpy(bits, b->arrays.positions + 3 * (size_t)vertex, sizeof bits);
    return bits[0] == p->bits[0] && bits[1] == p->bits[1] && bits[2] == p->bits[2];
}

static vv_status make_table(vvi_mesh_join *j, size_t slots)
{
    const vv_status st = vvi_source_grow(j->b->source, slots * sizeof(uint32_t));
    if (st != VV_OK)
        return st;
    uint32_t *slot = vvi_alloc_zeroed(j->b->job, slots * sizeof *slot, VVI_MEM_SCRATCH);
    if (!slot)
        return vv_fail_memory(slots * sizeof *slot);
    vvi_free(j->slot);
    j->slot = slot;
    j->mask = slots - 1;
    for (size_t v = 0; v < j->b->info.n_vertices; v++) {
        const place p = place_of(j->b->arrays.positions + 3 * v);
        size_t at = hash(&p) & j->mask;
        while (slot[at])
            at = (at + 1) & j->mask;
        slot[at] = (uint32_t)v + 1;
    }
    return VV_OK;
}

vv_status vvi_mesh_join_begin(vvi_mesh_join *out, vvi_mesh_builder *b, size_t n_triangles)
{
    size_t slots = 1024;
    while (slots < n_triangles && slots < (size_t)1 << 31)
        slots *= 2; /* closed meshes have half as many vertices as triangles */
    *out = (vvi_mesh_join){.b = b};
    return make_table(out, slots);
}

void vvi_mesh_join_end(vvi_mesh_join *j)
{
    vvi_free(j->slot);
    *j = (vvi_mesh_join){0};
}

static vv_status find(uint32_t *out, vvi_mesh_join *j, const place *p, size_t at)
{
    for (; j->slot[at]; at = (at + 1) & j->mask)
        if (is_at(j->b, j->slot[at] - 1, p)) {
            *out = j->slot[at] - 1;
            return VV_OK;
        }
    const vv_status st = vvi_mesh_builder_vertices(j->b, 1);
    if (st != VV_OK)
        return st;
    *out = (uint32_t)(j->b->info.n_vertices - 1);
    memcpy(j->b->arrays.positions + 3 * (size_t)*out, p->bits, sizeof p->bits);
    j->slot[at] = *out + 1;
    return VV_OK;
}

static vv_status add_batch(uint32_t *out, vvi_mesh_join *j, const float *corners, size_t n)
{
    place p[BATCH];
    size_t at[BATCH];
    vv_status st = VV_OK;
    for (size_t i = 0; i < n; i++) {
        p[i] = place_of(corners + 3 * i);
        at[i] = hash(&p[i]) & j->mask;
        __builtin_prefetch(j->slot + at[i]);
    }
    for (size_t i = 0; i < n; i++)
        if (j->slot[at[i]])
            __builtin_prefetch(j->b->arrays.positions + 3 * (size_t)(j->slot[at[i]] - 1));
    for (size_t i = 0; i < n && st == VV_OK; i++)
        st = find(out + i, j, &p[i], at[i]);
    return st;
}

vv_status vvi_mesh_join_add(vvi_mesh_join *j, const float *corners, size_t n)
{
    size_t t = 3 * j->b->info.n_triangles;
    vv_status st = vvi_mesh_builder_triangles(j->b, n);
    for (size_t i = 0; i < 3 * n && st == VV_OK; i += BATCH) {
        const size_t some = 3 * n - i < BATCH ? 3 * n - i : BATCH;
        if (2 * (j->b->info.n_vertices + some) > j->mask + 1)
            st = make_table(j, 2 * (j->mask + 1));
        if (st == VV_OK)
            st = add_batch(j->b->arrays.triangles + t + i, j, corners + 3 * i, some);
    }
    return st;
}
