#include "render/decorate/region_lines.h"

#include "core/memory.h"
#include "core/vec.h"

#include <math.h>
#include <stdlib.h>

enum { ROUND = 96 }; /* sides of an ellipse */
#define PI 3.14159265358979323846

typedef struct lines {
    const vv_region_shape *of;
    vvi_region_line *line;
    void *user;
} lines;

static vv_vec3 in_world(const vv_region_shape *r, double x, double y, double z)
{
    return vv_affine_point(r->frame, vvi_vec(x, y, z));
}

/* Ellipsoids: unit spheres once their axes are -------------------------------------------------------------------- */

/* The circle where normal . p is `far` on the unit sphere. */
static vv_status put_circle(const lines *l, vv_vec3 normal, double far)
{
    const double *h = l->of->half, radius = sqrt(1 - far * far);
    const vv_vec3 other = fabs(normal.x) < 0.7 ? vvi_vec(1, 0, 0) : vvi_vec(0, 1, 0);
    vv_vec3 u = vvi_cross(normal, other), last = {0, 0, 0};
    vv_status st = VV_OK;
    vvi_unit(&u);
    const vv_vec3 v = vvi_cross(normal, u);
    for (int i = 0; i <= ROUND && st == VV_OK; i++) {
        const double c = radius * cos(2 * PI * i / ROUND), s = radius * sin(2 * PI * i / ROUND);
        const vv_vec3 q = vvi_add(vvi_scaled(normal, far), vvi_add(vvi_scaled(u, c), vvi_scaled(v, s)));
        const vv_vec3 p = in_world(l->of, q.x * h[0], q.y * h[1], q.z * h[2]);
        st = i ? l->line(l->user, last, p) : VV_OK;
        last = p;
    }
    return st;
}

static vv_status cut_ellipsoid(const lines *l, const vv_plane *plane)
{
    const vv_affine *m = &l->of->frame;
    vv_vec3 n = vvi_vec(vvi_dot(plane->normal, m->axis[0]) * l->of->half[0],
                        vvi_dot(plane->normal, m->axis[1]) * l->of->half[1],
                        vvi_dot(plane->normal, m->axis[2]) * l->of->half[2]);
    const double length = vvi_length(n), far = (plane->offset - vvi_dot(plane->normal, m->origin)) / length;
    vvi_unit(&n);
    return fabs(far) < 1 ? put_circle(l, n, far) : VV_OK;
}

/* Outlines with a thickness --------------------------------------------------------------------------------------- */

/* Rows of x and y; yours to free. */
static double *outline_of(size_t *n_out, const vv_region_shape *r)
{
    const bool box = r->kind == VV_REGION_BOX, polygon = r->kind == VV_REGION_POLYGON;
    const size_t n = *n_out = polygon ? r->n_outline : box ? 4 : ROUND;
    double *v = vvi_calloc(2 * n + 1, sizeof *v);
    for (size_t i = 0; v && i < n; i++) {
        const double turn = box ? PI / 4 + PI / 2 * (double)i : 2 * PI * (double)i / ROUND, wide = box ? sqrt(2) : 1;
        v[2 * i] = polygon ? r->outline[2 * i] : wide * r->half[0] * cos(turn);
        v[2 * i + 1] = polygon ? r->outline[2 * i + 1] : wide * r->half[1] * sin(turn);
    }
    return v;
}

static vv_vec3 place(const vv_region_shape *r, const double *outline, size_t n, size_t i, bool upper)
{
    const double *at = outline + 2 * (i % n);
    return in_world(r, at[0], at[1], upper ? r->half[2] : -r->half[2]);
}

static double above(const vv_plane *plane, vv_vec3 p)
{
    return vvi_dot(plane->normal, p) - plane->offset;
}

/* Where a side crosses the plane; false: both of its ends are on one side. */
static bool crossing(vv_vec3 *out, const vv_plane *plane, vv_vec3 p, vv_vec3 q)
{
    const double a = above(plane, p), b = above(plane, q);
    if ((a > 0) == (b > 0))
        return false;
    *out = vvi_add(p, vvi_scaled(vvi_sub(q, p), a / (a - b)));
    return true;
}

