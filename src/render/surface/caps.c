/* Where solids are cut. A ray whose first point in a volume is inside its solid sees a flat face there, as in ray
 * casting; its edge is exact, whatever the triangles. */
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "gfx/backend.h"
#include "grid/probe.h"
#include "render/common/shade_ref.h"
#include "render/surface/surface.h"
#include "scene/lens.h"
#include <float.h>
#include <math.h>

/* What tells whether a place is on the right side of a solid's lower or upper surface. */
typedef struct border {
    vvi_probe probe;
    vv_affine world_to_index;
    double least, most;
    double slack; /* steps of the samples that triangles may be away from where the samples say */
} border;

/* lo above hi: nothing. */
typedef struct rectangle {
    double lo[2], hi[2];
} rectangle;

/* One volume, ready to be asked. */
typedef struct slab {
    const vvi_surface_volume *volume;
    vv_actor lit; /* as surfaces are: the side that is seen */
    border border[2];
    int n_borders;
    vv_affine world_to_index;
    double last[3];
    rectangle
        solid[6]; /* of lower and upper x, y, z, where rays enter: what the solid may reach, as shares of the face */
    bool unseen;  /* no ray enters where there may be a face */
} slab;

typedef struct capping {
    const vv_scene *scene;
    vv_image *image;
    slab *slabs;
    size_t n_slabs;
    int side;
    int32_t x0, y0, x1, y1; /* pixels outside see no face */
    uint16_t *seen;         /* by pixel: which face its middle sees, 0: none */
    const vv_job *job;
} capping;

typedef struct face {
    double depth;
    uint16_t code;   /* one for each face of each volume, above 0 */
    vv_vec3 inwards; /* length 1 */
    const slab *slab;
} face;

/* A half-space "at + step t >= 0" of a ray: moves its begin and its end. */
static bool keep(double *entry, double *end, double at, double step)
{
    const double t = -at / step;
    if (step > 0 && t >= *entry) {
        *entry = t > 0 ? t : 0; /* not -0 */
        return true;
    }
    if (step < 0 && t < *end)
        *end = t;
    if (step == 0 && at < 0)
        *end = -1;
    return false;
}

static void set_face(face *out, vv_vec3 inwards, int code)
{
    out->inwards = inwards;
    out->code = (uint16_t)code;
}

/* Where a ray begins to be in a volume, and the face that it goes through, whose normal may have any length; false
 * where it passes by. */
static bool enter(face *out, const slab *s, vv_vec3 origin, vv_vec3 direction)
{
    const vv_vec3 o = vv_affine_point(s->world_to_index, origin), d = vv_affine_vector(s->world_to_index, direction);
    const double from[3] = {o.x, o.y, o.z}, step[3] = {d.x, d.y, d.z};
    const vv_vec3 *m = s->world_to_index.axis;
    const vv_vec3 rows[3] = {{m[0].x, m[1].x, m[2].x}, {m[0].y, m[1].y, m[2].y}, {m[0].z, m[1].z, m[2].z}};
    double entry = 0, end = INFINITY;
    out->inwards = direction;
    out->code = 1;
    for (int a = 0; a < 3; a++) {
        if (keep(&entry, &end, from[a], step[a]))
            set_face(out, rows[a], 2 + 2 * a);
        if (keep(&entry, &end, s->last[a] - from[a], -step[a]))
            set_face(out, vvi_scaled(rows[a], -1), 3 + 2 * a);
    }
    const vv_actor *actor = s->volume->actor;
    for (size_t i = 0; i < actor->n_planes; i++) {
        const vv_plane *p = &actor->planes[i];
        if (keep(&entry, &end, vvi_dot(p->normal, origin) - p->offset, vvi_dot(p->normal, direction)))
            set_face(out, p->normal, 8 + (int)i);
    }
    out->depth = entry;
    out->slab = s;
    return entry < end;
}

static bool is_within(const border *b, const double p[3])
{
    const double value = vvi_probe_value(&b->probe, p), share = 4 * DBL_EPSILON; /* roundings of the values' scale */
    return value >= b->least - share * (fabs(b->least) + fabs(b->probe.offset)) &&
           value <= b->most + share * (fabs(b->most) + fabs(b->probe.offset));
}

