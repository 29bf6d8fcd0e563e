/** @file
 * Distances of points, segments and triangles (Ericson 2005, chapter 5).
 */
#ifndef VVI_MEASURE_TRIANGLE_H
#define VVI_MEASURE_TRIANGLE_H
#include "core/vec.h"

typedef struct vvi_triangle {
    vv_vec3 a, b, c;
} vvi_triangle;

/** a + t (b - a) */
static inline vv_vec3 vvi_between(vv_vec3 a, vv_vec3 b, double t)
{
    return vvi_add(a, vvi_scaled(vvi_sub(b, a), t));
}

/** Weights of the corners of the place of t that is nearest to p. Slivers and points are fine. */
vv_vec3 vvi_nearest_weights(vv_vec3 p, const vvi_triangle *t);
vv_vec3 vvi_triangle_at(const vvi_triangle *t, vv_vec3 weights);
/** Squared distance from p. */
double vvi_triangle_square(vv_vec3 p, const vvi_triangle *t);
/** Squared distance of two triangles, and the nearest places; 0 where they touch or cross. */
double vvi_triangles_square(vv_vec3 *on_s, vv_vec3 *on_t, const vvi_triangle *s, const vvi_triangle *t);
#endif
