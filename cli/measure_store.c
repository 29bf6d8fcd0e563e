/* What was asked and what came out, kept in a scene: --store. */
#include "core/memory.h"
#include "measure.h"
#include "mesh.h"
#include "output.h"
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

static vv_status put(vv_world **world, const char *name, vv_object *measurement)
{
    vv_object *root = &(*world)->base;
    char *path = vvi_asprintf("measurements.%s", name);
    vv_status st = path ? vv_path_put(&root, path, measurement, NULL) : vv_fail_memory(strlen(name));
    *world = (vv_world *)(void *)root;
    free(path);
    return st == VV_OK ? st : vv_fail_in(st, "--store");
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
    const vv_dataset *data = world->volumes->n ? vvi_volume_dataset(world, vvi_volume_nth(world, 0)) : NULL;
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
    const vv_measurement *m = vvi_measurement_named(world, name);
    if (!m)
        return;
    const char *kind = vv_measure_kind_of(m)->name, *was = measured_file(world, m->file);
    if (vv_measure_kind_of(m) == q->kind && same_file(was, measured_file(world, file)) &&
        same_file(m->other ? m->other : "", q->file[1] ? q->file[1] : ""))
        return;
    cli_command_note(command, "measurements.%s, which was %s of %s, is replaced", name, kind, was);
}

static vv_status set_path(vv_object **asked, const char *name, const char *path)
{
    vvi_text json = {0};
    if (!path)
        return VV_OK;
    vvi_text_json_path(&json, path);
    const vv_status st = json.bad ? vv_fail_memory(json.n) : vv_path_set(asked, name, json.s, NULL);
    vvi_text_free(&json);
    return st;
}

static vv_status keep(cli_command *command, const cli_question *q, const target *t, const vv_measurement *asked)
{
    const cli_measure_options *o = cli_command_options(command, &cli_measure_class);
    const char *scene = t->scene ? t->scene : q->file[0];
    vv_world *world = NULL;
    vv_object *whole = vv_object_retain(&asked->base); /* with the files that it is of */
    char name[64] = "";
    bool is_input = false;
    vv_status st = open_world(&world, &is_input, command, scene, q->file[0]);
    const char *file = is_input ? NULL : q->file[0];
    if (st == VV_OK && !is_input)
        st = check_reading(command, q->file[0]);
    if (st == VV_OK) {
        choose_name(name, world, t, q->kind->name);
        note_replaced(command, world, name, q, file);
    }
    if (st == VV_OK && (st = set_path(&whole, "file", file)) == VV_OK)
        st = set_path(&whole, "other", q->file[1]);
    if (st == VV_OK && (st = put(&world, name, whole)) == VV_OK &&
        (st = vv_scene_write(scene, world, command->job)) == VV_OK) {
        vvi_result_string(&command->json, "stored_in", scene);
        vvi_result_string(&command->json, "stored_as", name);
        if (!o->csv)
            cli_command_line(command, "stored", "%s: measurements.%s", scene, name);
    }
    vv_object_release(whole);
    vv_object_release(world ? &world->base : NULL);
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

vv_status cli_measure_store(cli_command *command, const cli_question *q, const vv_measurement *asked)
{
    const cli_measure_options *o = cli_command_options(command, &cli_measure_class);
    target t = {0};
    vv_status st = find_target(&t, o->store);
    if (st == VV_OK)
        st = keep(command, q, &t, asked);
    free(t.scene);
    return st;
}