/* Or nearly so: a face that stands out of its surface by little is better than a gap between them. */
static bool is_nearly_within(const border *b, vv_vec3 world)
{
    const vv_vec3 at = vv_affine_point(b->world_to_index, world);
    double p[3] = {at.x, at.y, at.z};
    bool within = is_within(b, p);
    for (int i = 0; i < 6 && b->slack > 0 && !within; i++) {
        const double way = i & 1 ? -b->slack : b->slack;
        p[i / 2] += way;
        within = is_within(b, p);
        p[i / 2] -= way;
    }
    return within;
}

static bool is_inside(const slab *s, vv_vec3 world)
{
    bool inside = true;
    for (int i = 0; i < s->n_borders && inside; i++)
        inside = is_nearly_within(&s->border[i], world);
    return inside;
}

/* Whether a place on a side of the slab is where the solid does not come to. */
static bool is_beside(const face *f, vv_vec3 world)
{
    if (f->code < 2 || f->code >= 8)
        return false;
    const slab *s = f->slab;
    const rectangle *r = &s->solid[f->code - 2];
    if (r->lo[0] > r->hi[0])
        return true;
    const vv_vec3 p = vv_affine_point(s->world_to_index, world);
    for (int a = 0; a < 2; a++) {
        const int axis = ((f->code - 2) / 2 + 1 + a) % 3;
        const double share = s->last[axis] > 0 ? (&p.x)[axis] / s->last[axis] : 0;
        if (share < r->lo[a] || share > r->hi[a])
            return true;
    }
    return false;
}

static bool nearest_face(face *out, const capping *c, vv_vec3 origin, vv_vec3 direction)
{
    bool found = false;
    for (size_t i = 0; i < c->n_slabs; i++) {
        face f;
        if (c->slabs[i].unseen || !enter(&f, &c->slabs[i], origin, direction) || (found && f.depth >= out->depth) ||
            is_beside(&f, vvi_add(origin, vvi_scaled(direction, f.depth))) ||
            !is_inside(f.slab, vvi_add(origin, vvi_scaled(direction, f.depth))))
            continue;
        *out = f;
        out->code = (uint16_t)(f.code + 256 * i);
        found = true;
    }
    if (found)
        vvi_unit(&out->inwards);
    return found;
}

static void light_face(double rgb[3], const capping *c, const face *f, vv_vec3 origin, vv_vec3 direction)
{
    const vv_actor *a = &f->slab->lit;
    const double color[3] = {(double)a->color[0], (double)a->color[1], (double)a->color[2]};
    vvi_shade_ref(rgb, c->scene, a, color, vvi_add(origin, vvi_scaled(direction, f->depth)), f->inwards,
                  vvi_scaled(direction, -1), 0, NULL);
}

/* side x side rays through a pixel; what its middle sees, where that is one. */
static uint16_t cap_pixel(const capping *c, int32_t x, int32_t y, int side)
{
    const size_t at = (size_t)y * (size_t)c->image->width + (size_t)x;
    double sum[4] = {0}, depth = INFINITY;
    vv_vec3 inwards = {0};
    uint16_t code = 0;
    for (int i = 0; i < side * side; i++) {
        const int column = i % side, row = i / side;
        const double px = x + (column + 0.5) / side, py = y + (row + 0.5) / side;
        vv_vec3 origin, direction;
        double rgb[3];
        face f;
        vvi_lens_ray(&origin, &direction, &c->scene->lens, c->scene->width, c->scene->height, px, py);
        if (!nearest_face(&f, c, origin, direction))
            continue;
        light_face(rgb, c, &f, origin, direction);
        for (int k = 0; k < 3; k++)
            sum[k] += rgb[k];
        sum[3]++;
        depth = fmin(depth, f.depth);
        code = f.code;
        inwards = f.inwards;
    }
    for (int k = 0; k < 4; k++)
        c->image->rgba[4 * at + (size_t)k] = (float)(sum[k] / (side * side));
    if (c->image->depth)
        c->image->depth[at] = (float)depth;
    if (c->image->normal && code)
        for (size_t k = 0; k < 3; k++)
            c->image->normal[3 * at + k] = -(float)(&inwards.x)[k];
    return code;
}

static vv_status cap_row(void *scratch, void *user, size_t y)
{
    const capping *c = user;
    (void)scratch;
    for (int32_t x = c->x0; x < c->x1 && (int32_t)y >= c->y0 && (int32_t)y < c->y1; x++)
        c->seen[y * (size_t)c->image->width + (size_t)x] = cap_pixel(c, x, (int32_t)y, 1);
    return vvi_job_poll(c->job);
}

