/** @file
 * Vertices of files that say the corners of each triangle anew: those that lie at the same place, bit for bit, become
 * one. Numbered in the order in which they first come.
 */
#ifndef VVI_IO_MESH_JOIN_H
#define VVI_IO_MESH_JOIN_H
#include "io/meshes/mesh_builder.h"

typedef struct vvi_mesh_join {
    vvi_mesh_builder *b;
    uint32_t *slot; /* vertex + 1 by place, 0 where free */
    size_t mask;    /* slots - 1, a power of two */
} vvi_mesh_join;

/** n_triangles: how many are expected. */
vv_status vvi_mesh_join_begin(vvi_mesh_join *out, vvi_mesh_builder *b, size_t n_triangles);
/** n more triangles, nine numbers each. */
vv_status vvi_mesh_join_add(vvi_mesh_join *join, const float *corners, size_t n);
void vvi_mesh_join_end(vvi_mesh_join *join); /* a zeroed one is fine */
#endif
