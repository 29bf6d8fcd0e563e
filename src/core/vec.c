#include "core/vec.h"

static vv_vec3 cross(vv_vec3 a, vv_vec3 b)
{
    return (vv_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static double dot(vv_vec3 a, vv_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static double length(vv_vec3 a)
{
    return sqrt(dot(a, a));
}

static vv_vec3 scale(vv_vec3 a, double s)
{
    return (vv_vec3){a.x * s, a.y * s, a.z * s};
}

vv_affine vv_affine_identity(void)
{
    return (vv_affine){.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
}

vv_vec3 vv_affine_vector(vv_affine a, vv_vec3 v)
{
    return (vv_vec3){a.axis[0].x * v.x + a.axis[1].x * v.y + a.axis[2].x * v.z,
                     a.axis[0].y * v.x + a.axis[1].y * v.y + a.axis[2].y * v.z,
                     a.axis[0].z * v.x + a.axis[1].z * v.y + a.axis[2].z * v.z};
}

vv_vec3 vv_affine_point(vv_affine a, vv_vec3 p)
{
    const vv_vec3 v = vv_affine_vector(a, p);
    return (vv_vec3){a.origin.x + v.x, a.origin.y + v.y, a.origin.z + v.z};
}

vv_affine vv_affine_compose(vv_affine a, vv_affine b)
{
    return (vv_affine){
        .axis = {vv_affine_vector(a, b.axis[0]), vv_affine_vector(a, b.axis[1]), vv_affine_vector(a, b.axis[2])},
        .origin = vv_affine_point(a, b.origin),
    };
}

double vv_affine_determinant(vv_affine a)
{
    return dot(a.axis[0], cross(a.axis[1], a.axis[2]));
}

/* The axes are scaled to length 1 first, so that neither nanometres nor light years overflow or pass for singular. */
bool vv_affine_invert(vv_affine *out, vv_affine a)
{
    double s[3];
    vv_vec3 u[3];
    for (int i = 0; i < 3; i++) {
        s[i] = length(a.axis[i]);
        u[i] = scale(a.axis[i], 1 / s[i]);
    }
    const double det = dot(u[0], cross(u[1], u[2]));
    if (!(fabs(det) > 1e-14) || !isfinite(s[0] + s[1] + s[2]))
        return false;
    const vv_vec3 r[3] = {
        scale(cross(u[1], u[2]), 1 / det / s[0]),
        scale(cross(u[2], u[0]), 1 / det / s[1]),
        scale(cross(u[0], u[1]), 1 / det / s[2]),
    };
    vv_affine inverse = {.axis = {{r[0].x, r[1].x, r[2].x}, {r[0].y, r[1].y, r[2].y}, {r[0].z, r[1].z, r[2].z}}};
    inverse.origin = scale(vv_affine_vector(inverse, a.origin), -1);
    *out = inverse;
    return true;
}

/* n . M q >= d, made unit again. */
vv_plane vvi_plane_mapped(const vv_plane *p, const vv_affine *map)
{
    const vv_vec3 n = p->normal, turned = {dot(n, map->axis[0]), dot(n, map->axis[1]), dot(n, map->axis[2])};
    const double size = length(turned);
    return (vv_plane){scale(turned, 1 / size), (p->offset - dot(n, map->origin)) / size};
}
