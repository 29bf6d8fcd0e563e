#include "manipulate/quaternion.h"

vv_vec3 vvi_turn_log(vvi_quaternion q)
{
    const double sign = q.w < 0 ? -1 : 1; /* q and -q are one turn */
    const vv_vec3 u = vvi_vec(sign * q.x, sign * q.y, sign * q.z);
    const double s = vvi_length(u), angle = 2 * atan2(s, sign * q.w);
    return vvi_scaled(u, s > 1e-12 ? angle / s : 2);
}

static vv_vec3 any_across(vv_vec3 v)
{
    const vv_vec3 other = fabs(v.x) < 0.6 ? vvi_vec(1, 0, 0) : vvi_vec(0, 1, 0);
    vv_vec3 across = vvi_cross(v, other);
    vvi_unit(&across);
    return across;
}

vvi_quaternion vvi_turn_between(vv_vec3 from, vv_vec3 to)
{
    const double cosine = vvi_dot(from, to);
    if (cosine < -1 + 1e-14) {
        const vv_vec3 axis = any_across(from);
        return (vvi_quaternion){0, axis.x, axis.y, axis.z};
    }
    const vv_vec3 u = vvi_cross(from, to);
    return vvi_turn_unit((vvi_quaternion){1 + cosine, u.x, u.y, u.z});
}

/* Shepperd 1978: divides by the largest of four components. */
vvi_quaternion vvi_turn_of_axes(vv_vec3 x, vv_vec3 y, vv_vec3 z)
{
    const double trace = x.x + y.y + z.z;
    vvi_quaternion q;
    if (trace >= x.x && trace >= y.y && trace >= z.z)
        q = (vvi_quaternion){1 + trace, y.z - z.y, z.x - x.z, x.y - y.x};
    else if (x.x >= y.y && x.x >= z.z)
        q = (vvi_quaternion){y.z - z.y, 1 + x.x - y.y - z.z, x.y + y.x, z.x + x.z};
    else if (y.y >= z.z)
        q = (vvi_quaternion){z.x - x.z, x.y + y.x, 1 + y.y - x.x - z.z, y.z + z.y};
    else
        q = (vvi_quaternion){x.y - y.x, z.x + x.z, y.z + z.y, 1 + z.z - x.x - y.y};
    return vvi_turn_unit(q);
}

vvi_quaternion vvi_slerp(vvi_quaternion a, vvi_quaternion b, double t)
{
    const double sign = vvi_turn_dot(a, b) < 0 ? -1 : 1;
    const vvi_quaternion to = {sign * b.w, sign * b.x, sign * b.y, sign * b.z};
    const vv_vec3 way = vvi_turn_log(vvi_turn_after(to, vvi_turn_back(a)));
    return vvi_turn_unit(vvi_turn_after(vvi_turn_by(vvi_scaled(way, t)), a));
}
