/* The frame driver: one view, one renderer, and in which order rays are cast. */
#include "core/cpu.h"
#include "core/job.h"
#include "gfx/gfx.h"
#include "render/decorate/decorate.h"
#include "render/frame.h"
#include "render/sight.h"
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

static vv_status render_tile(vvi_frame *frame, void *user, const vv_tile *tile, vv_image *scratch,
                             vv_render_counts *counts)
{
    const vv_pass pass = vvi_frame_pass(frame, 0.5, 0.5, 1, 0);
    return vvi_frame_render(frame, &pass, tile, frame->image, counts);
}

static vv_status render_all(vvi_frame *frame)
{
    return vvi_frame_loop(
        frame, &(vvi_tiles){.width = frame->image->width, .height = frame->image->height, .tile = render_tile});
}

static vv_status show_coarse(vvi_frame *frame, const vv_image *canvas, int32_t stride, int level)
{
    vv_status st = VV_OK;
    if (!frame->options->on_refined)
        return VV_OK;
    if ((st = vvi_preview_show(frame, canvas, stride)) == VV_OK && (st = vvi_frame_show(frame, NULL)) == VV_OK)
        vvi_frame_tell(frame, level, false);
    return st;
}

/* From coarse to fine, for who waits; and with squares filled in where that does. */
static vv_status render_refined(vvi_frame *frame)
{
    vv_image *canvas = NULL;
    vv_status st = vvi_preview_begin(&canvas, frame);
    if (st == VV_OK)
        st = show_coarse(frame, canvas, VVI_COARSE, 0);
    if (st == VV_OK && frame->scene->adaptive)
        st = vvi_adaptive_finish(frame, canvas);
    for (int32_t stride = VVI_COARSE; st == VV_OK && !frame->scene->adaptive && stride > 1; stride /= 2) {
        st = vvi_preview_refine(frame, canvas, stride);
        if (st == VV_OK && stride > 2)
            st = show_coarse(frame, canvas, stride / 2, 1);
    }
    if (st == VV_OK)
        st = vvi_preview_show(frame, canvas, 1);
    vv_image_release(canvas);
    return st;
}

/* All passes ------------------------------------------------------------------------------------------------------ */

/* By a renderer that makes a picture at once. */
static vv_status draw_all(vvi_frame *frame)
{
    const vv_image *image = frame->image;
    const size_t n = (size_t)image->width * (size_t)image->height;
    int64_t samples = 1;
    vv_status st = frame->scene->renderer->draw(frame->state, frame->image, frame->scene->samples, &samples,
                                                &frame->counts, frame->job);
    for (size_t i = 0; image->samples && i < n; i++)
        image->samples[i] = (uint32_t)samples;
    frame->passes = samples;
    frame->ended_by = VV_END_SAMPLES;
    if (st == VV_OK)
        st = vvi_frame_show(frame, NULL);
    return st;
}

static vv_status cast_all(vvi_frame *frame, double start_s)
{
    const vv_scene *scene = frame->scene;
    const bool looked_at = frame->options->on_refined && !scene->renderer->plane;
    vv_status st = looked_at || scene->adaptive ? render_refined(frame) : render_all(frame);
    frame->passes = 1;
    frame->ended_by = VV_END_SAMPLES;
    if (st == VV_OK)
        st = scene->samples > 1 ? vvi_samples_add(frame, start_s) : vvi_frame_show(frame, NULL);
    return st;
}

static vv_status render_passes(vvi_frame *frame, double start_s)
{
    vv_status st = frame->scene->renderer->draw ? draw_all(frame) : cast_all(frame, start_s);
    if (st == VV_OK)
        st = vvi_layers_fill(frame->image, frame->scene, frame->job);
    if (st == VV_OK)
        vvi_frame_tell(frame, 2, true);
    return st;
}

