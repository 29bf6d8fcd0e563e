/* Flooding after Meyer, with a queue for each height. Voxels wait in lists by height; where heights are many (more than
 * 16 bits) a list holds a span of them, and those of the span that the flood is in are kept in a heap. Each voxel waits
 * once, so that lists need one number a voxel. */
#include "segment/flood.h"
#include "core/memory.h"

#include <string.h>

enum { LISTS = 65536, STEPS_BETWEEN_LOOKS = 1 << 16 };
#define NOBODY 0xffffffffu

typedef struct waiting {
    int64_t height;
    uint32_t age, voxel;
} waiting;

typedef struct flood {
    uint32_t *label, *next;
    const vvi_heights *heights;
    const vvi_neighbours *around;
    bool lines;
    vvi_basins *basins;
    uint32_t *head, *tail;
    int shift; /* of a height above the lowest, for the number of its list; 0: a list has one height */
    int64_t list;
    int64_t level;
    double level_value;
    waiting *heap;
    size_t n, room;
    uint32_t age;
    vv_job *job;
} flood;

/* Basins ---------------------------------------------------------------------------------------------------------- */

uint32_t vvi_basins_root(vvi_basins *b, uint32_t label)
{
    while (b->parent[label] != label) {
        b->parent[label] = b->parent[b->parent[label]];
        label = b->parent[label];
    }
    return label;
}

static uint32_t root(const flood *f, uint32_t label)
{
    return f->basins ? vvi_basins_root(f->basins, label) : label;
}

static bool is_basin(uint32_t label)
{
    return label != VVI_FLOOD_NONE && label < VVI_FLOOD_OUTSIDE;
}

/* The one with the higher bottom becomes part of the other if it is not deep enough below the level where they meet. */
static uint32_t meet(flood *f, uint32_t a, uint32_t b)
{
    if (a == b || !f->basins)
        return a == b ? a : VVI_FLOOD_LINE;
    const double *bottom = f->basins->bottom;
    const bool a_is_lower = bottom[a] < bottom[b] || (bottom[a] == bottom[b] && a < b);
    const uint32_t low = a_is_lower ? a : b, high = a_is_lower ? b : a;
    if (!(f->level_value - bottom[high] < f->basins->depth))
        return VVI_FLOOD_LINE;
    f->basins->parent[high] = low;
    return low;
}

/* Those who wait -------------------------------------------------------------------------------------------------- */

static bool before(const waiting *a, const waiting *b)
{
    return a->height != b->height ? a->height < b->height : a->age < b->age;
}

static vv_status heap_add(flood *f, int64_t height, uint32_t voxel)
{
    if (f->n == f->room) {
        const size_t room = f->room ? 2 * f->room : 1024;
        waiting *more = vvi_realloc(f->job, f->heap, room * sizeof *more, VVI_MEM_SCRATCH);
        if (!more)
            return vv_fail_memory(room * sizeof *more);
        f->heap = more;
        f->room = room;
    }
    const waiting w = {height, f->age++, voxel};
    size_t at = f->n++;
    for (; at > 0 && before(&w, &f->heap[(at - 1) / 2]); at = (at - 1) / 2)
        f->heap[at] = f->heap[(at - 1) / 2];
    f->heap[at] = w;
    return VV_OK;
}

static waiting heap_take(flood *f)
{
    const waiting first = f->heap[0], last = f->heap[--f->n];
    size_t at = 0;
    for (size_t child = 1; child < f->n; child = 2 * at + 1) {
        child += child + 1 < f->n && before(&f->heap[child + 1], &f->heap[child]);
        if (!before(&f->heap[child], &last))
            break;
        f->heap[at] = f->heap[child];
        at = child;
    }
    f->heap[at] = last;
    return first;
}

static int64_t list_of(const flood *f, int64_t height)
{
    return (int64_t)(((uint64_t)height - (uint64_t)f->heights->lo) >> f->shift);
}

static vv_status wait(flood *f, int64_t voxel)
{
    const int64_t own = vvi_height_at(f->heights, voxel), height = own > f->level ? own : f->level;
    const int64_t list = list_of(f, height);
    if (f->shift && list == f->list)
        return heap_add(f, height, (uint32_t)voxel);
    f->next[voxel] = NOBODY;
    if (f->head[list] == NOBODY)
        f->head[list] = (uint32_t)voxel;
    else
        f->next[f->tail[list]] = (uint32_t)voxel;
    f->tail[list] = (uint32_t)voxel;
    return VV_OK;
}

static vv_status open_list(flood *f)
{
    vv_status st = VV_OK;
    for (uint32_t v = f->head[f->list]; v != NOBODY && st == VV_OK; v = f->next[v])
        st = heap_add(f, vvi_height_at(f->heights, v), v);
    f->head[f->list] = NOBODY;
    return st;
}

