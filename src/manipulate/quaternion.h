/** @file
 * Unit quaternions (w, x, y, z) as turns, in double precision: v -> q v q*. Angles in radians, right-handed.
 */
#ifndef VVI_MANIPULATE_QUATERNION_H
#define VVI_MANIPULATE_QUATERNION_H
#include "core/vec.h"

typedef struct vvi_quaternion {
    double w, x, y, z;
} vvi_quaternion;

static inline vvi_quaternion vvi_no_turn(void)
{
    return (vvi_quaternion){1, 0, 0, 0};
}

/** a after b. */
static inline vvi_quaternion vvi_turn_after(vvi_quaternion a, vvi_quaternion b)
{
    return (vvi_quaternion){
        a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

static inline vvi_quaternion vvi_turn_back(vvi_quaternion q)
{
    return (vvi_quaternion){q.w, -q.x, -q.y, -q.z};
}

static inline double vvi_turn_dot(vvi_quaternion a, vvi_quaternion b)
{
    return a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
}

/** Rounding makes lengths drift from 1. No turn where there is no length. */
static inline vvi_quaternion vvi_turn_unit(vvi_quaternion q)
{
    const double length = sqrt(vvi_turn_dot(q, q));
    if (!(length > 0) || !isfinite(length))
        return vvi_no_turn();
    return (vvi_quaternion){q.w / length, q.x / length, q.y / length, q.z / length};
}

static inline vv_vec3 vvi_turned(vvi_quaternion q, vv_vec3 v)
{
    const vv_vec3 u = vvi_vec(q.x, q.y, q.z), t = vvi_scaled(vvi_cross(u, v), 2);
    return vvi_add(vvi_add(v, vvi_scaled(t, q.w)), vvi_cross(u, t));
}

/** By the angle |v| about v. */
static inline vvi_quaternion vvi_turn_by(vv_vec3 v)
{
    const double angle = vvi_length(v);
    const double s = angle > 1e-8 ? sin(angle / 2) / angle : 0.5 - angle * angle / 48;
    return (vvi_quaternion){cos(angle / 2), s * v.x, s * v.y, s * v.z};
}

static inline vvi_quaternion vvi_turn_about(vv_vec3 unit_axis, double angle)
{
    return vvi_turn_by(vvi_scaled(unit_axis, angle));
}

/** The inverse of vvi_turn_by(): axis times angle, at most pi long. */
vv_vec3 vvi_turn_log(vvi_quaternion q);
/** The shortest turn of one unit vector to another; of opposite ones about any axis across. */
vvi_quaternion vvi_turn_between(vv_vec3 from, vv_vec3 to);
/** The turn that takes x, y and z to three unit vectors, which are square to each other and right-handed. */
vvi_quaternion vvi_turn_of_axes(vv_vec3 x, vv_vec3 y, vv_vec3 z);
/** At t in [0, 1] from a to b at a steady rate, the short way (Shoemake 1985). */
vvi_quaternion vvi_slerp(vvi_quaternion a, vvi_quaternion b, double t);
#endif
