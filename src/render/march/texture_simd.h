/** @file
 * The texture of a volume on the colours of a packet. For kernels only.
 *
 * Textures are worked out lane by lane (texture.c): patterns are mostly branches and texels are far apart, and only
 * volumes that have one pay for it.
 */
#ifndef VVI_RENDER_TEXTURE_SIMD_H
#define VVI_RENDER_TEXTURE_SIMD_H
#include "render/common/texture.h"
#include "render/march/kernels.h"
#include "render/march/lattice_simd.h"

/** Colours of lanes m, at p in index space, `steps` steps beyond world distance t0 of each lane. */
static __attribute__((noinline)) void texture_colors(vf rgb[3], const vvi_march_volume *f, const vf3 *p,
                                                     const double t0[VV_WIDTH], vf steps, vm m)
{
    float color[3][VVI_TEXTURE_LANES] = {{0}}, at[3][VVI_TEXTURE_LANES], distance[VVI_TEXTURE_LANES];
    vf_store(at[0], p->x);
    vf_store(at[1], p->y);
    vf_store(at[2], p->z);
    vf_store(distance, steps);
    for (int l = 0; l < VV_WIDTH; l++)
        distance[l] = (float)(t0[l] + (double)distance[l] * f->step);
    for (int c = 0; c < 3; c++)
        vf_store(color[c], rgb[c]);
    vvi_texture_apply(color, f->texture, at, distance, vm_bits(m));
    for (int c = 0; c < 3; c++)
        rgb[c] = vf_load(color[c]);
}

#endif
