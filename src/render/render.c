/* The picture driver: one view, one renderer, and in which order rays are cast. */
#include "core/cpu.h"
#include "core/job.h"
#include "gfx/gfx.h"
#include "render/decorate/decorate.h"
#include "render/picture.h"
#include "render/pixel_value.h"
#include "scene/resolve.h"
#include <string.h>

void vv_render_options_init(vv_render_options *options, size_t size)
{
    const vv_render_options all = {.size = size};
    memcpy(options, &all, size < sizeof all ? size : sizeof all);
}

const char *vv_render_end_name(vv_render_end end)
{
    static const char *const names[] = {"", "samples", "noise", "budget", "stop"};
    return names[end];
}

/* The first pass --------------------------------------------------------------------------------------------------- */

static vv_status render_tile(vvi_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                             vv_render_counts *counts)
{
    const vv_pass pass = vvi_picture_pass(picture, 0.5, 0.5, 1, 0);
    return vvi_picture_render(picture, &pass, tile, picture->image, counts);
}

static vv_status render_all(vvi_picture *picture)
{
    return vvi_picture_loop(
        picture, &(vvi_tiles){.width = picture->image->width, .height = picture->image->height, .tile = render_tile});
}

static vv_status show_coarse(vvi_picture *picture, const vv_image *canvas, int32_t stride, int level)
{
    vv_status st = VV_OK;
    if (!picture->options->on_refined)
        return VV_OK;
    if ((st = vvi_preview_show(picture, canvas, stride)) == VV_OK && (st = vvi_picture_show(picture, NULL)) == VV_OK)
        vvi_picture_tell(picture, level, false);
    return st;
}

/* From coarse to fine, for who waits; and with squares filled in where that does. */
static vv_status render_refined(vvi_picture *picture)
{
    vv_image *canvas = NULL;
    vv_status st = vvi_preview_begin(&canvas, picture);
    if (st == VV_OK)
        st = show_coarse(picture, canvas, VVI_COARSE, 0);
    if (st == VV_OK && picture->scene->adaptive)
        st = vvi_adaptive_finish(picture, canvas);
    for (int32_t stride = VVI_COARSE; st == VV_OK && !picture->scene->adaptive && stride > 1; stride /= 2) {
        st = vvi_preview_refine(picture, canvas, stride);
        if (st == VV_OK && stride > 2)
            st = show_coarse(picture, canvas, stride / 2, 1);
    }
    if (st == VV_OK)
        st = vvi_preview_show(picture, canvas, 1);
    vv_image_release(canvas);
    return st;
}

/* All passes ------------------------------------------------------------------------------------------------------ */

/* By a renderer that makes a picture at once. */
static vv_status draw_all(vvi_picture *picture)
{
    const vv_image *image = picture->image;
    const size_t n = (size_t)image->width * (size_t)image->height;
    int64_t samples = 1;
    vv_status st = picture->scene->renderer->draw(picture->state, picture->image, picture->scene->samples, &samples,
                                                  &picture->counts, picture->job);
    for (size_t i = 0; image->samples && i < n; i++)
        image->samples[i] = (uint32_t)samples;
    picture->passes = samples;
    picture->ended_by = VV_END_SAMPLES;
    if (st == VV_OK)
        st = vvi_picture_show(picture, NULL);
    return st;
}

static vv_status cast_all(vvi_picture *picture, double start_s)
{
    const vv_scene *scene = picture->scene;
    const bool looked_at = picture->options->on_refined && !scene->renderer->plane;
    vv_status st = looked_at || scene->adaptive ? render_refined(picture) : render_all(picture);
    picture->passes = 1;
    picture->ended_by = VV_END_SAMPLES;
    if (st == VV_OK)
        st = scene->samples > 1 ? vvi_samples_add(picture, start_s) : vvi_picture_show(picture, NULL);
    return st;
}

static vv_status render_passes(vvi_picture *picture, double start_s)
{
    vv_status st = picture->scene->renderer->draw ? draw_all(picture) : cast_all(picture, start_s);
    if (st == VV_OK)
        st = vvi_layers_fill(picture->image, picture->scene, picture->job);
    if (st == VV_OK)
        vvi_picture_tell(picture, 2, true);
    return st;
}

/* A picture of nothing is rarely what was meant, and says nothing of why. */
static void warn_of_nothing(const vvi_picture *picture)
{
    if (picture->counts.covered)
        return;
    vvi_log(picture->job, VV_LOG_WARNING, "render", "%s",
            picture->scene->n_actors + picture->scene->n_mesh_actors
                ? "nothing is seen: every value is transparent, cut away or outside the view; check the transfer "
                  "function or iso value, the cuts and the camera"
                : "nothing is seen: no volume is visible");
}

static bool is_translucent(const vv_mesh_actor *shape)
{
    vv_mesh_info shown = *vv_mesh_get_info(shape->mesh);
    if (shape->parts)
        shown.parts = shape->parts;
    if (shape->colors)
        shown.colors = shape->colors;
    return vvi_gfx_is_translucent(
        &(vvi_gfx_surface){.mesh = &shown, .color.a = shape->opacity, .one_color = shape->one_color});
}

