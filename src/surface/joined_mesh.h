/** @file
 * Several meshes as one with a part for each.
 */
#ifndef VVI_SURFACE_JOINED_MESH_H
#define VVI_SURFACE_JOINED_MESH_H
#include "core/status.h"
#include <volvis/mesh.h>

/** Part i is mesh i with the name and colour of parts[i] (whose triangles are not looked at). Space and unit are those
 * of the first mesh, places count from its origin; normals, values and colours stay where all meshes with vertices have
 * them. At least one mesh. Errors: VV_E_LIMIT, VV_E_MEMORY. Owns: *out is the caller's, the meshes stay so. */
vv_status vvi_mesh_join(vv_mesh **out, vv_mesh *const *meshes, const vv_mesh_part *parts, size_t n, vv_job *job);
#endif
