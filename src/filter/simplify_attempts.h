/** @file
 * Fewer triangles in attempts, until a distance is kept.
 */
#ifndef VVI_FILTER_SIMPLIFY_ATTEMPTS_H
#define VVI_FILTER_SIMPLIFY_ATTEMPTS_H
#include "surface/simplify.h"
#include <volvis/measure_distance.h>

typedef struct vvi_attempts {
    const vv_mesh *mesh;        /**< what is simplified */
    const vv_mesh_tree *before; /**< of what it must stay near: its own, or that of a surface that is within `error` of
                                   it, and it of that */
    double error;               /**< the largest distance */
    vvi_simplify_options options; /**< of each attempt; still, keep and corners are not looked at */
    const uint8_t *still;         /**< of each vertex: not 0: what is around it stays from the start; NULL: of none */
    vv_mesh *out;                 /**< set, with all below */
    vv_mesh_tree *after;          /**< of it; NULL: nothing is left */
    uint32_t *corners;            /**< three for each of its triangles, by the mesh's numbers */
    vvi_simplify_result result;
    bool kept;      /**< neither surface is farther from the other than the error */
    double largest; /**< distance that the last look saw; 0 where all are less than half of the error */
} vvi_attempts;

/** The places that moved too far are left as they were, and what comes to lie too far away beside them, until nothing
 * does; with a wider ring around them where that does not help, and where it costs next to nothing. Owns:
 * vvi_attempts_finish(); nothing on errors: those of vvi_mesh_simplify(). */
vv_status vvi_simplify_attempts(vvi_attempts *attempts, vv_job *job);
void vvi_attempts_finish(vvi_attempts *attempts);
#endif
