#include "command.h"
#include "core/memory.h"
#include "edits.h"
#include "input.h"
#include "output.h"
#include "picture_notes.h"
#include "pipeline.h"
#include "refusal.h"
#include "render/picture.h"
#include "render_plan.h"
#include "rendering.h"
#include "resuming.h"
#include "signals.h"
#include "value.h"
#include "verbs.h"
#include "watch.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const vv_property rows[] = {
    {VV_PROP(cli_render_options, bits), .kind = VV_KIND_I64, .limited = true, .min = 8, .max = 32, .def = 8,
     .automatic = "16 in EXR, 32 in PFM, else 8",
     .doc = "bits per channel of the picture: 8 or 16 in PNG and PDF, 16 or 32 (floats) in EXR, any of them in TIFF"},
    {VV_PROP(cli_render_options, image_quality), .kind = VV_KIND_I64, .limited = true, .min = 1, .max = 100, .def = 90,
     .automatic = "90 in JPEG; WebP is lossless",
     .doc = "of a JPEG or WebP: from 1 (small file) to 100 (closest to the picture)"},
    {VV_PROP(cli_render_options, dpi), .kind = VV_KIND_F64, .limited = true, .min = 1, .max = 100000, .def = 300,
     .automatic = "300 in PDF, else not stored",
     .doc = "pixels per inch: the size on paper stored in PNG, JPEG, TIFF and PDF"},
    {VV_PROP(cli_render_options, repeat), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = 1000,
     .doc = "render this many more times, and report the median time per picture"},
    {VV_PROP(cli_render_options, output_format), .kind = VV_KIND_STRING, .unit = "NAME", .automatic = "png",
     .doc =
         "of a picture that goes to standard output (-o -): jpeg, tiff, svg, ..., as 'volvis formats' lists them; for "
         "a file the suffix decides"},
    {VV_PROP(cli_render_options, resume), .kind = VV_KIND_PATH, .unit = "FILE", .automatic = "nothing is kept",
     .doc = "keep what is rendered in this file every few seconds, and go on from it where it is there: the same bytes "
            "as without a break, on any number of threads; Ctrl-C ends with exit code 75; the file goes once the "
            "picture is written"},
    {VV_PROP(cli_render_options, save_scene), .kind = VV_KIND_PATH, .automatic = "not written",
     .doc = "also write the scene, with everything that was chosen automatically, to this *.vv.json file"},
    {0},
};

static const vv_class options_class = {
    .name = "render",
    .doc = "options of render",
    .size = sizeof(cli_render_options),
    .properties = rows,
};

/* Missing datasets are left to the renderer, which says what it lacks. */
static vv_status load(cli_rendering *r)
{
    const vv_collection *volumes = r->world->volumes;
    const double start_s = cli_now_s();
    vv_status st = VV_OK;
    r->fields = calloc(volumes->n + 1, sizeof(vv_field *));
    r->meshes = calloc(volumes->n + 1, sizeof(vv_mesh *));
    if (!r->fields || !r->meshes)
        return vv_fail_memory(2 * volumes->n * sizeof(vv_field *));
    for (size_t i = 0; i < volumes->n && st == VV_OK; i++) {
        const vv_volume *volume = vvi_volume_nth(r->world, i);
        const vv_dataset *dataset = vvi_volume_dataset(r->world, volume);
        if (volume->visible && dataset && vv_dataset_is_mesh(dataset, r->command->job))
            st = vv_dataset_mesh(&r->meshes[r->n_meshes++], r->world, dataset, r->command->job);
        else if (volume->visible && dataset)
            st = vv_dataset_field(&r->fields[r->n_fields], r->world, dataset, volume->attribute, volume->frame,
                                  r->command->job);
        r->n_fields += r->fields[r->n_fields] != NULL;
    }
    r->load_s = cli_now_s() - start_s;
    return st;
}

