/** @file
 * Vectors, boxes and affine maps, in double precision. Right-handed space; angles in radians.
 */
#ifndef VOLVIS_VEC_H
#define VOLVIS_VEC_H
#include <volvis/base.h>
VV_BEGIN_DECLS

typedef struct vv_vec3 {
    double x, y, z;
} vv_vec3;

/** Linear colour, not premultiplied; components normally in [0, 1]. */
typedef struct vv_color {
    double r, g, b, a;
} vv_color;

/** p = origin + axis[0] * u + axis[1] * v + axis[2] * w. For a grid u, v, w are index coordinates, p is world. */
typedef struct vv_affine {
    vv_vec3 axis[3];
    vv_vec3 origin;
} vv_affine;

/** Half-space n . p >= offset, in the space its owner says. */
typedef struct vv_plane {
    vv_vec3 normal;
    double offset;
} vv_plane;

/** Axis-aligned box of reals. Empty when any hi < lo. */
typedef struct vv_bounds {
    vv_vec3 lo, hi;
} vv_bounds;

/** Box of samples: lo inclusive, lo + n exclusive, x fastest. */
typedef struct vv_box {
    int64_t lo[3];
    int64_t n[3];
} vv_box;

VV_API vv_affine vv_affine_identity(void);
/** a after b: the map p -> a(b(p)). */
VV_API vv_affine vv_affine_compose(vv_affine a, vv_affine b);
/** False, and *out untouched, when the map is singular. */
VV_API bool vv_affine_invert(vv_affine *out, vv_affine a);
VV_API vv_vec3 vv_affine_point(vv_affine a, vv_vec3 p);
/** Directions: the origin is left out. */
VV_API vv_vec3 vv_affine_vector(vv_affine a, vv_vec3 v);
VV_API double vv_affine_determinant(vv_affine a);

VV_END_DECLS
#endif