/* Whether a pixel beside this one sees another face: an edge may go through it. */
static bool at_edge(const capping *c, int32_t x, int32_t y)
{
    const int32_t w = c->image->width, h = c->image->height;
    const uint16_t here = c->seen[(size_t)y * (size_t)w + (size_t)x];
    for (int32_t j = y > 0 ? y - 1 : 0; j <= y + 1 && j < h; j++)
        for (int32_t i = x > 0 ? x - 1 : 0; i <= x + 1 && i < w; i++)
            if (c->seen[(size_t)j * (size_t)w + (size_t)i] != here)
                return true;
    return false;
}

static vv_status smooth_row(void *scratch, void *user, size_t y)
{
    const capping *c = user;
    (void)scratch;
    for (int32_t x = c->x0; x < c->x1 && (int32_t)y >= c->y0 && (int32_t)y < c->y1; x++)
        if (at_edge(c, x, (int32_t)y))
            cap_pixel(c, x, (int32_t)y, c->side);
    return vvi_job_poll(c->job);
}

/* Whether rays may enter through a face: those from an eye on its other side, or those of its direction. */
static bool faces_eye(const slab *s, const vv_lens *lens, int side)
{
    const vv_vec3 e = lens->parallel ? vv_affine_vector(s->world_to_index, vvi_scaled(lens->forward, -1))
                                     : vv_affine_point(s->world_to_index, lens->eye);
    const double at = (&e.x)[side / 2];
    return side & 1 ? at > (lens->parallel ? 0 : s->last[side / 2]) : at < 0;
}

/* Whether rays may begin inside of a slab. */
static bool holds_eye(const slab *s, const vv_lens *lens)
{
    const vv_actor *actor = s->volume->actor;
    for (int corner = 0; corner < 8 && lens->parallel; corner++) {
        const int64_t *n = vv_field_get_info(actor->field)->grid.dims;
        const vv_vec3 p = {corner & 1 ? (double)n[0] : -1, corner & 2 ? (double)n[1] : -1,
                           corner & 4 ? (double)n[2] : -1};
        if (vvi_dot(vvi_sub(vv_affine_point(actor->index_to_world, p), lens->eye), lens->forward) <= 0)
            return true;
    }
    const vv_vec3 e = vv_affine_point(s->world_to_index, lens->eye);
    return !lens->parallel && e.x >= 0 && e.y >= 0 && e.z >= 0 && e.x <= s->last[0] && e.y <= s->last[1] &&
           e.z <= s->last[2];
}

static bool is_cut_open(const slab *s, const vv_lens *lens)
{
    const vv_actor *actor = s->volume->actor;
    bool open = false;
    for (size_t i = 0; i < actor->n_planes && !open; i++) {
        const vv_plane *p = &actor->planes[i];
        open = lens->parallel ? vvi_dot(p->normal, lens->forward) > 0 : vvi_dot(p->normal, lens->eye) < p->offset;
    }
    return open;
}

/* The rectangle of pixels becomes large enough for a place on a slab. */
static void include(double box[4], const slab *s, const vvi_gfx_view *view, const double p[3])
{
    vv_affine index_to_world;
    if (!vv_affine_invert(&index_to_world, s->world_to_index))
        return;
    const vv_vec3 eye = vvi_gfx_to_eye(view, vv_affine_point(index_to_world, (vv_vec3){p[0], p[1], p[2]}));
    if (!view->lens.parallel && !(eye.z > 0)) {
        box[0] = box[1] = -INFINITY;
        box[2] = box[3] = INFINITY;
        return;
    }
    const vvi_gfx_spot spot = vvi_gfx_spot_of(view, eye);
    box[0] = fmin(box[0], spot.x), box[1] = fmin(box[1], spot.y);
    box[2] = fmax(box[2], spot.x), box[3] = fmax(box[3], spot.y);
}

static void include_face(double box[4], const slab *s, const vvi_gfx_view *view, int side, const rectangle *r)
{
    for (int corner = 0; corner < 4; corner++) {
        double p[3];
        p[side / 2] = side & 1 ? s->last[side / 2] : 0;
        for (int a = 0; a < 2; a++) {
            const int axis = (side / 2 + 1 + a) % 3;
            p[axis] = fmin(1, fmax(0, corner >> a & 1 ? r->hi[a] : r->lo[a])) * s->last[axis];
        }
        include(box, s, view, p);
    }
}

