#include "gfx/facets.h"
#include "core/job.h"
#include <string.h>

/* Pixels around a triangle that may show it: those whose middle it misses by little. */
#define REACH 0.5
/* Pixels outside of the window that areas reach: what closes seams lies there. */
#define MARGIN 2.0
/* Sides of areas that are not cut further, pixels: where colours differ, and where the target's image hides a part. */
#define SHORT 3.0
#define SHORT_HIDDEN 4.0

enum { RUN = 4096, ROOM = 64 };

/* Seen ------------------------------------------------------------------------------------------------------------ */

static vv_vec3 vertex(const vv_mesh_info *m, uint32_t i)
{
    const float *p = m->positions + 3 * (size_t)i;
    return vvi_add(m->origin, vvi_vec((double)p[0], (double)p[1], (double)p[2]));
}

static bool is_culled(const vvi_gfx_draw *d, const vvi_gfx_spot *s)
{
    if (!d->surface.cull)
        return false;
    const double turn = (s[1].x - s[0].x) * (s[2].y - s[0].y) - (s[2].x - s[0].x) * (s[1].y - s[0].y);
    return ((turn < 0) != d->mirrored) == (d->surface.cull == VVI_GFX_NO_FRONTS); /* y is down */
}

/* A triangle on the picture, cut: number of its corners. */
static size_t outline(vvi_gfx_spot spot[ROOM], const vvi_gfx_draw *d, size_t triangle)
{
    vv_vec3 points[2 * ROOM], spare[2 * ROOM];
    const vv_mesh_info *mesh = d->surface.mesh;
    for (int k = 0; k < 3; k++) {
        points[k] = vv_affine_point(d->surface.place, vertex(mesh, mesh->triangles[3 * triangle + (size_t)k]));
        if (!vvi_finite(points[k]))
            return 0;
    }
    const size_t n = vvi_gfx_cut_convex(points, spare, 3, ROOM, &d->state);
    if (n < 3 || n > ROOM)
        return 0;
    for (size_t i = 0; i < n; i++)
        spot[i] = vvi_gfx_spot_of(d->state.view, vvi_gfx_to_eye(d->state.view, points[i]));
    return is_culled(d, spot) ? 0 : n;
}

/* The next areas of an outline that has more corners than one can have; false: there are no more. */
static bool next_facet(vvi_gfx_facet *out, size_t *at, const vvi_gfx_spot *spot, size_t n, const vvi_gfx_draw *d)
{
    const double *w = d->state.window;
    const double window[4] = {w[0] - MARGIN, w[1] - MARGIN, w[2] + MARGIN, w[3] + MARGIN};
    enum { FEW = VVI_GFX_FACET_CORNERS - 4 }; /* the window adds four */
    while (*at + 2 < n) {
        vvi_gfx_spot some[3 * VVI_GFX_FACET_CORNERS] = {spot[0]};
        const size_t m = n - *at < FEW ? n - *at : FEW;
        memcpy(some + 1, spot + *at + 1, (m - 1) * sizeof *some);
        *at += m - 2;
        const size_t left = vvi_gfx_facet_window(some, m, window);
        *out = (vvi_gfx_facet){.draw = d, .n = (uint16_t)left};
        if (left < 3 || left > VVI_GFX_FACET_CORNERS)
            continue;
        memcpy(out->spot, some, left * sizeof *some);
        if (vvi_gfx_facet_init(out))
            return true;
    }
    return false;
}

static int32_t clamped(double v, int32_t most)
{
    return v < 0 ? 0 : v > most ? most : (int32_t)v;
}

/* Whether a pixel's middle is in the area, or misses it by little. */
static bool is_near(const vvi_gfx_facet *f, double sign, double x, double y)
{
    for (size_t k = 0; k < f->n; k++) {
        const vvi_gfx_spot *a = &f->spot[k], *b = &f->spot[k + 1 < f->n ? k + 1 : 0];
        const double dx = b->x - a->x, dy = b->y - a->y, side = sign * (dx * (y - a->y) - dy * (x - a->x));
        if (side < 0 && side * side > REACH * REACH * (dx * dx + dy * dy))
            return false;
    }
    return true;
}

/* Whether there is a pixel of the area at which it lies before what the image has there (or, of pixels that have
 * something, behind it). */
