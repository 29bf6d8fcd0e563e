/** @file
 * The texture of a volume on the colours of a packet. For kernels only.
 */
#ifndef VVI_RENDER_TEXTURE_SIMD_H
#define VVI_RENDER_TEXTURE_SIMD_H
#include "render/march/kernels.h"
#include "render/march/packet.h"

extern vvi_texture_kernel VV_KERNEL_TABLE(vvi_texture_apply); /* texture_kernel.c */

/** World distances at which the rays of a packet enter the volume. */
VV_INLINE vf entry_distance(const packet *r)
{
    float near[VV_WIDTH];
    for (int l = 0; l < VV_WIDTH; l++)
        near[l] = (float)r->t0[l];
    return vf_load(near);
}

/** Colours of lanes m, at p in index space, `steps` steps beyond world distance `entry`. */
VV_INLINE void texture_colors(vf rgb[3], const vvi_march_volume *f, const vf3 *p, vf entry, vf steps, vm m)
{
    float color[3][VVI_TEXTURE_LANES], at[3][VVI_TEXTURE_LANES], distance[VVI_TEXTURE_LANES];
    vf_store(at[0], p->x);
    vf_store(at[1], p->y);
    vf_store(at[2], p->z);
    vf_store(distance, vf_fma(steps, vf_set1((float)f->step), entry));
    for (int c = 0; c < 3; c++)
        vf_store(color[c], rgb[c]);
    VV_KERNEL_TABLE(vvi_texture_apply)(color, f->texture, at, distance, vm_bits(m));
    for (int c = 0; c < 3; c++)
        rgb[c] = vf_load(color[c]);
}

#endif
