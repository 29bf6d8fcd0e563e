/** @file
 * How far a surface is from another at most: a search that divides what may still be farther than what was found.
 */
#ifndef VVI_MEASURE_FARTHEST_PLACE_H
#define VVI_MEASURE_FARTHEST_PLACE_H
#include "measure/bvh.h"

/** A place of a, from its origin, and what is nearest to it of b. */
typedef struct vvi_spot {
    vv_vec3 at;
    double square; /**< of the distance */
    size_t near;   /**< in the order of b's tree */
} vvi_spot;

typedef struct vvi_farthest {
    const vv_mesh_tree *a, *b;
    vv_vec3 shift;           /**< from the origin of a to that of b */
    const double *square;    /**< of each vertex of a: squared distance to b, */
    const uint32_t *nearest; /**< and the triangle there */
    const double *bound;     /**< of each triangle of a: squared, no distance in it is larger */
    double largest;          /**< in, out: squared, the largest that was found */
    vv_vec3 worst;           /**< where */
    double most;             /**< out: squared, none is larger */
} vvi_farthest;

/** No squared distance between three places is larger than this: that to one triangle is a convex function, so that it
 * is largest at a corner; of the triangles nearest to the corners the best one counts. */
double vvi_spots_bound(const vv_mesh_tree *b, vv_vec3 shift, const vvi_spot p[3]);
/** Of pieces with the largest bound first, until `most` is within a thousandth of the largest distance, or as many
 * places have been looked at as both surfaces have triangles and 2^18 more. Same result for any thread count. Errors:
 * VV_E_MEMORY, VV_E_CANCELLED. */
vv_status vvi_farthest_search(vvi_farthest *search, vv_job *job);
#endif
