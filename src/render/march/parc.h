/** @file
 * PARC, polygon assisted ray casting (Avila, Sobierajski and Kaufman 1992): the outer faces of the boxes in which
 * something is visible, projected into a buffer of near and far depths. A ray is followed between its two depths only.
 */
#ifndef VVI_RENDER_PARC_H
#define VVI_RENDER_PARC_H
#include "grid/boxes.h"
#include <volvis/sys/scene.h>

/** Near and far depths of the cells of an image, a cell being 2^VVI_PARC_SHIFT pixels a side: rays of neighbouring
 * pixels are followed together anyway, and a small buffer is soon filled. */
enum { VVI_PARC_SHIFT = 2 };
static inline int32_t vvi_parc_cells(int32_t pixels)
{
    return (pixels + (1 << VVI_PARC_SHIFT) - 1) >> VVI_PARC_SHIFT;
}

/** Bounds that hold for every ray through a cell, wherever in their pixels the rays are. Depth is along the lens's
 * forward axis, in world length from its eye, less `origin`. Beside a box near <= far; where there is none near is
 * +infinity and far -infinity. */
typedef struct vvi_parc {
    int32_t width, height; /**< cells */
    vv_vec3 forward;       /**< axis of the lens */
    double origin;
    float *near, *far; /**< width * height; one allocation */
} vvi_parc;

/** What is seen of the boxes, and from where. */
typedef struct vvi_parc_view {
    const vv_lens *lens;
    int32_t width, height; /**< pixels of the picture */
    int32_t top, rows;     /**< of them those that the buffer is for; top: whole cells */
    vv_affine index_to_world;
    double lo[3], hi[3]; /**< the volume's domain in index space: border boxes reach to it */
    double before;       /**< index space: box i begins at i * 2^shift - before (nearest samples: 0.5) */
} vvi_parc_view;

/** Errors: VV_E_MEMORY, VV_E_CANCELLED. Owns: vvi_parc_finish(); zeroed on failure. Same bytes for any thread count. */
vv_status vvi_parc_init(vvi_parc *out, const vvi_boxes *boxes, const vvi_parc_view *view, vv_job *job);
void vvi_parc_finish(vvi_parc *parc); /* zeroed is fine */

#endif
