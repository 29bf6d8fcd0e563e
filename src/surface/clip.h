/** @file
 * Meshes cut by planes.
 */
#ifndef VVI_SURFACE_CLIP_H
#define VVI_SURFACE_CLIP_H
#include "core/status.h"
#include <volvis/mesh.h>

/**
 * What of a mesh lies on the kept side of all planes, n . p >= offset with unit n, in the mesh's space.
 *
 * Triangles that a plane goes through are cut there; a vertex on a plane is kept. With `cap` what was closed is closed
 * again: part by part, with flat faces between the loops where the surface was cut (surface/fill.h). They share the
 * vertices of the rim, so that no normal would suit both sides: such a mesh has none. Where the mesh was open there
 * are no loops, and a warning says so.
 *
 * Result   parts stay, empty ones too; vertices that no triangle has any more go, if a plane cuts anything off
 * Errors   VV_E_MEMORY, VV_E_LIMIT, VV_E_CANCELLED
 * Owns     *out is the caller's: another reference to the mesh where nothing is cut
 * Threads  on this one
 */
vv_status vvi_mesh_clip(vv_mesh **out, const vv_mesh *mesh, const vv_plane *planes, size_t n_planes, bool cap,
                        vv_job *job);

/**
 * The flat face where a plane cuts what a mesh encloses, in the mesh's space, without normals, values and colours.
 *
 * Part by part, with those triangles joined that share vertices; where chains are left that do not close, vertices at
 * one place are taken for one, and then all parts for one, and of the three what leaves the fewest such chains is
 * the result. A mesh that is inside out has the same face as one that is not.
 *
 * Result   *out NULL: there is no face; *n_gaps: chains that do not close, where the mesh is open or does not face one
 *          way: what lies between them stays hollow
 * Errors   VV_E_MEMORY, VV_E_LIMIT, VV_E_CANCELLED; *out is NULL then
 * Owns     *out is new and the caller's
 * Threads  on this one
 */
vv_status vvi_mesh_section(vv_mesh **out, size_t *n_gaps, const vv_mesh *mesh, const vv_plane *plane, vv_job *job);
#endif
