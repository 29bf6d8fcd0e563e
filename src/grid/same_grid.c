#include "grid/same_grid.h"
#include "core/units.h"
#include "core/vec.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define RESAMPLE "resample it first: 'volvis resample IT onto=VOLUME -o OUT'"
#define ANYWAY "; if they belong together sample by sample, drop the placement of one, as .npy files do"

static void print_dims(char out[96], const vv_grid *g)
{
    snprintf(out, 96, "%" PRId64 " x %" PRId64 " x %" PRId64, g->dims[0], g->dims[1], g->dims[2]);
}

static vv_status check_dims(const vv_grid *grid, const vv_grid *other, const char *name)
{
    char expected[96], found[96];
    if (memcmp(grid->dims, other->dims, sizeof grid->dims) == 0)
        return VV_OK;
    print_dims(expected, grid);
    print_dims(found, other);
    return vv_fail(VV_E_ARGUMENT, "the %s: expected %s samples, as many as the volume has, found %s; " RESAMPLE, name,
                   expected, found);
}

vv_grid vvi_grid_in_unit_of(const vv_grid *grid, const vv_grid *other)
{
    const double to = vvi_length_unit_metres(grid->unit), from = vvi_length_unit_metres(other->unit);
    vv_grid out = *other;
    if (!(to > 0) || !(from > 0) || strcmp(grid->unit, other->unit) == 0)
        return out;
    vv_affine *m = &out.index_to_world;
    for (int a = 0; a < 3; a++)
        m->axis[a] = vvi_scaled(m->axis[a], from / to);
    m->origin = vvi_scaled(m->origin, from / to);
    memcpy(out.unit, grid->unit, sizeof out.unit);
    return out;
}

static double steps(const vv_grid *grid, int axis)
{
    return fmax((double)(grid->dims[axis] - 1), 1);
}

static vv_status check_spacing(const vv_grid *grid, const vv_grid *other, const char *name)
{
    double s[3], t[3];
    bool same = true;
    for (int a = 0; a < 3; a++) {
        s[a] = vv_grid_spacing(grid, a);
        t[a] = vv_grid_spacing(other, a);
        same &= fabs(s[a] - t[a]) * steps(grid, a) <= VVI_GRID_SLACK * s[a];
    }
    return same ? VV_OK
                : vv_fail(VV_E_ARGUMENT,
                          "the %s: expected a spacing of %.9g x %.9g x %.9g %s, like the volume's, found %.9g x %.9g x "
                          "%.9g %s; " RESAMPLE ANYWAY,
                          name, s[0], s[1], s[2], grid->unit, t[0], t[1], t[2], other->unit);
}

static double farthest_corner(const vv_grid *a, const vv_grid *b)
{
    double most = 0;
    for (int corner = 0; corner < 8; corner++) {
        const vv_vec3 index = {corner & 1 ? steps(a, 0) : 0, corner & 2 ? steps(a, 1) : 0,
                               corner & 4 ? steps(a, 2) : 0};
        most = fmax(most, vvi_length(vvi_sub(vv_affine_point(a->index_to_world, index),
                                             vv_affine_point(b->index_to_world, index))));
    }
    return most;
}

/* The largest angle between axes that go together. */
static double turned_by(const vv_grid *a, const vv_grid *b)
{
    double most = 0;
    for (int i = 0; i < 3; i++) {
        const vv_vec3 u = a->index_to_world.axis[i], v = b->index_to_world.axis[i];
        most = fmax(most, atan2(vvi_length(vvi_cross(u, v)), vvi_dot(u, v)));
    }
    return most * 57.29577951308232;
}

