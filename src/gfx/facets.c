#include "gfx/facets.h"
#include "core/job.h"
#include "gfx/raster.h"
#include <stdlib.h>
#include <string.h>

enum { POLL = 4096 };

/* Pixels around a triangle that may show it: those whose middle it misses by little. */
#define REACH 0.5

/* A triangle on the picture: its corners, or none where one is behind the eye or cut away. */
typedef struct triangle {
    vv_vec3 world[3];
    vvi_gfx_spot spot[3];
    bool whole;
} triangle;

static vv_vec3 vertex(const vv_mesh_info *m, uint32_t i)
{
    const float *p = m->positions + 3 * (size_t)i;
    return vvi_add(m->origin, vvi_vec((double)p[0], (double)p[1], (double)p[2]));
}

static bool read_triangle(triangle *out, const vvi_gfx *gfx, const vvi_gfx_surface *s, size_t index)
{
    out->whole = true;
    for (int k = 0; k < 3; k++) {
        out->world[k] = vv_affine_point(s->place, vertex(s->mesh, s->mesh->triangles[3 * index + (size_t)k]));
        if (!vvi_finite(out->world[k]))
            return false;
        out->whole = vvi_gfx_spot_at(&out->spot[k], &gfx->state, out->world[k]) && out->whole;
    }
    return true;
}

static int32_t clamped(double v, int32_t most)
{
    return v < 0 ? 0 : v > most ? most : (int32_t)v;
}

/* Nearness of a triangle's plane, which is linear on the picture, held between its corners' own. */
typedef struct plane {
    double x, y, at, along_x, along_y, least, most;
} plane;

static plane plane_of(const vvi_gfx_spot s[3])
{
    const double x1 = s[1].x - s[0].x, y1 = s[1].y - s[0].y, x2 = s[2].x - s[0].x, y2 = s[2].y - s[0].y;
    const double n1 = s[1].near - s[0].near, n2 = s[2].near - s[0].near, area = x1 * y2 - x2 * y1;
    plane p = {.x = s[0].x, .y = s[0].y, .at = s[0].near};
    p.least = fmin(s[0].near, fmin(s[1].near, s[2].near));
    p.most = fmax(s[0].near, fmax(s[1].near, s[2].near));
    if (fabs(area) > 1e-12) {
        p.along_x = (n1 * y2 - n2 * y1) / area;
        p.along_y = (x1 * n2 - x2 * n1) / area;
    }
    return p;
}

static double near_at(const plane *p, double x, double y)
{
    return fmin(fmax(p->at + (x - p->x) * p->along_x + (y - p->y) * p->along_y, p->least), p->most);
}

/* Whether a pixel's middle is in the triangle, or misses it by little. */
static bool is_near(const vvi_gfx_spot s[3], double x, double y)
{
    const double area = (s[1].x - s[0].x) * (s[2].y - s[0].y) - (s[2].x - s[0].x) * (s[1].y - s[0].y);
    for (int k = 0; k < 3; k++) {
        const vvi_gfx_spot *a = &s[k], *b = &s[(k + 1) % 3];
        const double dx = b->x - a->x, dy = b->y - a->y, side = dx * (y - a->y) - dy * (x - a->x);
        if ((area < 0 ? -side : side) < -REACH * hypot(dx, dy))
            return false;
    }
    return true;
}

/* Whether there is a pixel of the triangle at which it lies before what the image has there (or, of pixels that have
 * something, behind it). */
static bool has_pixel(const triangle *t, bool before, const vvi_gfx_view *view, const vv_image *image)
{
    double x0 = INFINITY, x1 = -INFINITY, y0 = INFINITY, y1 = -INFINITY;
    for (int k = 0; k < 3; k++) {
        x0 = fmin(x0, t->spot[k].x), x1 = fmax(x1, t->spot[k].x);
        y0 = fmin(y0, t->spot[k].y), y1 = fmax(y1, t->spot[k].y);
    }
    if (x1 < 0 || y1 < 0 || x0 > image->width || y0 > image->height)
        return false;
    const plane p = plane_of(t->spot);
    const int32_t left = clamped(x0 - REACH, image->width - 1), right = clamped(x1 + REACH, image->width - 1),
                  bottom = clamped(y1 + REACH, image->height - 1);
    for (int32_t y = clamped(y0 - REACH, image->height - 1); y <= bottom; y++)
        for (int32_t x = left; x <= right; x++) {
            const double there = (double)image->depth[(size_t)y * (size_t)image->width + (size_t)x];
            const double depth = vvi_gfx_depth_of(view, x + 0.5, y + 0.5, near_at(&p, x + 0.5, y + 0.5));
            if (is_near(t->spot, x + 0.5, y + 0.5) && vvi_gfx_is_before(view, depth, there) == before &&
                (before || isfinite(there)))
                return true;
        }
    return false;
}

