#include "command.h"
#include "core/memory.h"
#include "edits.h"
#include "input.h"
#include "io/sink.h"
#include "output.h"
#include "picture_notes.h"
#include "pipeline.h"
#include "render/recipe.h"
#include "render_plan.h"
#include "signals.h"
#include "verbs.h"
#include "watch.h"
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/render.h>

typedef struct render_options {
    vv_object base;
    int64_t bits, image_quality, repeat;
    double dpi;
    char *save_scene, *output_format;
} render_options;

static const vv_property rows[] = {
    {VV_PROP(render_options, bits), .kind = VV_KIND_I64, .limited = true, .min = 8, .max = 32, .def = 8,
     .automatic = "16 in EXR, 32 in PFM, else 8",
     .doc = "bits per channel of the picture: 8 or 16 in PNG and PDF, 16 or 32 (floats) in EXR, any of them in TIFF"},
    {VV_PROP(render_options, image_quality), .kind = VV_KIND_I64, .limited = true, .min = 1, .max = 100, .def = 90,
     .automatic = "90 in JPEG; WebP is lossless",
     .doc = "of a JPEG or WebP: from 1 (small file) to 100 (closest to the picture)"},
    {VV_PROP(render_options, dpi), .kind = VV_KIND_F64, .limited = true, .min = 1, .max = 100000, .def = 300,
     .automatic = "300 in PDF, else not stored",
     .doc = "pixels per inch: the size on paper stored in PNG, JPEG, TIFF and PDF"},
    {VV_PROP(render_options, repeat), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = 1000,
     .doc = "render this many more times, and report the median time per picture"},
    {VV_PROP(render_options, output_format), .kind = VV_KIND_STRING, .unit = "NAME", .automatic = "png",
     .doc =
         "of a picture that goes to standard output (-o -): jpeg, tiff, svg, ..., as 'volvis formats' lists them; for "
         "a file the suffix decides"},
    {VV_PROP(render_options, save_scene), .kind = VV_KIND_PATH, .automatic = "not written",
     .doc = "also write the scene, with everything that was chosen automatically, to this *.vv.json file"},
    {0},
};

static const vv_class options_class = {
    .name = "render",
    .doc = "options of render",
    .size = sizeof(render_options),
    .properties = rows,
};

typedef struct rendering {
    cli_command *command;
    const render_options *options;
    const char *output;
    char suffix[16]; /* of the format that standard output gets; "": none was asked for */
    char named[24];  /* a file of that format, to ask what it can hold; else "" */
    vv_world *world; /* after the edits */
    vvi_recipe recipe;
    vv_image_options image_options; /* without text */
    vv_image *image;
    bool is_figure; /* SVG */
    char *figure;
    vv_render_report first, last;
    double load_s, first_s, render_s, write_s;
    vv_field **fields; /* of the volumes, kept so that loading is timed apart and happens once */
    vv_mesh **meshes;  /* the same */
    size_t n_fields, n_meshes;
} rendering;

static const vv_view *view_of(const rendering *r)
{
    return (const vv_view *)(const void *)vv_collection_find(r->world->views, r->recipe.view);
}

/* Missing datasets are left to the renderer, which says what it lacks. */
static vv_status load(rendering *r)
{
    const vv_collection *volumes = r->world->volumes;
    const double start_s = cli_now_s();
    vv_status st = VV_OK;
    r->fields = calloc(volumes->n + 1, sizeof(vv_field *));
    r->meshes = calloc(volumes->n + 1, sizeof(vv_mesh *));
    if (!r->fields || !r->meshes)
        return vv_fail_memory(2 * volumes->n * sizeof(vv_field *));
    for (size_t i = 0; i < volumes->n && st == VV_OK; i++) {
        const vv_volume *volume = (const vv_volume *)(const void *)volumes->entry[i].object;
        const vv_dataset *dataset = cli_input_dataset(r->world, volume);
        if (volume->visible && dataset && vv_dataset_is_mesh(dataset, r->command->job))
            st = vv_dataset_mesh(&r->meshes[r->n_meshes++], dataset, r->command->job);
        else if (volume->visible && dataset)
            st = vv_dataset_field(&r->fields[r->n_fields], dataset, volume->attribute, volume->frame, r->command->job);
        r->n_fields += r->fields[r->n_fields] != NULL;
    }
    r->load_s = cli_now_s() - start_s;
    return st;
}

