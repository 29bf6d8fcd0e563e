/* The picture of `render`, written with what it was made of, and told of. */
#include "rendering.h"
#include "io/sink.h"
#include "model/contents.h"
#include "picture_notes.h"
#include "resuming.h"
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/sys/scene.h>

const vv_view *cli_rendering_view(const cli_rendering *r)
{
    return vvi_view_named(r->world, r->recipe.view);
}

/* "16 rays per pixel", "up to 37 rays a pixel, 5.3 on average, ended by noise" */
static void describe_rays(cli_rendering *r)
{
    const vv_render_report *f = &r->last;
    char *out = r->recipe.rays;
    const size_t room = sizeof r->recipe.rays;
    const double pixels = r->image ? (double)r->image->width * r->image->height : 1;
    const double mean = r->in_parts ? (double)f->passes : (double)f->rays / pixels;
    const char *by = f->ended_by == VV_END_SAMPLES ? "" : vv_render_end_name(f->ended_by);
    size_t n = (size_t)snprintf(out, room, "%" PRId64 " ray%s per pixel", f->passes, f->passes == 1 ? "" : "s");
    if (mean < 0.95 * (double)f->passes)
        n += (size_t)snprintf(out + n, room - n, " at most, %.2f on average", mean);
    if (*by)
        snprintf(out + n, room - n, ", ended by %s", by);
}

/* A picture that time or a signal ended is made again by its number of passes, not by a clock. */
static vv_status fix_passes(cli_rendering *r, vv_world **fixed)
{
    const vv_render_choice *choice = (const vv_render_choice *)(const void *)cli_rendering_view(r)->render;
    vv_object *root = &(*fixed)->base;
    char path[128], value[32];
    vv_status st;
    if (!(choice->budget > 0) && r->last.ended_by != VV_END_STOPPED)
        return VV_OK;
    snprintf(path, sizeof path, "views.%s.render.budget", r->recipe.view);
    if ((st = vv_path_unset(&root, path, NULL)) == VV_OK) {
        snprintf(path, sizeof path, "views.%s.render.samples", r->recipe.view);
        snprintf(value, sizeof value, "%" PRId64, r->last.passes);
        st = vv_path_set(&root, path, value, NULL);
    }
    *fixed = (vv_world *)(void *)root;
    return st;
}

static vv_status write_bytes(const cli_rendering *r, const void *bytes, size_t n)
{
    vv_sink *sink;
    vv_status st = vvi_sink_open(&sink, r->output, r->command->job);
    if (st != VV_OK)
        return st;
    if ((st = vvi_sink_write(sink, bytes, n)) == VV_OK)
        return vvi_sink_commit(sink);
    vvi_sink_abandon(sink);
    return st;
}

static vv_status write_to_standard(const cli_rendering *r, const vv_image_options *options)
{
    uint8_t *bytes;
    size_t n;
    vv_status st = vv_image_encode(&bytes, &n, r->suffix, r->image, options, r->command->job);
    if (st != VV_OK)
        return st;
    st = write_bytes(r, bytes, n);
    vv_image_bytes_free(bytes);
    return st;
}

/* What it is to have: the recipe is written before its pixels are made. */
static vv_status foresee_passes(cli_rendering *r)
{
    vv_scene *scene;
    const vv_status st = vv_scene_resolve(&scene, r->world, r->recipe.view, r->command->job);
    if (st != VV_OK)
        return st;
    r->last = (vv_render_report){.method = scene->renderer->name, .passes = scene->samples, .ended_by = VV_END_SAMPLES};
    vv_scene_release(scene);
    return VV_OK;
}

static vv_status make_parts(cli_rendering *r, const vv_image_options *options)
{
    const double start_s = cli_now_s();
    const vv_status st = vv_render_to_file(&r->first, r->output, r->world, r->recipe.view, options, r->command->job);
    r->last = r->first;
    r->render_s = r->first.render_s;
    r->first_s = cli_now_s() - start_s;
    return st;
}

static vv_status write_picture(cli_rendering *r, const vv_world *fixed)
{
    vv_image_options options = r->image_options;
    vv_text *text = NULL;
    size_t n = 0;
    vv_status st;
    if ((st = vvi_recipe_text(&text, &n, fixed, &r->recipe, r->output)) != VV_OK)
        return st;
    options.text = text;
    options.n_text = n;
    st = r->in_parts    ? make_parts(r, &options)
         : r->suffix[0] ? write_to_standard(r, &options)
                        : vv_image_write(r->output, r->image, &options, r->command->job);
    vv_text_free(text, n);
    return st;
}

