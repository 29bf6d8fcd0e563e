/* Boxes, ellipses, polygons and ellipsoids in frames of their own, sample by sample. */
#include "measure/region_samples.h"

#include "core/vec.h"
#include "measure/sums.h"

#include <math.h>
#include <string.h>

#define HAIR 1e-9 /* of a step */
#define PI 3.14159265358979323846

static bool is_flat(vv_region_kind kind)
{
    return kind == VV_REGION_ELLIPSE || kind == VV_REGION_POLYGON || kind == VV_REGION_BOX;
}

/* Geometry -------------------------------------------------------------------------------------------------------- */

static const double *corner(const vv_region_shape *r, size_t i)
{
    return r->outline + 2 * (i % r->n_outline);
}

/* Twice the area to the left of the way from a over b to c. */
static double turn(const double *a, const double *b, const double *c)
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static bool cross(const double *a, const double *b, const double *c, const double *d)
{
    return turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
}

static bool crosses_itself(const vv_region_shape *r)
{
    for (size_t i = 0; i + 2 < r->n_outline; i++)
        for (size_t k = i + 2; k < r->n_outline; k++)
            if (cross(corner(r, i), corner(r, i + 1), corner(r, k), corner(r, k + 1)))
                return true;
    return false;
}

/* The shoelace formula, from the first corner so that outlines far away lose no digits. */
static double polygon_area(const vv_region_shape *r)
{
    double twice = 0;
    for (size_t i = 1; i + 1 < r->n_outline; i++)
        twice += turn(corner(r, 0), corner(r, i), corner(r, i + 1));
    return crosses_itself(r) ? NAN : fabs(twice) / 2;
}

/* In its own coordinates. */
static double plane_area(const vv_region_shape *r)
{
    if (r->kind == VV_REGION_POLYGON)
        return polygon_area(r);
    return (r->kind == VV_REGION_BOX ? 4 : PI) * r->half[0] * r->half[1];
}

double vv_region_shape_area(const vv_region_shape *r)
{
    return is_flat(r->kind) ? plane_area(r) * vvi_length(vvi_cross(r->frame.axis[0], r->frame.axis[1])) : NAN;
}

double vv_region_shape_volume(const vv_region_shape *r)
{
    const double depth = is_flat(r->kind) ? 2 * r->half[2] : 4 * r->half[2] / 3;
    return plane_area(r) * depth * fabs(vv_affine_determinant(r->frame));
}

/* On a grid ------------------------------------------------------------------------------------------------------- */

static void find_ends(vvi_region_samples *s)
{
    for (int a = 0; a < 2; a++) {
        s->lo[a] = -s->of.half[a];
        s->hi[a] = s->of.half[a];
        for (size_t i = 0; s->of.kind == VV_REGION_POLYGON && i < s->of.n_outline; i++) {
            const double at = s->of.outline[2 * i + (size_t)a];
            s->lo[a] = i ? fmin(s->lo[a], at) : at;
            s->hi[a] = i ? fmax(s->hi[a], at) : at;
        }
    }
}

/* The samples between the least and the largest index of its corners. */
static void find_box(vvi_region_samples *s, const vv_grid *grid, const vv_affine *to_index)
{
    vv_bounds all = vvi_bounds_none();
    for (int k = 0; k < 8; k++)
        vvi_bounds_add(&all,
                       vv_affine_point(*to_index, vvi_vec(k & 1 ? s->hi[0] : s->lo[0], k & 2 ? s->hi[1] : s->lo[1],
                                                          k & 4 ? s->of.half[2] : -s->of.half[2])));
    const double lo[3] = {all.lo.x, all.lo.y, all.lo.z}, hi[3] = {all.hi.x, all.hi.y, all.hi.z};
    for (int a = 0; a < 3; a++) {
        const double last = (double)grid->dims[a] - 1;
        const double from = fmin(fmax(ceil(lo[a] - 1e-6), 0), last + 1), to = fmax(fmin(floor(hi[a] + 1e-6), last), -1);
        s->beyond |= lo[a] < -0.5 - 1e-6 || hi[a] > last + 0.5 + 1e-6;
        s->box.lo[a] = (int64_t)from;
        s->box.n[a] = to >= from ? (int64_t)(to - from) + 1 : 0;
    }
    if (!s->box.n[0] || !s->box.n[1] || !s->box.n[2])
        s->box = (vv_box){{0}, {0}};
}