static int by_time(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* There is a whole picture: Ctrl-C ends the frame with it. */
static bool is_interrupted(void *user)
{
    (void)user;
    cli_signals_soften();
    return cli_signals_came();
}

static vv_status frame(rendering *r, vv_render_report *report)
{
    vv_render_options options;
    vv_image_release(r->image);
    r->image = NULL;
    free(r->figure);
    r->figure = NULL;
    vv_render_options_init(&options, sizeof options);
    options.figure_out = r->is_figure ? &r->figure : NULL;
    options.enough = is_interrupted;
    return vv_render(&r->image, report, r->world, r->recipe.view, &options, r->command->job);
}

/* The first frame has warmed everything up: the median of n more is what a frame takes. */
static vv_status repeat(rendering *r, size_t n)
{
    vv_status st = VV_OK;
    double *times = calloc(n, sizeof *times);
    if (!times)
        return vv_fail_memory(n * sizeof *times);
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        st = frame(r, &r->last);
        times[i] = r->last.render_s;
    }
    qsort(times, n, sizeof *times, by_time);
    r->render_s = n % 2 ? times[n / 2] : (times[n / 2 - 1] + times[n / 2]) / 2;
    free(times);
    return st;
}

static vv_status render(rendering *r)
{
    const double start_s = cli_now_s();
    const vv_status st = frame(r, &r->first);
    r->first_s = cli_now_s() - start_s;
    r->last = r->first;
    r->render_s = r->first.render_s;
    return st == VV_OK && r->options->repeat > 0 ? repeat(r, (size_t)r->options->repeat) : st;
}

/* "16 rays per pixel", "up to 37 rays a pixel, 5.3 on average, ended by noise" */
static void describe_rays(rendering *r)
{
    const vv_render_report *f = &r->last;
    char *out = r->recipe.rays;
    const size_t room = sizeof r->recipe.rays;
    const double pixels = r->image ? (double)r->image->width * r->image->height : 1;
    const double mean = (double)f->rays / pixels;
    const char *by = f->ended_by == VV_END_SAMPLES ? "" : vv_render_end_name(f->ended_by);
    size_t n = (size_t)snprintf(out, room, "%" PRId64 " ray%s per pixel", f->passes, f->passes == 1 ? "" : "s");
    if (mean < 0.95 * (double)f->passes)
        n += (size_t)snprintf(out + n, room - n, " at most, %.2f on average", mean);
    if (*by)
        snprintf(out + n, room - n, ", ended by %s", by);
}

