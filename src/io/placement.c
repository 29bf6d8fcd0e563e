#include "io/placement.h"
#include "core/units.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

double vvi_length(vv_vec3 v)
{
    return sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

static vv_vec3 cross(vv_vec3 a, vv_vec3 b)
{
    return (vv_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static vv_vec3 scaled_to(vv_vec3 v, double length)
{
    const double now = vvi_length(v);
    const double f = now > 0 ? length / now : 0;
    return (vv_vec3){v.x * f, v.y * f, v.z * f};
}

void vvi_complete_axes(vv_affine *p, int n)
{
    double step = INFINITY;
    for (int a = 0; a < n; a++)
        step = fmin(step, vvi_length(p->axis[a]));
    if (n < 2) {
        /* any right angle will do; from the world axis that lies least along the line */
        const vv_vec3 x = p->axis[0];
        const vv_vec3 other = fabs(x.y) <= fabs(x.x) ? (vv_vec3){0, 1, 0} : (vv_vec3){-1, 0, 0};
        const vv_vec3 z = cross(x, other);
        p->axis[1] = scaled_to(cross(z, x), step);
    }
    if (n < 3)
        p->axis[2] = scaled_to(cross(p->axis[0], p->axis[1]), step);
}

double vvi_placement_distance(const vv_affine *a, const vv_affine *b, const int64_t dims[3])
{
    double most = 0;
    for (int corner = 0; corner < 8; corner++) {
        const vv_vec3 index = {corner & 1 ? (double)(dims[0] - 1) : 0, corner & 2 ? (double)(dims[1] - 1) : 0,
                               corner & 4 ? (double)(dims[2] - 1) : 0};
        const vv_vec3 p = vv_affine_point(*a, index), q = vv_affine_point(*b, index);
        most = fmax(most, vvi_length((vv_vec3){p.x - q.x, p.y - q.y, p.z - q.z}));
    }
    return most;
}

static void to_numbers(double out[12], const vv_affine *a)
{
    const vv_vec3 v[4] = {a->axis[0], a->axis[1], a->axis[2], a->origin};
    for (int i = 0; i < 4; i++) {
        out[3 * i] = v[i].x;
        out[3 * i + 1] = v[i].y;
        out[3 * i + 2] = v[i].z;
    }
}

static vv_vec3 times(vv_vec3 v, double factor)
{
    return (vv_vec3){v.x * factor, v.y * factor, v.z * factor};
}

void vvi_grid_scale(vv_grid *grid, double factor, const char *unit)
{
    vv_affine *p = &grid->index_to_world;
    for (int a = 0; a < 3; a++)
        p->axis[a] = times(p->axis[a], factor);
    p->origin = times(p->origin, factor);
    snprintf(grid->unit, sizeof grid->unit, "%s", unit);
}

bool vvi_grid_in_unit(vv_grid *out, const vv_grid *grid, const char *const *units)
{
    const double metres = vvi_length_unit_metres(grid->unit);
    *out = *grid;
    for (; *units; units++)
        if (strcmp(*units, grid->unit) == 0)
            return true;
    if (!(metres > 0))
        return false;
    const char *unit = metres < 1e-6 ? "um" : "mm";
    vvi_grid_scale(out, metres / vvi_length_unit_metres(unit), unit);
    return true;
}

bool vvi_is_identity(const vv_affine *a)
{
    double n[12];
    to_numbers(n, a);
    for (int i = 0; i < 12; i++)
        if (n[i] != (i % 4 == 0 && i < 9 ? 1.0 : 0.0))
            return false;
    return true;
}

bool vvi_affine_finite(const vv_affine *a)
{
    double n[12];
    to_numbers(n, a);
    for (int i = 0; i < 12; i++)
        if (!isfinite(n[i]))
            return false;
    return true;
}
