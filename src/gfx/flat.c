#include "gfx/flat.h"
#include "core/job.h"
#include <stdlib.h>
#include <string.h>

/* Places nearer to the eye's plane than this share of their distance are behind it. */
#define NEAREST 1e-6

/* Growing list of spots ------------------------------------------------------------------------------------------- */

typedef struct spots {
    vvi_gfx_spot *spot;
    size_t n, room;
    vv_job *job;
    bool failed;
} spots;

static void add(spots *s, vvi_gfx_spot spot)
{
    if (s->n == s->room) {
        const size_t room = s->room ? 2 * s->room : 64;
        vvi_gfx_spot *more = vvi_realloc(s->job, s->spot, room * sizeof *more, VVI_MEM_SCRATCH);
        s->failed |= !more;
        if (!more)
            return;
        s->spot = more;
        s->room = room;
    }
    s->spot[s->n++] = spot;
}

vvi_gfx_spot vvi_gfx_between(vvi_gfx_spot a, vvi_gfx_spot b, double t)
{
    return (vvi_gfx_spot){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.near + t * (b.near - a.near)};
}

/* A kept shape around the spots, which are freed; NULL in *out when it covers nothing. */
static vv_status make(vvi_gfx_flat **out, vvi_gfx *gfx, vvi_gfx_flat_kind kind, spots *s, double reach)
{
    const vvi_gfx_state *state = &gfx->state;
    const size_t bytes = sizeof **out + s->n * sizeof *s->spot;
    vvi_gfx_flat *shape = s->n && !s->failed ? vvi_gfx_keep(gfx, bytes) : NULL;
    *out = NULL;
    if (s->failed || (s->n && !shape)) {
        const vv_status st = vv_fail_memory(bytes);
        vvi_free(s->spot);
        return st;
    }
    if (!shape)
        return VV_OK;
    *shape = (vvi_gfx_flat){.kind = kind,
                            .view = state->view,
                            .depth = state->depth && state->view,
                            .id = state->id,
                            .spots = (vvi_gfx_spot *)(shape + 1),
                            .n_spots = s->n,
                            .box = {INFINITY, INFINITY, -INFINITY, -INFINITY}};
    memcpy(shape->window, state->window, sizeof shape->window);
    for (size_t i = 0; i < s->n; i++) {
        const vvi_gfx_spot p = shape->spots[i] = s->spot[i];
        const double low[2] = {p.x - reach, p.y - reach}, high[2] = {p.x + reach, p.y + reach};
        for (int a = 0; a < 2; a++) {
            shape->box[a] = fmin(shape->box[a], low[a]);
            shape->box[2 + a] = fmax(shape->box[2 + a], high[a]);
        }
    }
    vvi_free(s->spot);
    for (int a = 0; a < 2; a++) {
        shape->box[a] = fmax(shape->box[a], shape->window[a]);
        shape->box[2 + a] = fmin(shape->box[2 + a], shape->window[2 + a]);
    }
    if (shape->box[0] < shape->box[2] && shape->box[1] < shape->box[3])
        *out = shape;
    return VV_OK;
}

/* Cutting --------------------------------------------------------------------------------------------------------- */

/* Half-spaces of the world that what is drawn lies in: before the eye, and the state's cuts. */
typedef struct cutter {
    const vvi_gfx_state *state;
    size_t n_planes;
    double nearest; /* forward */
} cutter;

static cutter cutter_of(const vvi_gfx_state *state, const vv_vec3 *points, size_t n)
{
    double far = 0;
    for (size_t i = 0; state->view && i < n; i++)
        far = fmax(far, vvi_length(vvi_sub(points[i], state->view->lens.eye)));
    return (cutter){state, state->view ? state->cuts->n_planes + 1 : 0, NEAREST * far};
}

/* Above 0: inside of half-space i. */
static double side(const cutter *c, size_t i, vv_vec3 p)
{
    const vv_lens *lens = &c->state->view->lens;
    if (i == 0)
        return vvi_dot(vvi_sub(p, lens->eye), lens->forward) - c->nearest;
    const vv_plane *plane = &c->state->cuts->planes[i - 1];
    return vvi_dot(plane->normal, p) - plane->offset;
}

