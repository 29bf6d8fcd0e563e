/* Shapes in the pixels of one tile: how much of each they cover, how near they are there, and the blending. */
#include "gfx/flat.h"
#include <stdlib.h>
#include <string.h>

/* Lines of an area's pixel that polygons are cut into. */
#define STRIPS 16

typedef struct tile {
    const vvi_gfx_area *area;
    float cover[VVI_GFX_TILE * VVI_GFX_TILE]; /* 0 .. 1 */
    float near[VVI_GFX_TILE * VVI_GFX_TILE];
} tile;

/* Pixels of the tile from the one that holds lo to the one that holds hi. */
static void pixels(int32_t *begin, int32_t *end, double lo, double hi, int32_t from, int32_t to)
{
    *begin = lo > from ? lo < to ? (int32_t)floor(lo) : to : from;
    *end = hi < to ? hi > from ? (int32_t)ceil(hi) : from : to;
}

static float *at(float *numbers, const tile *t, int32_t x, int32_t y)
{
    return numbers + (ptrdiff_t)(y - t->area->y0) * VVI_GFX_TILE + (x - t->area->x0);
}

static void put(tile *t, int32_t x, int32_t y, double cover, double near)
{
    float *c = at(t->cover, t, x, y);
    if (cover > (double)*c) {
        *c = (float)cover;
        *at(t->near, t, x, y) = (float)near;
    }
}

/* Of a pixel whose middle is `distance` from the middle of a strip of that half width. */
static double strip_cover(double distance, double radius)
{
    return fmax(0, fmin(distance + 0.5, radius) - fmax(distance - 0.5, -radius));
}

static void cover_segment(tile *t, vvi_gfx_spot a, vvi_gfx_spot b, double radius)
{
    const double reach = radius + 1, dx = b.x - a.x, dy = b.y - a.y, length2 = dx * dx + dy * dy;
    int32_t x0, x1, y0, y1;
    pixels(&y0, &y1, fmin(a.y, b.y) - reach, fmax(a.y, b.y) + reach, t->area->y0, t->area->y1);
    pixels(&x0, &x1, fmin(a.x, b.x) - reach, fmax(a.x, b.x) + reach, t->area->x0, t->area->x1);
    for (int32_t y = y0; y < y1; y++)
        for (int32_t x = x0; x < x1; x++) {
            const double px = x + 0.5 - a.x, py = y + 0.5 - a.y;
            const double along = length2 > 0 ? fmin(1, fmax(0, (px * dx + py * dy) / length2)) : 0;
            const double d = hypot(px - along * dx, py - along * dy);
            if (d < reach)
                put(t, x, y, strip_cover(d, radius), a.near + along * (b.near - a.near));
        }
}

static void cover_disc(tile *t, vvi_gfx_spot p, double radius)
{
    int32_t x0, x1, y0, y1;
    pixels(&y0, &y1, p.y - radius - 1, p.y + radius + 1, t->area->y0, t->area->y1);
    pixels(&x0, &x1, p.x - radius - 1, p.x + radius + 1, t->area->x0, t->area->x1);
    for (int32_t y = y0; y < y1; y++)
        for (int32_t x = x0; x < x1; x++)
            put(t, x, y, strip_cover(hypot(x + 0.5 - p.x, y + 0.5 - p.y), radius) * fmin(1, 2 * radius), p.near);
}

static void cover_bitmap(tile *t, const vvi_gfx_flat *s)
{
    int32_t x0, x1, y0, y1;
    pixels(&y0, &y1, s->top, (double)s->top + s->height, t->area->y0, t->area->y1);
    pixels(&x0, &x1, s->left, (double)s->left + s->width, t->area->x0, t->area->x1);
    for (int32_t y = y0; y < y1; y++)
        for (int32_t x = x0; x < x1; x++) {
            const size_t from = (size_t)(y - s->top) * (size_t)s->width + (size_t)(x - s->left);
            put(t, x, y, s->coverage[from] / 255.0, s->spots[0].near);
        }
}

