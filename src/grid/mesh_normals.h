/** @file
 * Normals at vertices, of the triangles around them.
 */
#ifndef VVI_GRID_MESH_NORMALS_H
#define VVI_GRID_MESH_NORMALS_H
#include "core/status.h"
#include <volvis/mesh.h>

/** Unit normals, three floats a vertex; 0 where there is none. Cross products of the sides of each triangle at a
 * corner, over their squared lengths: exact for vertices on a sphere (Max 1999). On this thread. Errors: VV_E_MEMORY,
 * VV_E_CANCELLED. */
vv_status vvi_normals_of(float *out, const float *positions, size_t n_vertices, const uint32_t *triangles,
                         size_t n_triangles, vv_job *job);

/** Normals of a mesh that are 0 become the mean of those of the triangles around them, weighted by area; where these
 * have no area, of the normals at their other corners, and without any, z. Others stay. The same bytes for any number
 * of threads; where none is 0, a look at each. `normals`: the mesh's own, to write; NULL: nothing to do. Errors:
 * VV_E_MEMORY, VV_E_CANCELLED. */
vv_status vvi_normals_fill(float *normals, const vv_mesh *mesh, vv_job *job);
#endif