static void set_level(flood *f, int64_t height)
{
    if (f->basins && height != f->level)
        f->level_value = f->basins->value(f->basins->user, height);
    f->level = height;
}

/* Who is next; NOBODY at the end. */
static vv_status take(uint32_t *voxel, flood *f)
{
    *voxel = NOBODY;
    for (;;) {
        if (f->n > 0) {
            const waiting w = heap_take(f);
            set_level(f, w.height);
            *voxel = w.voxel;
            return VV_OK;
        }
        if (!f->shift && f->list >= 0 && f->head[f->list] != NOBODY) {
            *voxel = f->head[f->list];
            f->head[f->list] = f->next[*voxel];
            set_level(f, f->heights->lo + f->list);
            return VV_OK;
        }
        do
            f->list++;
        while (f->list < LISTS && f->head[f->list] == NOBODY);
        if (f->list >= LISTS)
            return VV_OK;
        const vv_status st = f->shift ? open_list(f) : VV_OK;
        if (st != VV_OK)
            return st;
    }
}

/* The flood ------------------------------------------------------------------------------------------------------- */

/* That of the basins around it, where they are one. */
static uint32_t decide(flood *f, const int64_t *around, int n)
{
    uint32_t label = VVI_FLOOD_NONE;
    for (int i = 0; i < n && label != VVI_FLOOD_LINE; i++) {
        const uint32_t there = f->label[around[i]];
        if (is_basin(there))
            label = label == VVI_FLOOD_NONE ? root(f, there) : meet(f, label, root(f, there));
    }
    return label;
}

/* Basins meet at the higher one of two voxels: that of them which is taken later. */
static void meet_around(flood *f, uint32_t label, const int64_t *around, int n)
{
    for (int i = 0; i < n; i++) {
        const uint32_t there = f->label[around[i]];
        if (is_basin(there) && there != label && vvi_height_at(f->heights, around[i]) <= f->level)
            meet(f, root(f, label), root(f, there));
    }
}

static vv_status visit(flood *f, uint32_t voxel)
{
    int64_t around[VVI_NEIGHBOURS_MOST];
    const int n = vvi_neighbours_at(around, f->around, voxel);
    vv_status st = VV_OK;
    if (f->label[voxel] == VVI_FLOOD_WAITS)
        f->label[voxel] = decide(f, around, n);
    else if (f->basins && !f->lines)
        meet_around(f, f->label[voxel], around, n);
    if (f->label[voxel] == VVI_FLOOD_LINE)
        return VV_OK;
    for (int i = 0; i < n && st == VV_OK; i++)
        if (f->label[around[i]] == VVI_FLOOD_NONE) {
            f->label[around[i]] = f->lines ? VVI_FLOOD_WAITS : f->label[voxel];
            st = wait(f, around[i]);
        }
    return st;
}

static vv_status run(flood *f, int64_t n)
{
    vv_status st = VV_OK;
    uint32_t voxel;
    for (int64_t v = 0; v < n && st == VV_OK; v++)
        if (is_basin(f->label[v]))
            st = wait(f, v);
    for (int64_t done = 0; st == VV_OK && (st = take(&voxel, f)) == VV_OK && voxel != NOBODY; done++) {
        st = visit(f, voxel);
        if (st == VV_OK && done % STEPS_BETWEEN_LOOKS == 0)
            st = vvi_job_progress(f->job, "flood", (uint64_t)done, (uint64_t)n);
    }
    return st == VV_OK ? vvi_job_progress(f->job, "flood", (uint64_t)n, (uint64_t)n) : st;
}

vv_status vvi_flood(uint32_t *label, const vvi_heights *heights, const vvi_neighbours *around, bool lines,
                    vvi_basins *basins, uint32_t *next, vv_job *job)
{
    const size_t bytes = 2 * LISTS * sizeof(uint32_t);
    flood f = {.heights = heights,
               .around = around,
               .lines = lines,
               .basins = basins,
               .head = vvi_alloc(job, bytes, VVI_MEM_SCRATCH),
               .list = -1,
               .level = heights->lo,
               .job = job};
    f.label = label;
    f.next = next;
    if (!f.head)
        return vv_fail_memory(bytes);
    memset(f.head, 0xff, bytes);
    f.tail = f.head + LISTS;
    while (((uint64_t)heights->hi - (uint64_t)heights->lo) >> f.shift >= LISTS) /* their distance needs 64 bits */
        f.shift++;
    if (basins)
        f.level_value = basins->value(basins->user, f.level);
    const vv_status st = run(&f, around->n[0] * around->n[1] * around->n[2]);
    vvi_free(f.head);
    vvi_free(f.heap);
    return st;
}