static vvi_gfx_spot spot_of(const vvi_gfx_state *state, vv_vec3 p)
{
    return state->view ? vvi_gfx_spot_of(state->view, vvi_gfx_to_eye(state->view, p))
                       : (vvi_gfx_spot){.x = p.x, .y = p.y};
}

bool vvi_gfx_spot_at(vvi_gfx_spot *out, const vvi_gfx_state *state, vv_vec3 at)
{
    const cutter c = cutter_of(state, &at, 1);
    for (size_t i = 0; i < c.n_planes; i++)
        if (!(side(&c, i, at) > 0 || (i && side(&c, i, at) == 0)))
            return false;
    *out = spot_of(state, at);
    return true;
}

/* Lines ----------------------------------------------------------------------------------------------------------- */

typedef struct dashing {
    double dash, space; /* dash 0: none */
    double along;       /* pixels since the line's begin */
    const double *box;  /* what lies outside, `reach` away, is left out */
    double reach;
} dashing;

/* The part of a segment that can be seen: [*t0, *t1] of it (Liang & Barsky 1984). */
static bool part_in_box(double *t0, double *t1, const dashing *d, vvi_gfx_spot a, vvi_gfx_spot b)
{
    const double from[2] = {a.x, a.y}, step[2] = {b.x - a.x, b.y - a.y};
    *t0 = 0, *t1 = 1;
    for (int i = 0; i < 2; i++) {
        const double lo = d->box[i] - d->reach - from[i], hi = d->box[2 + i] + d->reach - from[i];
        if (step[i] == 0) {
            if (lo > 0 || hi < 0)
                return false;
            continue;
        }
        *t0 = fmax(*t0, (step[i] > 0 ? lo : hi) / step[i]);
        *t1 = fmin(*t1, (step[i] > 0 ? hi : lo) / step[i]);
    }
    return *t0 <= *t1;
}

static void add_segment(spots *s, dashing *d, vvi_gfx_spot a, vvi_gfx_spot b)
{
    const double length = hypot(b.x - a.x, b.y - a.y), begin = d->along;
    double t0, t1;
    d->along += length;
    if (!part_in_box(&t0, &t1, d, a, b))
        return;
    if (!(d->dash > 0) || !(length > 0)) {
        add(s, vvi_gfx_between(a, b, t0));
        add(s, vvi_gfx_between(a, b, t1));
        return;
    }
    const double period = d->dash + d->space;
    for (double n = floor((begin + t0 * length) / period); n * period < begin + t1 * length && !s->failed; n++) {
        const double from = fmax((n * period - begin) / length, t0),
                     to = fmin((n * period + d->dash - begin) / length, t1);
        if (from < to) {
            add(s, vvi_gfx_between(a, b, from));
            add(s, vvi_gfx_between(a, b, to));
        }
    }
}

static void cut_segment(spots *s, dashing *d, const cutter *c, vv_vec3 a, vv_vec3 b)
{
    double t0 = 0, t1 = 1;
    for (size_t i = 0; i < c->n_planes; i++) {
        const double da = side(c, i, a), db = side(c, i, b);
        if (da < 0 && db < 0)
            return;
        if (da < 0)
            t0 = fmax(t0, da / (da - db));
        else if (db < 0)
            t1 = fmin(t1, da / (da - db));
    }
    const vv_vec3 way = vvi_sub(b, a);
    if (t0 <= t1)
        add_segment(s, d, spot_of(c->state, vvi_add(a, vvi_scaled(way, t0))),
                    spot_of(c->state, t1 < 1 ? vvi_add(a, vvi_scaled(way, t1)) : b));
}

