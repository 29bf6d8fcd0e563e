/** @file
 * Vertices at the same place, as one.
 */
#ifndef VVI_SURFACE_VERTEX_PLACES_H
#define VVI_SURFACE_VERTEX_PLACES_H
#include "core/status.h"
#include <volvis/runtime.h>

/** For each vertex the first one at exactly the same place (itself, where there is no earlier). *out: n numbers, for
 * vvi_free(); NULL on errors: VV_E_MEMORY, VV_E_CANCELLED. On this thread. */
vv_status vvi_number_places(uint32_t **out, const float *positions, size_t n_vertices, vv_job *job);
#endif