/* A picture that time or a signal ended is made again by its number of passes, not by a clock. */
static vv_status fix_passes(rendering *r, vv_world **fixed)
{
    const vv_render_choice *choice = (const vv_render_choice *)(const void *)view_of(r)->render;
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

static vv_status write_bytes(const rendering *r, const void *bytes, size_t n)
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

static vv_status write_to_standard(const rendering *r, const vv_image_options *options)
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

static vv_status write_picture(rendering *r, const vv_world *fixed)
{
    vv_image_options options = r->image_options;
    vv_text *text = NULL;
    size_t n = 0;
    vv_status st;
    if ((st = vvi_recipe_text(&text, &n, fixed, &r->recipe, r->output)) != VV_OK)
        return st;
    options.text = text;
    options.n_text = n;
    st = r->suffix[0] ? write_to_standard(r, &options) : vv_image_write(r->output, r->image, &options, r->command->job);
    vv_text_free(text, n);
    return st;
}

static vv_status write_figure(const rendering *r)
{
    return write_bytes(r, r->figure, strlen(r->figure));
}

static vv_status write(rendering *r)
{
    const double start_s = cli_now_s();
    vv_world *fixed = NULL;
    vv_status st;
    describe_rays(r);
    if ((st = vvi_recipe_fix(&fixed, r->world, r->recipe.view, r->command->job)) != VV_OK)
        return st;
    if (r->command->common->verbose)
        cli_tell_choices(r->command, fixed, r->recipe.view, r->last.method);
    if ((st = fix_passes(r, &fixed)) == VV_OK &&
        (st = r->is_figure ? write_figure(r) : write_picture(r, fixed)) == VV_OK && r->options->save_scene)
        st = vv_scene_write(r->options->save_scene, fixed, r->command->job);
    vv_object_release(&fixed->base);
    r->write_s = cli_now_s() - start_s;
    return st;
}

/* Each layer and the file that it is in. */
static void report_layers(const rendering *r)
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

static void report(rendering *r)
{
    vvi_result *json = &r->command->json;
    const vv_render_report *f = &r->last;
    const vv_image *image = r->image;
    vvi_check(image != NULL);
    vvi_result_string(json, "output", r->output);
    vvi_result_integer(json, "width", image->width);
    vvi_result_integer(json, "height", image->height);
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
                    image->width, image->height, f->method, r->recipe.rays, f->threads, f->threads == 1 ? "" : "s",
                    f->isa, r->load_s, r->first.prepare_s, r->render_s);
    report_layers(r);
    r->command->kept = f->ended_by == VV_END_STOPPED;
    vvi_result_bool(json, "interrupted", r->command->kept);
    if (r->command->kept)
        cli_command_note(r->command, "interrupted: the picture of %" PRId64 " rays per pixel was written", f->passes);
}

/* A figure has colours alone. */
static vv_status choose_figure(rendering *r)
{
    if (cli_layers_of(view_of(r)))
        return vv_fail(VV_E_ARGUMENT, "--aov: an SVG figure has no layers; write EXR or PNG");
    if (vv_object_is_set(&r->options->base, "bits") || vv_object_is_set(&r->options->base, "image_quality") ||
        vv_object_is_set(&r->options->base, "dpi"))
        return vv_fail(VV_E_ARGUMENT,
                       "--bits, --image-quality and --dpi are for images, and SVG is a figure; omit them");
    return VV_OK;
}

/* Asked before the work is done. What a recipe says of bits holds where the format of the output has them. */
static vv_status choose_image(rendering *r)
{
    vv_image_options *options = &r->image_options;
    const char *named = r->named[0] ? r->named : r->output;
    const bool asked = vv_object_is_set(&r->options->base, "bits");
    if (r->is_figure)
        return choose_figure(r);
    const vv_status useless = cli_output_check_image_options(r->command, named);
    if (useless != VV_OK)
        return useless;
    vv_image_options_init(options, sizeof *options);
    if (vv_object_is_set(&r->options->base, "image_quality"))
        options->quality = (int)r->options->image_quality;
    if (vv_object_is_set(&r->options->base, "dpi"))
        options->dpi = r->options->dpi;
    options->layers = cli_layers_of(view_of(r));
    options->bits = asked ? (int)r->options->bits : r->recipe.bits;
    if (!asked && vv_image_check(named, options, r->command->job) != VV_OK)
        options->bits = 0;
    r->recipe.bits = options->bits;
    if (r->suffix[0] && options->layers)
        return vv_fail(VV_E_ARGUMENT, "layers (--aov) are not written to standard output; give a file's name");
    const vv_status st = vv_image_check(named, options, r->command->job);
    const vv_view *view = view_of(r);
    return st == VV_OK ? vv_image_check_size(named, (int32_t)view->width, (int32_t)view->height, r->command->job) : st;
}

static void finish(rendering *r)
{
    for (size_t i = 0; i < r->n_fields; i++)
        vv_field_release(r->fields[i]);
    for (size_t i = 0; i < r->n_meshes; i++)
        vv_mesh_release(r->meshes[i]);
    free(r->fields);
    free(r->meshes);
    free(r->figure);
    vv_image_release(r->image);
    if (r->world)
        vv_object_release(&r->world->base);
}