/* One of its upright faces, whose border the plane crosses twice or not at all. */
static vv_status cut_face(const lines *l, const vv_plane *plane, const vv_vec3 corner[4])
{
    vv_vec3 end[4];
    size_t n = 0;
    for (int i = 0; i < 4; i++)
        n += crossing(&end[n], plane, corner[i], corner[(i + 1) % 4]);
    return n == 2 ? l->line(l->user, end[0], end[1]) : VV_OK;
}

/* Along the line of the cut, from one crossing to the next. */
static int by_x(const void *a, const void *b)
{
    const double x = ((const vv_vec3 *)a)->x, y = ((const vv_vec3 *)b)->x;
    return (x > y) - (x < y);
}

/* A cap: every second part of the line between its crossings is inside. */
static vv_status cut_cap(const lines *l, const vv_plane *plane, const double *outline, size_t n, bool upper)
{
    const vv_vec3 along = vvi_cross(plane->normal, l->of->frame.axis[2]);
    vv_vec3 *at = vvi_calloc(2 * n + 1, sizeof *at); /* how far along and which, and the crossings themselves */
    vv_status st = at ? VV_OK : vv_fail_memory(2 * n * sizeof *at);
    size_t found = 0;
    for (size_t i = 0; at && i < n; i++)
        if (crossing(&at[n + found], plane, place(l->of, outline, n, i, upper),
                     place(l->of, outline, n, i + 1, upper))) {
            at[found] = vvi_vec(vvi_dot(along, at[n + found]), (double)found, 0);
            found++;
        }
    if (at)
        qsort(at, found, sizeof *at, by_x);
    for (size_t i = 0; i + 1 < found && st == VV_OK; i += 2)
        st = l->line(l->user, at[n + (size_t)at[i].y], at[n + (size_t)at[i + 1].y]);
    free(at);
    return st;
}

static vv_status cut_prism(const lines *l, const vv_plane *plane)
{
    size_t n;
    double *outline = outline_of(&n, l->of);
    vv_status st = outline ? VV_OK : vv_fail_memory(2 * n * sizeof *outline);
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        const vv_vec3 face[4] = {place(l->of, outline, n, i, false), place(l->of, outline, n, i + 1, false),
                                 place(l->of, outline, n, i + 1, true), place(l->of, outline, n, i, true)};
        st = cut_face(l, plane, face);
    }
    for (int upper = 0; upper < 2 && st == VV_OK; upper++)
        st = cut_cap(l, plane, outline, n, upper);
    free(outline);
    return st;
}

static vv_status edges_of_prism(const lines *l)
{
    size_t n;
    double *outline = outline_of(&n, l->of);
    vv_status st = outline ? VV_OK : vv_fail_memory(2 * n * sizeof *outline);
    const size_t each = l->of->kind == VV_REGION_ELLIPSE ? n / 4 : 1; /* uprights */
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        for (int upper = 0; upper < 2 && st == VV_OK; upper++)
            st = l->line(l->user, place(l->of, outline, n, i, upper), place(l->of, outline, n, i + 1, upper));
        if (st == VV_OK && i % each == 0)
            st = l->line(l->user, place(l->of, outline, n, i, false), place(l->of, outline, n, i, true));
    }
    free(outline);
    return st;
}

vv_status vvi_region_cut(const vv_region_shape *region, const vv_plane *plane, vvi_region_line *line, void *user)
{
    const lines l = {region, line, user};
    return region->kind == VV_REGION_ELLIPSOID ? cut_ellipsoid(&l, plane) : cut_prism(&l, plane);
}

vv_status vvi_region_edges(const vv_region_shape *region, vvi_region_line *line, void *user)
{
    const lines l = {region, line, user};
    vv_status st = VV_OK;
    if (region->kind != VV_REGION_ELLIPSOID)
        return edges_of_prism(&l);
    for (int a = 0; a < 3 && st == VV_OK; a++)
        st = put_circle(&l, vvi_vec(a == 0, a == 1, a == 2), 0);
    return st;
}
