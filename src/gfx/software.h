/** @file
 * The software back end's parts.
 */
#ifndef VVI_GFX_SOFTWARE_H
#define VVI_GFX_SOFTWARE_H
#include "gfx/bin.h"

/** A mesh or a shape, in the order of the calls. */
typedef struct vvi_gfx_command {
    vvi_gfx_draw *draw; /**< NULL: a shape */
    vvi_gfx_flat *shape;
} vvi_gfx_command;

/** All that is to be drawn. */
typedef struct vvi_gfx_software_picture {
    vvi_gfx_list commands;
    uint32_t n_ids;   /**< of triangles, so far */
    bool translucent; /**< some meshes are */
    vvi_gfx_tiling tiling;
    vvi_gfx_bin *bins; /**< at the end: of all meshes, in order */
    size_t n_bins;
    const vvi_gfx_kernels *kernels;
} vvi_gfx_software_picture;

/** What one thread needs for a tile. */
typedef struct vvi_gfx_tile_room {
    vvi_gfx_samples samples;
    vvi_gfx_pattern pattern;     /**< of its samples */
    vvi_gfx_fragments fragments; /**< of one row of blocks; then `triangle` is counted by mesh */
    vvi_gfx_fragments some;      /**< those of one mesh, where several are seen */
    float *numbers;              /**< where both lie */
    uint32_t *id;                /**< of each fragment's triangle */
    int32_t *pixel;              /**< column + VVI_GFX_TILE * row in the tile */
    float *weight;
    uint32_t *mask; /**< samples, where they are translucent */
    size_t n_most;  /**< fragments that there is room for */
    float depth[VVI_GFX_TILE * VVI_GFX_TILE];
} vvi_gfx_tile_room;

vv_status vvi_gfx_tile_room_new(vvi_gfx_tile_room **out, const vvi_gfx *gfx);
void vvi_gfx_tile_room_free(vvi_gfx_tile_room *room); /* NULL is fine */
/** Draws everything into one tile of the image. */
vv_status vvi_gfx_tile_draw(vvi_gfx *gfx, vvi_gfx_tile_room *room, size_t tile);

/** Draws all translucent triangles of a tile, whose opaque ones are in room->samples. */
vv_status vvi_gfx_translucent(vvi_gfx *gfx, vvi_gfx_tile_room *room, const vvi_gfx_area *area, size_t tile);
/** Works out the light of room->fragments, whose triangles are in room->id. */
void vvi_gfx_light(vvi_gfx_tile_room *room, const vvi_gfx_software_picture *picture);
/** Which mesh a triangle is of. */
const vvi_gfx_draw *vvi_gfx_draw_of(const vvi_gfx_software_picture *picture, uint32_t id);
/** What a window leaves of an area, in whole pixels. */
vvi_gfx_area vvi_gfx_clipped(const vvi_gfx_area *area, const double window[4]);

vv_status vvi_gfx_software_pick(vvi_gfx_picked *out, vvi_gfx *gfx, double x, double y, double beyond);
#endif