/* There is a whole picture: Ctrl-C ends the frame with it. */
static bool is_interrupted(void *user)
{
    (void)user;
    cli_signals_soften();
    return cli_signals_came();
}

static vv_status frame(cli_rendering *r, vv_render_report *report)
{
    vv_render_options options;
    vv_image_release(r->image);
    r->image = NULL;
    free(r->figure);
    r->figure = NULL;
    if (r->checkpoint)
        return cli_resuming_render(r, report);
    vv_render_options_init(&options, sizeof options);
    options.figure_out = r->is_figure ? &r->figure : NULL;
    options.enough = is_interrupted;
    return vv_render(&r->image, report, r->world, r->recipe.view, &options, r->command->job);
}

/* The first frame has warmed everything up: the median of n more is what a frame takes. */
static vv_status repeat(cli_rendering *r, size_t n)
{
    vv_status st = VV_OK;
    double *times = calloc(n, sizeof *times);
    if (!times)
        return vv_fail_memory(n * sizeof *times);
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        st = frame(r, &r->last);
        times[i] = r->last.render_s;
    }
    r->render_s = cli_value_median(times, n);
    free(times);
    return st;
}

static vv_status render(cli_rendering *r)
{
    const double start_s = cli_now_s();
    const vv_status st = frame(r, &r->first);
    r->first_s = cli_now_s() - start_s;
    r->last = r->first;
    r->render_s = r->first.render_s;
    return st == VV_OK && r->options->repeat > 0 ? repeat(r, (size_t)r->options->repeat) : st;
}

/* Whether what it shows, and what it is written as, can be made from the top down. */
static vv_status check_parts(const cli_rendering *r)
{
    const vv_view *view = cli_rendering_view(r);
    vv_scene *scene;
    vv_status st =
        vv_image_check_rows(r->output, (int32_t)view->width, (int32_t)view->height, &r->image_options, r->command->job);
    if (st == VV_OK && (st = vv_scene_resolve(&scene, r->world, r->recipe.view, r->command->job)) == VV_OK) {
        st = vvi_has_parts(scene);
        vv_scene_release(scene);
    }
    if (st != VV_E_UNSUPPORTED)
        return st;
    char why[1024]; /* which matters because memory is short */
    snprintf(why, sizeof why, "%s", vv_error_last()->message);
    return vv_fail(VV_E_LIMIT, "%s, or give more with --memory", why);
}

/* What makes it at once, however large it is, and how it were made part by part; NULL: nothing does. */
static const char *wants_all(const cli_rendering *r)
{
    return r->checkpoint        ? "omit --resume, which keeps all of it"
           : r->options->repeat ? "omit --repeat, which makes all of it"
           : r->is_figure       ? "write PNG, as a figure needs all of it"
           : r->suffix[0]       ? "name a file, as standard output gets all of it"
                                : NULL;
}

/* Larger than memory: it is made while it is written. */
static vv_status choose_parts(cli_rendering *r)
{
    uint64_t bytes;
    const vv_status st = vv_render_memory(&bytes, &r->at_once, r->world, r->recipe.view, r->command->job);
    r->in_parts = st == VV_OK && !r->at_once && !wants_all(r);
    return r->in_parts ? check_parts(r) : st;
}

/* What cannot be made part by part is left to find out whether there is memory. */
static vv_status explain_limit(const cli_rendering *r, vv_status st)
{
    const char *instead = wants_all(r);
    char why[1024];
    if (st != VV_E_LIMIT || r->at_once || !instead)
        return st;
    const char *message = vv_error_last()->message, *advice = strstr(message, "; give");
    snprintf(why, sizeof why, "%.*s", (int)(advice ? (size_t)(advice - message) : strlen(message)), message);
    return vv_fail(VV_E_LIMIT, "%s; give more with --memory, make it smaller, or %s: then it is made part by part", why,
                   instead);
}

