#include "command.h"
#include "edits.h"
#include "grid/label_id.h"
#include "picture_notes.h"
#include "refusal.h"
#include "value.h"
#include "verbs.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/pick.h>

typedef struct pick_options {
    vv_object base;
    vv_collection *pixel; /* of cli_word */
} pick_options;

static const vv_property rows[] = {
    {VV_PROP(pick_options, pixel), .kind = VV_KIND_LIST, .cls = &cli_word_class, .unit = "X,Y",
     .doc = "which pixel of the view, counted from 0 at the top left; may be repeated"},
    {0},
};

static const vv_class options_class = {
    .name = "pick",
    .doc = "options of pick",
    .size = sizeof(pick_options),
    .properties = rows,
};

static vv_status parse_pixel(vv_pixel *out, const char *typed)
{
    double at[2];
    if (cli_value_numbers(at, 2, typed, false) != VV_OK || at[0] != floor(at[0]) || at[1] != floor(at[1]) ||
        fabs(at[0]) > 1e6 || fabs(at[1]) > 1e6)
        return vv_fail(VV_E_ARGUMENT, "--pixel: expected X,Y in whole pixels, as in 400,300, found '%s'", typed);
    *out = (vv_pixel){(int32_t)at[0], (int32_t)at[1]};
    return VV_OK;
}

static vv_status take_pixels(vv_pixel **out, size_t *n_out, const cli_command *command)
{
    const pick_options *options = cli_command_options(command, &options_class);
    const size_t n = options->pixel ? options->pixel->n : 0;
    vv_status st = VV_OK;
    if (n == 0)
        return vv_fail(VV_E_ARGUMENT, "pick needs --pixel X,Y: which pixel?");
    *out = calloc(n, sizeof **out);
    if (!*out)
        return vv_fail_memory(n * sizeof **out);
    for (size_t i = 0; i < n && st == VV_OK; i++)
        st = parse_pixel(&(*out)[i], cli_word_nth(options->pixel, i));
    *n_out = n;
    return st;
}

static void put_vector(vvi_result *json, const char *key, vv_vec3 v)
{
    vvi_result_open(json, key, '[');
    vvi_result_number(json, NULL, v.x);
    vvi_result_number(json, NULL, v.y);
    vvi_result_number(json, NULL, v.z);
    vvi_result_close(json, ']');
}

/* What the volume's scene calls a label; NULL where it does not. */
static const char *label_name(const vv_world *world, const vv_picked *p)
{
    const vv_volume *volume = p->volume ? vvi_volume_named(world, p->volume) : NULL;
    if (!volume)
        return NULL;
    const vv_segmentation *segmentation = (const vv_segmentation *)(const void *)volume->segmentation;
    const vv_collection *names = ((const vv_labels *)(const void *)segmentation->labels)->names;
    for (size_t i = 0; i < names->n; i++) {
        const vv_label_name *entry = (const vv_label_name *)(const void *)names->entry[i].object;
        if (entry->label == p->label)
            return entry->name;
    }
    return NULL;
}

static void report_json(vvi_result *json, const vv_picked *p, const vv_world *world)
{
    vvi_result_open(json, NULL, '{');
    vvi_result_integer(json, "x", p->pixel.x);
    vvi_result_integer(json, "y", p->pixel.y);
    vvi_result_bool(json, "hit", p->hit);
    if (p->hit) {
        vvi_result_string(json, "volume", p->volume);
        vvi_result_unsigned(json, "id", p->id);
        vvi_result_number(json, "depth", p->depth);
        put_vector(json, "world", p->world);
    }
    if (p->volume) {
        put_vector(json, "index", p->index);
        vvi_result_number(json, "value", p->value);
        if (!p->is_mesh)
            put_vector(json, "gradient", p->gradient);
        put_vector(json, "normal", p->normal);
    }
    if (p->is_mesh) {
        vvi_result_string(json, "part", p->part);
        vvi_result_bool(json, "cut", p->triangle == VV_NO_TRIANGLE);
        if (p->triangle != VV_NO_TRIANGLE)
            vvi_result_unsigned(json, "triangle", p->triangle);
    }
    if (p->labelled)
        vvi_result_label(json, "label", p->label, p->label_unsigned);
    if (p->labelled)
        vvi_result_string(json, "label_name", label_name(world, p));
    vvi_result_close(json, '}');
}

/* Places are known to a few millionths of how far they are away: what is less than that of the whole is 0. */
static void put_place(cli_command *command, const char *name, vv_vec3 v, double scale, const char *unit)
{
    const double least = 1e-6 * fmax(scale, fmax(fmax(fabs(v.x), fabs(v.y)), fabs(v.z)));
    double c[3] = {v.x, v.y, v.z};
    for (int i = 0; i < 3; i++)
        c[i] = fabs(c[i]) < least ? 0 : c[i];
    cli_command_line(command, name, "%.6g, %.6g, %.6g%s%s", c[0], c[1], c[2], *unit ? " " : "", unit);
}

