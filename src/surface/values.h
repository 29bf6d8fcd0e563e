/** @file
 * What another field has at the vertices of a surface.
 */
#ifndef VVI_SURFACE_VALUES_H
#define VVI_SURFACE_VALUES_H
#include "core/status.h"
#include <volvis/mesh.h>

/**
 * The value of a field, on whatever grid in the same world, at each vertex of a mesh that is not shared yet.
 *
 * Linear between samples; labels: the nearest sample's. Up to half a voxel beyond the outermost samples their value is
 * taken; farther out a vertex's value is NaN. The name is the field's, or "value".
 *
 * Errors   VV_E_ARGUMENT (no such component, another unit of length, a flat grid), VV_E_MEMORY, VV_E_READ,
 * VV_E_CANCELLED
 */
vv_status vvi_mesh_sample(vv_mesh *mesh, const vv_field *field, int component, vv_job *job);
#endif
