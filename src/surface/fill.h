/** @file
 * Triangles of flat regions between loops.
 */
#ifndef VVI_SURFACE_FILL_H
#define VVI_SURFACE_FILL_H
#include "core/status.h"
#include <volvis/runtime.h>

typedef struct vvi_loops {
    const double *at;       /**< x y of each point */
    const uint32_t *points; /**< those of all loops, one loop after the other */
    const size_t *begin;    /**< n + 1: where each loop begins in `points`, and the end */
    size_t n;
} vvi_loops;

/**
 * What lies to the left of all loops: counter-clockwise ones are outlines, clockwise ones holes in the smallest outline
 * around them. No point is added and every side of a loop has one triangle, whatever the loops look like: so a surface
 * whose gaps are filled by it is closed. Where loops touch, some triangles have no area (surface/touching_loops.h);
 * where they cross, some are turned.
 *
 * Source   holes are joined to their outline by a bridge (Eberly), then ears are cut off (Meisters 1975), with those
 *          corners that could lie in them in a grid
 * Errors   VV_E_MEMORY, VV_E_CANCELLED; *out is NULL then
 * Owns     *out: 3 * *n_out points, vvi_free()
 * Threads  on this one
 */
vv_status vvi_fill_loops(uint32_t **out, size_t *n_out, const vvi_loops *loops, vv_job *job);
#endif
