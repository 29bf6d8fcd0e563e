/* The general kernel of the ray caster and that of cubic surfaces, for one instruction set. Their table is that of
 * raycast_kernels.c. */
#include "render/march/blend.h"
#include "render/march/surface_cubic.h"

extern vvi_blend_kernel VV_KERNEL_TABLE(vvi_blend_tile);
extern vvi_ray_kernel VV_KERNEL_TABLE(vvi_cubic_tile);

void VV_KERNEL_TABLE(vvi_blend_tile)(const vvi_blend_setup *f, const vv_tile *tile, vv_render_counts *counts)
{
    for (int32_t y = tile->y0; y < tile->y1; y += PACKET_H)
        for (int32_t x = tile->x0; x < tile->x1; x += PACKET_W)
            blend_packet(f, x, y, packet_lanes(tile, x, y), counts);
}

void VV_KERNEL_TABLE(vvi_cubic_tile)(const vvi_ray_setup *f, const vv_tile *tile, vv_render_counts *counts)
{
    for (int32_t y = tile->y0; y < tile->y1; y += PACKET_H)
        for (int32_t x = tile->x0; x < tile->x1; x += PACKET_W) {
            packet r;
            const vm live = packet_lanes(tile, x, y);
            packet_begin(&r, f, x, y, live);
            counts->rays += (uint64_t)vm_count(live);
            surface_cubic_packet(f, &r, live, counts);
        }
}