static vv_status check(const vv_region_shape *r)
{
    const bool outline = r->kind == VV_REGION_POLYGON;
    const vv_vec3 *m = r->frame.axis, at = r->frame.origin;
    bool good = isfinite(vv_affine_determinant(r->frame)) && isfinite(at.x + at.y + at.z) && isfinite(m[0].x);
    for (int a = outline ? 2 : 0; a < 3; a++)
        good &= r->half[a] > 0 && isfinite(r->half[a]);
    for (size_t i = 0; outline && i < 2 * r->n_outline; i++)
        good &= isfinite(r->outline[i]);
    if (outline && r->n_outline < 3)
        return vv_fail(VV_E_ARGUMENT, "a polygon needs three corners at least, and %zu are given", r->n_outline);
    return good ? VV_OK
                : vv_fail(VV_E_ARGUMENT, "the region has no extent, or numbers that are not finite; expected extents "
                                         "above 0");
}

vv_status vvi_region_samples_init(vvi_region_samples *out, const vv_grid *grid, const vv_region_shape *region)
{
    vv_affine to_local, to_index;
    const vv_status st = check(region);
    *out = (vvi_region_samples){.of = *region};
    if (st != VV_OK)
        return st;
    if (!vv_affine_invert(&to_local, region->frame) || !vv_affine_invert(&to_index, grid->index_to_world))
        return vv_fail(VV_E_ARGUMENT, "the region's frame, or the grid, lies in one plane: it has no volume");
    out->local = vv_affine_compose(to_local, grid->index_to_world);
    to_index = vv_affine_compose(to_index, region->frame);
    for (int a = 0; a < 3; a++)
        out->nudge = fmax(out->nudge, HAIR * vvi_length(out->local.axis[a]));
    find_ends(out);
    find_box(out, grid, &to_index);
    return VV_OK;
}

/* Each side has its lower end and not its upper one: corners and points on sides are counted once. */
static bool in_outline(const vv_region_shape *r, double x, double y)
{
    bool in = false;
    for (size_t i = 0; i < r->n_outline; i++) {
        const double *a = corner(r, i), *b = corner(r, i + 1);
        if ((a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
            in = !in;
    }
    return in;
}

static bool between(double x, double half)
{
    return x >= -half && x < half;
}

static bool is_in(const vvi_region_samples *s, vv_vec3 p)
{
    const double *h = s->of.half, n = s->nudge;
    const double round = p.x * p.x / (h[0] * h[0]) + p.y * p.y / (h[1] * h[1]);
    switch (s->of.kind) {
    case VV_REGION_BOX:
        return between(p.x + n, h[0]) && between(p.y + n, h[1]) && between(p.z + n, h[2]);
    case VV_REGION_ELLIPSE:
        return round <= 1 + HAIR && between(p.z + n, h[2]);
    case VV_REGION_POLYGON:
        return between(p.z + n, h[2]) && in_outline(&s->of, p.x + n, p.y + n);
    case VV_REGION_ELLIPSOID:
        return round + p.z * p.z / (h[2] * h[2]) <= 1 + HAIR;
    case VV_REGION_NONE:
        break;
    }
    return true;
}

static bool has_row(const vvi_region_samples *s, int64_t j, int64_t k)
{
    return j >= s->box.lo[1] && j < s->box.lo[1] + s->box.n[1] && k >= s->box.lo[2] && k < s->box.lo[2] + s->box.n[2];
}

static bool has(const vvi_region_samples *s, int64_t i, int64_t j, int64_t k)
{
    return i >= s->box.lo[0] && i < s->box.lo[0] + s->box.n[0] &&
           is_in(s, vv_affine_point(s->local, vvi_vec((double)i, (double)j, (double)k)));
}

void vvi_region_samples_keep_row(uint64_t *bits, size_t words, const vvi_region_samples *s, int64_t j, int64_t k)
{
    if (!has_row(s, j, k)) {
        memset(bits, 0, words * sizeof *bits);
        return;
    }
    for (size_t w = 0; w < words; w++)
        for (uint64_t left = bits[w]; left; left &= left - 1)
            if (!has(s, 64 * (int64_t)w + __builtin_ctzll(left), j, k))
                bits[w] &= ~(left & -left);
}

uint64_t vvi_region_samples_count(const vvi_region_samples *s)
{
    uint64_t n = 0;
    for (int64_t k = s->box.lo[2]; k < s->box.lo[2] + s->box.n[2]; k++)
        for (int64_t j = s->box.lo[1]; j < s->box.lo[1] + s->box.n[1]; j++)
            for (int64_t i = s->box.lo[0]; i < s->box.lo[0] + s->box.n[0]; i++)
                n += has(s, i, j, k);
    return n;
}
