#include "surface/tracked_cells.h"
#include "core/memory.h"

#include <stdlib.h>
#include <string.h>

enum { FEWEST_SLOTS = 64 };

static size_t hash(const int32_t brick[3])
{
    uint64_t h = 0;
    for (int a = 0; a < 3; a++) /* splitmix64's last steps, for each axis */
        h = (h ^ (uint32_t)brick[a]) * 0xbf58476d1ce4e5b9u, h ^= h >> 29;
    return (size_t)h;
}

/* Where the brick is, or the open place where it belongs. */
static size_t slot_of(const vvi_tracked *t, const int32_t brick[3])
{
    size_t i = hash(brick) & (t->n_slots - 1);
    while (t->slot[i] && memcmp(t->slot[i]->at, brick, sizeof t->slot[i]->at) != 0)
        i = (i + 1) & (t->n_slots - 1);
    return i;
}

vvi_tracked_brick *vvi_tracked_find(const vvi_tracked *t, const int32_t brick[3])
{
    return t->n_slots ? t->slot[slot_of(t, brick)] : NULL;
}

/* Twice as many places. */
static vv_status grow(vvi_tracked *t)
{
    const vvi_tracked old = *t;
    const size_t n = old.n_slots ? 2 * old.n_slots : FEWEST_SLOTS;
    vvi_tracked_brick **slot = vvi_alloc_zeroed(t->job, n * sizeof(void *), VVI_MEM_SCRATCH);
    if (!slot)
        return vv_fail_memory(n * sizeof(void *));
    t->slot = slot;
    t->n_slots = n;
    for (size_t i = 0; i < old.n_slots; i++)
        if (old.slot[i])
            t->slot[slot_of(t, old.slot[i]->at)] = old.slot[i];
    vvi_free(old.slot);
    return VV_OK;
}

vv_status vvi_tracked_make(vvi_tracked_brick **out, vvi_tracked *t, const int32_t at[3])
{
    const int32_t brick[3] = {at[0] >> VVI_TRACKED_SHIFT, at[1] >> VVI_TRACKED_SHIFT, at[2] >> VVI_TRACKED_SHIFT};
    if (t->last && memcmp(t->last->at, brick, sizeof brick) == 0) {
        *out = t->last;
        return VV_OK;
    }
    const vv_status st = 2 * t->n_bricks >= t->n_slots ? grow(t) : VV_OK;
    if (st != VV_OK)
        return st;
    vvi_tracked_brick **slot = &t->slot[slot_of(t, brick)];
    if (!*slot) {
        if (!(*slot = vvi_alloc_zeroed(t->job, sizeof **slot, VVI_MEM_SCRATCH)))
            return vv_fail_memory(sizeof **slot);
        memcpy((*slot)->at, brick, sizeof brick);
        t->n_bricks++;
    }
    *out = t->last = *slot;
    return VV_OK;
}

static int by_place(const void *a, const void *b)
{
    const vvi_tracked_brick *x = *(vvi_tracked_brick *const *)a, *y = *(vvi_tracked_brick *const *)b;
    for (int axis = 2; axis >= 0; axis--)
        if (x->at[axis] != y->at[axis])
            return x->at[axis] < y->at[axis] ? -1 : 1;
    return 0;
}

vv_status vvi_tracked_sort(vvi_tracked *t)
{
    size_t n = 0;
    t->sorted = vvi_alloc(t->job, (t->n_bricks + 1) * sizeof(void *), VVI_MEM_SCRATCH);
    if (!t->sorted)
        return vv_fail_memory((t->n_bricks + 1) * sizeof(void *));
    for (size_t i = 0; i < t->n_slots; i++)
        if (t->slot[i])
            t->sorted[n++] = t->slot[i];
    qsort(t->sorted, n, sizeof(void *), by_place);
    return VV_OK;
}

void vvi_tracked_finish(vvi_tracked *t)
{
    for (size_t i = 0; i < t->n_slots; i++)
        vvi_free(t->slot[i]);
    vvi_free(t->slot);
    vvi_free(t->sorted);
    *t = (vvi_tracked){0};
}
