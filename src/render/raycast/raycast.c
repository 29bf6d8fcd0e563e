/* The row of the renderer table: ray casting. */
#include "render/raycast/raycast.h"
#include "config.h"
#include "core/job.h"
#include "registry.h"
#include "render/raycast/prepare_light.h"
#include "scene/label_ids.h"
#include <math.h>
#include <string.h>

static vv_ray_value projects(const vv_object *params)
{
    const int mode = ((const vvi_raycast_params *)params)->mode;
    return !vvi_raycast_projects(mode) ? VV_PROJECTS_NOTHING
           : mode == VV_RAY_MEAN       ? VV_PROJECTS_MEAN
           : mode == VV_RAY_SUM        ? VV_PROJECTS_SUM
           : mode == VV_RAY_MINIMUM    ? VV_PROJECTS_SMALLEST
                                       : VV_PROJECTS_EXTREME;
}

static bool solid(double *lo, double *hi, const vv_scene *scene, const vv_actor *actor)
{
    const vvi_raycast_params *p = (const vvi_raycast_params *)vv_actor_params(scene, actor);
    return vvi_raycast_solid(lo, hi, p, actor);
}

/* One value of a ray has a colour and no light, and surfaces have the volume's colour. */
static bool heeds(const vv_object *params, vv_aspect aspect)
{
    const int mode = ((const vvi_raycast_params *)params)->mode;
    switch (aspect) {
    case VV_ASPECT_TRANSFER:
        return mode != VV_RAY_ISOSURFACE;
    case VV_ASPECT_OPACITY:
        return mode == VV_RAY_COMPOSITE;
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
    if (!scene->n_actors && scene->n_mesh_actors && projects(scene->params) != VV_PROJECTS_NOTHING)
        return vv_fail(VV_E_UNSUPPORTED,
                       "volumes.%s: is a mesh, and this mode shows one value of each ray; use mode=composite or "
                       "isosurface, or make a volume visible beside it",
                       scene->mesh_actors[0].look.id);
    return VV_OK;
}

/* Pixels along the side of a piece of a tile, whose rays are one batch. */
enum { PIECE = 16 };

/* What is drawn into. */
typedef struct target {
    vv_image *image;
    vv_render_counts *counts;
} target;

/* NULL: they are not asked for. */
static void copy_hit(vvi_hits *to, const vvi_hits *from, size_t i)
{
    if (!to)
        return;
    to->volume[i] = from->volume[i];
    to->value[i] = from->value[i];
    for (int a = 0; a < 3; a++) {
        to->gradient[a][i] = from->gradient[a][i];
        to->normal[a][i] = from->normal[a][i];
    }
}

/* The nearest surface of a volume along each ray, where the ray then ends. */
static void find_surfaces(vvi_sink *near, vvi_rays *rays, const vvi_raycast_state *s, vv_render_counts *counts)
{
    vvi_hits hits;
    vvi_sink other = {.hits = near->hits ? &hits : NULL};
    bool first = true;
    for (size_t v = 0; v < s->n_volumes; v++) {
        if (!s->volume[v].solid || !s->volume[v].visible)
            continue;
        vvi_sink *found = first ? near : &other;
        s->volume[v].kernel(found, &s->volume[v].ray, rays, counts);
        for (size_t i = 0; i < rays->n; i++) {
            if (!first && other.depth[i] < near->depth[i]) {
                copy_hit(near->hits, other.hits, i);
                near->depth[i] = other.depth[i];
                near->through[i] = other.through[i];
                for (int c = 0; c < 3; c++)
                    near->rgb[c][i] = other.rgb[c][i];
            }
            rays->far[i] = (double)near->depth[i];
        }
        first = false;
    }
}

static void clear(vvi_sink *sink, size_t n)
{
    memset(sink->rgb, 0, sizeof sink->rgb);
    for (size_t i = 0; i < n; i++) {
        sink->through[i] = 1;
        sink->depth[i] = INFINITY;
        if (sink->hits)
            sink->hits->volume[i] = -1;
    }
}

/* All that ends rays: the nearest of surfaces and opaque meshes. */
static void find_opaque(vvi_mesh_sink *out, vvi_rays *rays, const vvi_raycast_state *s, vv_render_counts *counts)
{
    if (s->n_surfaces)
        find_surfaces(&out->sink, rays, s, counts);
    else
        clear(&out->sink, rays->n);
    memset(out->id, 0, sizeof out->id);
    if (!s->meshes.n)
        return;
    vvi_ray_meshes_opaque(out, &s->meshes, rays);
    for (size_t i = 0; i < rays->n; i++) {
        rays->far[i] = (double)out->sink.depth[i];
        if (out->sink.hits && out->id[i])
            out->sink.hits->volume[i] = -1;
    }
}

static void put_behind(vvi_sink *front, const vvi_sink *behind, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        for (int c = 0; c < 3; c++)
            front->rgb[c][i] += front->through[i] * behind->rgb[c][i];
        front->through[i] *= behind->through[i];
        if (isfinite(front->depth[i]))
            continue;
        front->depth[i] = behind->depth[i];
        copy_hit(front->hits, behind->hits, i);
    }
}

