/* Coordinates along three edges of the box around everything, the ones at the outside of its picture, lowest and
 * leftmost first; ticks at round numbers. Numbers stand outside the box, or inside where there is no room. */
#include "render/decorate/round_numbers.h"
#include "render/decorate/sheet.h"
#include "scene/lens.h"
#include <math.h>
#include <stdio.h>

#define TICK_EM 0.4
#define GAP_EM 0.3
#define CAPITALS 0.72 /* ems */
#define ROOM_EM 3.2   /* between ticks, at least */
#define SHORT_EM 5.0  /* edges that look shorter say nothing, */
#define SHORT 0.2     /* and so do those that are this share of the longest: they look away */
enum { MOST_TICKS = 12 };

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

/* The edges at the outside of the box's picture. */
static size_t find_edges(edge out[12], const vvi_sheet *s, const vv_bounds *b)
{
    double longest = 0;
    size_t n = 0, kept = 0;
    for (int k = 0; k < 12; k++) {
        const int axis = k / 4, u = (axis + 1) % 3, v = (axis + 2) % 3;
        const int bits = (k & 1 ? 1 << u : 0) | (k & 2 ? 1 << v : 0);
        edge *e = &out[n];
        *e = (edge){.axis = axis, .from = corner(b, bits), .to = corner(b, bits | 1 << axis)};
        if (faces_eye(s, b, u, k & 1) == faces_eye(s, b, v, k & 2)) /* before the data, or behind them */
            continue;
        if (project(e, s, b)) {
            longest = fmax(longest, hypot(e->x1 - e->x0, e->y1 - e->y0));
            n++;
        }
    }
    for (size_t i = 0; i < n; i++)
        if (hypot(out[i].x1 - out[i].x0, out[i].y1 - out[i].y0) > SHORT * longest)
            out[kept++] = out[i];
    return kept;
}

/* Where a tick is. */
static vv_vec3 tick_place(const vvi_sheet *s, const edge *e, double value)
{
    const double from = coordinate(e->from, e->axis), to = coordinate(e->to, e->axis);
    const double t = (value - from) / (to - from);
    const vv_vec3 world = vvi_add(e->from, vvi_scaled(vvi_sub(e->to, e->from), t));
    double x = e->x0, y = e->y0, depth;
    vvi_sheet_project(&x, &y, &depth, s, world);
    return vvi_vec(x, y, 0);
}

/* How far the middle of a text of this size must be from a place to stand free of it. */
static double reach(const vv_vec3 *away, double width, double height)
{
    return (fabs(away->x) * width + fabs(away->y) * height) / 2;
}

static void put_label(vvi_sheet_axis_label *l, double x, double y, double wide, double high)
{
    l->x = x;
    l->y = y;
    l->box = (vvi_box){x - wide / 2, y - high / 2, x + wide / 2, y + high / 2};
}

static bool overlap(const vvi_box *a, const vvi_box *b, double gap)
{
    return a->x0 < b->x1 + gap && b->x0 < a->x1 + gap && a->y0 < b->y1 + gap && b->y0 < a->y1 + gap;
}

/* Ticks and numbers; false where numbers would stand in each other. */
static bool put_ticks(vvi_sheet_axis *out, const vvi_sheet *s, const edge *e, const vvi_ticks *ticks)
{
    const double size = vvi_sheet_small(s);
    out->n = ticks->n < VVI_AXIS_TICKS ? ticks->n : VVI_AXIS_TICKS;
    for (int i = 0; i < out->n; i++) {
        const double value = vvi_tick_at(ticks, i);
        vvi_sheet_axis_label *l = &out->tick[i].number;
        vvi_print_tick(l->text, value, ticks->step);
        const double wide = vvi_sheet_length(s, l->text, size), high = CAPITALS * size;
        const double away = (TICK_EM + GAP_EM) * s->em + reach(&out->away, wide, high);
        const vv_vec3 p = tick_place(s, e, value);
        out->tick[i].at = p;
        put_label(l, p.x + out->away.x * away, p.y + out->away.y * away, wide, high);
        if (i && overlap(&l->box, &out->tick[i - 1].number.box, s->layout.gap))
            return false;
    }
    return true;
}

