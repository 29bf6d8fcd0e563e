/** @file
 * Rays of the eye, through the lens. For kernels only: rays through empty space would otherwise cost more to make than
 * to follow.
 */
#ifndef VVI_RENDER_MARCH_EYE_H
#define VVI_RENDER_MARCH_EYE_H
#include "core/simd.h"
#include "render/march/parc.h"
#include "render/march/rays.h"
#include <math.h>

/* Pixels of a block of 4 x 4 in Morton order, so that each 4 of them are 2 x 2 pixels, and each 8 are 4 x 2. */
static const int8_t block_x[VVI_RAY_GROUP] = {0, 1, 0, 1, 2, 3, 2, 3, 0, 1, 0, 1, 2, 3, 2, 3};
static const int8_t block_y[VVI_RAY_GROUP] = {0, 0, 1, 1, 0, 0, 1, 1, 2, 2, 3, 3, 2, 2, 3, 3};

/* The cell of PARC's buffer that a ray passes through; -1 where it passes beside the image. */
VV_INLINE int32_t eye_cell(const vvi_eye *eye, double x, double y)
{
    const int32_t across = vvi_parc_cells(eye->width);
    if (!(x >= 0 && y >= eye->top && x < eye->width && y < eye->top + eye->rows))
        return -1;
    return (((int32_t)y - eye->top) >> VVI_PARC_SHIFT) * across + ((int32_t)x >> VVI_PARC_SHIFT);
}

VV_INLINE void eye_block(vvi_rays *out, const vvi_eye *eye, const vv_tile *tile, int32_t x0, int32_t y0)
{
    const vv_lens *lens = &eye->lens;
    const double spread = lens->parallel ? 0 : 1, shift = lens->parallel ? 1 : 0;
    const size_t at = out->n;
    double x[VVI_RAY_GROUP], y[VVI_RAY_GROUP];
    for (int i = 0; i < VVI_RAY_GROUP; i++) {
        x[i] = (x0 + block_x[i]) * eye->stride + eye->x;
        y[i] = eye->top + (y0 + block_y[i]) * eye->stride + eye->y;
    }
    for (int i = 0; i < VVI_RAY_GROUP; i++) {
        const double u = (x[i] / eye->width * 2 - 1) * lens->half_width;
        const double v = (1 - y[i] / eye->height * 2) * lens->half_height;
        const double px = lens->right.x * u + lens->up.x * v;
        const double py = lens->right.y * u + lens->up.y * v;
        const double pz = lens->right.z * u + lens->up.z * v;
        const double dx = lens->forward.x + px * spread, dy = lens->forward.y + py * spread;
        const double dz = lens->forward.z + pz * spread;
        const double s = 1 / sqrt(dx * dx + dy * dy + dz * dz);
        out->direction[0][at + i] = dx * s;
        out->direction[1][at + i] = dy * s;
        out->direction[2][at + i] = dz * s;
        out->origin[0][at + i] = lens->eye.x + px * shift;
        out->origin[1][at + i] = lens->eye.y + py * shift;
        out->origin[2][at + i] = lens->eye.z + pz * shift;
    }
    for (int i = 0; i < VVI_RAY_GROUP; i++) {
        const int32_t column = x0 + block_x[i], row = y0 + block_y[i];
        out->near[at + i] = 0;
        out->far[at + i] = INFINITY;
        out->phase[at + i] = 0.5f;
        out->cell[at + i] = eye_cell(eye, x[i], y[i]);
        out->pixel[at + i] = column < tile->x1 && row < tile->y1 ? row * eye->row + column : -1;
    }
    if (eye->jitter) /* by the pixel of the scene, whatever part of it the image is */
        for (int i = 0; i < VVI_RAY_GROUP; i++)
            out->phase[at + i] = vvi_ray_phase((int32_t)floor(x[i]), (int32_t)floor(y[i]), eye->seed);
    out->n += VVI_RAY_GROUP;
}

VV_INLINE void eye_rays(vvi_rays *out, const vvi_eye *eye, const vv_tile *tile)
{
    out->n = 0;
    for (int32_t y = tile->y0; y < tile->y1; y += 4)
        for (int32_t x = tile->x0; x < tile->x1; x += 4)
            eye_block(out, eye, tile, x, y);
}

#endif
