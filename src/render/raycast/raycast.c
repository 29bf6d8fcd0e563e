/* The row of the renderer table: ray casting. */
#include "render/raycast/raycast.h"
#include "core/job.h"
#include "registry.h"
#include <math.h>
#include <string.h>

static vv_ray_value projects(const vv_object *params)
{
    const int mode = ((const vvi_raycast_params *)params)->mode;
    return !vvi_raycast_projects(mode) ? VV_PROJECTS_NOTHING
           : mode == VVI_RAYCAST_MEAN  ? VV_PROJECTS_MEAN
           : mode == VVI_RAYCAST_SUM   ? VV_PROJECTS_SUM
                                       : VV_PROJECTS_EXTREME;
}

static bool solid(double *lo, double *hi, const vv_scene *scene, const vv_actor *actor)
{
    const vvi_raycast_params *p = (const vvi_raycast_params *)scene->params;
    return vvi_raycast_solid(lo, hi, p, actor);
}

/* One value of a ray has a colour and no light, and surfaces have the volume's colour. */
static bool heeds(const vv_object *params, vv_aspect aspect)
{
    const int mode = ((const vvi_raycast_params *)params)->mode;
    switch (aspect) {
    case VV_ASPECT_TRANSFER:
        return mode != VVI_RAYCAST_ISOSURFACE;
    case VV_ASPECT_OPACITY:
        return mode == VVI_RAYCAST_COMPOSITE;
    case VV_ASPECT_THRESHOLD:
    case VV_ASPECT_SHADING:
    case VV_ASPECT_COLOR:
        return !vvi_raycast_projects(mode);
    case VV_ASPECT_CUTS:
    case VV_ASPECT_DIRECTION:
        return true;
    case VV_ASPECT_WINDOW:
    case VV_ASPECT_CROSS_HAIR:
        break;
    }
    return false;
}

static vv_status accepts(const vv_scene *scene)
{
    if (scene->n_actors > VVI_BLEND_VOLUMES)
        return vv_fail(
            VV_E_UNSUPPORTED,
            "volumes.%s: ray casting shows at most %d volumes at a time and %zu are visible; set visible=false on some",
            scene->actors[VVI_BLEND_VOLUMES].id, VVI_BLEND_VOLUMES, scene->n_actors);
    if (scene->n_actors > 1 && projects(scene->params) != VV_PROJECTS_NOTHING)
        return vv_fail(VV_E_UNSUPPORTED,
                       "volumes.%s: this mode shows one volume at a time and %zu are visible; set visible=false on "
                       "the others, or mode=composite",
                       scene->actors[1].id, scene->n_actors);
    return VV_OK;
}

/* The surfaces of one piece of a tile, the nearest of each pixel. */
enum { PIECE = 32 };
typedef struct surfaces {
    float rgba[PIECE * PIECE * 4], depth[PIECE * PIECE];
} surfaces;

/* One pass over one piece of a tile. */
typedef struct piece {
    const vv_pass *pass;
    vv_tile tile;
    vv_image *image;
    vv_render_counts *counts;
} piece;

static void set_pass(vvi_ray_setup *f, const piece *p)
{
    f->pixel_x = p->pass->x;
    f->pixel_y = p->pass->y;
    f->stride = p->pass->stride;
    f->row = p->image->width;
    f->jitter_seed = p->pass->number;
    f->rgba = p->image->rgba;
    f->depth = p->image->depth;
}

/* One volume's surface, the piece's first pixel at (0, 0). */
static void draw_surface(surfaces *out, const vvi_raycast_volume *v, const piece *p)
{
    vvi_ray_setup frame = v->blend.ray;
    vv_render_counts counts = {0};
    const vv_tile tile = {0, 0, p->tile.x1 - p->tile.x0, p->tile.y1 - p->tile.y0};
    set_pass(&frame, p);
    frame.pixel_x += frame.stride * p->tile.x0;
    frame.pixel_y += frame.stride * p->tile.y0;
    frame.row = PIECE;
    frame.rgba = out->rgba;
    frame.depth = out->depth;
    v->kernel(&frame, &tile, &counts);
    p->counts->samples += counts.samples;
}

static void keep_nearest(surfaces *near, const surfaces *other)
{
    for (size_t i = 0; i < (size_t)PIECE * PIECE; i++) {
        if (!(other->depth[i] < near->depth[i]))
            continue;
        near->depth[i] = other->depth[i];
        memcpy(near->rgba + 4 * i, other->rgba + 4 * i, 4 * sizeof *near->rgba);
    }
}