static vv_status write_figure(const cli_rendering *r)
{
    return write_bytes(r, r->figure, strlen(r->figure));
}

vv_status cli_rendering_write(cli_rendering *r)
{
    const double start_s = cli_now_s();
    vv_world *fixed = NULL;
    vv_status st = r->in_parts ? foresee_passes(r) : VV_OK;
    if (st != VV_OK)
        return st;
    describe_rays(r);
    if ((st = vvi_recipe_fix(&fixed, r->world, r->recipe.view, r->command->job)) != VV_OK)
        return st;
    if (r->command->common->verbose)
        cli_tell_choices(r->command, fixed, r->recipe.view, r->last.method);
    if ((st = fix_passes(r, &fixed)) == VV_OK &&
        (st = r->is_figure ? write_figure(r) : write_picture(r, fixed)) == VV_OK && r->options->save_scene)
        st = vv_scene_write(r->options->save_scene, fixed, r->command->job);
    vv_object_release(&fixed->base);
    if (st == VV_OK)
        cli_resuming_end(r);
    r->write_s = cli_now_s() - start_s - (r->in_parts ? r->first.prepare_s + r->render_s : 0);
    return st;
}

/* Each layer and the file that it is in. */
static void report_layers(const cli_rendering *r)
{
    vvi_result *json = &r->command->json;
    const unsigned layers = r->image_options.layers;
    if (!layers)
        return;
    vvi_result_open(json, "layers", '{');
    for (size_t i = 0; i < VV_LAYER_COUNT; i++) {
        if (!(layers >> i & 1))
            continue;
        char *path = vv_image_layer_path(r->output, i, r->command->job);
        vvi_result_string(json, vv_layer_name(i), path ? path : "");
        cli_command_line(r->command, vv_layer_name(i), "%s", path ? path : "");
        free(path);
    }
    vvi_result_close(json, '}');
}

void cli_rendering_report(cli_rendering *r)
{
    vvi_result *json = &r->command->json;
    const vv_render_report *f = &r->last;
    const int32_t width = (int32_t)cli_rendering_view(r)->width, height = (int32_t)cli_rendering_view(r)->height;
    vvi_result_string(json, "output", r->output);
    vvi_result_integer(json, "width", width);
    vvi_result_integer(json, "height", height);
    vvi_result_bool(json, "in_parts", r->in_parts);
    vvi_result_string(json, "view", r->recipe.view);
    vvi_result_string(json, "method", f->method);
    vvi_result_number(json, "load_s", r->load_s);
    vvi_result_number(json, "prepare_s", r->first.prepare_s);
    vvi_result_number(json, "first_s", r->first_s);
    vvi_result_number(json, "render_s", r->render_s);
    vvi_result_number(json, "write_s", r->write_s);
    vvi_result_unsigned(json, "peak_bytes", vv_runtime_memory_peak(r->command->runtime));
    vvi_result_unsigned(json, "samples", f->samples);
    vvi_result_unsigned(json, "rays", f->rays);
    vvi_result_integer(json, "passes", f->passes);
    vvi_result_string(json, "ended_by", vv_render_end_name(f->ended_by));
    vvi_result_string(json, "isa", f->isa);
    vvi_result_integer(json, "threads", f->threads);
    vvi_text_add_clean(&r->command->text, r->output);
    vvi_text_printf(&r->command->text,
                    ": %" PRId32 " x %" PRId32
                    ", %s, %s; %d thread%s, %s; read %.2f s, prepared %.2f s, rendered %.3f s\n",
                    width, height, f->method, r->recipe.rays, f->threads, f->threads == 1 ? "" : "s", f->isa, r->load_s,
                    r->first.prepare_s, r->render_s);
    report_layers(r);
    r->command->kept = f->ended_by == VV_END_STOPPED;
    vvi_result_bool(json, "interrupted", r->command->kept);
    if (r->checkpoint)
        vvi_result_bool(json, "resumed", r->resumed);
    if (r->command->kept)
        cli_command_note(r->command, "interrupted: the picture of %" PRId64 " rays per pixel was written", f->passes);
}
