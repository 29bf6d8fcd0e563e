/** @file
 * Surfaces, of mesh files or of volumes where they have a value, and distances of places, of other surfaces, and along
 * them.
 */
#ifndef CLI_MEASURE_SURFACES_H
#define CLI_MEASURE_SURFACES_H
#include "measure.h"

/** From the one --point to the nearest of a surface. */
vv_status cli_measure_point_to_surface(cli_result *result, const char *file);
/** From one surface to another: least, mean, root mean square and Hausdorff. */
vv_status cli_measure_two_surfaces(cli_result *result, const char *file_a, const char *file_b);
/** Between two --points, along a surface. */
vv_status cli_measure_geodesic(cli_result *result, const char *file);
#endif
