/** @file
 * Surface tracking: the connected piece of an isosurface through a place, found by going from cell to cell.
 */
#ifndef VVI_SURFACE_TRACKING_H
#define VVI_SURFACE_TRACKING_H
#include "surface/marching.h"

typedef struct vvi_tracking_options {
    vvi_marching_options surface;
    vv_vec3 seed;  /**< a place in the world */
    int64_t reach; /**< cells that the surface may be away from the seed; 0: as far as the volume goes */
} vvi_tracking_options;

/**
 * The piece of surface nearest to a place, as part of what vvi_marching_cubes() gives.
 *
 * The cells around the seed are looked through in shells until one is crossed; of the pieces of surface in it and in
 * the next shell, the one with the nearest crossing is followed. Two sheets that meet one cell stay apart.
 *
 * Vertices, normals and triangles are those of the whole surface, bit for bit, in another order, which depends on the
 * piece alone: not on the seed or the number of threads.
 *
 * Memory   a few tens of bytes for each cell of the piece, and the mesh
 * Errors   those of vvi_marching_cubes(), and VV_E_NOT_FOUND (no surface within reach)
 * Owns     *out is the caller's
 */
vv_status vvi_track_surface(vv_mesh **out, const vv_field *field, const vvi_tracking_options *options, vv_job *job);
#endif
