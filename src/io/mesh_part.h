/** @file
 * Parts of meshes by what people call them: FILE:PART.
 */
#ifndef VVI_IO_MESH_PART_H
#define VVI_IO_MESH_PART_H
#include "core/status.h"
#include <volvis/mesh.h>

/** *mesh becomes the part of this name or, where none is called so, of this number from 0; NULL: it stays as it is.
 * path: what the file is called in errors: VV_E_NOT_FOUND (with the nearest name, or all), VV_E_ARGUMENT (several of
 * the name), VV_E_MEMORY; *mesh is what it was then. */
vv_status vvi_mesh_pick_part(vv_mesh **mesh, const char *part, const char *path, vv_job *job);
#endif
