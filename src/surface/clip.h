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
#endif
