/* Picking: one ray for each pixel by the view's renderer, then what is at its depth. */
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "gfx/mesh_look.h"
#include "grid/label_id.h"
#include "render/common/mesh_caps.h"
#include "render/picture.h"
#include "render/pixel_value.h"
#include <math.h>
#include <string.h>
#include <volvis/pick.h>

typedef struct picking {
    const vv_scene *scene;
    void *state; /* the renderer's */
    vvi_sight sight;
    vv_image *whole; /* of renderers that make a picture at once; else NULL */
    vvi_mesh_caps caps;
    vv_picked *out;
    const vv_pixel *pixels;
    vv_job *job;
} picking;

static vv_vec3 normal_at(const vv_image *image, size_t at)
{
    const float *n = image->normal + 3 * at;
    return vvi_vec((double)n[0], (double)n[1], (double)n[2]);
}

/* What the renderer says of a pixel itself, and the data at that place: samples that are not interpolated have their
 * values to the last digit there. */
static void describe(vv_picked *out, const picking *p, const vv_image *image, size_t at)
{
    const double x = out->pixel.x + 0.5, y = out->pixel.y + 0.5;
    const bool told = p->scene->renderer->can & VV_CAN_LAYERS && image->id && image->normal && image->value;
    vvi_seen seen;
    if (told)
        vvi_sight_of(&seen, &p->sight, image->id[at], x, y, out->depth);
    else
        vvi_sight_at(&seen, &p->sight, x, y, out->depth);
    if (told && seen.actor) {
        seen.normal = normal_at(image, at);
        if (!seen.actor->nearest && seen.actor->classes.kind != VV_SEGMENT_LABELS)
            seen.value = (double)image->value[at];
    }
    out->world = seen.world;
    out->value = seen.value;
    if (!seen.actor)
        return;
    out->volume = seen.actor->id;
    out->id = seen.id;
    out->index = seen.index;
    out->gradient = seen.gradient;
    out->normal = seen.normal;
    out->labelled = seen.actor->classes.kind == VV_SEGMENT_LABELS ||
                    vv_field_get_info(seen.actor->field)->meaning == VV_MEANING_LABEL;
    if (out->labelled)
        out->label = seen.label;
    out->label_unsigned = out->labelled && vvi_label_is_unsigned(vv_field_get_info(seen.actor->field)->type);
}

static void take_pixel(vv_picked *out, const vv_image *image, size_t at)
{
    memcpy(out->rgba, image->rgba + 4 * at, sizeof out->rgba);
    out->depth = (double)image->depth[at];
    out->hit = isfinite(out->depth);
}

static vv_status pick_drawn(const picking *p, vv_picked *out)
{
    const size_t at = (size_t)out->pixel.y * (size_t)p->whole->width + (size_t)out->pixel.x;
    take_pixel(out, p->whole, at);
    if (out->hit && p->whole->id && p->whole->id[at] > p->scene->n_actors) {
        out->id = p->whole->id[at]; /* of a mesh: see describe_shapes() */
        return VV_OK;
    }
    if (out->hit)
        describe(out, p, p->whole, at);
    if (out->hit && p->whole->normal)
        out->normal = normal_at(p->whole, at);
    return VV_OK;
}

/* An image of one pixel, whose ray goes where the pass says. */
static vv_status pick_one(void *scratch, void *user, size_t index)
{
    const picking *p = user;
    const vv_pixel pixel = p->pixels[index];
    const vv_pass pass = {.x = pixel.x + 0.5, .y = pixel.y + 0.5, .stride = 1, .seed = p->scene->seed};
    vv_render_counts counts = {0};
    vv_image *image;
    vv_picked *out = &p->out[index];
    (void)scratch;
    *out = (vv_picked){.pixel = pixel, .depth = INFINITY, .value = NAN};
    if (p->whole)
        return pick_drawn(p, out);
    const unsigned told = p->scene->renderer->can & VV_CAN_LAYERS ? VV_LAYER_NORMAL | VV_LAYER_ID | VV_LAYER_VALUE : 0;
    const unsigned layers = VV_LAYER_DEPTH | told | (p->scene->n_mesh_actors ? VV_LAYER_ID : 0);
    vv_status st = vv_image_new(&image, 1, 1, layers, p->job);
    if (st != VV_OK)
        return st;
    st = p->scene->renderer->render(p->state, &pass, &(vv_tile){0, 0, 1, 1}, image, &counts, p->job);
    if (st == VV_OK)
        take_pixel(out, image, 0);
    if (st == VV_OK && image->id && image->id[0] > p->scene->n_actors)
        out->id = image->id[0]; /* of a mesh: see describe_shapes() */
    else if (st == VV_OK && out->hit)
        describe(out, p, image, 0);
    vv_image_release(image);
    return st;
}

static vv_status check_pixels(const picking *p, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const vv_pixel *at = &p->pixels[i];
        if (at->x < 0 || at->y < 0 || at->x >= p->scene->width || at->y >= p->scene->height)
            return vv_fail(VV_E_ARGUMENT, "pixel %d,%d lies outside the view, which has %d x %d, counted from 0", at->x,
                           at->y, p->scene->width, p->scene->height);
    }
    return VV_OK;
}