/* Polygons -------------------------------------------------------------------------------------------------------- */

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Adds the part of a pixel row that is covered from x = a to b, `share` of its height. */
static void add_span(tile *t, int32_t y, double a, double b, double share)
{
    const int32_t left = t->area->x0, right = t->area->x1;
    a = fmax(a, left);
    b = fmin(b, right);
    for (int32_t x = a < b ? (int32_t)a : right; x < right && x < b; x++)
        *at(t->cover, t, x, y) += (float)(share * (fmin(b, x + 1) - fmax(a, x)));
}

/* Places where the outline crosses a horizontal line, ascending. */
static size_t crossings(double *out, const vvi_gfx_flat *s, double y)
{
    size_t n = 0;
    for (size_t i = 0; i < s->n_spots; i++) {
        const vvi_gfx_spot a = s->spots[i], b = s->spots[(i + 1) % s->n_spots];
        if ((a.y <= y) != (b.y <= y))
            out[n++] = a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x);
    }
    qsort(out, n, sizeof *out, ascending);
    return n;
}

/* near = plane[0] + plane[1] x + plane[2] y, from the area vector of the outline (Newell). */
static void plane_of(double plane[3], const vvi_gfx_flat *s)
{
    double n[3] = {0};
    const vvi_gfx_spot o = s->spots[0];
    for (size_t i = 0; i < s->n_spots; i++) {
        const vvi_gfx_spot a = s->spots[i], b = s->spots[(i + 1) % s->n_spots];
        n[0] += (a.y - b.y) * (a.near + b.near - 2 * o.near);
        n[1] += (a.near - b.near) * (a.x + b.x - 2 * o.x);
        n[2] += (a.x - b.x) * (a.y + b.y - 2 * o.y);
    }
    plane[1] = n[2] != 0 ? -n[0] / n[2] : 0;
    plane[2] = n[2] != 0 ? -n[1] / n[2] : 0;
    plane[0] = o.near - plane[1] * o.x - plane[2] * o.y;
}

static void cover_polygon(tile *t, const vvi_gfx_flat *s, double *places)
{
    int32_t y0, y1;
    double plane[3];
    pixels(&y0, &y1, s->box[1], s->box[3], t->area->y0, t->area->y1);
    plane_of(plane, s);
    for (int32_t y = y0; y < y1; y++) {
        for (int i = 0; i < STRIPS; i++) {
            const size_t n = crossings(places, s, y + (i + 0.5) / STRIPS);
            for (size_t k = 0; k + 1 < n; k += 2)
                add_span(t, y, places[k], places[k + 1], 1.0 / STRIPS);
        }
        for (int32_t x = t->area->x0; x < t->area->x1; x++)
            *at(t->near, t, x, y) = (float)(plane[0] + plane[1] * (x + 0.5) + plane[2] * (y + 0.5));
    }
}

/* Blending -------------------------------------------------------------------------------------------------------- */

vv_color vvi_gfx_stop_color(const vvi_gfx_stop *stops, size_t n_stops, double at)
{
    size_t i = 0;
    while (i < n_stops && stops[i].at < at)
        i++;
    const vvi_gfx_stop *b = &stops[i < n_stops ? i : n_stops - 1], *a = &stops[i ? i - 1 : 0];
    const double f = i == 0 || b->at <= a->at ? 1 : fmin(1, (at - a->at) / (b->at - a->at));
    const double wa = (1 - f) * a->color.a, wb = f * b->color.a, alpha = wa + wb;
    const double sa = alpha > 0 ? wa / alpha : 1 - f, sb = alpha > 0 ? wb / alpha : f;
    return (vv_color){sa * a->color.r + sb * b->color.r, sa * a->color.g + sb * b->color.g,
                      sa * a->color.b + sb * b->color.b, alpha};
}

/* Premultiplied. */
static void color_at(double out[4], const vvi_gfx_paint *p, double x, double y)
{
    vv_color c = p->color;
    if (p->n_stops) {
        const double dx = p->to.x - p->from.x, dy = p->to.y - p->from.y, length2 = dx * dx + dy * dy;
        const double t = length2 > 0 ? ((x - p->from.x) * dx + (y - p->from.y) * dy) / length2 : 0;
        c = vvi_gfx_stop_color(p->stops, p->n_stops, t);
    }
    out[0] = c.r * c.a, out[1] = c.g * c.a, out[2] = c.b * c.a, out[3] = c.a;
}