static vvi_gfx_draw draw_of(const vvi_gfx *gfx, const vvi_gfx_surface *s)
{
    vvi_gfx_draw d = {
        .state = gfx->state, .surface = *s, .mirrored = vv_affine_determinant(s->place) < 0, .to_eye = s->place};
    d.to_eye.origin = vvi_sub(vv_affine_point(s->place, s->mesh->origin), gfx->state.view->lens.eye);
    return d;
}

/* Light in the middle of what is seen of it. */
static void light_up(vvi_gfx_facet *out, const vvi_gfx_draw *draw, uint32_t number)
{
    double x = 0, y = 0;
    const vvi_gfx_shape *s = out->shape;
    for (size_t i = 0; i < s->n_spots; i++) {
        x += s->spots[i].x;
        y += s->spots[i].y;
        out->near += s->spots[i].near;
    }
    const double n = (double)s->n_spots;
    vvi_gfx_fragment f = {.triangle = number, .x = (float)(x / n), .y = (float)(y / n)};
    vvi_gfx_shade_ref(&f, draw);
    out->near /= n;
    out->color = (vv_color){(double)f.rgba[0], (double)f.rgba[1], (double)f.rgba[2], (double)f.rgba[3]};
}

static vv_status grow(vvi_gfx_facets *f, vvi_gfx *gfx)
{
    const size_t room = f->room ? 2 * f->room : 1024;
    if (f->n == gfx->target.triangles)
        return vv_fail(VV_E_LIMIT,
                       "more than %zu triangles are seen, too many for a figure: take fewer ('volvis simplify', method "
                       "reduced or boxes with fewer triangles), or write PNG",
                       gfx->target.triangles);
    if (f->n < f->room)
        return VV_OK;
    vvi_gfx_facet *more = vvi_alloc(gfx->job, room * sizeof *more, VVI_MEM_SCRATCH);
    if (!more)
        return vv_fail_memory(room * sizeof *more);
    if (f->n)
        memcpy(more, f->facet, f->n * sizeof *more);
    vvi_free(f->facet);
    f->facet = more;
    f->room = room;
    return VV_OK;
}

static bool is_culled(const triangle *t, const vvi_gfx_surface *s, const vvi_gfx_draw *draw)
{
    if (!s->cull || !t->whole)
        return false;
    const double turn = (t->spot[1].x - t->spot[0].x) * (t->spot[2].y - t->spot[0].y) -
                        (t->spot[2].x - t->spot[0].x) * (t->spot[1].y - t->spot[0].y);
    return ((turn < 0) != draw->mirrored) == (s->cull == VVI_GFX_NO_FRONTS); /* y is down */
}

static vv_status add_one(vvi_gfx_facets *out, vvi_gfx *gfx, const vvi_gfx_draw *draw, size_t index)
{
    const vv_image *hiding = gfx->target.hiding ? gfx->target.hiding : gfx->target.image;
    const vv_image *under = gfx->target.image;
    vvi_gfx_shape *shape;
    triangle t;
    if (!read_triangle(&t, gfx, &draw->surface, index) || is_culled(&t, &draw->surface, draw) ||
        (t.whole && hiding && hiding->depth && !has_pixel(&t, true, gfx->state.view, hiding)))
        return VV_OK;
    vv_status st = vvi_gfx_shape_polygon(&shape, gfx, t.world, 3, &(vvi_gfx_fill){0});
    if (st != VV_OK || !shape || (st = grow(out, gfx)) != VV_OK)
        return st;
    vvi_gfx_facet *f = &out->facet[out->n];
    *f = (vvi_gfx_facet){.shape = shape, .number = out->n};
    f->behind = t.whole && under && under->depth && has_pixel(&t, false, gfx->state.view, under);
    light_up(f, draw, (uint32_t)index);
    out->n++;
    return VV_OK;
}

vv_status vvi_gfx_facets_add(vvi_gfx_facets *out, vvi_gfx *gfx, const vvi_gfx_surface *surface)
{
    const vvi_gfx_draw draw = draw_of(gfx, surface);
    const vv_mesh_info *m = surface->mesh;
    vv_status st = VV_OK;
    for (size_t i = 0; i < 3 * m->n_triangles; i++)
        if (m->triangles[i] >= m->n_vertices)
            return vv_fail(VV_E_ARGUMENT, "triangle %zu names vertex %u of a mesh of %zu vertices", i / 3,
                           m->triangles[i], m->n_vertices);
    for (size_t i = 0; i < m->n_triangles && st == VV_OK; i++) {
        st = add_one(out, gfx, &draw, i);
        if (st == VV_OK && i % POLL == 0)
            st = vvi_job_poll(gfx->job);
    }
    return st;
}

static int by_depth(const void *a, const void *b)
{
    const vvi_gfx_facet *x = a, *y = b;
    if (x->near != y->near)
        return x->near < y->near ? -1 : 1;
    return (x->number > y->number) - (x->number < y->number);
}

void vvi_gfx_facets_sort(vvi_gfx_facets *facets)
{
    if (facets->n)
        qsort(facets->facet, facets->n, sizeof *facets->facet, by_depth);
}

void vvi_gfx_facets_free(vvi_gfx_facets *facets)
{
    vvi_free(facets->facet);
}
