/** @file
 * Whether a mesh is closed, and where it is not.
 */
#ifndef VVI_MEASURE_CLOSED_H
#define VVI_MEASURE_CLOSED_H
#include "core/status.h"
#include <volvis/mesh.h>

/** The edges that do not have as many triangles on one side as on the other, vertices at the same place counting as
 * one: how many, and a vertex pair of the first. `triangles`: n of the mesh's. Errors: VV_E_MEMORY, VV_E_CANCELLED. */
vv_status vvi_open_edges(size_t *n_out, uint32_t first_out[2], const vv_mesh_info *mesh, const uint32_t *triangles,
                         size_t n, vv_job *job);
#endif