/* "x (mm)"; for anatomical data the direction that grows. */
static void name_axis(char out[64], const vvi_sheet *s, int axis)
{
    static const char *const plain[] = {"x", "y", "z"}, *const anatomical[] = {"R", "A", "S"};
    snprintf(out, 64, "%s (%s)", (vvi_sheet_is_anatomical(s) ? anatomical : plain)[axis], vvi_unit_sign(s->unit));
}

/* Beyond the numbers, in the middle or nearer to an end; else where the axis ends. Along edges that are steep in the
 * picture it stands on its side. */
static void put_name(vvi_sheet_axis *out, const vvi_sheet *s, const vvi_layout *l, const edge *e)
{
    static const double along[] = {0.5, 0.25, 0.75};
    const double high = CAPITALS * s->em;
    double far = TICK_EM * s->em;
    name_axis(out->name.text, s, e->axis);
    for (int i = 0; i < out->n; i++) {
        const vvi_sheet_axis_label *n = &out->tick[i].number;
        if (n->there)
            far = fmax(far, (TICK_EM + GAP_EM) * s->em + 2 * reach(&out->away, n->box.x1 - n->box.x0, high));
    }
    out->upright = fabs(out->away.x) > 0.85;
    for (int k = 0; k < 10 && !out->name.there; k++) { /* free of data, then anywhere */
        const int i = k % 5;
        const double wide = vvi_sheet_length(s, out->name.text, s->em);
        const bool turned = out->upright && i < 3;
        vv_vec3 d = out->away, p = out->to;
        if (i < 3)
            p = vvi_add(vvi_scaled(out->from, 1 - along[i]), vvi_scaled(out->to, along[i]));
        else
            d = vvi_sub(i == 3 ? out->to : out->from, i == 3 ? out->from : out->to);
        if (i == 4)
            p = out->from;
        vvi_unit(&d);
        const double away =
            (i < 3 ? far : 0) + 1.4 * GAP_EM * s->em + reach(&d, turned ? high : wide, turned ? wide : high);
        put_label(&out->name, p.x + d.x * away, p.y + d.y * away, turned ? high : wide, turned ? wide : high);
        out->name.there =
            vvi_layout_is_free(l, out->name.box) && (k >= 5 || !(vvi_sheet_covered(s, out->name.box) > 0));
        out->upright = turned;
    }
}

/* An edge with its numbers on one side; how good it is. */
static double try_edge(vvi_sheet_axis *out, const vvi_sheet *s, const edge *e, bool inside)
{
    const double from = coordinate(e->from, e->axis), to = coordinate(e->to, e->axis);
    const double length = hypot(e->x1 - e->x0, e->y1 - e->y0), turn = inside ? -1 : 1;
    int most = (int)fmin(length / (ROOM_EM * s->em), MOST_TICKS), n = 0;
    vvi_ticks ticks;
    *out =
        (vvi_sheet_axis){.from = {e->x0, e->y0, 0}, .to = {e->x1, e->y1, 0}, .away = {turn * e->dx, turn * e->dy, 0}};
    do
        ticks = vvi_nice_ticks(from, to, most);
    while (!put_ticks(out, s, e, &ticks) && most-- > 1);
    for (int more = most + 1; out->n < 2 && more <= MOST_TICKS;
         more++) { /* 50 alone may lie there, and 20, 40, 60 too */
        ticks = vvi_nice_ticks(from, to, more);
        if (!put_ticks(out, s, e, &ticks))
            out->n = 0;
    }
    double hidden = 0;
    for (int i = 0; i < out->n; i++) {
        vvi_sheet_axis_label *l = &out->tick[i].number;
        l->there = vvi_layout_is_free(&s->layout, l->box);
        n += l->there;
        hidden += l->there ? vvi_sheet_covered(s, l->box) : 0;
    }
    if (n < 2)
        return -INFINITY;
    out->there = true;
    put_name(out, s, &s->layout, e);
    return 0.9 * e->dy - e->dx - (inside ? 3 : 0) + (6.0 * n - 4.0 * hidden) / out->n + (out->name.there ? 1 : 0);
}

