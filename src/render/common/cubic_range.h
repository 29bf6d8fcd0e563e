/** @file
 * Between which values a cubic B-spline stays in each block of voxel cells.
 */
#ifndef VVI_RENDER_CUBIC_RANGE_H
#define VVI_RENDER_CUBIC_RANGE_H
#include "grid/minmax.h"

/**
 * Min-max cells of the spline whose coefficients a lattice has (cubic_spline.h), under a key of the job's cache: a
 * block has all values that the spline takes inside it and on its faces, and little more. Coefficients swing about hard
 * edges and in noise where the spline hardly does: by their range all blocks of a noisy head would have something to
 * show.
 *
 * Shapes   lattice: VVI_SAMPLE_F32, VVI_FETCH_LINEAR; vvi_cached_value() is a vvi_minmax
 * Errors   VV_E_MEMORY, VV_E_CANCELLED
 * Threads  same bytes for any thread count
 */
vv_status vvi_cubic_range_get(vvi_cached **out, const vvi_cache_key *key, const vvi_lattice *lattice, int shift,
                              vv_job *job);

#endif