/* What standard output is to hold; a file's suffix says it. */
static vv_status choose_format(rendering *r)
{
    const char *name = r->options->output_format;
    r->is_figure = cli_output_is_figure(r->output);
    if (!name)
        return VV_OK;
    const vv_status st = cli_output_suffix(r->suffix, sizeof r->suffix, r->command, r->output, name);
    if (st != VV_OK)
        return st;
    snprintf(r->named, sizeof r->named, "image%s", r->suffix);
    r->is_figure = cli_output_is_figure(r->named);
    return VV_OK;
}

static vv_status run(cli_command *command)
{
    rendering r = {.command = command, .options = cli_command_options(command, &options_class)};
    vv_status st;
    if ((st = cli_output_need(&r.output, command, "the picture")) != VV_OK || (st = choose_format(&r)) != VV_OK ||
        (st = cli_output_check(command, r.output, r.is_figure ? CLI_OUTPUT_TEXT : CLI_OUTPUT_IMAGE, NULL)) != VV_OK ||
        (r.options->save_scene &&
         (st = cli_output_check(command, r.options->save_scene, CLI_OUTPUT_TEXT, NULL)) != VV_OK) ||
        (st = cli_command_start(command)) != VV_OK)
        return st;
    if ((st = cli_edited_world(&r.world, &r.recipe, command)) == VV_OK && (st = choose_image(&r)) == VV_OK) {
        if (command->common->dry_run)
            st = cli_render_plan(command, r.world, view_of(&r), r.output);
        else if ((st = load(&r)) != VV_OK)
            st = cli_fail_data(command, r.world, command->args.words[0], st);
        else if ((st = render(&r)) == VV_OK && (st = write(&r)) == VV_OK)
            report(&r);
    }
    finish(&r);
    return st;
}

static const char *const examples[] = {
    "volvis render head.nii.gz -o head.png",
    "volvis render lobster.nrrd -o a.png --method raycast --tf bone --view 30,20 --size 1024x1024",
    "volvis render head.nrrd -o mip.png --mode maximum --view left --background white --zoom 1.5",
    "volvis render t1.nii.gz act.nii.gz -o overlay.png --slice axial --tf act=hot --range act=3..8",
    "volvis render head.nrrd -o skin.png --iso 90 --clip x:10..40",
    "volvis render head.nrrd -o smooth.png --spp 16",
    "volvis render head.nrrd -o best.png --noise 1% --budget 10s",
    "volvis render head.nrrd -o b.png --tf '0:0 100:0 150:0.1#e0b090 200:0.9#fff' --set lights.key.intensity=2",
    "volvis render head.nrrd -o head.exr --aov depth,normal,id --background transparent",
    "volvis render skin.ply -o skin.png",
    "volvis render head.nrrd skin.ply -o both.png --set volumes.skin.color=#d0a08080",
    "volvis render head.nrrd -o figure.svg --decorate axes,scale-bar,legend --background white",
    "volvis render head.nrrd lobster.nrrd -o '{stem}.jpg'",
    "volvis render head.nrrd -o - --output-format jpeg > head.jpg",
    "volvis render a.png -o again.png",
    NULL,
};

const cli_verb cli_verb_render = {
    .name = "render",
    .doc = "one image",
    .about = "INPUT is a data file, a mesh, a scene (*.vv.json) or a picture made by VolVis. Data files become a World "
             "in which something is always visible; further files, including meshes next to volumes, are added to the "
             "World of the first. The picture holds the scene, version, seed and data checksums that made it, so that "
             "rendering the picture again reproduces it.",
    .words = "INPUT ...",
    .choices = "files",
    .min_words = 1,
    .max_words = 16,
    .options = {&options_class, &cli_look_class, &cli_reading_class, &cli_watching_class},
    .examples = examples,
    .makes_file = true,
    .each_input = true,
    .world = true,
    .run = run,
};
