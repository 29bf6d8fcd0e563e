/** @file
 * Measuring mesh files.
 */
#ifndef CLI_MEASURE_MESHES_H
#define CLI_MEASURE_MESHES_H
#include "command.h"
#include <volvis/vec.h>

/** Whether a file is a mesh, by its first bytes and its name. */
bool cli_is_mesh(const cli_command *command, const char *path);
/** What: "summary", "area", "volume" or "box"; csv: a table. */
vv_status cli_measure_mesh(cli_command *command, const char *what, const char *path, bool csv);
/** From a place, in the mesh's space, to the nearest of its surface. */
vv_status cli_measure_mesh_point(cli_command *command, const char *path, vv_vec3 point, bool csv);
/** From one surface to another. */
vv_status cli_measure_mesh_distance(cli_command *command, const char *path_a, const char *path_b, bool csv);
#endif
