/** @file
 * What is known of the cells and edges around a piece of surface, in bricks that are made where it goes: memory is
 * proportional to the piece and not to the volume.
 */
#ifndef VVI_SURFACE_TRACKED_CELLS_H
#define VVI_SURFACE_TRACKED_CELLS_H
#include "core/status.h"
#include <volvis/runtime.h>

enum {
    VVI_TRACKED_SHIFT = 4,
    VVI_TRACKED_SIDE = 1 << VVI_TRACKED_SHIFT,
    VVI_TRACKED_CELLS = VVI_TRACKED_SIDE * VVI_TRACKED_SIDE * VVI_TRACKED_SIDE,
    VVI_TRACKED_WORDS = 3 * VVI_TRACKED_CELLS / 64
};

/** Cells and edges belong to the sample at their lower corner. Edge a of local sample s is bit 3 * s + a. */
typedef struct vvi_tracked_brick {
    int32_t at[3];                      /**< in the grid of bricks */
    uint16_t cell[VVI_TRACKED_CELLS];   /**< the tracker's: 0 at first */
    uint64_t edge[VVI_TRACKED_WORDS];   /**< edges that the piece crosses */
    uint16_t before[VVI_TRACKED_WORDS]; /**< crossed edges in the words before */
    uint32_t first_vertex, n_edges, n_interior;
    size_t first_triangle, n_triangles;
} vvi_tracked_brick;

typedef struct vvi_tracked {
    vvi_tracked_brick **slot; /**< a hash table with open places */
    size_t n_slots, n_bricks;
    vvi_tracked_brick **sorted; /**< n_bricks, by z, y, x; once vvi_tracked_sort() was called */
    vvi_tracked_brick *last;    /**< found last */
    vv_job *job;
} vvi_tracked;

/** The brick of the sample `at`, made if it is not there. Errors: VV_E_MEMORY, VV_E_LIMIT. */
vv_status vvi_tracked_make(vvi_tracked_brick **out, vvi_tracked *t, const int32_t at[3]);
/** The brick at this place in the grid of bricks, or NULL. Any number of threads, while none makes bricks. */
vvi_tracked_brick *vvi_tracked_find(const vvi_tracked *t, const int32_t brick[3]);
/** Brings the bricks into an order that does not depend on how they were found. */
vv_status vvi_tracked_sort(vvi_tracked *t);
void vvi_tracked_finish(vvi_tracked *t);

/** Number of a sample in its brick. */
static inline int vvi_tracked_local(const int32_t at[3])
{
    const int32_t last = VVI_TRACKED_SIDE - 1;
    return (at[2] & last) << 2 * VVI_TRACKED_SHIFT | (at[1] & last) << VVI_TRACKED_SHIFT | (at[0] & last);
}

/** Number of a crossed edge among those of its brick, once `before` is known. */
static inline uint32_t vvi_tracked_rank(const vvi_tracked_brick *b, int edge)
{
    const uint64_t below = b->edge[edge >> 6] & (((uint64_t)1 << (edge & 63)) - 1);
    return b->before[edge >> 6] + (uint32_t)__builtin_popcountll(below);
}
#endif