vv_status vvi_gfx_flat_line(vvi_gfx_flat **out, vvi_gfx *gfx, const vv_vec3 *points, size_t n_points, vvi_gfx_join join,
                            const vvi_gfx_stroke *stroke, bool undashed)
{
    const cutter c = cutter_of(&gfx->state, points, n_points);
    dashing d = {.dash = undashed ? 0 : stroke->dash,
                 .space = stroke->space,
                 .box = gfx->state.window,
                 .reach = 0.5 * stroke->width + 1};
    const size_t step = join == VVI_GFX_PAIRS ? 2 : 1;
    spots s = {.job = gfx->job};
    for (size_t i = 0; i + 1 < n_points; i += step) {
        if (join == VVI_GFX_PAIRS)
            d.along = 0;
        cut_segment(&s, &d, &c, points[i], points[i + 1]);
    }
    if (join == VVI_GFX_LOOP && n_points > 2)
        cut_segment(&s, &d, &c, points[n_points - 1], points[0]);
    const vv_status st = make(out, gfx, VVI_GFX_SEGMENTS, &s, d.reach);
    if (*out) {
        (*out)->radius = 0.5 * stroke->width;
        (*out)->paint.color = stroke->color;
    }
    return st;
}

vv_status vvi_gfx_flat_points(vvi_gfx_flat **out, vvi_gfx *gfx, const vv_vec3 *points, size_t n_points, double diameter,
                              vv_color color)
{
    spots s = {.job = gfx->job};
    for (size_t i = 0; i < n_points; i++) {
        vvi_gfx_spot spot;
        if (vvi_gfx_spot_at(&spot, &gfx->state, points[i]))
            add(&s, spot);
    }
    const vv_status st = make(out, gfx, VVI_GFX_DISCS, &s, 0.5 * diameter + 1);
    if (*out) {
        (*out)->radius = 0.5 * diameter;
        (*out)->paint.color = color;
    }
    return st;
}

/* Polygons -------------------------------------------------------------------------------------------------------- */

/* What of a polygon lies in one half-space (Sutherland & Hodgman 1974): at most twice as many corners. */
static size_t cut_polygon(vv_vec3 *out, const vv_vec3 *in, size_t n, const cutter *c, size_t plane)
{
    size_t m = 0;
    for (size_t i = 0; i < n; i++) {
        const vv_vec3 a = in[i], b = in[(i + 1) % n];
        const double da = side(c, plane, a), db = side(c, plane, b);
        if (da >= 0)
            out[m++] = a;
        if ((da < 0) != (db < 0))
            out[m++] = vvi_add(a, vvi_scaled(vvi_sub(b, a), da / (da - db)));
    }
    return m;
}

size_t vvi_gfx_cut_convex(vv_vec3 *points, vv_vec3 *spare, size_t n, size_t room, const vvi_gfx_state *state)
{
    const cutter c = cutter_of(state, points, n);
    for (size_t i = 0; i < c.n_planes && n && 2 * n <= room; i++) {
        n = cut_polygon(spare, points, n, &c, i);
        memcpy(points, spare, n * sizeof *points);
    }
    return n;
}

static vv_status cut_all(vv_vec3 **points_out, size_t *n_out, vvi_gfx *gfx, const vv_vec3 *points, size_t n)
{
    const cutter c = cutter_of(&gfx->state, points, n);
    const vv_vec3 *from = points;
    for (size_t i = 0; i < c.n_planes; i++) {
        vv_vec3 *to = vvi_gfx_keep(gfx, 2 * (n + 1) * sizeof *to);
        if (!to)
            return vv_fail_memory(2 * (n + 1) * sizeof *to);
        n = cut_polygon(to, from, n, &c, i);
        from = to;
    }
    *points_out = (vv_vec3 *)from;
    *n_out = n;
    return VV_OK;
}

static vv_status keep_fill(vvi_gfx_paint *out, vvi_gfx *gfx, const vvi_gfx_fill *fill)
{
    *out = (vvi_gfx_paint){.color = fill->color};
    if (!fill->n_stops)
        return VV_OK;
    vvi_gfx_stop *stops = vvi_gfx_keep(gfx, fill->n_stops * sizeof *stops);
    if (!stops)
        return vv_fail_memory(fill->n_stops * sizeof *stops);
    memcpy(stops, fill->stops, fill->n_stops * sizeof *stops);
    out->stops = stops;
    out->n_stops = fill->n_stops;
    out->from = spot_of(&gfx->state, fill->from);
    out->to = spot_of(&gfx->state, fill->to);
    return VV_OK;
}