static bool has_pixel(const vvi_gfx_facet *f, bool before, const vv_image *image)
{
    const vvi_gfx_view *view = f->draw->state.view;
    const vvi_gfx_spot *s = f->spot;
    double least = INFINITY, most = -INFINITY, sign = 0;
    if (f->high[0] < 0 || f->high[1] < 0 || f->low[0] > image->width || f->low[1] > image->height)
        return false;
    for (size_t k = 0; k < f->n; k++) {
        least = fmin(least, s[k].near), most = fmax(most, s[k].near);
        if (k >= 2)
            sign += (s[k - 1].x - s[0].x) * (s[k].y - s[0].y) - (s[k].x - s[0].x) * (s[k - 1].y - s[0].y);
    }
    sign = sign < 0 ? -1 : 1;
    const int32_t left = clamped(f->low[0] - REACH, image->width - 1),
                  right = clamped(f->high[0] + REACH, image->width - 1),
                  bottom = clamped(f->high[1] + REACH, image->height - 1);
    for (int32_t y = clamped(f->low[1] - REACH, image->height - 1); y <= bottom; y++)
        for (int32_t x = left; x <= right; x++) {
            const double px = x + 0.5, py = y + 0.5;
            if (!is_near(f, sign, px, py))
                continue;
            const double there = (double)image->depth[(size_t)y * (size_t)image->width + (size_t)x],
                         near = fmin(fmax(vvi_gfx_facet_near(f, px, py), least), most);
            if (vvi_gfx_is_before(view, vvi_gfx_depth_of(view, px, py, near), there) == before &&
                (before || isfinite(there)))
                return true;
        }
    return false;
}

static bool is_seen(const vvi_gfx_facet *f, const vvi_gfx *gfx)
{
    const vv_image *hiding = gfx->target.hiding ? gfx->target.hiding : gfx->target.image;
    return !hiding || !hiding->depth || has_pixel(f, true, hiding);
}

/* Taking down ----------------------------------------------------------------------------------------------------- */

typedef struct looking {
    const vvi_gfx *gfx;
    const vvi_gfx_draw *draw;
    uint8_t *seen; /* of each triangle */
} looking;

static vv_status look_at_run(void *scratch, void *shared, size_t index)
{
    const looking *l = shared;
    const vv_mesh_info *m = l->draw->surface.mesh;
    const size_t begin = index * RUN, end = m->n_triangles - begin < RUN ? m->n_triangles : begin + RUN;
    vvi_gfx_spot spot[ROOM];
    vvi_gfx_facet f;
    (void)scratch;
    for (size_t i = begin; i < end; i++) {
        for (size_t k = 3 * i; k < 3 * i + 3; k++)
            if (m->triangles[k] >= m->n_vertices)
                return vv_fail(VV_E_ARGUMENT, "triangle %zu uses vertex %u of a mesh of %zu vertices", i,
                               m->triangles[k], m->n_vertices);
        const size_t n = outline(spot, l->draw, i);
        for (size_t at = 0; !l->seen[i] && next_facet(&f, &at, spot, n, l->draw);)
            l->seen[i] = is_seen(&f, l->gfx);
    }
    return vvi_job_poll(l->gfx->job);
}

static vv_status too_many(size_t n, size_t most)
{
    return vv_fail(VV_E_LIMIT,
                   "%zu triangles are seen, too many for a figure, which has at most %zu: use fewer ('volvis "
                   "simplify', method reduced or boxes with fewer triangles), or write PNG",
                   n, most);
}

vv_status vvi_gfx_facets_grow(vvi_gfx_facets *f, size_t n, vv_job *job)
{
    if (n <= f->room - f->n)
        return VV_OK;
    const size_t room = f->n + n > 2 * f->room ? f->n + n : 2 * f->room;
    vvi_gfx_facet *more = vvi_realloc(job, f->facet, room * sizeof *more, VVI_MEM_SCRATCH);
    if (!more)
        return vv_fail_memory(room * sizeof *more);
    f->facet = more;
    f->room = room;
    return VV_OK;
}

static vv_color light_at(const vvi_gfx_facet *f, double x, double y)
{
    vvi_gfx_fragment fragment = {.triangle = f->triangle, .x = (float)x, .y = (float)y};
    vvi_gfx_shade_ref(&fragment, f->draw);
    const float *c = fragment.rgba;
    return (vv_color){(double)c[0], (double)c[1], (double)c[2], (double)c[3]};
}