/* A figure has colours alone. */
static vv_status choose_figure(cli_rendering *r)
{
    if (cli_layers_of(cli_rendering_view(r)))
        return cli_refused(r->command, "aov",
                           vv_fail(VV_E_ARGUMENT, "--aov: an SVG figure has no layers; write EXR or PNG"));
    if (vv_object_is_set(&r->options->base, "bits") || vv_object_is_set(&r->options->base, "image_quality") ||
        vv_object_is_set(&r->options->base, "dpi"))
        return cli_refused(
            r->command, "bits,image-quality,dpi",
            vv_fail(VV_E_ARGUMENT, "--bits, --image-quality and --dpi are for images, and SVG is a figure; omit them"));
    return VV_OK;
}

/* Asked before the work is done. What a recipe says of bits holds where the format of the output has them. */
static vv_status choose_image(cli_rendering *r)
{
    vv_image_options *options = &r->image_options;
    const char *named = r->named[0] ? r->named : r->output;
    const bool set = vv_object_is_set(&r->options->base, "bits"),
               asked = set && cli_option_is_typed(r->command, "bits");
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
    options->layers = cli_layers_of(cli_rendering_view(r));
    options->bits = set ? (int)r->options->bits : r->recipe.bits;
    if (!asked && vv_image_check(named, options, r->command->job) != VV_OK)
        options->bits = 0;
    r->recipe.bits = options->bits;
    if (r->suffix[0] && options->layers)
        return cli_refused(
            r->command, "aov",
            vv_fail(VV_E_ARGUMENT, "layers (--aov) are not written to standard output; give a file's name"));
    const vv_status st = vv_image_check(named, options, r->command->job);
    const vv_view *view = cli_rendering_view(r);
    return st == VV_OK ? vv_image_check_size(named, (int32_t)view->width, (int32_t)view->height, r->command->job) : st;
}

static void finish(cli_rendering *r)
{
    for (size_t i = 0; i < r->n_fields; i++)
        vv_field_release(r->fields[i]);
    for (size_t i = 0; i < r->n_meshes; i++)
        vv_mesh_release(r->meshes[i]);
    free(r->fields);
    free(r->meshes);
    free(r->figure);
    free(r->checkpoint);
    vv_image_release(r->image);
    if (r->world)
        vv_object_release(&r->world->base);
}

/* What standard output is to hold; a file's suffix says it. */
static vv_status choose_format(cli_rendering *r)
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
    cli_rendering r = {.command = command, .options = cli_command_options(command, &options_class)};
    vv_status st;
    if ((st = cli_output_need(&r.output, command, "the picture")) != VV_OK || (st = choose_format(&r)) != VV_OK ||
        (st = cli_resuming_check(&r)) != VV_OK ||
        (st = cli_output_check(command, r.output, r.is_figure ? CLI_OUTPUT_TEXT : CLI_OUTPUT_IMAGE, NULL)) != VV_OK ||
        (r.options->save_scene &&
         (st = cli_output_check(command, r.options->save_scene, CLI_OUTPUT_TEXT, NULL)) != VV_OK) ||
        (st = cli_command_start(command)) != VV_OK)
        return st;
    if ((st = cli_edited_world(&r.world, &r.recipe, command)) == VV_OK && (st = choose_image(&r)) == VV_OK) {
        if (command->common->dry_run)
            st = (st = choose_parts(&r)) == VV_OK
                     ? explain_limit(&r, cli_render_plan(command, r.world, r.recipe.view, r.output, r.in_parts))
                     : st;
        else if ((st = load(&r)) != VV_OK)
            st = cli_fail_data(command, r.world, command->args.words[0], st);
        else if ((st = choose_parts(&r)) == VV_OK &&
                 (st = r.in_parts ? VV_OK : explain_limit(&r, render(&r))) == VV_OK && r.saved)
            cli_resuming_report(&r);
        else if (st == VV_OK && (st = cli_rendering_write(&r)) == VV_OK)
            cli_rendering_report(&r);
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
    "volvis render head.nrrd -o poster.png --size 1200 --resume poster.part",
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
