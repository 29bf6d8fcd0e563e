/* The general kernel of the ray caster and that of cubic surfaces, for one instruction set. Their table is that of
 * raycast_kernels.c. */
#include "render/march/blend.h"
#include "render/march/surface_cubic.h"

extern vvi_blend_kernel VV_KERNEL_TABLE(vvi_blend_rays);
extern vvi_ray_kernel VV_KERNEL_TABLE(vvi_cubic_rays);

void VV_KERNEL_TABLE(vvi_blend_rays)(vvi_sink *out, const vvi_blend_setup *f, const vvi_rays *rays,
                                     vv_render_counts *counts)
{
    for (size_t at = 0; at < rays->n; at += VV_WIDTH)
        blend_packet(out, f, rays, at, counts);
}

void VV_KERNEL_TABLE(vvi_cubic_rays)(vvi_sink *out, const vvi_march_volume *f, const vvi_rays *rays,
                                     vv_render_counts *counts)
{
    for (size_t at = 0; at < rays->n; at += VV_WIDTH) {
        packet r;
        packet_begin(&r, f, rays, at);
        surface_cubic_packet(out, f, &r, at, counts);
    }
}