static double unlike(vv_color a, vv_color b)
{
    const double from[4] = {a.r, a.g, a.b, a.a}, to[4] = {b.r, b.g, b.b, b.a};
    double most = 255 * fabs(a.a - b.a);
    for (int c = 0; c < 3; c++)
        most =
            fmax(most, 255 * fabs(vv_srgb_encode(fmin(1, fmax(0, from[c]))) - vv_srgb_encode(fmin(1, fmax(0, to[c])))));
    return most;
}

/* Light in the middle, and how far that of the corners differs, and of the sides' middles. */
static void light_up(vvi_gfx_facet *f)
{
    const vvi_gfx_spot middle = vvi_gfx_facet_middle(f);
    size_t side;
    double most = 0;
    f->color = light_at(f, middle.x, middle.y);
    if (vvi_gfx_facet_longest(&side, f) > SHORT)
        for (size_t i = 0; i < f->n; i++) {
            const vvi_gfx_spot a = f->spot[i], b = vvi_gfx_between(a, f->spot[i + 1 < f->n ? i + 1 : 0], 0.5);
            most = fmax(most, fmax(unlike(f->color, light_at(f, a.x, a.y)), unlike(f->color, light_at(f, b.x, b.y))));
        }
    f->error = (float)most;
}

static vv_status add_seen(vvi_gfx_facets *out, vvi_gfx *gfx, const vvi_gfx_draw *draw, size_t triangle)
{
    vvi_gfx_spot spot[ROOM];
    vvi_gfx_facet f;
    vv_status st = VV_OK;
    const size_t n = outline(spot, draw, triangle);
    for (size_t at = 0; st == VV_OK && next_facet(&f, &at, spot, n, draw);) {
        if (!is_seen(&f, gfx) || (st = vvi_gfx_facets_grow(out, 1, gfx->job)) != VV_OK)
            continue;
        f.triangle = (uint32_t)triangle;
        out->facet[out->n++] = f;
    }
    return st;
}

static vv_status add_all(vvi_gfx_facets *out, vvi_gfx *gfx, const vvi_gfx_draw *draw, const uint8_t *seen)
{
    const size_t all = draw->surface.mesh->n_triangles, most = gfx->target.triangles;
    size_t n = out->n;
    for (size_t i = 0; i < all; i++)
        n += seen[i];
    if (n > most)
        return too_many(n, most);
    vv_status st = vvi_gfx_facets_grow(out, n - out->n, gfx->job);
    for (size_t i = 0; i < all && st == VV_OK; i++)
        if (seen[i])
            st = add_seen(out, gfx, draw, i);
    return st;
}

vv_status vvi_gfx_facets_add(vvi_gfx_facets *out, vvi_gfx *gfx, const vvi_gfx_surface *surface)
{
    static const vvi_work work = {.item = look_at_run};
    const size_t n = surface->mesh->n_triangles;
    vvi_gfx_draw *draw = vvi_gfx_keep(gfx, sizeof *draw);
    looking l = {.gfx = gfx, .draw = draw, .seen = vvi_alloc_zeroed(gfx->job, n + 1, VVI_MEM_SCRATCH)};
    if (!draw || !l.seen) {
        vvi_free(l.seen);
        return vv_fail_memory(sizeof *draw + n);
    }
    *draw = (vvi_gfx_draw){.state = gfx->state,
                           .surface = *surface,
                           .mirrored = vv_affine_determinant(surface->place) < 0,
                           .to_eye = surface->place};
    draw->to_eye.origin = vvi_sub(vv_affine_point(surface->place, surface->mesh->origin), gfx->state.view->lens.eye);
    vv_status st = vvi_parallel_for(gfx->job, &work, &l, (n + RUN - 1) / RUN);
    if (st == VV_OK)
        st = add_all(out, gfx, draw, l.seen);
    vvi_free(l.seen);
    return st;
}

/* Cutting --------------------------------------------------------------------------------------------------------- */

typedef struct cutting {
    vvi_gfx_facets *facets;
    const vvi_gfx *gfx;
    const vv_image *under; /* NULL: nothing is */
    size_t most;
    float level; /* of errors that are too large */
} cutting;

