/** @file
 * Surfaces of several values, and what another field has at the vertices of a surface.
 */
#ifndef VVI_SURFACE_VALUES_H
#define VVI_SURFACE_VALUES_H
#include "surface/marching.h"

/**
 * vvi_marching_cubes() for each of n values (that of the options is not looked at), as a mesh with a part for each,
 * named after it: "300". The samples are read once.
 *
 * Errors   those of vvi_marching_cubes(); VV_E_ARGUMENT for no values
 * Owns     *out is the caller's
 */
vv_status vvi_marching_values(vv_mesh **out, const vv_field *field, const double *values, size_t n,
                              const vvi_marching_options *options, vv_job *job);

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