static void draw_surfaces(surfaces *near, const vvi_raycast_state *s, const piece *p)
{
    surfaces other;
    bool first = true;
    for (size_t i = 0; i < (size_t)PIECE * PIECE; i++)
        near->depth[i] = other.depth[i] = INFINITY;
    for (size_t i = 0; i < s->n_volumes; i++) {
        const vvi_raycast_volume *v = &s->volume[i];
        if (!v->solid || !v->visible)
            continue;
        draw_surface(first ? near : &other, v, p);
        if (!first)
            keep_nearest(near, &other);
        first = false;
    }
}

static uint64_t pixels(const vv_tile *tile)
{
    return (uint64_t)(tile->x1 - tile->x0) * (uint64_t)(tile->y1 - tile->y0);
}

static void copy_surfaces(const surfaces *near, const piece *p)
{
    const size_t width = (size_t)(p->tile.x1 - p->tile.x0);
    for (int32_t y = p->tile.y0; y < p->tile.y1; y++) {
        const size_t at = (size_t)y * (size_t)p->image->width + (size_t)p->tile.x0;
        const size_t from = (size_t)(y - p->tile.y0) * PIECE;
        memcpy(p->image->rgba + 4 * at, near->rgba + 4 * from, 4 * width * sizeof *near->rgba);
        if (p->image->depth)
            memcpy(p->image->depth + at, near->depth + from, width * sizeof *near->depth);
    }
    p->counts->rays += pixels(&p->tile);
}

static void draw_blend(const vvi_raycast_state *s, const surfaces *behind, const piece *p)
{
    vvi_blend_setup frame = s->blend;
    for (size_t i = 0; i < frame.n_volumes; i++)
        set_pass(&frame.volume[i].ray, p);
    if (behind) {
        frame.behind_rgba = behind->rgba;
        frame.behind_depth = behind->depth;
        frame.behind_x = p->tile.x0;
        frame.behind_y = p->tile.y0;
        frame.behind_row = PIECE;
    }
    frame.row = p->image->width;
    frame.rgba = p->image->rgba;
    frame.depth = p->image->depth;
    s->kernel(&frame, &p->tile, p->counts);
}

static void draw(const vvi_raycast_state *s, const piece *p)
{
    if (vvi_raycast_is_plain(s)) {
        vvi_ray_setup frame = s->volume[0].blend.ray;
        set_pass(&frame, p);
        s->volume[0].kernel(&frame, &p->tile, p->counts);
        return;
    }
    surfaces near;
    if (s->n_surfaces)
        draw_surfaces(&near, s, p);
    if (s->kernel)
        draw_blend(s, s->n_surfaces ? &near : NULL, p);
    else
        copy_surfaces(&near, p);
}

/* Pixels along the side of a piece: of rays of very many steps some milliseconds' worth, so that a stop is heard. */
static int32_t piece_size(const vvi_raycast_state *s)
{
    float steps = 0;
    for (size_t i = 0; i < s->n_volumes; i++)
        steps += s->volume[i].blend.ray.steps;
    return steps > 16384 ? 4 : steps > 2048 ? 16 : PIECE;
}

static bool any_visible(const vvi_raycast_state *s)
{
    for (size_t i = 0; i < s->n_volumes; i++)
        if (s->volume[i].visible)
            return true;
    return false;
}

static vv_status render(void *state, const vv_pass *pass, const vv_tile *tile, vv_image *image,
                        vv_render_counts *counts, vv_job *job)
{
    const vvi_raycast_state *s = state;
    if (!any_visible(s)) {
        counts->rays += pixels(tile);
        return VV_OK; /* the image begins clear */
    }
    const int32_t size = piece_size(s);
    piece p = {.pass = pass, .image = image, .counts = counts};
    for (int32_t y = tile->y0; y < tile->y1; y += size)
        for (int32_t x = tile->x0; x < tile->x1; x += size) {
            p.tile =
                (vv_tile){x, y, x + size < tile->x1 ? x + size : tile->x1, y + size < tile->y1 ? y + size : tile->y1};
            const vv_status st = vvi_job_poll(job);
            if (st != VV_OK)
                return st;
            draw(s, &p);
        }
    return VV_OK;
}

const vv_renderer vvi_renderer_raycast = {
    .api = VV_RENDERER_API,
    .name = "raycast",
    .doc = "ray casting with space skipping: light through clouds, projections to one value per ray, surfaces; local "
           "illumination",
    .params = &vvi_raycast_class,
    .accepts = accepts,
    .prepare = vvi_raycast_prepare,
    .render = render,
    .finish = vvi_raycast_finish,
    .projects = projects,
    .solid = solid,
    .heeds = heeds,
};