static vv_status light_run(void *scratch, void *shared, size_t index)
{
    const cutting *c = shared;
    const size_t begin = index * RUN / 16, n = c->facets->n, end = n - begin < RUN / 16 ? n : begin + RUN / 16;
    (void)scratch;
    for (size_t i = begin; i < end; i++) {
        vvi_gfx_facet *f = &c->facets->facet[i];
        f->behind = c->under && has_pixel(f, false, c->under);
        light_up(f);
    }
    return vvi_job_poll(c->gfx->job);
}

/* Whether the target's image hides some of it and not the rest. */
static bool is_mixed(const vvi_gfx_facet *f, const cutting *c)
{
    size_t side;
    return f->behind && vvi_gfx_facet_longest(&side, f) > SHORT_HIDDEN && has_pixel(f, true, c->under);
}

static bool is_uneven(const vvi_gfx_facet *f, const cutting *c)
{
    size_t side;
    return f->error > c->level && vvi_gfx_facet_longest(&side, f) > SHORT;
}

static void put(vvi_gfx_facet *to, vvi_gfx_facet *f, const cutting *c)
{
    f->behind = f->behind && has_pixel(f, false, c->under);
    light_up(f);
    *to = *f;
}

/* Halves of one, those that are seen; false: there are no halves. */
static bool halve(cutting *c, size_t i)
{
    vvi_gfx_facets *all = c->facets;
    vvi_gfx_facet a, b;
    if (!vvi_gfx_facet_halve(&a, &b, &all->facet[i]))
        return false;
    const bool first = is_seen(&a, c->gfx), second = is_seen(&b, c->gfx);
    if (first && second)
        put(&all->facet[all->n++], &b, c);
    put(&all->facet[i], first || !second ? &a : &b, c);
    return true;
}

static vv_status cut_where(cutting *c, bool (*wanted)(const vvi_gfx_facet *f, const cutting *c))
{
    vvi_gfx_facets *all = c->facets;
    for (size_t i = 0; i < all->n && all->n < c->most; i++) {
        vv_status st = vvi_gfx_facets_grow(all, 1, c->gfx->job);
        while (st == VV_OK && all->n < c->most && wanted(&all->facet[i], c) && halve(c, i))
            st = vvi_gfx_facets_grow(all, 1, c->gfx->job);
        if (st == VV_OK && i % 64 == 0)
            st = vvi_job_poll(c->gfx->job);
        if (st != VV_OK)
            return st;
    }
    return VV_OK;
}

/* The largest differences first, as long as there is room. */
static vv_status cut_all(cutting *c)
{
    static const float levels[] = {64, 32, 16, 8};
    vv_status st = c->under ? cut_where(c, is_mixed) : VV_OK;
    for (size_t k = 0; k < sizeof levels / sizeof *levels && st == VV_OK && c->facets->n < c->most; k++) {
        c->level = levels[k];
        st = cut_where(c, is_uneven);
    }
    return st;
}

vv_status vvi_gfx_facets_finish(vvi_gfx_facets *facets, vvi_gfx *gfx)
{
    static const vvi_work work = {.item = light_run};
    const vv_image *image = gfx->target.image;
    const size_t most = gfx->target.triangles / 2;
    cutting c = {.facets = facets, .gfx = gfx, .under = image && image->depth ? image : NULL, .most = most};
    bool whole = true;
    vv_status st = vvi_parallel_for(gfx->job, &work, &c, (facets->n + RUN / 16 - 1) / (RUN / 16));
    if (st == VV_OK)
        st = cut_all(&c);
    if (st == VV_OK && facets->n == c.most && c.level > 8)
        vvi_log(gfx->job, VV_LOG_WARNING, "svg",
                "colours vary strongly within triangles, and more than %zu areas would be too many for a figure: some "
                "are in steps; PNG shows them correctly",
                c.most);
    if (st == VV_OK)
        st = vvi_gfx_facets_order(&whole, facets, gfx->target.triangles + most, gfx->job);
    if (st == VV_OK && !whole)
        vvi_log(
            gfx->job, VV_LOG_WARNING, "svg",
            "triangles intersect in so many places that some are painted in the wrong order; PNG shows them correctly");
    return st;
}

void vvi_gfx_facets_free(vvi_gfx_facets *facets)
{
    vvi_free(facets->facet);
}