/* A picture of nothing is rarely what was meant, and says nothing of why. */
static void warn_of_nothing(const vvi_frame *frame)
{
    if (frame->counts.covered)
        return;
    vvi_log(frame->job, VV_LOG_WARNING, "render", "%s",
            frame->scene->n_actors + frame->scene->n_shapes
                ? "nothing is seen: every value is transparent, cut away or outside the view; check the transfer "
                  "function or iso value, the cuts and the camera"
                : "nothing is seen: no volume is visible");
}

static bool is_translucent(const vv_shape *shape)
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
static void warn_of_layers(const vvi_frame *frame)
{
    const vv_scene *scene = frame->scene;
    const vv_render_choice *choice = (const vv_render_choice *)(const void *)scene->view->render;
    const vv_layer_choice *layers = (const vv_layer_choice *)(const void *)choice->layers;
    size_t i = 0;
    if (!(layers->depth || layers->normal || layers->id || layers->value))
        return;
    while (i < scene->n_shapes && !is_translucent(&scene->shapes[i]))
        i++;
    if (i < scene->n_shapes)
        vvi_log(frame->job, VV_LOG_WARNING, "render",
                "volumes.%s: is a translucent mesh: the layers hold what is seen behind such meshes; 'volvis pick' "
                "reports them too, and a colour without transparency puts them into the layers",
                scene->shapes[i].look.id);
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

static void fill_report(vv_render_report *report, const vvi_frame *frame, double start_s)
{
    report->render_s = vvi_render_clock() - start_s;
    report->rays = frame->counts.rays;
    report->samples = frame->counts.samples;
    report->passes = frame->passes;
    report->ended_by = frame->ended_by;
}

vv_status vvi_accepts(const vv_scene *scene)
{
    const vv_renderer *renderer = scene->renderer;
    if (!renderer->render && !renderer->draw)
        return vv_fail(VV_E_UNSUPPORTED, "method '%s' draws nothing", renderer->name);
    if (scene->n_shapes && !renderer->shapes)
        return vv_fail(VV_E_UNSUPPORTED, "volumes.%s: is a mesh, which method '%s' does not draw; use method=surface",
                       scene->shapes[0].look.id, renderer->name);
    return renderer->accepts ? renderer->accepts(scene) : VV_OK;
}

static vv_status render_scene(vv_image **out, vv_render_report *report, const vv_scene *scene,
                              const vv_render_options *options, vv_job *job)
{
    const vv_renderer *renderer = scene->renderer;
    vvi_frame frame = {.scene = scene, .options = options, .job = job, .bare = options->figure_out};
    const uint64_t n_tiles =
        ((uint64_t)scene->width + VVI_TILE - 1) / VVI_TILE * (((uint64_t)scene->height + VVI_TILE - 1) / VVI_TILE);
    vv_status st = VV_OK;
    const double start = vvi_render_clock();
    if ((st = vvi_accepts(scene)) != VV_OK || (st = vvi_decorate_check(scene)) != VV_OK)
        return st;
    if ((st = vv_image_new(&frame.image, scene->width, scene->height, scene->layers, job)) != VV_OK)
        return st;
    if (renderer->prepare && (st = renderer->prepare(&frame.state, scene, job)) != VV_OK)
        goto fail;
    frame.n_ahead = n_tiles * (uint64_t)scene->samples; /* at most: noise and time may end it before */
    const double prepared = vvi_render_clock();
    report->prepare_s += prepared - start;
    st = render_passes(&frame, prepared);
    if (st == VV_OK)
        st = vvi_scene_health(scene);
    fill_report(report, &frame, prepared);
    if (st == VV_OK && options->figure_out)
        st = vvi_frame_figure(options->figure_out, &frame);
    if (renderer->finish)
        renderer->finish(frame.state);
    if (st != VV_OK)
        goto fail;
    warn_of_nothing(&frame);
    warn_of_layers(&frame);
    *out = frame.image;
    return VV_OK;
fail:
    vv_image_release(frame.image);
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