vv_status vvi_gfx_flat_polygon(vvi_gfx_flat **out, vvi_gfx *gfx, const vv_vec3 *points, size_t n_points,
                               const vvi_gfx_fill *fill)
{
    vvi_gfx_paint paint;
    vv_vec3 *cut = NULL;
    size_t n = 0;
    *out = NULL;
    vv_status st = keep_fill(&paint, gfx, fill);
    if (st != VV_OK || (st = cut_all(&cut, &n, gfx, points, n_points)) != VV_OK)
        return st;
    spots s = {.job = gfx->job};
    for (size_t i = 0; i < n; i++)
        add(&s, spot_of(&gfx->state, cut[i]));
    st = make(out, gfx, VVI_GFX_OUTLINE, &s, 0);
    if (*out)
        (*out)->paint = paint;
    return st;
}

/* Text ------------------------------------------------------------------------------------------------------------ */

/* Above the base line, in ems; for all fonts, so that text stands where a figure's layout wants it. */
#define CAPITALS 0.72
#define DESCENT 0.22

double vvi_gfx_base_line(const vvi_gfx_label *label)
{
    static const double down[] = {[VVI_GFX_BASE_LINE] = 0,
                                  [VVI_GFX_CENTRE] = 0.5 * CAPITALS,
                                  [VVI_GFX_TOP] = CAPITALS,
                                  [VVI_GFX_BOTTOM] = -DESCENT};
    return down[label->level] * label->size;
}

double vvi_gfx_halo(const vvi_gfx_label *label)
{
    return fmax(1, floor(label->size / 10 + 0.5));
}

/* A bitmap turned about its origin, counter-clockwise: (x, y) goes to (y, -x), y down, for each quarter. */
static void turn(vvi_gfx_coverage *c, uint8_t *to, const uint8_t *from, int quarters)
{
    const vvi_gfx_coverage old = *c;
    const bool across = quarters & 1;
    const int32_t x1 = old.left + old.width, y1 = old.top + old.height;
    const int32_t left[4] = {old.left, old.top, -x1, -y1}, top[4] = {old.top, -x1, -y1, old.left};
    c->width = across ? old.height : old.width;
    c->height = across ? old.width : old.height;
    c->left = left[quarters];
    c->top = top[quarters];
    for (int32_t y = 0; y < old.height; y++)
        for (int32_t x = 0; x < old.width; x++) {
            const int32_t tx[4] = {x, y, old.width - 1 - x, old.height - 1 - y};
            const int32_t ty[4] = {y, old.width - 1 - x, old.height - 1 - y, x};
            to[(size_t)ty[quarters] * (size_t)c->width + (size_t)tx[quarters]] =
                from[(size_t)y * (size_t)old.width + (size_t)x];
        }
}

/* The most of what covers the discs around the pixels: a border of `reach` more on each side. */
static void widen(vvi_gfx_coverage *c, uint8_t *to, const uint8_t *from, int32_t reach)
{
    const int32_t width = c->width + 2 * reach, height = c->height + 2 * reach;
    memset(to, 0, (size_t)width * (size_t)height);
    for (int32_t dy = -reach; dy <= reach; dy++)
        for (int32_t dx = -reach; dx <= reach; dx++) {
            const double part = reach + 0.5 - hypot(dx, dy);
            if (part <= 0)
                continue;
            for (int32_t y = 0; y < c->height; y++)
                for (int32_t x = 0; x < c->width; x++) {
                    uint8_t *p = to + (size_t)(y + dy + reach) * (size_t)width + (size_t)(x + dx + reach);
                    const double v = from[(size_t)y * (size_t)c->width + (size_t)x] * fmin(part, 1);
                    *p = v > *p ? (uint8_t)v : *p;
                }
        }
    c->left -= reach;
    c->top -= reach;
    c->width = width;
    c->height = height;
}

