/** @file
 * Placement shared by the formats.
 */
#ifndef VVI_IO_PLACEMENT_H
#define VVI_IO_PLACEMENT_H
#include <volvis/field.h>

/** Steps for the axes that a flat or linear file does not have: at right angles to the others, right-handed, as long as
 * the shortest step that there is. Columns [n, 3) are set. */
void vvi_complete_axes(vv_affine *placement, int n);
double vvi_length(vv_vec3 v);
/** The largest distance between where two placements put the corners of a grid. */
double vvi_placement_distance(const vv_affine *a, const vv_affine *b, const int64_t dims[3]);
/** The same grid with lengths in a unit of the list (which NULL ends): its own if that is there, else um for what is
 * shorter than that and mm for the rest, which the list has. False, and only a copy, of units that are no lengths. */
bool vvi_grid_in_unit(vv_grid *out, const vv_grid *grid, const char *const *units);
/** Lengths in another unit: every number times `factor`. */
void vvi_grid_scale(vv_grid *grid, double factor, const char *unit);
/** Whether the placement is the identity: samples at their index. */
bool vvi_is_identity(const vv_affine *a);
bool vvi_affine_finite(const vv_affine *a);
#endif
