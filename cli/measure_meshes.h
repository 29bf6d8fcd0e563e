/** @file
 * Measuring mesh files.
 */
#ifndef CLI_MEASURE_MESHES_H
#define CLI_MEASURE_MESHES_H
#include "measure.h"

/** What: "summary", "area", "volume" or "box". */
vv_status cli_measure_mesh(cli_result *result, const char *what, const char *path);
#endif
