/** @file
 * Meshes that the import program reads: docs/decisions/0009-import-program.md.
 */
#ifndef VVI_IMPORT_MESH_H
#define VVI_IMPORT_MESH_H
#include "io/notes.h"

/** Where the arrays of a mesh lie in memory that is shared: bytes from its beginning; `end` is their sum. Pixels: of
 * all textures, one after the other. */
typedef struct vvi_mesh_room {
    uint64_t positions, normals, values, colors, triangles, parts, coordinates, coordinate_of, pixels, end;
} vvi_mesh_room;

/** `with`: which of the arrays that may lack there are (VVI_MESH_*). */
vvi_mesh_room vvi_mesh_room_of(const vv_mesh_info *mesh, unsigned with);

/** As vvi_mesh_read_noted() with all parts, by the import program; what it says and gives is checked as if it were the
 * file. */
vv_status vvi_import_mesh(vv_mesh **out, const vv_mesh_format **format_out, vv_notes *notes, const char *path,
                          const vv_mesh_read_options *options, vv_job *job);
#endif