static void take(vvi_sheet_axis *a, vvi_layout *l)
{
    for (int i = 0; i < a->n; i++)
        a->tick[i].number.there = a->tick[i].number.there && vvi_layout_take(l, a->tick[i].number.box);
    a->name.there = a->name.there && vvi_layout_take(l, a->name.box);
}

void vvi_sheet_axes_place(vvi_sheet_axes *out, vvi_sheet *s)
{
    const vv_bounds b = vvi_sheet_bounds(s);
    edge edges[12];
    const size_t n = b.hi.x >= b.lo.x ? find_edges(edges, s, &b) : 0;
    *out = (vvi_sheet_axes){0};
    for (int axis = 0; axis < 3; axis++) {
        double best = -INFINITY;
        for (size_t i = 0; i < 2 * n; i++) {
            vvi_sheet_axis trial;
            const edge *e = &edges[i / 2];
            const double score = e->axis == axis ? try_edge(&trial, s, e, i & 1) : -INFINITY;
            out->axis[axis].seen |= e->axis == axis;
            if (score > best) {
                best = score;
                out->axis[axis] = trial;
                out->axis[axis].seen = true;
            }
        }
        take(&out->axis[axis], &s->layout);
    }
}

static vv_status draw_label(const vvi_sheet_axis_label *l, const vvi_sheet *s, double size, int quarters)
{
    const vvi_gfx_label label = {.size = size, .anchor = VVI_GFX_MIDDLE, .level = VVI_GFX_CENTRE, .quarters = quarters};
    return l->there ? vvi_sheet_label(s, l->x, l->y, &label, l->text) : VV_OK;
}

static vv_status draw_axis(const vvi_sheet_axis *a, const vvi_sheet *s)
{
    vv_vec3 lines[2 * VVI_AXIS_TICKS + 2] = {a->from, a->to};
    for (int i = 0; i < a->n; i++) {
        lines[2 * i + 2] = a->tick[i].at;
        lines[2 * i + 3] = vvi_add(a->tick[i].at, vvi_scaled(a->away, TICK_EM * s->em));
    }
    vv_status st = vvi_sheet_line(s, lines, 2 * (size_t)a->n + 2, s->line);
    for (int i = 0; i < a->n && st == VV_OK; i++)
        st = draw_label(&a->tick[i].number, s, vvi_sheet_small(s), 0);
    return st == VV_OK ? draw_label(&a->name, s, s->em, a->upright) : st;
}

/* An axis that is looked along is not missed. */
static void tell_missing(const vvi_sheet_axis *a, const vvi_sheet *s, int axis)
{
    char name[64], what[96];
    name_axis(name, s, axis);
    snprintf(what, sizeof what, a->there ? "the name of the axis %s" : "the axis %s", name);
    if (a->seen && !(a->there && a->name.there))
        vvi_sheet_left_out(s, what);
}

vv_status vvi_sheet_axes_draw(const vvi_sheet_axes *axes, const vvi_sheet *s)
{
    vv_status st = VV_OK;
    bool any = false;
    for (int i = 0; i < 3 && st == VV_OK; i++) {
        any = any || axes->axis[i].there;
        if (axes->axis[i].there)
            st = draw_axis(&axes->axis[i], s);
    }
    if (!any && s->wanted->axes)
        vvi_sheet_left_out(s, "the axes");
    for (int i = 0; i < 3 && any && s->wanted->axes; i++)
        tell_missing(&axes->axis[i], s, i);
    return st;
}
