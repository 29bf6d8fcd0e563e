/** @file
 * Meshes on the picture: vertices projected, triangles cut and sorted into tiles, in parallel and without locks.
 */
#ifndef VVI_GFX_BIN_H
#define VVI_GFX_BIN_H
#include "gfx/lighting.h"

/** Triangles of a bin. */
enum { VVI_GFX_BIN = 8192, VVI_GFX_CUT = (int)0x80000000 };

/** A run of triangles of one mesh, by the tiles that they may cover. An entry is the number of a triangle of the run,
 * or VVI_GFX_CUT and the number of a piece of a triangle that was cut. */
typedef struct vvi_gfx_bin {
    const vvi_gfx_draw *draw;
    uint32_t first, n;
    uint32_t *begin; /**< of each tile's entries; one more at the end */
    uint32_t *entry; /**< in the order of the triangles */
    vvi_gfx_triangle *pieces;
    size_t n_pieces, room;
} vvi_gfx_bin;

/** The tiles of a picture. */
typedef struct vvi_gfx_tiling {
    int32_t width, height; /**< pixels */
    int32_t across, down;  /**< tiles */
} vvi_gfx_tiling;

/** Fills a bin whose draw, first and n are given; samples: a pixel. Free with vvi_gfx_bin_free(), also on failure. */
vv_status vvi_gfx_bin_fill(vvi_gfx_bin *bin, const vvi_gfx_tiling *tiling, int samples, const vvi_gfx_kernels *kernels,
                           vv_job *job);
void vvi_gfx_bin_free(vvi_gfx_bin *bin);
/** The triangle of an entry. */
void vvi_gfx_bin_triangle(vvi_gfx_triangle *out, const vvi_gfx_bin *bin, uint32_t entry);
#endif