static vv_status draw_whole(picking *p)
{
    vv_render_counts counts = {0};
    int64_t samples;
    const unsigned layers = VV_LAYER_DEPTH | (p->scene->renderer->can & VV_CAN_NORMALS ? VV_LAYER_NORMAL : 0) |
                            (p->scene->n_mesh_actors ? VV_LAYER_ID : 0);
    const vv_status st = vv_image_new(&p->whole, p->scene->width, p->scene->height, layers, p->job);
    return st == VV_OK ? p->scene->renderer->draw(p->state, p->whole, 1, &samples, &counts, p->job) : st;
}

/* Meshes ---------------------------------------------------------------------------------------------------------- */

/* Where a ray meets a triangle, the shares of its corners: by the areas between the place and these. */
static void shares_at(double out[3], const vv_mesh_actor *shape, const vvi_gfx_picked *at)
{
    const vv_mesh_info *m = vv_mesh_get_info(shape->mesh);
    const uint32_t *v = m->triangles + 3 * (size_t)at->primitive;
    double all = 0;
    vv_vec3 side[3];
    for (int k = 0; k < 3; k++) {
        const float *p = m->positions + 3 * (size_t)v[k];
        const vv_vec3 corner = vvi_add(m->origin, vvi_vec((double)p[0], (double)p[1], (double)p[2]));
        side[k] = vvi_sub(vv_affine_point(shape->place, corner), at->world);
    }
    for (int k = 0; k < 3; k++) {
        out[k] = vvi_dot(vvi_cross(side[(k + 1) % 3], side[(k + 2) % 3]), at->normal);
        all += out[k];
    }
    for (int k = 0; k < 3; k++)
        out[k] /= all;
}

static double value_at(const vv_mesh_info *m, uint32_t triangle, const double share[3])
{
    double sum = 0;
    for (int k = 0; k < 3 && m->values; k++)
        sum += share[k] * (double)m->values[m->triangles[3 * (size_t)triangle + (size_t)k]];
    return m->values ? sum : NAN;
}

/* The one that is lit, as layers have it, towards the eye. */
static vv_vec3 normal_to(vv_vec3 way, const vv_mesh_actor *shape, const vvi_gfx_picked *at, const double share[3])
{
    vv_vec3 normal;
    if (!vvi_gfx_normal_at(&normal, vv_mesh_get_info(shape->mesh), &shape->place, at->primitive, share, false))
        normal = at->normal;
    return vvi_dot(normal, way) > 0 ? vvi_scaled(normal, -1) : normal;
}

static void name_part(vv_picked *out, const vv_mesh_info *m, uint32_t triangle)
{
    for (size_t i = 0; i < m->n_parts; i++)
        if (triangle - m->parts[i].first_triangle < m->parts[i].n_triangles)
            memcpy(out->part, m->parts[i].name, sizeof out->part);
}

/* A mesh as it is drawn: of the scene's, or after them one of their caps. */
static const vv_mesh_actor *drawn_shape(const picking *p, size_t i)
{
    const size_t n = p->scene->n_mesh_actors;
    return i < n ? &p->scene->mesh_actors[i] : &p->caps.cap[i - n].actor;
}

static void take_hit(vv_picked *out, const picking *p, const vvi_gfx_picked *at)
{
    const vv_scene *scene = p->scene;
    const size_t i = at->id - scene->n_actors - 1, n = scene->n_mesh_actors;
    const vv_mesh_actor *shape = drawn_shape(p, i);
    vv_affine to_mesh;
    double share[3];
    out->id = (uint32_t)(scene->n_actors + (i < n ? i : p->caps.cap[i - n].owner) + 1);
    out->volume = shape->look.id;
    out->is_mesh = true;
    out->triangle = i < n ? at->primitive : VV_NO_TRIANGLE;
    out->depth = at->depth;
    out->world = at->world;
    const vv_vec3 way = scene->lens.parallel ? scene->lens.forward : vvi_sub(at->world, scene->lens.eye);
    shares_at(share, shape, at);
    out->normal = normal_to(way, shape, at, share);
    out->value = value_at(vv_mesh_get_info(shape->mesh), at->primitive, share);
    if (vv_affine_invert(&to_mesh, shape->place))
        out->index = vv_affine_point(to_mesh, at->world);
    name_part(out, vv_mesh_get_info(shape->mesh), at->primitive);
}

static vv_status draw_shape(vvi_gfx *gfx, vv_mesh_info *shown, const picking *p, size_t i)
{
    const vv_mesh_actor *shape = drawn_shape(p, i);
    const vvi_gfx_surface surface = vvi_gfx_surface_of(shown, shape);
    vvi_gfx_id(gfx, (uint32_t)(p->scene->n_actors + i + 1));
    const vv_status st = vvi_gfx_cuts(gfx, shape->look.planes, shape->look.n_planes);
    return st == VV_OK ? vvi_gfx_mesh(gfx, &surface) : st;
}

