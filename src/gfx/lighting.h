/** @file
 * A mesh as the kernels see it.
 */
#ifndef VVI_GFX_LIGHTING_H
#define VVI_GFX_LIGHTING_H
#include "gfx/kernels.h"

/** What kernels need of a draw, in floats; kept by gfx. */
typedef struct vvi_gfx_prepared {
    vvi_gfx_projection projection;
    vvi_gfx_lighting lighting;
    float decode[256];
} vvi_gfx_prepared;

vv_status vvi_gfx_prepare(vvi_gfx_prepared **out, vvi_gfx *gfx, const vvi_gfx_draw *draw);
/** Places nearer to the eye's plane are cut off: forward. */
double vvi_gfx_nearest(const vvi_gfx_draw *draw);
#endif
