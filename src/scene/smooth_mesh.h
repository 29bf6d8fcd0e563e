/** @file
 * Normals of meshes that come without: smooth ones, but of each side where a mesh has an edge.
 */
#ifndef VVI_SCENE_SMOOTH_MESH_H
#define VVI_SCENE_SMOOTH_MESH_H
#include "core/status.h"
#include <volvis/mesh.h>

/** A copy with normals of its vertices, those of triangles around (vvi_normals_of()), where vertices at one place count
 * as one. Triangles there that no edge joins whose normals are less than 59 degrees apart have normals of their own: so
 * have all around a tip, where one leans more than 45 degrees from their mean. For them vertices are added behind those
 * that there are, which keep their numbers; triangles and parts keep theirs. On this thread. Errors: VV_E_MEMORY,
 * VV_E_LIMIT, VV_E_CANCELLED. */
vv_status vvi_mesh_smooth_shaded(vv_mesh **out, const vv_mesh *mesh, vv_job *job);
#endif
