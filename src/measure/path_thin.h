/** @file
 * Paths with fewer points.
 */
#ifndef VVI_MEASURE_PATH_THIN_H
#define VVI_MEASURE_PATH_THIN_H
#include <volvis/field.h>

/**
 * Leaves out points of a path, in place: no point that goes is farther than `far` from the line that takes its place.
 * The first and the last one stay.
 *
 * Errors   VV_E_MEMORY; the path is as it was
 * Source   Douglas & Peucker 1973, The Canadian Cartographer 10(2)
 */
vv_status vvi_path_thin(size_t *n_out, vv_vec3 *points, size_t n, double far);
#endif
