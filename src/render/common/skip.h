/** @file
 * Space skipping: which cells of the min-max grid can be seen, and how far the nearest such cell is.
 */
#ifndef VVI_RENDER_SKIP_H
#define VVI_RENDER_SKIP_H
#include "core/status.h"
#include "grid/minmax.h"

/** Over the blocks of a vvi_minmax: distance[block] = 0 where something may be visible, else the Chebyshev distance in
 * blocks to the nearest such block, at most 255. Guard bytes follow the last one. */
typedef struct vvi_skip {
    int32_t n[3];
    int shift; /**< a block has 2^shift voxel cells a side */
    uint8_t *distance;
    uint64_t n_occupied;
} vvi_skip;

/** Whether any stored value in [lo, hi] is visible. */
typedef bool vvi_visible_fn(const void *user, float lo, float hi);

/** Same result for any thread count. Free with vvi_skip_free(). */
vv_status vvi_skip_build(vvi_skip **out, const vvi_minmax *minmax, vvi_visible_fn *visible, const void *user,
                         vv_job *job);
void vvi_skip_free(void *skip); /* NULL is fine */

#endif
