/** @file
 * What the general kernel of the ray caster gets: several volumes, each classified in its own way, blended along one
 * ray.
 */
#ifndef VVI_RENDER_RAYCAST_BLEND_KERNEL_H
#define VVI_RENDER_RAYCAST_BLEND_KERNEL_H
#include "render/raycast/raycast_kernels.h"

enum { VVI_BLEND_VOLUMES = 8 };

/** One volume of a blend. */
typedef struct vvi_blend_volume {
    vvi_ray_frame ray; /**< place, samples, blocks, table, light; `step` is the same in all volumes of a frame */
    bool nearest;
} vvi_blend_volume;

typedef struct vvi_blend_frame {
    vvi_blend_volume volume[VVI_BLEND_VOLUMES];
    size_t n_volumes; /**< at least 1; all have the same view, step and `opaque` */
    double step;
    float opaque; /**< a ray ends when less transmittance than this is left */
    /** Surfaces that the volumes are seen with, drawn before: opaque where the depth is finite. Pixel (x, y) of the
     * image is at (y - behind_y) * behind_row + x - behind_x. NULL: none. */
    const float *behind_rgba, *behind_depth;
    int32_t behind_x, behind_y, behind_row;
    int32_t row;         /**< pixels from one row of the image to the next */
    float *rgba, *depth; /**< out: rows of `row` pixels; depth may be NULL */
} vvi_blend_frame;

#endif
