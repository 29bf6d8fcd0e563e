/* What was asked and what came out, kept in a scene: --store. */
#include "core/memory.h"
#include "core/units.h"
#include "grid/label_id.h"
#include "measure.h"
#include "measure_stored.h"
#include "mesh.h"
#include "output.h"
#include "value.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

/* [SCENE.vv.json:]NAME, or SCENE.vv.json alone. */
typedef struct target {
    char *scene;      /* NULL: the input is it */
    const char *name; /* "": one is made from the kind */
} target;

static bool is_scene_name(const char *text, size_t n)
{
    return n > 5 && strncasecmp(text + n - 5, ".json", 5) == 0;
}

static vv_status find_target(target *out, const char *typed)
{
    const char *colon = strrchr(typed, ':');
    const size_t n = colon ? (size_t)(colon - typed) : strlen(typed);
    *out = (target){.name = colon ? colon + 1 : typed};
    if (!is_scene_name(typed, n) && !colon)
        return VV_OK;
    if (!is_scene_name(typed, n))
        return vv_fail(VV_E_ARGUMENT,
                       "--store: '%s' is not a scene; expected NAME, SCENE.vv.json or SCENE.vv.json:NAME", typed);
    out->scene = strndup(typed, n);
    out->name = colon ? colon + 1 : "";
    return out->scene ? VV_OK : vv_fail_memory(n);
}

/* Arguments ---------------------------------------------------------------------------------------------------------
 */

static void add_path(vvi_text *out, const char *name, const char *path)
{
    if (!path)
        return;
    vvi_text_printf(out, ", \"%s\": ", name);
    vvi_text_json_path(out, path);
}

static void add_vector(vvi_text *out, const char *name, const char *typed)
{
    if (!typed)
        return;
    vvi_text_printf(out, ", \"%s\": ", name);
    cli_value_vector(out, typed);
}

static void add_label(vvi_text *out, const char *name, const char *typed)
{
    char digits[VVI_LABEL_DIGITS];
    vv_label_id id;
    if (typed && vvi_label_parse(&id, typed, true))
        vvi_text_printf(out, ", \"%s\": \"%s\"", name, vvi_label_print(digits, id, false));
}

static void add_object(vvi_text *out, const cli_result *result, const cli_measure_options *o)
{
    double lo = NAN, hi = NAN;
    if (o->iso && vvi_parse_number(&lo, o->iso))
        cli_figure_add_number(out, "iso", lo);
    if (o->other_iso && vvi_parse_number(&hi, o->other_iso))
        cli_figure_add_number(out, "other_iso", hi);
    if (o->threshold && cli_threshold_parse(&lo, &hi, o->threshold) == VV_OK) {
        cli_figure_add_number(out, "threshold_lo", lo);
        cli_figure_add_number(out, "threshold_hi", hi);
    }
    add_label(out, "label", result->label[0][0] ? result->label[0] : o->label);
    add_label(out, "other_label", result->label[1][0] ? result->label[1] : o->other_label);
    add_vector(out, "seed", o->seed);
    if (o->point && o->point->n) {
        vvi_text_add(out, ", \"points\": [");
        for (size_t i = 0; i < o->point->n; i++) {
            vvi_text_add(out, i ? ", " : "");
            cli_value_vector(out, cli_word_nth(o->point, i));
        }
        vvi_text_add(out, "]");
    }
}

static void add_range(vvi_text *out, const char *range)
{
    if (!range)
        return;
    vvi_text_add(out, ", \"range\": [");
    cli_value_vector(out, range);
    vvi_text_add(out, "]");
}

/* The measurement as JSON. file: NULL where it is the scene's own. */
static void describe(vvi_text *out, const cli_result *result, const cli_question *q, const char *file)
{
    const cli_measure_options *o = cli_command_options(result->command, &cli_measure_class);
    vvi_text_add(out, "{\"what\": ");
    vvi_text_json(out, q->kind);
    add_path(out, "file", file);
    add_path(out, "other", q->file[1]);
    add_object(out, result, o);
    if (o->component)
        vvi_text_printf(out, ", \"component\": %d", result->component);
    cli_measure_add_same(out, &o->base);
    add_range(out, o->range);
    if (result->planes.n)
        vvi_text_printf(out, ", \"cut_planes\": [%s]", result->planes.s);
    vvi_text_printf(out, ", \"figures\": [%s]}", result->figures.n ? result->figures.s : "");
    out->bad |= result->planes.bad || result->figures.bad;
}

/* The scene ---------------------------------------------------------------------------------------------------------
 */

/* The scene's World, or a new one on the data that was measured. */
static vv_status open_world(vv_world **out, bool *is_input, cli_command *command, const char *scene, const char *input)
{
    vv_model *model = NULL;
    vvi_recipe recipe;
    *is_input = strcmp(scene, input) == 0;
    if (access(scene, F_OK) == 0)
        return vv_scene_read(out, scene, command->job);
    if (!cli_mesh_is_input(command, input)) {
        *is_input = true;
        return cli_input_world(out, &recipe, command, input);
    }
    const vv_status st = vv_model_new(&model, command->runtime);
    if (st == VV_OK)
        *out = vv_model_snapshot(model);
    vv_model_release(model);
    return st;
}

static void choose_name(char out[64], const vv_world *world, const target *t, const char *kind)
{
    snprintf(out, 64, "%s", *t->name ? t->name : kind);
    for (int i = 2; !*t->name && vv_collection_find(world->measurements, out); i++)
        snprintf(out, 64, "%s_%d", kind, i);
}

