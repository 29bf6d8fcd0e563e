/** @file
 * The software back end's parts.
 */
#ifndef VVI_GFX_SOFTWARE_H
#define VVI_GFX_SOFTWARE_H
#include "gfx/bin.h"

/** A mesh or a shape, in the order of the calls. */
typedef struct vvi_gfx_command {
    vvi_gfx_draw *draw; /**< NULL: a shape */
    vvi_gfx_shape *shape;
} vvi_gfx_command;

/** All that is to be drawn. */
typedef struct vvi_gfx_software_picture {
    vvi_gfx_list commands;
    uint32_t n_ids; /**< of triangles, so far */
    vvi_gfx_tiling tiling;
    vvi_gfx_bin *bins; /**< at the end: of all meshes, in order */
    size_t n_bins;
    const vvi_gfx_kernels *kernels;
} vvi_gfx_software_picture;

/** What one thread needs for a tile. */
typedef struct vvi_gfx_tile_room {
    vvi_gfx_samples samples;
    vvi_gfx_fragments fragments; /**< of one row of blocks; then `triangle` is counted by mesh */
    vvi_gfx_fragments some;      /**< those of one mesh, where several are seen */
    float *numbers;              /**< where both lie */
    uint32_t *id;                /**< of each fragment's triangle */
    int32_t *pixel;              /**< column + VVI_GFX_TILE * row in the tile */
    float *weight;
    float depth[VVI_GFX_TILE * VVI_GFX_TILE];
} vvi_gfx_tile_room;

vv_status vvi_gfx_tile_room_new(vvi_gfx_tile_room **out, const vvi_gfx *gfx);
void vvi_gfx_tile_room_free(vvi_gfx_tile_room *room); /* NULL is fine */
/** Draws everything into one tile of the image. */
vv_status vvi_gfx_tile_draw(vvi_gfx *gfx, vvi_gfx_tile_room *room, size_t tile);

vv_status vvi_gfx_software_pick(vvi_gfx_picked *out, vvi_gfx *gfx, double x, double y);
#endif
