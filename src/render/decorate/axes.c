/* Coordinates along three edges of the box around everything, the ones at the outside of its picture, lowest and
 * leftmost first; ticks at round numbers. */
#include "render/common/lens.h"
#include "render/decorate/nice.h"
#include "render/decorate/sheet.h"
#include <math.h>
#include <stdio.h>

#define TICK_EM 0.4
#define GAP_EM 0.3
#define ROOM_EM 3.2  /* between ticks, at least */
#define SHORT_EM 4.0 /* edges that look shorter say nothing */

typedef struct edge {
    int axis;
    vv_vec3 from, to;      /* World, along the axis */
    double x0, y0, x1, y1; /* pixels */
    double dx, dy;         /* away from the box, length 1 */
} edge;

static double coordinate(vv_vec3 p, int axis)
{
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

/* Corner by bits: which of the ends on each axis. */
static vv_vec3 corner(const vv_bounds *b, int bits)
{
    return vvi_vec(bits & 1 ? b->hi.x : b->lo.x, bits & 2 ? b->hi.y : b->lo.y, bits & 4 ? b->hi.z : b->lo.z);
}

/* Whether a side of the box, looking along +-axis, is seen. */
static bool faces_eye(const vvi_sheet *s, const vv_bounds *b, int axis, bool far)
{
    const vv_lens *lens = &s->scene->lens;
    const vv_vec3 n = vvi_vec(axis == 0, axis == 1, axis == 2), p = corner(b, far ? 7 : 0);
    const vv_vec3 to_eye = lens->parallel ? vvi_scaled(lens->forward, -1) : vvi_sub(lens->eye, p);
    return (far ? 1 : -1) * vvi_dot(n, to_eye) > 0;
}

/* False where the edge is not all before the eye, or looks like a point. */
static bool project(edge *e, const vvi_sheet *s, const vv_bounds *b)
{
    double depth, x, y;
    if (!vvi_sheet_project(&e->x0, &e->y0, &depth, s, e->from) ||
        !vvi_sheet_project(&e->x1, &e->y1, &depth, s, e->to) ||
        !vvi_sheet_project(&x, &y, &depth, s, vvi_scaled(vvi_add(b->lo, b->hi), 0.5)))
        return false;
    const double ex = e->x1 - e->x0, ey = e->y1 - e->y0, length = hypot(ex, ey);
    if (!(length > SHORT_EM * s->em))
        return false;
    e->dx = ey / length;
    e->dy = -ex / length;
    if (e->dx * ((e->x0 + e->x1) / 2 - x) + e->dy * ((e->y0 + e->y1) / 2 - y) < 0) {
        e->dx = -e->dx;
        e->dy = -e->dy;
    }
    return true;
}

/* The edge along an axis between a side that is seen and one that is not, lowest or leftmost. */
static bool choose(edge *best, const vvi_sheet *s, const vv_bounds *b, int axis)
{
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    double most = -INFINITY;
    for (int i = 0; i < 4; i++) {
        const int bits = (i & 1 ? 1 << u : 0) | (i & 2 ? 1 << v : 0);
        edge e = {.axis = axis, .from = corner(b, bits), .to = corner(b, bits | 1 << axis)};
        const bool outside = faces_eye(s, b, u, i & 1) != faces_eye(s, b, v, i & 2);
        if (!project(&e, s, b))
            continue;
        const double score = 0.9 * e.dy - e.dx + (outside ? 10 : 0);
        if (score > most) {
            most = score;
            *best = e;
        }
    }
    return most > -INFINITY;
}

/* Where a tick is, and how far a text of this size must be from a place to stand free of it. */
static vv_vec3 tick_place(const vvi_sheet *s, const edge *e, double value)
{
    const double from = coordinate(e->from, e->axis), to = coordinate(e->to, e->axis);
    const double t = (value - from) / (to - from);
    const vv_vec3 world = vvi_add(e->from, vvi_scaled(vvi_sub(e->to, e->from), t));
    double x = e->x0, y = e->y0, depth;
    vvi_sheet_project(&x, &y, &depth, s, world);
    return vvi_vec(x, y, 0);
}

static double reach(const edge *e, double width, double height)
{
    return (fabs(e->dx) * width + fabs(e->dy) * height) / 2;
}

static vv_status draw_ticks(double *far_out, const vvi_sheet *s, const edge *e, const vvi_ticks *ticks)
{
    const double size = 0.85 * s->em;
    vv_status st = VV_OK;
    for (int i = 0; i < ticks->n && st == VV_OK; i++) {
        char text[40];
        const double value = vvi_tick_at(ticks, i);
        const vv_vec3 p = tick_place(s, e, value), d = vvi_vec(e->dx, e->dy, 0);
        const vv_vec3 mark[2] = {p, vvi_add(p, vvi_scaled(d, TICK_EM * s->em))};
        vvi_print_tick(text, value, ticks->step);
        const double away = (TICK_EM + GAP_EM) * s->em + reach(e, vvi_sheet_length(s, text, size), 0.72 * size);
        const vv_vec3 at = vvi_add(p, vvi_scaled(d, away));
        *far_out = fmax(*far_out, 2 * away - (TICK_EM + GAP_EM) * s->em);
        if ((st = vvi_sheet_line(s, mark, 2, VVI_GFX_STRIP, s->line)) == VV_OK)
            st = vvi_sheet_text(s, at.x, at.y, size, VVI_GFX_MIDDLE, VVI_GFX_CENTRE, text);
    }
    return st;
}

/* "x (mm)"; for anatomical data the direction that grows. */
static void name_axis(char out[64], const vvi_sheet *s, int axis)
{
    static const char *const plain[] = {"x", "y", "z"}, *const anatomical[] = {"R", "A", "S"};
    const bool ras = s->scene->n_actors && vv_field_get_info(s->scene->actors[0].field)->grid.space == VV_SPACE_RAS;
    snprintf(out, 64, "%s (%s)", (ras ? anatomical : plain)[axis], vvi_unit_sign(s->unit));
}

/* Beyond the numbers; along edges that are steep in the picture the name stands on its side. */
static vv_status draw_name(const vvi_sheet *s, const edge *e, double far)
{
    char name[64];
    name_axis(name, s, e->axis);
    const bool steep = fabs(e->dx) > 0.85;
    const double length = vvi_sheet_length(s, name, s->em), high = 0.75 * s->em;
    const double away = far + 1.2 * GAP_EM * s->em + (steep ? reach(e, high, length) : reach(e, length, high));
    const vvi_gfx_label label = {.size = s->em,
                                 .anchor = VVI_GFX_MIDDLE,
                                 .level = VVI_GFX_CENTRE,
                                 .quarters = steep,
                                 .color = s->ink,
                                 .halo = s->paper};
    const vv_vec3 at = {(e->x0 + e->x1) / 2 + e->dx * away, (e->y0 + e->y1) / 2 + e->dy * away, 0};
    return s->font ? vvi_gfx_text(s->gfx, at, &label, name) : VV_OK;
}

static vv_status draw_axis(const vvi_sheet *s, const edge *e)
{
    double far = 0;
    const double from = coordinate(e->from, e->axis), to = coordinate(e->to, e->axis);
    const double length = hypot(e->x1 - e->x0, e->y1 - e->y0);
    const vvi_ticks ticks = vvi_nice_ticks(from, to, (int)fmin(length / (ROOM_EM * s->em), 12));
    const vv_vec3 ends[2] = {{e->x0, e->y0, 0}, {e->x1, e->y1, 0}};
    vv_status st = vvi_sheet_line(s, ends, 2, VVI_GFX_STRIP, s->line);
    if (st == VV_OK)
        st = draw_ticks(&far, s, e, &ticks);
    return st == VV_OK ? draw_name(s, e, far) : st;
}

vv_status vvi_sheet_axes(const vvi_sheet *s)
{
    const vv_bounds b = vvi_sheet_bounds(s);
    vv_status st = VV_OK;
    edge e = {0};
    for (int axis = 0; axis < 3 && b.hi.x >= b.lo.x && st == VV_OK; axis++)
        if (choose(&e, s, &b, axis))
            st = draw_axis(s, &e);
    return st;
}