static vv_status bitmap(vvi_gfx_flat **out, vvi_gfx *gfx, vvi_gfx_spot at, const vvi_gfx_coverage *c, vv_color color)
{
    spots s = {.job = gfx->job};
    const double reach = fmax(fmax(abs(c->left), abs(c->left + c->width)), fmax(abs(c->top), abs(c->top + c->height)));
    add(&s, at);
    const vv_status st = make(out, gfx, VVI_GFX_BITMAP, &s, reach + 1);
    vvi_gfx_flat *shape = *out;
    if (!shape)
        return st;
    shape->paint.color = color;
    shape->coverage = c->coverage;
    shape->left = c->left + (int32_t)floor(at.x);
    shape->top = c->top + (int32_t)floor(at.y);
    shape->width = c->width;
    shape->height = c->height;
    return st;
}

static vv_status turned_copy(vvi_gfx_coverage *c, vvi_gfx *gfx, int quarters)
{
    const size_t n = (size_t)c->width * (size_t)c->height;
    uint8_t *copy = vvi_gfx_keep(gfx, n);
    if (!copy)
        return vv_fail_memory(n);
    turn(c, copy, c->coverage, quarters & 3);
    c->coverage = copy;
    return VV_OK;
}

static vv_status halo(vvi_gfx_flat **out, vvi_gfx *gfx, vvi_gfx_spot at, const vvi_gfx_label *label, vvi_gfx_coverage c)
{
    const int32_t reach = (int32_t)vvi_gfx_halo(label);
    const size_t n = (size_t)(c.width + 2 * reach) * (size_t)(c.height + 2 * reach);
    uint8_t *wide = vvi_gfx_keep(gfx, n);
    if (!wide)
        return vv_fail_memory(n);
    widen(&c, wide, c.coverage, reach);
    c.coverage = wide;
    return bitmap(out, gfx, at, &c, label->halo);
}

/* Light is blended as it adds up, which thins dark letters: what covers half of a pixel leaves three quarters of its
 * brightness. They get the weight that people know from screens and print. */
static void embolden(vvi_gfx_coverage *c, vv_color color)
{
    const double y = 0.2126 * color.r + 0.7152 * color.g + 0.0722 * color.b, dark = fmax(0, 1 - y / 0.25);
    const size_t n = (size_t)c->width * (size_t)c->height;
    for (size_t i = 0; i < n && dark > 0; i++)
        c->coverage[i] = (uint8_t)(255 * (1 - pow(1 - c->coverage[i] / 255.0, 1 + dark)) + 0.5);
}

vv_status vvi_gfx_flat_text(vvi_gfx_flat *out[2], vvi_gfx *gfx, vv_vec3 at, const vvi_gfx_label *label,
                            const char *utf8)
{
    const vvi_gfx_font *font = gfx->target.font;
    vvi_gfx_coverage c = {0};
    vvi_gfx_spot spot;
    double x, y;
    out[0] = out[1] = NULL;
    if (!font)
        return vv_fail(VV_E_UNSUPPORTED, "text cannot be drawn: the picture was begun without a font");
    if (!vvi_gfx_spot_at(&spot, &gfx->state, at))
        return VV_OK;
    vv_status st = font->draw(font->user, &c, utf8, label->size, gfx->job);
    if (st != VV_OK || !c.width || !c.height) {
        vvi_free(c.coverage);
        return st;
    }
    uint8_t *drawn = c.coverage;
    x = label->anchor == VVI_GFX_BEGIN ? 0 : label->anchor == VVI_GFX_MIDDLE ? -0.5 * c.advance : -c.advance;
    y = vvi_gfx_base_line(label);
    for (int i = 0; i < (label->quarters & 3); i++) {
        const double old = x;
        x = y;
        y = -old;
    }
    spot.x = floor(spot.x + x + 0.5); /* whole pixels keep letters sharp */
    spot.y = floor(spot.y + y + 0.5);
    st = turned_copy(&c, gfx, label->quarters);
    vvi_free(drawn);
    if (st == VV_OK && label->halo.a > 0)
        st = halo(&out[0], gfx, spot, label, c);
    if (st == VV_OK)
        embolden(&c, label->color);
    return st == VV_OK ? bitmap(&out[1], gfx, spot, &c, label->color) : st;
}
