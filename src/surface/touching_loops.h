/** @file
 * Loops of a cut that touch, as loops that do not.
 */
#ifndef VVI_SURFACE_TOUCHING_LOOPS_H
#define VVI_SURFACE_TOUCHING_LOOPS_H
#include "surface/fill.h"

typedef struct vvi_untangled {
    vvi_loops loops;     /**< what is in them is the untangled's */
    uint32_t *triangles; /**< without area, three points each */
    size_t n_triangles;
} vvi_untangled;

/**
 * Points nearer to each other than coordinates are known, a few roundings of a float, get one place. Where several
 * sides meet at a place, loops go from each side to the one across the solid, which lies to the left of both: loops
 * neither cross nor run back over themselves there. Sides that run there and back between two places go.
 *
 * Triangles between the points of a place keep what was closed closed: they and a filling of the new loops have each
 * side of the old loops once.
 *
 * Errors   VV_E_MEMORY; *out is zeroed then
 * Owns     *out, for vvi_untangled_finish()
 * Threads  on this one
 */
vv_status vvi_untangle(vvi_untangled *out, const vvi_loops *loops, vv_job *job);
void vvi_untangled_finish(vvi_untangled *untangled); /* zeroed is fine */
#endif