/* What is no solid, from near to far; false: there is nothing. */
static bool draw_clouds(vvi_sink *out, const vvi_raycast_state *s, const vvi_rays *rays, vv_render_counts *counts)
{
    if (s->cloud) {
        s->cloud->kernel(out, &s->cloud->ray, rays, counts);
        return true;
    }
    if (s->blend.n_volumes == 0)
        return false;
    s->kernels->blend(out, &s->blend, rays, counts);
    return true;
}

/* Steps over a triangle to what lies behind it: by more than floats lose. */
#define BEYOND 1e-6
/* Less light than this is not followed from triangle to triangle. */
#define LEAST_THROUGH 1e-4f

/* Clouds between translucent triangles, and these: they change neither depths nor numbers, as everywhere. */
static void draw_between(vvi_sink *out, const vvi_raycast_state *s, vvi_rays *rays, vv_render_counts *counts)
{
    vvi_mesh_sink layer;
    vvi_hits hits;
    vvi_sink clouds = {.hits = out->hits ? &hits : NULL};
    double end[VVI_RAY_BATCH] = {0};
    const size_t n = rays->n;
    memcpy(end, rays->far, n * sizeof *end);
    clear(out, n);
    for (size_t met = 1; met > 0;) {
        met = vvi_ray_meshes_translucent(&layer, &s->meshes, rays);
        for (size_t i = 0; i < n; i++)
            rays->far[i] = fmin(end[i], (double)layer.sink.depth[i]);
        if (draw_clouds(&clouds, s, rays, counts))
            put_behind(out, &clouds, n);
        for (size_t i = 0; i < n; i++) {
            const double at = (double)layer.sink.depth[i];
            const bool more = isfinite(at);
            for (int c = 0; c < 3 && more; c++)
                out->rgb[c][i] += out->through[i] * layer.sink.rgb[c][i];
            out->through[i] *= more ? layer.sink.through[i] : 1;
            rays->near[i] = more && out->through[i] > LEAST_THROUGH ? at + BEYOND * at : INFINITY;
            rays->far[i] = end[i];
        }
    }
}

static void store(const target *t, const vvi_rays *rays, const vvi_sink *sink)
{
    for (size_t i = 0; i < rays->n; i++) {
        if (rays->pixel[i] < 0)
            continue;
        const size_t at = (size_t)rays->pixel[i];
        for (size_t c = 0; c < 3; c++)
            t->image->rgba[4 * at + c] = sink->rgb[c][i];
        t->image->rgba[4 * at + 3] = 1 - sink->through[i];
        if (t->image->depth)
            t->image->depth[at] = sink->depth[i];
    }
}

/* The data's value, as a label's number stands for the label. */
static float hit_value(const vvi_raycast_volume *v, float stored)
{
    if (v->ids) {
        const vvi_label_ids *ids = vvi_cached_value(v->ids);
        const size_t number = stored < 0 ? 0 : (size_t)stored;
        const vv_label_id id = number < ids->n ? ids->id[number] : 0;
        return ids->is_unsigned ? (float)(uint64_t)id : (float)id;
    }
    return (float)((double)stored * v->hold.value_scale + v->hold.value_offset);
}

