/* Straight lines that leave out what has its place on the picture: letters, plates, the scale bar. */
#include "core/vec.h"
#include "render/decorate/sheet.h"
#include <math.h>

enum { PIECES = 64 };

/* Shares of a line, as it is seen. */
typedef struct span {
    double from, to;
} span;

typedef struct pieces {
    const vvi_sheet *sheet;
    double width;
    vv_vec3 point[2 * PIECES];
    size_t n; /* points */
} pieces;

/* All edges before all lines: no line ends at the edge of another. */
static vv_status draw(pieces *p)
{
    const vvi_sheet *s = p->sheet;
    const vvi_gfx_stroke edge = {.color = vvi_faded(s->paper, 0.6), .width = p->width + 1.2 * s->line};
    const vvi_gfx_stroke line = {.color = s->ink, .width = p->width};
    vv_status st = p->n ? vvi_gfx_line(s->gfx, p->point, p->n, VVI_GFX_PAIRS, &edge) : VV_OK;
    if (p->n && st == VV_OK)
        st = vvi_gfx_line(s->gfx, p->point, p->n, VVI_GFX_PAIRS, &line);
    p->n = 0;
    return st;
}

/* Narrows a span to where a line from `a`, `b` long, lies between two borders. */
static void narrow(span *out, double a, double b, double lo, double hi)
{
    const double t0 = (lo - a) / b, t1 = (hi - a) / b;
    if (b == 0 && (a <= lo || a >= hi))
        out->to = -1;
    if (b == 0)
        return;
    out->from = fmax(out->from, fmin(t0, t1));
    out->to = fmin(out->to, fmax(t0, t1));
}

/* Where boxes are in the way, in no order; how many. */
static size_t find_blocked(span out[VVI_LAYOUT_MOST], const vvi_sheet *s, vv_vec3 from, vv_vec3 to)
{
    const double around = s->layout.gap / 2;
    size_t n = 0;
    for (size_t i = 0; i < s->layout.n; i++) {
        const vvi_box *b = &s->layout.box[i];
        span inside = {0, 1};
        narrow(&inside, from.x, to.x - from.x, b->x0 - around, b->x1 + around);
        narrow(&inside, from.y, to.y - from.y, b->y0 - around, b->y1 + around);
        if (inside.to > inside.from)
            out[n++] = inside;
    }
    return n;
}

/* The end of the boxes that follow each other from a share on; itself where none begins before it. */
static double end_of_blocked(double at, const span *blocked, size_t n)
{
    double end = at;
    do {
        at = end;
        for (size_t i = 0; i < n; i++)
            if (blocked[i].from <= at && blocked[i].to > end)
                end = blocked[i].to;
    } while (end > at);
    return end;
}

/* The next piece from *at on, which moves behind it; false: there is none. */
static bool next_free(span *out, double *at, const span *blocked, size_t n)
{
    *at = end_of_blocked(*at, blocked, n);
    *out = (span){*at, 1};
    for (size_t i = 0; i < n; i++)
        if (blocked[i].from > *at)
            out->to = fmin(out->to, blocked[i].from);
    *at = out->to;
    return out->to > out->from;
}

/* The point that is seen at a share of the way between two, which are so far away. */
static vv_vec3 seen_at(vv_vec3 p, vv_vec3 q, double share, double depth_p, double depth_q)
{
    const double t = share * depth_p / ((1 - share) * depth_q + share * depth_p);
    return vvi_add(vvi_scaled(p, 1 - t), vvi_scaled(q, t));
}

static vv_status add(pieces *out, vv_vec3 p, vv_vec3 q)
{
    const vvi_sheet *s = out->sheet;
    vv_vec3 from = p, to = q;
    double depth[2] = {1, 1}, at = 0;
    span blocked[VVI_LAYOUT_MOST], piece;
    const bool seen = !s->in_world || (vvi_sheet_project(&from.x, &from.y, &depth[0], s, p) &&
                                       vvi_sheet_project(&to.x, &to.y, &depth[1], s, q));
    const size_t n = seen ? find_blocked(blocked, s, from, to) : 0;
    const bool near = s->in_world && seen && !s->scene->lens.parallel;
    vv_status st = VV_OK;
    while (st == VV_OK && next_free(&piece, &at, blocked, n)) {
        if (out->n + 2 > 2 * PIECES)
            st = draw(out);
        out->point[out->n++] = seen_at(p, q, piece.from, near ? depth[0] : 1, near ? depth[1] : 1);
        out->point[out->n++] = seen_at(p, q, piece.to, near ? depth[0] : 1, near ? depth[1] : 1);
    }
    return st;
}

vv_status vvi_sheet_line(const vvi_sheet *s, const vv_vec3 *points, size_t n, double width)
{
    pieces out = {.sheet = s, .width = width};
    vv_status st = VV_OK;
    for (size_t i = 0; i + 1 < n && st == VV_OK; i += 2)
        st = add(&out, points[i], points[i + 1]);
    return st == VV_OK ? draw(&out) : st;
}
