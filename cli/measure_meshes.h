/** @file
 * Measuring mesh files.
 */
#ifndef CLI_MEASURE_MESHES_H
#define CLI_MEASURE_MESHES_H
#include "measure.h"
#include <volvis/vec.h>

/** What: "summary", "area", "volume" or "box". */
vv_status cli_measure_mesh(cli_result *result, const char *what, const char *path);
/** From a place, in the mesh's space, to the nearest of its surface. */
vv_status cli_measure_mesh_point(cli_result *result, const char *path, vv_vec3 point);
/** From one surface to another. */
vv_status cli_measure_mesh_distance(cli_result *result, const char *path_a, const char *path_b);
#endif