/* Layers of the pixels in which a volume is what is seen. */
static void store_hits(const target *t, const vvi_raycast_state *s, const vvi_rays *rays, const vvi_hits *hits)
{
    for (size_t i = 0; i < rays->n; i++) {
        if (rays->pixel[i] < 0 || hits->volume[i] < 0)
            continue;
        const size_t at = (size_t)rays->pixel[i];
        if (t->image->id)
            t->image->id[at] = (uint32_t)hits->volume[i] + 1;
        if (t->image->value)
            t->image->value[at] = hit_value(&s->volume[hits->volume[i]], hits->value[i]);
        for (size_t c = 0; c < 3 && t->image->normal; c++)
            t->image->normal[3 * at + c] = hits->normal[c][i];
    }
}

/* Layers of the pixels in which a mesh is what is seen. */
static void store_meshes(const target *t, const vvi_rays *rays, const vvi_sink *front, const vvi_mesh_sink *opaque)
{
    for (size_t i = 0; i < rays->n; i++) {
        if (rays->pixel[i] < 0 || !opaque->id[i] || front->hits->volume[i] >= 0)
            continue;
        const size_t at = (size_t)rays->pixel[i];
        if (t->image->id)
            t->image->id[at] = opaque->id[i];
        for (size_t c = 0; c < 3 && t->image->normal; c++)
            t->image->normal[3 * at + c] = opaque->normal[c][i];
    }
}

/* One value of each ray over what lies below, as slices are blended. Where it takes half of that light or more, what is
 * seen is at its depth. */
static void put_layer(vvi_sink *below, const vvi_sink *layer, int blend, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const float through = blend == VV_SLICE_ADD ? 1 : layer->through[i];
        for (int c = 0; c < 3; c++)
            below->rgb[c][i] = layer->rgb[c][i] + through * below->rgb[c][i];
        below->through[i] *= layer->through[i];
        if (!isfinite(layer->depth[i]) || through > 0.5f)
            continue;
        below->depth[i] = layer->depth[i];
        copy_hit(below->hits, layer->hits, i);
    }
}

/* Layers are of whole rays, whatever else these meet. */
static void draw_layers(vvi_sink *below, const vvi_raycast_state *s, const vvi_rays *rays, vv_render_counts *counts)
{
    vvi_hits hits;
    vvi_sink layer = {.hits = below->hits ? &hits : NULL};
    for (size_t i = 0; i < s->n_volumes; i++) {
        const vvi_raycast_volume *v = &s->volume[i];
        if (!v->layer)
            continue;
        v->kernel(&layer, &v->ray, rays, counts);
        put_layer(below, &layer, v->actor->layer.blend, rays->n);
    }
}

/* What is opaque ends rays; clouds and what is translucent are in front of it, and layers over all. */
static void draw(const vvi_raycast_state *s, const target *t, const vvi_eye *eye, const vv_tile *piece)
{
    const bool any_opaque = s->n_surfaces || s->meshes.n;
    const bool layers = t->image->id || t->image->normal || t->image->value;
    vvi_hits front_hits, opaque_hits;
    vvi_rays rays;
    vvi_mesh_sink opaque;
    vvi_sink front;
    double near[VVI_RAY_BATCH], far[VVI_RAY_BATCH];
    opaque.sink.hits = layers ? &opaque_hits : NULL;
    front.hits = layers ? &front_hits : NULL;
    s->kernels->eye(&rays, eye, piece);
    memcpy(near, rays.near, sizeof near);
    memcpy(far, rays.far, sizeof far);
    if (any_opaque)
        find_opaque(&opaque, &rays, s, t->counts);
    if (s->meshes.translucent)
        draw_between(&front, s, &rays, t->counts);
    else if (!draw_clouds(&front, s, &rays, t->counts))
        clear(&front, rays.n);
    if (any_opaque)
        put_behind(&front, &opaque.sink, rays.n);
    if (s->n_layers) {
        memcpy(rays.near, near, sizeof near);
        memcpy(rays.far, far, sizeof far);
        draw_layers(&front, s, &rays, t->counts);
    }
    store(t, &rays, &front);
    if (layers)
        store_hits(t, s, &rays, &front_hits);
    if (layers && s->meshes.n)
        store_meshes(t, &rays, &front, &opaque);
}