/* What may see a face of a slab; false: nothing. */
static bool find_pixels(double box[4], const slab *s, const vvi_gfx_view *view)
{
    const rectangle whole = {.hi = {1, 1}};
    const bool cut = is_cut_open(s, &view->lens);
    bool some = cut;
    for (int side = 0; side < 6; side++) {
        const bool solid = s->solid[side].lo[0] <= s->solid[side].hi[0];
        if (cut || solid)
            include_face(box, s, view, side, cut ? &whole : &s->solid[side]);
        some |= solid;
    }
    if (!holds_eye(s, &view->lens))
        return some;
    box[0] = box[1] = -INFINITY;
    box[2] = box[3] = INFINITY;
    return true;
}

static int32_t pixel_of(double at, int32_t n)
{
    return (int32_t)fmin(n, fmax(0, at));
}

/* The pixels that are worked on; false: there are none. */
static bool set_pixels(capping *c)
{
    const vvi_gfx_view view = vvi_gfx_view_of(&c->scene->lens, c->image->width, c->image->height);
    double box[4] = {INFINITY, INFINITY, -INFINITY, -INFINITY};
    bool some = false;
    for (size_t i = 0; i < c->n_slabs; i++) {
        c->slabs[i].unseen = !find_pixels(box, &c->slabs[i], &view);
        some |= !c->slabs[i].unseen;
    }
    c->x0 = pixel_of(box[0] - 2, c->image->width);
    c->y0 = pixel_of(box[1] - 2, c->image->height);
    c->x1 = pixel_of(box[2] + 3, c->image->width);
    c->y1 = pixel_of(box[3] + 3, c->image->height);
    return some;
}

/* By a sample and its neighbours; samples of a face lie in the middle of boxes, or from end to end. */
static void widen(rectangle *r, double i, double j, int64_t n_i, int64_t n_j)
{
    const double at[2] = {i, j}, n[2] = {(double)n_i, (double)n_j};
    for (int a = 0; a < 2; a++) {
        r->lo[a] = fmin(r->lo[a], (at[a] - 1) / n[a]);
        r->hi[a] = fmax(r->hi[a], (at[a] + 2) / fmax(1, n[a] - 1));
    }
}

/* Item: one face of one slab. Linear between samples, values are nowhere larger or smaller than at them. Only the lower
 * side of the solid is asked, whose samples are those that the slab's faces are at. */
static vv_status look_at_face(void *scratch, void *user, size_t index)
{
    const capping *c = user;
    slab *s = &c->slabs[index / 6];
    const border *b = &s->border[s->n_borders - 1];
    const int side = (int)(index % 6), axis = side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
    const int64_t n = b->probe.dims[axis], deep = b->slack > 0 && n > 1 ? 2 : 1;
    rectangle *r = &s->solid[side];
    (void)scratch;
    *r = (rectangle){.lo = {INFINITY, INFINITY}, .hi = {-INFINITY, -INFINITY}};
    for (int64_t layer = 0; layer < deep && faces_eye(s, &c->scene->lens, side); layer++)
        for (int64_t j = 0; j < b->probe.dims[v]; j++)
            for (int64_t i = 0; i < b->probe.dims[u]; i++) {
                double p[3];
                p[axis] = (double)(side & 1 ? n - 1 - layer : layer);
                p[u] = (double)i;
                p[v] = (double)j;
                if (is_within(b, p))
                    widen(r, (double)i, (double)j, b->probe.dims[u], b->probe.dims[v]);
            }
    return vvi_job_poll(c->job);
}

static vv_status cap_all(capping *c, vv_job *job)
{
    static const vvi_work faces = {.item = look_at_face}, first = {.item = cap_row}, second = {.item = smooth_row};
    const size_t n = (size_t)c->image->width * (size_t)c->image->height;
    vv_status st = vvi_parallel_for(job, &faces, c, 6 * c->n_slabs);
    if (st != VV_OK || !set_pixels(c))
        return st;
    c->seen = vvi_alloc_zeroed(job, n * sizeof *c->seen, VVI_MEM_SCRATCH);
    if (!c->seen)
        return vv_fail_memory(n * sizeof *c->seen);
    st = vvi_parallel_for(job, &first, c, (size_t)c->image->height);
    if (st == VV_OK && c->side > 1)
        st = vvi_parallel_for(job, &second, c, (size_t)c->image->height);
    vvi_free(c->seen);
    return st;
}