bool vvi_gfx_is_before(const vvi_gfx_view *view, double depth, double there)
{
    const double pixel = (view->lens.parallel ? 1 : depth) / fmin(view->scale_x, view->scale_y);
    return depth <= there + 1.5 * pixel;
}

static void set_layers(vv_image *image, size_t i, uint32_t id)
{
    if (image->id)
        image->id[i] = id;
    if (image->value)
        image->value[i] = NAN;
    for (int c = 0; image->normal && c < 3; c++)
        image->normal[3 * i + (size_t)c] = 0;
}

static void blend_pixel(const vvi_gfx_flat *s, tile *t, int32_t x, int32_t y, vv_image *image, float *depth)
{
    const double cover = fmin(1, (double)*at(t->cover, t, x, y));
    const size_t i = (size_t)y * (size_t)image->width + (size_t)x;
    float *rgba = image->rgba + 4 * i, *there = at(depth, t, x, y);
    double color[4];
    if (!(cover > 0))
        return;
    color_at(color, &s->paint, x + 0.5, y + 0.5);
    bool over = true;
    if (s->depth) {
        const double d = vvi_gfx_depth_of(s->view, x + 0.5, y + 0.5, (double)*at(t->near, t, x, y));
        over = vvi_gfx_is_before(s->view, d, (double)*there);
        if (over && cover * color[3] >= 0.5 && d < (double)*there) {
            *there = (float)d;
            set_layers(image, i, s->id);
        }
    }
    const double under = over ? cover : cover * (1 - (double)rgba[3]), left = over ? 1 - cover * color[3] : 1;
    for (int c = 0; c < 4; c++)
        rgba[c] = (float)(left * (double)rgba[c] + under * color[c]);
}

/* How much of a pixel the shape's window leaves. */
static double window_share(const vvi_gfx_flat *s, int32_t x, int32_t y)
{
    const double *w = s->window;
    return fmax(0, fmin(w[2], x + 1) - fmax(w[0], x)) * fmax(0, fmin(w[3], y + 1) - fmax(w[1], y));
}

static void blend(const vvi_gfx_flat *s, tile *t, vv_image *image, float *depth)
{
    int32_t x0, x1, y0, y1;
    pixels(&y0, &y1, s->box[1], s->box[3], t->area->y0, t->area->y1);
    pixels(&x0, &x1, s->box[0], s->box[2], t->area->x0, t->area->x1);
    for (int32_t y = y0; y < y1; y++)
        for (int32_t x = x0; x < x1; x++) {
            *at(t->cover, t, x, y) *= (float)window_share(s, x, y);
            blend_pixel(s, t, x, y, image, depth);
        }
}

static vv_status cover_outline(tile *t, const vvi_gfx_flat *s, vv_job *job)
{
    const size_t bytes = s->n_spots * sizeof(double);
    double *places = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    if (!places)
        return vv_fail_memory(bytes);
    cover_polygon(t, s, places);
    vvi_free(places);
    return VV_OK;
}

static void cover_others(tile *t, const vvi_gfx_flat *s)
{
    if (s->kind == VVI_GFX_BITMAP)
        cover_bitmap(t, s);
    for (size_t i = 0; s->kind == VVI_GFX_SEGMENTS && i + 1 < s->n_spots; i += 2)
        cover_segment(t, s->spots[i], s->spots[i + 1], s->radius);
    for (size_t i = 0; s->kind == VVI_GFX_DISCS && i < s->n_spots; i++)
        cover_disc(t, s->spots[i], s->radius);
}

vv_status vvi_gfx_flat_draw(const vvi_gfx_flat *s, const vvi_gfx_area *area, vv_image *image, float *depth, vv_job *job)
{
    if (s->box[0] >= area->x1 || s->box[2] <= area->x0 || s->box[1] >= area->y1 || s->box[3] <= area->y0)
        return VV_OK;
    tile *t = vvi_alloc_zeroed(job, sizeof *t, VVI_MEM_SCRATCH);
    vv_status st = VV_OK;
    if (!t)
        return vv_fail_memory(sizeof *t);
    t->area = area;
    if (s->kind == VVI_GFX_OUTLINE)
        st = cover_outline(t, s, job);
    else
        cover_others(t, s);
    if (st == VV_OK)
        blend(s, t, image, depth);
    vvi_free(t);
    return st;
}
