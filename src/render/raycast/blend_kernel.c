/* The general kernel of the ray caster, for one instruction set. Its table is that of raycast_kernels.c. */
#include "render/raycast/blend.h"

extern vvi_blend_kernel VV_KERNEL_TABLE(vvi_blend_tile);

void VV_KERNEL_TABLE(vvi_blend_tile)(const vvi_blend_frame *f, const vv_tile *tile, vv_render_counts *counts)
{
    for (int32_t y = tile->y0; y < tile->y1; y += PACKET_H)
        for (int32_t x = tile->x0; x < tile->x1; x += PACKET_W)
            blend_packet(f, x, y, packet_lanes(tile, x, y), counts);
}