/* Spacings are equal, places are not. */
static vv_status fail_place(const vv_grid *grid, const vv_grid *other, const char *name)
{
    char along[16], found[16];
    const double degrees = turned_by(grid, other);
    const vv_vec3 p = grid->index_to_world.origin, q = other->index_to_world.origin;
    vv_grid_orientation(along, grid);
    vv_grid_orientation(found, other);
    if (strcmp(along, found) != 0)
        return vv_fail(VV_E_ARGUMENT,
                       "the %s: expected the axis order %s, like the volume's, found %s; reorient one, as in 'volvis "
                       "reorient IN --order RAS -o OUT'" ANYWAY,
                       name, along, found);
    if (degrees > 1e-3)
        return vv_fail(
            VV_E_ARGUMENT,
            "the %s: expected axes parallel to the volume's, found them rotated by %.3g degrees; " RESAMPLE ANYWAY,
            name, degrees);
    return vv_fail(VV_E_ARGUMENT,
                   "the %s: expected the first sample at %.9g, %.9g, %.9g %s, like the volume's, found it at %.9g, "
                   "%.9g, %.9g; " RESAMPLE ANYWAY,
                   name, p.x, p.y, p.z, grid->unit, q.x, q.y, q.z);
}

static bool says_nothing(const vv_grid *grid)
{
    return strcmp(grid->unit, "voxels") == 0;
}

vv_status vvi_grid_alike(const vv_grid *grid, const vv_grid *other, const char *name)
{
    const vv_grid found = vvi_grid_in_unit_of(grid, other);
    vv_status st = check_dims(grid, other, name);
    if (st != VV_OK || says_nothing(grid) || says_nothing(other))
        return st;
    if ((st = check_spacing(grid, &found, name)) != VV_OK || grid->space != found.space)
        return st;
    return farthest_corner(grid, &found) <= VVI_GRID_SLACK * vv_grid_voxel(grid) ? VV_OK
                                                                                 : fail_place(grid, &found, name);
}

/* Which sample of the other a sample is, exactly and rounded; how far apart the two are at most along an axis. */
static double off_by(const vvi_grid_fit *fit, vv_vec3 index, const vv_affine *to_other)
{
    const vv_vec3 exact = vv_affine_point(*to_other, index);
    double most = 0;
    for (int a = 0; a < 3; a++) {
        const double whole = (double)fit->first[a] + fit->sign[a] * (&index.x)[a];
        most = fmax(most, fabs((&exact.x)[fit->axis[a]] - whole));
    }
    return most;
}

/* The axis of the other that axis a follows most. */
static void choose_axis(vvi_grid_fit *fit, int a, const vv_affine *to_other)
{
    const double *along = &to_other->axis[a].x;
    for (int b = 1; b < 3; b++)
        if (fabs(along[b]) > fabs(along[fit->axis[a]]))
            fit->axis[a] = b;
    fit->sign[a] = along[fit->axis[a]] < 0 ? -1 : 1;
}

bool vvi_grid_fits(vvi_grid_fit *out, const vv_grid *grid, const vv_grid *other)
{
    const vv_grid found = vvi_grid_in_unit_of(grid, other);
    vv_affine inverse;
    *out = (vvi_grid_fit){0};
    if (says_nothing(grid) || says_nothing(other) || grid->space != found.space ||
        !vv_affine_invert(&inverse, found.index_to_world))
        return false;
    const vv_affine to_other = vv_affine_compose(inverse, grid->index_to_world);
    for (int a = 0; a < 3; a++) {
        choose_axis(out, a, &to_other);
        const double first = (&to_other.origin.x)[out->axis[a]];
        if (!(fabs(first) < 1e9))
            return false;
        out->first[a] = (int64_t)llround(first);
    }
    double most = out->axis[0] == out->axis[1] || out->axis[1] == out->axis[2] || out->axis[0] == out->axis[2] ? 1 : 0;
    for (int corner = 0; corner < 8; corner++) {
        const vv_vec3 index = {corner & 1 ? steps(grid, 0) : 0, corner & 2 ? steps(grid, 1) : 0,
                               corner & 4 ? steps(grid, 2) : 0};
        most = fmax(most, off_by(out, index, &to_other));
    }
    return most <= VVI_GRID_SLACK;
}
