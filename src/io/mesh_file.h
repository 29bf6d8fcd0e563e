/** @file
 * Mesh files: what the program asks beyond <volvis/mesh_file.h>.
 */
#ifndef VVI_IO_MESH_FILE_H
#define VVI_IO_MESH_FILE_H
#include "io/notes.h"

/** vv_mesh_read() that tells the format and keeps metadata and warnings instead of logging them. */
vv_status vvi_mesh_read_noted(vv_mesh **out, const vv_mesh_format **format_out, vv_notes *notes, const char *path,
                              const vv_mesh_read_options *options, vv_job *job);
/** How sure a row is that a file with these first bytes and this name is its own, the best of all rows: 0 no, 1 maybe,
 * 2 certainly. *out is that row; NULL for 0. */
int vvi_mesh_format_of_head(const vv_mesh_format **out, const uint8_t *head, size_t n, const char *path,
                            const vv_registry *registry);
/** Whether a row of volumes is sure that a file with these first bytes is its own. */
bool vvi_format_is_certain(const uint8_t *head, size_t n, const char *path, const vv_registry *registry);
/** Whether a file with these first bytes and this name is a mesh: they say so, or they leave it in doubt and the suffix
 * is a mesh format's. What the rows of volumes are sure of is none. */
bool vvi_mesh_is_head(const uint8_t *head, size_t n, const char *path, const vv_registry *registry);
/** The same of a regular file; nothing else is one. */
bool vvi_mesh_is_file(const char *path, const vv_job *job);
/** By the suffix of a path, ".gz" and its like passed; NULL when no row has it. */
const vv_mesh_format *vvi_mesh_format_of_path(const char *path, const vv_registry *registry);
/** By name, or by a suffix without its dot; NULL when there is none. */
const vv_mesh_format *vvi_mesh_format_find(const char *name, const vv_registry *registry);
/** The same with its error: VV_E_ARGUMENT with the nearest real name. */
vv_status vvi_mesh_format_named(const vv_mesh_format **out, const char *name, const vv_registry *registry);
#endif
