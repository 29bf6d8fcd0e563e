/** @file
 * Vertices at one place that have nothing to do with one another.
 */
#ifndef VVI_SURFACE_PLACE_COPIES_H
#define VVI_SURFACE_PLACE_COPIES_H
#include "core/status.h"
#include <volvis/runtime.h>

/** Moves vertices that are at the place of an earlier one by steps of a float along x, until each has a place of its
 * own: for methods that take vertices at one place for one. Vertices at open edges do not move, so that seams stay
 * seams. On this thread, the same bytes each time. Errors: VV_E_MEMORY. */
vv_status vvi_tell_apart(float *positions, size_t n_vertices, const uint32_t *indices, size_t n_indices, vv_job *job);
#endif
