/** @file
 * A queue of numbers by least key.
 */
#ifndef VVI_MEASURE_HEAP_H
#define VVI_MEASURE_HEAP_H
#include "core/job.h"
#include "core/memory.h"

typedef struct vvi_heap_item {
    double key, value;
    uint32_t index;
    uint32_t kind;
} vvi_heap_item;

typedef struct vvi_heap {
    vvi_heap_item *items;
    size_t n, room;
} vvi_heap;

/** Of equal keys the lower kind and index comes first, so that the order is always the same. */
static inline bool vvi_heap_before(const vvi_heap_item *a, const vvi_heap_item *b)
{
    return a->key != b->key ? a->key < b->key : a->kind != b->kind ? a->kind < b->kind : a->index < b->index;
}

static inline vv_status vvi_heap_push(vvi_heap *heap, vvi_heap_item item, vv_job *job)
{
    if (heap->n == heap->room) {
        const size_t room = heap->room ? 2 * heap->room : 1024;
        vvi_heap_item *items = vvi_realloc(job, heap->items, room * sizeof *items, VVI_MEM_SCRATCH);
        if (!items)
            return vv_fail_memory(room * sizeof *items);
        heap->items = items;
        heap->room = room;
    }
    size_t at = heap->n++;
    for (; at > 0 && vvi_heap_before(&item, &heap->items[(at - 1) / 2]); at = (at - 1) / 2)
        heap->items[at] = heap->items[(at - 1) / 2];
    heap->items[at] = item;
    return VV_OK;
}

/** The heap is not empty. */
static inline vvi_heap_item vvi_heap_pop(vvi_heap *heap)
{
    const vvi_heap_item first = heap->items[0], last = heap->items[--heap->n];
    size_t at = 0;
    for (size_t child = 1; child < heap->n; child = 2 * at + 1) {
        if (child + 1 < heap->n && vvi_heap_before(&heap->items[child + 1], &heap->items[child]))
            child++;
        if (!vvi_heap_before(&heap->items[child], &last))
            break;
        heap->items[at] = heap->items[child];
        at = child;
    }
    heap->items[at] = last;
    return first;
}
#endif
