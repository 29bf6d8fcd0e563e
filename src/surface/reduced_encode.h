/** @file
 * From samples to the records of a reduced surface.
 */
#ifndef VVI_SURFACE_REDUCED_ENCODE_H
#define VVI_SURFACE_REDUCED_ENCODE_H
#include "surface/reduced.h"
#include "surface/subsample.h"

/** Fills bricks, records and counts of *r, whose n[] it sets too. *over_out: there would be more than the budgets
 * (0: none) allow, and nothing was made. Same bytes for any thread count. */
vv_status vvi_reduced_encode(vvi_reduced *r, bool *over_out, const vvi_lattice_samples *samples, const vvi_march *m,
                             size_t max_triangles, size_t max_bytes);
#endif