/* Where half of the light is gone, of what lies before `most`; where that is nowhere, and nothing lies there, the first
 * place. Opaque ones take all of it. */
static vv_status find_half(vvi_gfx_picked *out, vvi_gfx *gfx, const vv_picked *pixel, double most)
{
    double through = 1, beyond = 0;
    vvi_gfx_picked at = {.hit = true};
    *out = (vvi_gfx_picked){0};
    while (at.hit && through > 0.5) {
        const vv_status st = vvi_gfx_pick(&at, gfx, pixel->pixel.x + 0.5, pixel->pixel.y + 0.5, beyond);
        if (st != VV_OK)
            return st;
        at.hit = at.hit && at.depth < most;
        beyond = at.depth;
        through *= at.hit ? 1 - at.opacity : 1;
        if (at.hit && at.opacity > 0 && (!out->hit || through <= 0.5))
            *out = at;
    }
    if (through > 0.5 && isfinite(most))
        out->hit = false;
    return VV_OK;
}

/* The picture says where the first opaque thing is; the ray itself, which triangles lie before it. */
static vv_status describe_shape(vv_picked *out, vvi_gfx *gfx, const picking *p)
{
    const bool mesh = out->hit && out->id > p->scene->n_actors;
    vvi_gfx_picked at;
    const vv_status st = find_half(&at, gfx, out, out->hit && !mesh ? out->depth : INFINITY);
    if (st != VV_OK || !at.hit)
        return st;
    const vv_pixel pixel = out->pixel;
    const float rgba[4] = {out->rgba[0], out->rgba[1], out->rgba[2], out->rgba[3]};
    *out = (vv_picked){.pixel = pixel, .hit = true, .value = NAN};
    memcpy(out->rgba, rgba, sizeof rgba);
    take_hit(out, p, &at);
    return VV_OK;
}

static vv_status describe_shapes(picking *p, size_t n)
{
    vvi_gfx *gfx = NULL;
    if (!p->scene->n_mesh_actors)
        return VV_OK;
    vv_status st = vvi_mesh_caps_open(&p->caps, p->scene, p->job);
    const size_t n_drawn = p->scene->n_mesh_actors + p->caps.n, bytes = (n_drawn + 1) * sizeof(vv_mesh_info);
    if (st != VV_OK)
        return st;
    vv_mesh_info *shown = vvi_alloc(p->job, bytes, VVI_MEM_SCRATCH);
    vv_image *canvas = p->whole ? vv_image_retain(p->whole) : NULL;
    if (!shown)
        st = vv_fail_memory(bytes);
    else
        st = canvas ? VV_OK : vv_image_new(&canvas, p->scene->width, p->scene->height, 0, p->job);
    if (st == VV_OK)
        st = vvi_gfx_begin(&gfx, &vvi_gfx_software, &(vvi_gfx_target){.image = canvas}, p->job);
    if (st == VV_OK)
        vvi_gfx_camera(gfx, &p->scene->lens);
    for (size_t i = 0; i < n_drawn && st == VV_OK; i++)
        st = draw_shape(gfx, &shown[i], p, i);
    for (size_t i = 0; i < n && st == VV_OK; i++)
        st = p->out[i].rgba[3] > 0 ? describe_shape(&p->out[i], gfx, p) : VV_OK;
    vvi_gfx_abandon(gfx);
    vv_image_release(canvas);
    vvi_free(shown);
    vvi_mesh_caps_close(&p->caps);
    return st;
}

static vv_status pick_scene(picking *p, size_t n)
{
    static const vvi_work work = {.item = pick_one};
    const vv_renderer *renderer = p->scene->renderer;
    vv_status st;
    if ((st = check_pixels(p, n)) != VV_OK || (st = vvi_accepts(p->scene)) != VV_OK ||
        (st = vvi_sight_open(&p->sight, p->scene, p->job)) != VV_OK)
        return st;
    if (!renderer->prepare || (st = renderer->prepare(&p->state, p->scene, p->job)) == VV_OK) {
        st = renderer->draw ? draw_whole(p) : VV_OK;
        if (st == VV_OK)
            st = vvi_parallel_for(p->job, &work, p, n);
        if (st == VV_OK)
            st = describe_shapes(p, n);
        vv_image_release(p->whole);
        if (renderer->finish)
            renderer->finish(p->state);
    }
    vvi_sight_close(&p->sight);
    return st;
}

vv_status vv_pick(vv_picked *out, const vv_pixel *pixels, size_t n, vv_world *world, const char *view, vv_job *job)
{
    vv_scene *scene = NULL;
    vv_status st = vv_scene_resolve(&scene, world, view, job);
    if (st != VV_OK)
        return st;
    st = pick_scene(&(picking){.scene = scene, .out = out, .pixels = pixels, .job = job}, n);
    if (st == VV_OK)
        st = vvi_scene_health(scene);
    vv_scene_release(scene);
    return st;
}