static void report_mesh(cli_command *command, const vv_picked *p)
{
    if (*p->part)
        cli_command_line(command, "part", "%s", p->part);
    if (p->triangle == VV_NO_TRIANGLE)
        cli_command_line(command, "triangle", "none: the face of a cut");
    else
        cli_command_line(command, "triangle", "%" PRIu32, p->triangle);
    if (isfinite(p->value))
        cli_command_line(command, "value", "%.6g", p->value);
    cli_command_line(command, "normal", "%.6g, %.6g, %.6g", p->normal.x, p->normal.y, p->normal.z);
}

static void report_text(cli_command *command, const vv_picked *p, const vv_world *world, const char *unit)
{
    char digits[VVI_LABEL_DIGITS];
    vvi_text_printf(&command->text, "pixel %" PRId32 ",%" PRId32 "%s\n", p->pixel.x, p->pixel.y,
                    p->hit ? "" : ": nothing there");
    if (!p->hit)
        return;
    cli_command_line(command, "volume", "%s", p->volume ? p->volume : "none");
    put_place(command, "world", p->world, p->depth, unit);
    cli_command_line(command, "depth", "%.6g %s", p->depth, unit);
    if (p->is_mesh)
        report_mesh(command, p);
    if (!p->volume || p->is_mesh)
        return;
    put_place(command, "index", p->index, 1, "");
    cli_command_line(command, "value", "%.6g", p->value);
    cli_command_line(command, "gradient", "%.6g, %.6g, %.6g by %s", p->gradient.x, p->gradient.y, p->gradient.z, unit);
    cli_command_line(command, "normal", "%.6g, %.6g, %.6g", p->normal.x, p->normal.y, p->normal.z);
    const char *name = p->labelled ? label_name(world, p) : NULL;
    if (p->labelled)
        cli_command_line(command, "label", "%s%s%s", vvi_label_print(digits, p->label, p->label_unsigned),
                         name ? " " : "", name ? name : "");
}

static void report(cli_command *command, const vv_picked *picked, size_t n, const vv_world *world, const char *view)
{
    const char *unit = world->unit ? world->unit : "voxels";
    vvi_result_string(&command->json, "view", view);
    vvi_result_string(&command->json, "unit", unit);
    vvi_result_open(&command->json, "pixels", '[');
    for (size_t i = 0; i < n; i++) {
        report_json(&command->json, &picked[i], world);
        report_text(command, &picked[i], world, unit);
    }
    vvi_result_close(&command->json, ']');
}

static vv_status pick(cli_command *command, const vv_pixel *pixels, size_t n)
{
    vv_world *world;
    vvi_recipe recipe;
    vv_status st = cli_edited_world(&world, &recipe, command);
    if (st != VV_OK)
        return st;
    vv_picked *picked = calloc(n, sizeof *picked);
    if (!picked)
        st = vv_fail_memory(n * sizeof *picked);
    else if (command->common->dry_run)
        cli_command_line(command, "picks", "%zu pixels of view '%s'", n, recipe.view);
    else if ((st = vv_pick(picked, pixels, n, world, recipe.view, command->job)) == VV_OK)
        report(command, picked, n, world, recipe.view);
    else
        st = cli_fail_data(command, world, command->args.words[0], st);
    free(picked);
    vv_object_release(&world->base);
    return st;
}

/* What is drawn over a picture, behind it or beside it, and how often rays are cast, is nothing to what one ray hits.
 */
static vv_status check_look(const cli_command *command)
{
    static const char *const drawn[] = {
        "aov",        "decorate", "title",    "caption", "background",       "color", "noise", "budget",
        "no_shading", "spp",      "lighting", "shadows", "ambient_occlusion"};
    const cli_look *look = cli_command_options(command, &cli_look_class);
    char option[64];
    for (size_t i = 0; i < sizeof drawn / sizeof drawn[0]; i++) {
        if (!vv_object_is_set(&look->base, drawn[i]))
            continue;
        cli_option_name(option, vv_class_find(&cli_look_class, drawn[i]));
        return cli_refused(command, option,
                           vv_fail(VV_E_ARGUMENT, "--%s does nothing to what is seen at a pixel: omit it", option));
    }
    return VV_OK;
}

static vv_status run(cli_command *command)
{
    vv_pixel *pixels = NULL;
    size_t n = 0;
    vv_status st;
    if ((st = check_look(command)) != VV_OK)
        return st;
    if ((st = take_pixels(&pixels, &n, command)) == VV_OK && (st = cli_command_start(command)) == VV_OK)
        st = pick(command, pixels, n);
    free(pixels);
    return st;
}

static const char *const examples[] = {
    "volvis pick head.nrrd --pixel 400,300",
    "volvis pick head.nrrd --iso 90 --view left --size 512x512 --pixel 256,256 --pixel 10,10 --json",
    "volvis pick a.png --pixel 30,20",
    NULL,
};

const cli_verb cli_verb_pick = {
    .name = "pick",
    .doc = "what is seen at pixels of a view: volume, point, value, gradient",
    .about = "INPUT and the options for the look of the picture are those of render; for a picture made by VolVis, its "
             "own pixels can be queried. One ray is cast through each pixel. It hits where half of the light has been "
             "absorbed (composite), at the largest value (maximum), or at the surface. A thin cloud is not hit.",
    .words = "INPUT ...",
    .choices = "files",
    .min_words = 1,
    .max_words = 16,
    .options = {&options_class, &cli_look_class, &cli_reading_class},
    .examples = examples,
    .world = true,
    .run = run,
};