static vv_status invert(vv_affine *out, const vv_affine *index_to_world, const vv_actor *actor)
{
    return vv_affine_invert(out, *index_to_world)
               ? VV_OK
               : vv_fail(VV_E_UNSUPPORTED, "volumes.%s: has no thickness", actor->id);
}

/* Of samples that a coarser surface was made of. */
static vv_status open_coarse(border *b, slab *s, const vvi_surface_model *model, int side, vv_job *job)
{
    const vv_actor *actor = s->volume->actor;
    const vv_grid *grid = &vv_field_get_info(model->samples)->grid;
    vv_affine place;
    vv_status st = vvi_surface_place(&place, actor);
    const vv_affine index_to_world = vv_affine_compose(place, grid->index_to_world);
    if (st != VV_OK || (st = invert(&b->world_to_index, &index_to_world, actor)) != VV_OK)
        return st;
    b->least = side == 0 ? model->least : -INFINITY;
    b->most = side == 1 ? model->most : INFINITY;
    if (!model->blocks) { /* triangles end where these samples do, and take four places on an edge */
        b->slack = 0.125;
        s->world_to_index = b->world_to_index;
        for (int a = 0; a < 3; a++)
            s->last[a] = (double)(grid->dims[a] - 1);
    }
    return vvi_probe_open(&b->probe, model->samples, 0, model->blocks, job);
}

/* Of the volume's own samples. */
static vv_status open_exact(border *b, const vvi_surface_volume *v, double least, double most, vv_job *job)
{
    b->least = least;
    b->most = most;
    const vv_status st = invert(&b->world_to_index, &v->actor->index_to_world, v->actor);
    return st == VV_OK ? vvi_probe_open(&b->probe, v->actor->field, v->actor->component, false, job) : st;
}

static vv_status open_slab(slab *s, const vvi_surface_volume *v, vv_job *job)
{
    const int64_t *n = vv_field_get_info(v->actor->field)->grid.dims;
    const vvi_surface_model *model[2];
    bool coarse = false;
    s->volume = v;
    s->lit = *v->actor;
    s->lit.two_sided = false;
    for (int a = 0; a < 3; a++)
        s->last[a] = (double)(n[a] - 1);
    for (int side = 0; side < 2; side++) {
        model[side] = v->model[side] ? vvi_cached_value(v->model[side]) : NULL;
        coarse |= model[side] && model[side]->samples;
    }
    vv_status st = invert(&s->world_to_index, &v->actor->index_to_world, v->actor);
    if (st == VV_OK && !coarse)
        return open_exact(&s->border[s->n_borders++], v, v->lo, v->hi, job);
    for (int side = 1; side >= 0 && st == VV_OK; side--) {
        border *b = &s->border[s->n_borders++];
        st = model[side] && model[side]->samples ? open_coarse(b, s, model[side], side, job)
             : side                              ? open_exact(b, v, -INFINITY, v->hi, job)
                                                 : open_exact(b, v, v->lo, INFINITY, job);
    }
    return st;
}

vv_status vvi_surface_caps(vv_image *image, const vvi_surface_state *state, int side, vv_job *job)
{
    capping c = {.scene = state->scene, .image = image, .side = side, .job = job};
    vv_status st = VV_OK;
    const size_t bytes = (state->n_volumes + 1) * sizeof *c.slabs;
    c.slabs = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH);
    if (!c.slabs)
        return vv_fail_memory(bytes);
    for (size_t i = 0; i < state->n_volumes && st == VV_OK; i++)
        if (state->volumes[i].border)
            st = open_slab(&c.slabs[c.n_slabs++], &state->volumes[i], job);
    if (st == VV_OK && c.n_slabs)
        st = cap_all(&c, job);
    for (size_t i = 0; i < c.n_slabs; i++)
        for (int k = 0; k < c.slabs[i].n_borders; k++)
            vvi_probe_close(&c.slabs[i].border[k].probe);
    vvi_free(c.slabs);
    return st;
}