/* They are blended over what the layers tell of, which is the first opaque thing. Said once, of the first of them. */
static void warn_of_layers(const vvi_picture *picture)
{
    const vv_scene *scene = picture->scene;
    const vv_render_choice *choice = (const vv_render_choice *)(const void *)scene->view->render;
    const vv_layer_choice *layers = (const vv_layer_choice *)(const void *)choice->layers;
    size_t i = 0;
    if (!(layers->depth || layers->normal || layers->id || layers->value))
        return;
    while (i < scene->n_mesh_actors && !is_translucent(&scene->mesh_actors[i]))
        i++;
    if (i < scene->n_mesh_actors)
        vvi_log(picture->job, VV_LOG_WARNING, "render",
                "volumes.%s: is a translucent mesh: the layers hold what is seen behind such meshes; 'volvis pick' "
                "reports them too, and a colour without transparency puts them into the layers",
                scene->mesh_actors[i].look.id);
}

/* Samples that went while they were drawn were drawn as 0. */
vv_status vvi_scene_health(const vv_scene *scene)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < scene->n_actors && st == VV_OK; i++) {
        const vv_actor *actor = &scene->actors[i];
        st = vv_field_health(actor->field);
        if (st == VV_OK && actor->colors)
            st = vv_field_health(actor->colors);
        if (st != VV_OK)
            st = vv_fail_in(st, "volumes.%s", actor->id);
    }
    return st;
}

static void fill_report(vv_render_report *report, const vvi_picture *picture, double start_s)
{
    report->render_s = vvi_render_clock() - start_s;
    report->rays = picture->counts.rays;
    report->samples = picture->counts.samples;
    report->passes = picture->passes;
    report->ended_by = picture->ended_by;
}

vv_status vvi_accepts(const vv_scene *scene)
{
    const vv_renderer *renderer = scene->renderer;
    if (!renderer->render && !renderer->draw)
        return vv_fail(VV_E_UNSUPPORTED, "method '%s' draws nothing", renderer->name);
    if (scene->n_mesh_actors && !renderer->mesh_actors)
        return vv_fail(VV_E_UNSUPPORTED, "volumes.%s: is a mesh, which method '%s' does not draw; use method=surface",
                       scene->mesh_actors[0].look.id, renderer->name);
    return renderer->accepts ? renderer->accepts(scene) : VV_OK;
}

static vv_status render_scene(vv_image **out, vv_render_report *report, const vv_scene *scene,
                              const vv_render_options *options, vv_job *job)
{
    const vv_renderer *renderer = scene->renderer;
    vvi_picture picture = {.scene = scene, .options = options, .job = job, .bare = options->figure_out};
    const uint64_t n_tiles =
        ((uint64_t)scene->width + VVI_TILE - 1) / VVI_TILE * (((uint64_t)scene->height + VVI_TILE - 1) / VVI_TILE);
    vv_status st = VV_OK;
    const double start = vvi_render_clock();
    if ((st = vvi_accepts(scene)) != VV_OK || (st = vvi_decorate_check(scene)) != VV_OK)
        return st;
    if ((st = vv_image_new(&picture.image, scene->width, scene->height, scene->layers, job)) != VV_OK)
        return st;
    if (renderer->prepare && (st = renderer->prepare(&picture.state, scene, job)) != VV_OK)
        goto fail;
    picture.n_ahead = n_tiles * (uint64_t)scene->samples; /* at most: noise and time may end it before */
    const double prepared = vvi_render_clock();
    report->prepare_s += prepared - start;
    st = render_passes(&picture, prepared);
    if (st == VV_OK)
        st = vvi_scene_health(scene);
    fill_report(report, &picture, prepared);
    if (st == VV_OK && options->figure_out)
        st = vvi_picture_figure(options->figure_out, &picture);
    if (renderer->finish)
        renderer->finish(picture.state);
    if (st != VV_OK)
        goto fail;
    warn_of_nothing(&picture);
    warn_of_layers(&picture);
    *out = picture.image;
    return VV_OK;
fail:
    vv_image_release(picture.image);
    return st;
}

static const char *isa_name(const vv_job *job)
{
    const uint32_t cpu = vvi_job_cpu(job);
    return cpu & VVI_CPU_AVX512 ? "avx512" : cpu & VVI_CPU_AVX2 ? "avx2" : cpu & VVI_CPU_NEON ? "neon" : "base";
}

vv_status vv_render(vv_image **out, vv_render_report *report, vv_world *world, const char *view,
                    const vv_render_options *options, vv_job *job)
{
    vv_scene *scene = NULL;
    vv_render_report mine = {.isa = isa_name(job), .threads = vvi_job_threads(job)};
    vv_render_options all;
    const double start = vvi_render_clock();
    *out = NULL;
    vv_render_options_init(&all, sizeof all);
    if (options)
        memcpy(&all, options, options->size < sizeof all ? options->size : sizeof all);
    vv_status st = vv_scene_resolve(&scene, world, view, job);
    if (st != VV_OK)
        return st;
    mine.method = scene->renderer->name;
    mine.load_s = ((const vvi_resolved *)scene)->load_s;
    mine.prepare_s = vvi_render_clock() - start - mine.load_s;
    st = render_scene(out, &mine, scene, &all, job);
    vv_scene_release(scene);
    if (report)
        *report = mine;
    return st;
}
