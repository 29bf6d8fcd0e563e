/** @file
 * Small vector arithmetic.
 */
#ifndef VVI_CORE_VEC_H
#define VVI_CORE_VEC_H
#include <math.h>
#include <volvis/vec.h>

static inline vv_vec3 vvi_vec(double x, double y, double z)
{
    return (vv_vec3){x, y, z};
}
static inline vv_vec3 vvi_add(vv_vec3 a, vv_vec3 b)
{
    return vvi_vec(a.x + b.x, a.y + b.y, a.z + b.z);
}
static inline vv_vec3 vvi_sub(vv_vec3 a, vv_vec3 b)
{
    return vvi_vec(a.x - b.x, a.y - b.y, a.z - b.z);
}
static inline vv_vec3 vvi_scaled(vv_vec3 a, double s)
{
    return vvi_vec(a.x * s, a.y * s, a.z * s);
}
static inline double vvi_dot(vv_vec3 a, vv_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline vv_vec3 vvi_cross(vv_vec3 a, vv_vec3 b)
{
    return vvi_vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline bool vvi_finite(vv_vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}
static inline double vvi_length(vv_vec3 v)
{
    return hypot(hypot(v.x, v.y), v.z);
}
/** Length 1; false, and *v untouched, when it has no length or is not finite. */
static inline bool vvi_unit(vv_vec3 *v)
{
    const double length = vvi_length(*v);
    if (!(length > 0) || !isfinite(length))
        return false;
    *v = vvi_scaled(*v, 1 / length);
    return true;
}
/** A plane of q where its places are p = map q; its normal has length 1. */
vv_plane vvi_plane_mapped(const vv_plane *plane, const vv_affine *map);

#endif
