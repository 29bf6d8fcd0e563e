/** @file
 * The boxes of a volume in which something may be visible: what PARC projects, and what is drawn while
 * the hand moves.
 */
#ifndef VVI_GRID_BOXES_H
#define VVI_GRID_BOXES_H
#include "core/status.h"
#include "grid/minmax.h"

/** A box has six faces: towards smaller and larger index on each axis. */
enum { VVI_BOX_FACES = 6 };

/** Uniform boxes of 2^shift voxel cells a side (fewer at the far borders), x fastest: box (i, j, k) is number
 * (k * n[1] + j) * n[0] + i. Immutable; read it from any thread. */
typedef struct vvi_boxes {
    int32_t n[3];
    int shift;
    size_t n_kept;
    uint32_t *kept; /**< n_kept numbers, ascending */
    uint8_t *outer; /**< by kept box: bit 2 * axis + (1 towards larger index) where no kept box is beyond that face */
    size_t n_outer; /**< faces that lie outside */
} vvi_boxes;

/**
 * The boxes of 2^shift cells that hold a min-max block in which something is visible.
 *
 * Range    shift: of the blocks, or larger
 * Errors   VV_E_LIMIT (more boxes than 32 bits count), VV_E_MEMORY, VV_E_CANCELLED
 * Owns     *out is new: vvi_boxes_free()
 * Threads  the same list for any thread count
 */
vv_status vvi_boxes_build(vvi_boxes **out, const vvi_minmax *minmax, int shift, vvi_visible_fn *visible,
                          const void *user, vv_job *job);
void vvi_boxes_free(void *boxes); /* NULL is fine */

/** Whether box (i, j, k) is kept; none are beyond the borders. By binary search. */
bool vvi_boxes_has(const vvi_boxes *boxes, int64_t i, int64_t j, int64_t k);

/** Where a kept box lies in the grid of boxes. */
static inline void vvi_box_place(int32_t out[3], const vvi_boxes *boxes, uint32_t number)
{
    const uint32_t nx = (uint32_t)boxes->n[0], ny = (uint32_t)boxes->n[1];
    out[0] = (int32_t)(number % nx);
    out[1] = (int32_t)(number / nx % ny);
    out[2] = (int32_t)(number / nx / ny);
}

/** What the list holds in memory. */
static inline uint64_t vvi_boxes_bytes(const vvi_boxes *boxes)
{
    return sizeof *boxes + boxes->n_kept * (sizeof *boxes->kept + sizeof *boxes->outer);
}

#endif
