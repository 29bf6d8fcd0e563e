/** @file
 * The part of a volume that is measured: a convex region, as half-spaces in index space. In a row of samples or cells
 * it is one interval.
 */
#ifndef VVI_MEASURE_REGION_H
#define VVI_MEASURE_REGION_H
#include "core/status.h"
#include <volvis/field.h>

/** Six of the box, and as many of the caller. */
#define VVI_REGION_PLANES 38

/** normal . p >= offset, p in index coordinates; normals have length 1 there. */
typedef struct vvi_region {
    int n;
    vv_plane plane[VVI_REGION_PLANES];
} vvi_region;

/** Samples or cells [lo, end) of a row. */
typedef struct vvi_interval {
    int64_t lo, end;
} vvi_interval;

/** margin: how far beyond its samples the box reaches, 0 or half a step. Errors: VV_E_ARGUMENT. */
vv_status vvi_region_init(vvi_region *out, const vv_grid *grid, const vv_box *box, double margin,
                          const vv_plane *planes, size_t n_planes);
/** Points (i + at.x, j + at.y, k + at.z) of row (j, k) inside, i from lo to end - 1. */
vvi_interval vvi_region_points(const vvi_region *region, vv_vec3 at, int64_t j, int64_t k, int64_t lo, int64_t end);
/** Cells from (i, j, k) to the next sample along each axis whose corners are all inside; `touched`: whose corners are
 * not all outside one plane. */
vvi_interval vvi_region_cells(const vvi_region *region, bool touched, int64_t j, int64_t k, int64_t lo, int64_t end);
/** The same region where every step-th sample counts. */
vvi_region vvi_region_coarse(const vvi_region *region, int64_t step);
#endif
