/* Where solids are cut. A ray whose first point in a volume is inside its solid sees a flat face there, as in ray
 * casting; its edge is exact, whatever the triangles. */
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "grid/probe.h"
#include "render/common/lens.h"
#include "render/common/shade_ref.h"
#include "render/surface/surface.h"
#include <math.h>

/* One volume, ready to be asked. */
typedef struct slab {
    const vvi_surface_volume *volume;
    vv_actor lit; /* as surfaces are: the side that is seen */
    vvi_probe probe;
    vv_affine world_to_index;
    double last[3];
} slab;

typedef struct capping {
    const vv_scene *scene;
    vv_image *image;
    slab *slabs;
    size_t n_slabs;
    int side;
    uint16_t *seen; /* by pixel: which face its middle sees, 0: none */
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

static bool is_inside(const slab *s, vv_vec3 world)
{
    const vv_vec3 p = vv_affine_point(s->world_to_index, world);
    const double value = vvi_probe_value(&s->probe, (double[3]){p.x, p.y, p.z});
    return value >= s->volume->lo && value <= s->volume->hi;
}

static bool nearest_face(face *out, const capping *c, vv_vec3 origin, vv_vec3 direction)
{
    bool found = false;
    for (size_t i = 0; i < c->n_slabs; i++) {
        face f;
        if (!enter(&f, &c->slabs[i], origin, direction) || (found && f.depth >= out->depth) ||
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
                  vvi_scaled(direction, -1), 0);
}

/* side x side rays through a pixel; what its middle sees, where that is one. */
static uint16_t cap_pixel(const capping *c, int32_t x, int32_t y, int side)
{
    const size_t at = (size_t)y * (size_t)c->image->width + (size_t)x;
    double sum[4] = {0}, depth = INFINITY;
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
    }
    for (int k = 0; k < 4; k++)
        c->image->rgba[4 * at + (size_t)k] = (float)(sum[k] / (side * side));
    if (c->image->depth)
        c->image->depth[at] = (float)depth;
    return code;
}

static vv_status cap_row(void *scratch, void *user, size_t y)
{
    const capping *c = user;
    (void)scratch;
    for (int32_t x = 0; x < c->image->width; x++)
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
    for (int32_t x = 0; x < c->image->width; x++)
        if (at_edge(c, x, (int32_t)y))
            cap_pixel(c, x, (int32_t)y, c->side);
    return vvi_job_poll(c->job);
}

static vv_status cap_all(capping *c, vv_job *job)
{
    static const vvi_work first = {.item = cap_row}, second = {.item = smooth_row};
    const size_t n = (size_t)c->image->width * (size_t)c->image->height;
    c->seen = vvi_alloc(job, n * sizeof *c->seen, VVI_MEM_SCRATCH);
    if (!c->seen)
        return vv_fail_memory(n * sizeof *c->seen);
    vv_status st = vvi_parallel_for(job, &first, c, (size_t)c->image->height);
    if (st == VV_OK && c->side > 1)
        st = vvi_parallel_for(job, &second, c, (size_t)c->image->height);
    vvi_free(c->seen);
    return st;
}

static vv_status open_slab(slab *s, const vvi_surface_volume *v, vv_job *job)
{
    const int64_t *n = vv_field_get_info(v->actor->field)->grid.dims;
    s->volume = v;
    s->lit = *v->actor;
    s->lit.two_sided = false;
    for (int a = 0; a < 3; a++)
        s->last[a] = (double)(n[a] - 1);
    if (!vv_affine_invert(&s->world_to_index, v->actor->index_to_world))
        return vv_fail(VV_E_UNSUPPORTED, "volumes.%s: has no thickness", v->actor->id);
    return vvi_probe_open(&s->probe, v->actor->field, v->actor->component, false, job);
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
        vvi_probe_close(&c.slabs[i].probe);
    vvi_free(c.slabs);
    return st;
}
