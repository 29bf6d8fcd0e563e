/** @file
 * Space skipping: which cells of the min-max grid can be seen, and how far the nearest cell
 * of the other sort is.
 */
#ifndef VVI_RENDER_SKIP_H
#define VVI_RENDER_SKIP_H
#include "core/status.h"
#include "grid/minmax.h"

/** What reach[block] says: a bit, and a distance in the rest. */
enum { VVI_SKIP_OCCUPIED = 128, VVI_SKIP_DISTANCE = 127 };

/** Over the blocks of a vvi_minmax. reach[block] & VVI_SKIP_OCCUPIED: something may be visible in it. The other bits:
 * the Chebyshev distance in blocks to the nearest block of the other sort, from 1 to at most 127; what lies outside the
 * grid is of neither sort. Guard bytes follow the last one. */
typedef struct vvi_skip {
    int32_t n[3];
    int shift; /**< a block has 2^shift voxel cells a side */
    uint8_t *reach;
    uint64_t n_occupied;
} vvi_skip;

/** Same result for any thread count. Free with vvi_skip_free(). */
vv_status vvi_skip_build(vvi_skip **out, const vvi_minmax *minmax, vvi_visible_fn *visible, const void *user,
                         vv_job *job);
void vvi_skip_free(void *skip); /* NULL is fine */

#endif
