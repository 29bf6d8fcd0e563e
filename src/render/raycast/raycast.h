/** @file
 * Ray casting: the parameters, and what one frame prepares. Rows: vvi_renderer_raycast.
 */
#ifndef VVI_RENDER_RAYCAST_H
#define VVI_RENDER_RAYCAST_H
#include "render/raycast/raycast_kernels.h"
#include <volvis/model.h>

typedef enum vvi_raycast_mode { VVI_RAYCAST_COMPOSITE, VVI_RAYCAST_MAXIMUM, VVI_RAYCAST_ISOSURFACE } vvi_raycast_mode;

/** views.<view>.render.raycast */
typedef struct vvi_raycast_params {
    vv_object base;
    int mode;
    double iso;  /**< value */
    double step; /**< world length */
    double opaque;
    bool skipping;
} vvi_raycast_params;

extern const vv_class vvi_raycast_class;

/** The frame that kernels get, with what it holds on to. Tests make one to compare kernels with the reference. */
typedef struct vvi_raycast_state {
    vvi_ray_frame frame;
    vvi_ray_kernel *kernel; /**< NULL: nothing is visible */
    vvi_lattice_hold hold;
    struct vvi_cached *minmax, *skip;
    float *alpha, *color;
} vvi_raycast_state;

vv_status vvi_raycast_prepare(void **state_out, const vv_scene *scene, vv_job *job);
void vvi_raycast_finish(void *state); /* NULL is fine */

/** Brute force in double precision, one pixel, no skipping and no early end beyond the frame's own `opaque`: the
 * definition of the right answer. rgba premultiplied; *depth_out INFINITY where nothing is. */
void vvi_raycast_ref(double rgba_out[4], double *depth_out, const vv_scene *scene, const vvi_raycast_state *state,
                     int32_t x, int32_t y);
#endif
