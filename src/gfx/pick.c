/* The nearest triangle on a ray: all of them are asked, in double precision. */
#include "core/job.h"
#include "gfx/software.h"

typedef struct ray {
    vv_vec3 start, way; /* from the eye; way has length 1 */
    vv_vec3 eye;
} ray;

typedef struct picking {
    const vvi_gfx_software_picture *picture;
    const vvi_gfx_draw *draw;
    ray ray;
    double beyond;         /* hits up to here do not count */
    vvi_gfx_picked *found; /* by run of triangles: the nearest of the run */
    const vv_job *job;
} picking;

enum { RUN = 65536 };
/* How far beyond an edge a ray still meets a triangle: so that none slips between two. */
#define SLACK 1e-10

static vv_vec3 corner(const vvi_gfx_draw *draw, uint32_t vertex)
{
    const float *p = draw->surface.mesh->positions + 3 * (size_t)vertex;
    return vv_affine_point(draw->to_eye, vvi_vec((double)p[0], (double)p[1], (double)p[2]));
}

/* Moeller & Trumbore 1997. */
static bool meets(vvi_gfx_picked *out, const ray *r, const vvi_gfx_draw *draw, uint32_t triangle)
{
    const uint32_t *index = draw->surface.mesh->triangles + 3 * (size_t)triangle;
    const vv_vec3 a = corner(draw, index[0]), e1 = vvi_sub(corner(draw, index[1]), a),
                  e2 = vvi_sub(corner(draw, index[2]), a), p = vvi_cross(r->way, e2), from = vvi_sub(r->start, a);
    const double det = vvi_dot(e1, p), u = vvi_dot(from, p) / det;
    if (!(fabs(det) > 0) || !(u >= -SLACK && u <= 1 + SLACK))
        return false;
    const vv_vec3 q = vvi_cross(from, e1);
    const double v = vvi_dot(r->way, q) / det, t = vvi_dot(e2, q) / det;
    const bool front = (det > 0) != draw->mirrored;
    if (!(v >= -SLACK && u + v <= 1 + SLACK) || !(t > 0) || (draw->surface.cull == VVI_GFX_NO_BACKS && !front) ||
        (draw->surface.cull == VVI_GFX_NO_FRONTS && front))
        return false;
    vv_vec3 n = vvi_cross(e1, e2);
    vvi_unit(&n);
    *out = (vvi_gfx_picked){.hit = true,
                            .id = draw->state.id,
                            .primitive = triangle,
                            .depth = t,
                            .world = vvi_add(vvi_add(r->start, vvi_scaled(r->way, t)), r->eye),
                            .normal = draw->mirrored ? vvi_scaled(n, -1) : n};
    return true;
}

static bool is_cut(const vvi_gfx_draw *draw, vv_vec3 world)
{
    for (size_t i = 0; i < draw->state.cuts->n_planes; i++)
        if (vvi_dot(draw->state.cuts->planes[i].normal, world) < draw->state.cuts->planes[i].offset)
            return true;
    return false;
}

static vv_status pick_run(void *scratch, void *shared, size_t index)
{
    const picking *p = shared;
    const size_t n = p->draw->surface.mesh->n_triangles, begin = index * RUN, end = begin + RUN < n ? begin + RUN : n;
    vvi_gfx_picked *best = &p->found[index], one;
    (void)scratch;
    *best = (vvi_gfx_picked){.depth = INFINITY};
    for (size_t i = begin; i < end; i++)
        if (meets(&one, &p->ray, p->draw, (uint32_t)i) && one.depth > p->beyond && one.depth < best->depth &&
            !is_cut(p->draw, one.world))
            *best = one;
    return vvi_job_poll(p->job);
}

static vv_status pick_draw(vvi_gfx_picked *out, picking *p, vv_job *job)
{
    static const vvi_work work = {.item = pick_run};
    const size_t n = (p->draw->surface.mesh->n_triangles + RUN - 1) / RUN;
    p->found = vvi_alloc(job, n * sizeof *p->found, VVI_MEM_SCRATCH);
    if (!p->found)
        return vv_fail_memory(n * sizeof *p->found);
    const vv_status st = vvi_parallel_for(job, &work, p, n);
    for (size_t i = 0; i < n && st == VV_OK; i++)
        if (p->found[i].depth < out->depth)
            *out = p->found[i];
    vvi_free(p->found);
    return st;
}

static ray ray_at(const vvi_gfx_view *view, double x, double y)
{
    const vv_lens *lens = &view->lens;
    const vv_vec3 across = vvi_add(vvi_scaled(lens->right, (x - view->middle_x) / view->scale_x),
                                   vvi_scaled(lens->up, (view->middle_y - y) / view->scale_y));
    ray r = {.way = lens->forward, .eye = lens->eye};
    if (lens->parallel)
        r.start = across;
    else
        r.way = vvi_add(lens->forward, across);
    vvi_unit(&r.way);
    return r;
}

static bool in_window(const vvi_gfx_draw *draw, double x, double y)
{
    const double *w = draw->state.window;
    return x >= w[0] && y >= w[1] && x < w[2] && y < w[3];
}

static double opacity_of(const vvi_gfx_picked *at, const vvi_gfx_draw *draw, double x, double y)
{
    vvi_gfx_fragment f = {.triangle = at->primitive, .x = (float)x, .y = (float)y};
    vvi_gfx_shade_ref(&f, draw);
    return fmin(fmax((double)f.rgba[3], 0), 1);
}

vv_status vvi_gfx_software_pick(vvi_gfx_picked *out, vvi_gfx *gfx, double x, double y, double beyond)
{
    picking p = {.picture = gfx->own, .beyond = beyond, .job = gfx->job};
    const vvi_gfx_draw *seen = NULL;
    vv_status st = VV_OK;
    for (size_t i = 0; i < p.picture->commands.n && st == VV_OK; i++) {
        p.draw = ((const vvi_gfx_command *)p.picture->commands.item[i])->draw;
        if (!p.draw || !in_window(p.draw, x, y))
            continue;
        p.ray = ray_at(p.draw->state.view, x, y);
        const double before = out->depth;
        st = pick_draw(out, &p, gfx->job);
        seen = out->depth < before ? p.draw : seen;
    }
    if (st == VV_OK && out->hit)
        out->opacity = opacity_of(out, seen, x, y);
    return st;
}