/* Where samples are brought when rays ask for them, and some did not fit, all is done again, with all of the room. */
static vv_status draw_bringing(const vvi_raycast_state *s, const target *t, const vvi_eye *eye, const vv_tile *piece,
                               vv_job *job)
{
    const uint64_t samples = t->counts->samples;
    bool lacking = true;
    vv_status st = VV_OK;
    for (int alone = 0; alone < 2 && lacking && st == VV_OK; alone++) {
        t->counts->samples = samples;
        vvi_bricks_enter(s->bricks, s->n_bricks, alone, job);
        draw(s, t, eye, piece);
        st = vvi_bricks_leave(&lacking, s->bricks, s->n_bricks);
    }
    if (st == VV_OK && lacking)
        return vv_fail(VV_E_LIMIT,
                       "the parts of the data that %d x %d pixels show do not fit in memory together; raise "
                       "the limit (--memory), or reduce the data",
                       piece->x1 - piece->x0, piece->y1 - piece->y0);
    return st;
}

static uint64_t pixels(const vv_tile *tile)
{
    return (uint64_t)(tile->x1 - tile->x0) * (uint64_t)(tile->y1 - tile->y0);
}

/* Where rays have very many steps some milliseconds' worth of pixels, so that a stop is heard. */
static int32_t piece_size(const vvi_raycast_state *s)
{
    float steps = 0;
    for (size_t i = 0; i < s->n_volumes; i++)
        steps += s->volume[i].ray.steps;
    return steps > 16384 ? 4 : PIECE;
}

static bool any_visible(const vvi_raycast_state *s)
{
    if (s->meshes.n)
        return true;
    for (size_t i = 0; i < s->n_volumes; i++)
        if (s->volume[i].visible)
            return true;
    return false;
}

static vv_status render(void *state, const vv_pass *pass, const vv_tile *tile, vv_image *image,
                        vv_render_counts *counts, vv_job *job)
{
    const vvi_raycast_state *s = state;
    counts->rays += pixels(tile);
    if (!any_visible(s))
        return VV_OK; /* the image begins clear */
    const int32_t size = piece_size(s);
    const target t = {image, counts};
    vvi_eye eye = s->eye;
    eye.x = pass->x;
    eye.y = pass->y;
    eye.stride = pass->stride;
    eye.top = pass->top;
    eye.row = image->width;
    eye.seed = pass->number;
    for (int32_t y = tile->y0; y < tile->y1; y += size)
        for (int32_t x = tile->x0; x < tile->x1; x += size) {
            const vv_tile piece = {x, y, x + size < tile->x1 ? x + size : tile->x1,
                                   y + size < tile->y1 ? y + size : tile->y1};
            vv_status st = vvi_job_poll(job);
            if (st != VV_OK)
                return st;
            if (s->n_bricks && (st = draw_bringing(s, &t, &eye, &piece, job)) != VV_OK)
                return st;
            if (!s->n_bricks)
                draw(s, &t, &eye, &piece);
        }
    return VV_OK;
}

/* Least and largest values by cells: a twentieth of the samples, and never nothing; coefficients of cubic splines; the
 * light volume, of all lamps that it takes. */
static uint64_t memory(const vv_object *params, const vv_volume *volume, const vv_field_info *info)
{
    const uint64_t n = (uint64_t)info->grid.dims[0] * (uint64_t)info->grid.dims[1] * (uint64_t)info->grid.dims[2];
    const vvi_lighting lighting = vvi_raycast_lighting_of((const vvi_raycast_params *)params);
    uint64_t bytes = 0;
    if (vv_field_info_bytes(&bytes, info) != VV_OK)
        return 0;
    return bytes / 20 + (2 << 20) + (volume->interpolation == VV_INTERPOLATE_CUBIC ? n * sizeof(float) : 0) +
           vvi_raycast_light_bytes(&info->grid, lighting);
}

const vv_renderer vvi_renderer_raycast = {
    .api = VV_RENDERER_API,
    .name = "raycast",
    .label = "Ray casting",
    .doc = "ray casting with space skipping: light through clouds, projections to one value per ray, surfaces, meshes "
           "among them; local light, with shadows and ambient occlusion where they are asked for",
    .params = &vvi_raycast_class,
    .takes = VV_CONTENT_SAMPLES | (VV_HAVE_EMBREE ? VV_CONTENT_MESHES : 0),
    .best_for = VV_CONTENT_SAMPLES | (VV_HAVE_EMBREE ? VV_CONTENT_MESHES : 0),
    .can = VV_CAN_LAYERS,
    .accepts = accepts,
    .prepare = vvi_raycast_prepare,
    .render = render,
    .finish = vvi_raycast_finish,
    .projects = projects,
    .solid = solid,
    .heeds = heeds,
    .memory = memory,
};