static vv_status put(vv_world **world, const char *name, const char *json, cli_command *command)
{
    vv_model *model = NULL;
    char *path = vvi_asprintf("measurements.%s", name);
    vv_status st = path ? vv_model_new(&model, command->runtime) : vv_fail_memory(strlen(name));
    if (st == VV_OK && (st = vv_model_replace(model, NULL, *world)) == VV_OK &&
        (st = vv_model_set(model, NULL, path, json)) != VV_OK)
        st = vv_fail_in(st, "--store");
    if (st == VV_OK) {
        vv_object_release(&(*world)->base);
        *world = vv_model_snapshot(model);
    }
    vv_model_release(model);
    free(path);
    return st;
}

/* Files beside a scene's own are named by their path alone. */
static vv_status check_reading(const cli_command *command, const char *input)
{
    const cli_reading *reading = cli_command_options(command, &cli_reading_class);
    if (!reading->raw && !reading->part && !reading->input_format && !reading->missing &&
        !vv_object_is_set(&reading->base, "frame"))
        return VV_OK;
    return vv_fail(VV_E_ARGUMENT,
                   "--store: how %s is read is not kept in a scene of other data: store it in a new scene of its own",
                   input);
}

/* What a measurement is of: its file, or that of the scene's first volume. */
static const char *measured_file(const vv_world *world, const char *file)
{
    const vv_collection *volumes = world->volumes;
    const vv_dataset *data =
        volumes->n ? cli_input_dataset(world, (const vv_volume *)(const void *)volumes->entry[0].object) : NULL;
    return file ? file : data && data->path ? data->path : "";
}

static bool same_file(const char *a, const char *b)
{
    return strcmp(a, b) == 0 || cli_output_is(a, b);
}

/* A name that was given and has something else already. file: NULL: the scene's own. */
static void note_replaced(cli_command *command, const vv_world *world, const char *name, const cli_question *q,
                          const char *file)
{
    const vv_measurement *m = (const vv_measurement *)(const void *)vv_collection_find(world->measurements, name);
    if (!m)
        return;
    const char *kind = vv_class_find(m->base.cls, "what")->names[m->what], *was = measured_file(world, m->file);
    if (strcmp(kind, q->kind) == 0 && same_file(was, measured_file(world, file)) &&
        same_file(m->other ? m->other : "", q->file[1] ? q->file[1] : ""))
        return;
    cli_command_note(command, "measurements.%s, which was %s of %s, is replaced", name, kind, was);
}

static vv_status keep(cli_result *result, const cli_question *q, const target *t, const char *scene)
{
    cli_command *command = result->command;
    vv_world *world = NULL;
    vvi_text json = {0};
    char name[64] = "";
    bool is_input = false;
    vv_status st = open_world(&world, &is_input, command, scene, q->file[0]);
    if (st == VV_OK && !is_input)
        st = check_reading(command, q->file[0]);
    if (st == VV_OK) {
        choose_name(name, world, t, q->kind);
        note_replaced(command, world, name, q, is_input ? NULL : q->file[0]);
        describe(&json, result, q, is_input ? NULL : q->file[0]);
        st = json.bad ? vv_fail_memory(json.n) : put(&world, name, json.s, command);
    }
    if (st == VV_OK && (st = vv_scene_write(scene, world, command->job)) == VV_OK) {
        vvi_result_string(&command->json, "stored_in", scene);
        vvi_result_string(&command->json, "stored_as", name);
        if (!result->csv)
            cli_command_line(command, "stored", "%s: measurements.%s", scene, name);
    }
    vvi_text_free(&json);
    if (world)
        vv_object_release(&world->base);
    return st;
}

vv_status cli_measure_store_check(cli_command *command, const char *input)
{
    const cli_measure_options *o = cli_command_options(command, &cli_measure_class);
    target t = {0};
    vv_status st = find_target(&t, o->store);
    if (st == VV_OK && command->common->set && command->common->set->n)
        st = vv_fail(VV_E_ARGUMENT,
                     "--store keeps no --set: make the scene first, as in 'volvis render IN --set ... --save-scene "
                     "study.vv.json -o a.png'");
    if (st == VV_OK && strcmp(input, "-") == 0)
        st = vv_fail(VV_E_ARGUMENT, "--store: standard input cannot be measured again from a scene: give a file");
    if (st == VV_OK && !t.scene &&
        (cli_mesh_is_input(command, input) || cli_input_contents(command, input) != CLI_INPUT_SCENE))
        st = vv_fail(VV_E_ARGUMENT, "--store: %s is not a scene; name one, as in --store study.vv.json%s%s", input,
                     *t.name ? ":" : "", t.name);
    if (st == VV_OK && cli_output_is(command->common->output, t.scene ? t.scene : input))
        st = vv_fail_at(VV_E_ARGUMENT, command->common->output, NULL,
                        "is the scene that --store writes to; give another name to -o");
    free(t.scene);
    return st;
}

vv_status cli_measure_store(cli_result *result, const cli_question *q)
{
    const cli_measure_options *o = cli_command_options(result->command, &cli_measure_class);
    target t = {0};
    vv_status st = find_target(&t, o->store);
    if (st == VV_OK)
        st = keep(result, q, &t, t.scene ? t.scene : q->file[0]);
    free(t.scene);
    return st;
}
