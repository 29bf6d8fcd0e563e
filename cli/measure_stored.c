/* The measurements of a scene once more, and whether they give what they gave. */
#include "core/memory.h"
#include "core/names.h"
#include "measure.h"
#include "model/classes.h"
#include "output.h"
#include "picture_notes.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct again {
    cli_command *command;
    const char *scene;
    vv_world *world;
    size_t n_changed, n_new, n_failed;
    vvi_text text; /* what the program says; the command's own text is that of each measurement meanwhile */
    bool csv;
} again;

static const char *kind_of(const vv_measurement *m)
{
    return vv_measure_kind_of(m)->name;
}

/* Names of files are told as they may be shown: what a scene names may come from anybody. */
static void put_name(vvi_text *out, const char *label, const char *name)
{
    if (!name || !*name)
        return;
    vvi_text_printf(out, "  %-16s ", label);
    vvi_text_add_clean(out, name);
    vvi_text_add(out, "\n");
}

/* What was measured: the object, with its value where VolVis chose it, and the part. */
static void put_subject(vvi_text *out, const vv_answer *answer, const vv_measurement *m)
{
    put_name(out, "object", vv_answer_object(answer));
    put_name(out, "region", vv_answer_region(answer));
    for (size_t i = 0; i < m->cut_planes->n; i++) {
        const vv_cut_plane *p = (const vv_cut_plane *)(const void *)m->cut_planes->entry[i].object;
        vvi_text_printf(out, "  %-16s plane(n=%g,%g,%g d=%g)\n", i ? "" : "cut planes", p->normal.x, p->normal.y,
                        p->normal.z, p->offset);
    }
    put_name(out, "mask", m->mask);
    put_name(out, "values", m->values);
}

static vv_status put(again *a, const char *id, const vv_measurement *then, const vv_measurement *now,
                     const vv_answer *answer)
{
    vvi_changes changes;
    const vv_status st = vvi_changes_find(&changes, then->figures, now->figures);
    if (st != VV_OK)
        return st;
    cli_changes_json(&a->command->json, &changes);
    a->n_changed += changes.n_changed > 0;
    a->n_new += !changes.compared;
    if (!a->csv) {
        vvi_text_printf(&a->text, "%s: %s%s", id, kind_of(then), then->file ? " of " : "");
        vvi_text_add_clean(&a->text, then->file ? then->file : "");
        vvi_text_add(&a->text, !changes.compared       ? ", for the first time\n"
                               : changes.n_changed > 0 ? ", CHANGED\n"
                                                       : ", as before\n");
        put_subject(&a->text, answer, then);
    }
    cli_changes_put(&a->text, a->csv, id, &changes);
    vvi_changes_free(&changes);
    return VV_OK;
}

/* The answer, and the measurement with its figures. What it says as text is left aside. */
static vv_status ask(vv_answer **answer, vv_measurement **now, again *a, const vv_measurement *m)
{
    cli_command *command = a->command;
    const cli_measure_options *o = cli_command_options(command, &cli_measure_class);
    const vvi_text text = command->text;
    const cli_question question = {.kind = vv_measure_kind_of(m),
                                   .file = {m->file ? m->file : a->scene, m->other},
                                   .edited = a->scene,
                                   .asked = (vv_measurement *)(void *)vv_object_retain(&m->base)};
    command->text = (vvi_text){0};
    vv_status st = cli_measure_ask(answer, now, command, &question);
    if (st == VV_OK) {
        vvi_answer_add_json(&command->json, *answer);
        st = cli_plot_write(command, *answer, question.file[0], o->log);
    }
    vvi_text_free(&command->text);
    command->text = text;
    vv_object_release(&question.asked->base);
    return st;
}

static vv_status keep(again *a, const char *id, vv_measurement *now)
{
    const cli_measure_options *o = cli_command_options(a->command, &cli_measure_class);
    if (!o->update)
        return VV_OK;
    vv_object *root = &a->world->base;
    char *path = vvi_asprintf("measurements.%s", id);
    const vv_status st = path ? vv_path_put(&root, path, &now->base, NULL) : vv_fail_memory(strlen(id));
    a->world = (vv_world *)(void *)root;
    free(path);
    return st;
}

/* A failure of one measurement: of its file or its words. The others are still worth asking. */
static bool stays_alone(vv_status st)
{
    return st == VV_E_ARGUMENT || st == VV_E_NOT_FOUND || st == VV_E_READ || st == VV_E_FORMAT ||
           st == VV_E_UNSUPPORTED;
}

/* before: the JSON without what was said until it failed. */
static void put_failure(again *a, const char *id, const vv_measurement *m, const vvi_result *before)
{
    vvi_result *json = &a->command->json;
    const char *why = vv_error_last()->message;
    a->n_failed++;
    json->depth = before->depth;
    json->filled = before->filled;
    if (json->text.s) {
        json->text.n = before->text.n;
        json->text.s[json->text.n] = 0;
    }
    vvi_result_string(json, "error", why);
    if (a->csv) {
        vvi_text_printf(&a->text, "%s,,,,,,failed\n", id);
        cli_command_note(a->command, "%s", why);
    } else {
        vvi_text_printf(&a->text, "%s: %s, NOT MEASURED: %s\n", id, kind_of(m), why);
    }
}

static bool is_gone(const char *word)
{
    cli_input_name name;
    const bool gone = word && cli_input_split(&name, word) == VV_OK && access(name.path, F_OK) != 0;
    if (word)
        cli_input_name_free(&name);
    return gone;
}

/* A file of its own that is not where it was: where to say its new place. */
static vv_status fail_moved(const vv_measurement *m, const char *id, vv_status st)
{
    const char *const words[] = {m->file, m->other, m->mask, m->values};
    static const char *const names[] = {"file", "other", "mask", "values"};
    char word[160], remedy[200];
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (is_gone(words[i])) {
            snprintf(word, sizeof word, "measurements.%s", id);
            snprintf(remedy, sizeof remedy, "give its new place by --set measurements.%s.%s=FILE", id, names[i]);
            return cli_fail_moved(word, words[i], NULL, remedy);
        }
    return vv_fail_in(st, "measurements.%s", id);
}

static vv_status measure_again(again *a, const char *id, const vv_measurement *m)
{
    vvi_result *json = &a->command->json;
    vv_answer *answer = NULL;
    vv_measurement *now = NULL;
    vvi_result_open(json, NULL, '{');
    vvi_result_string(json, "name", id);
    vvi_result_string(json, "measured", kind_of(m));
    const vvi_result before = *json;
    vv_status st = ask(&answer, &now, a, m);
    if (st == VV_OK) {
        if ((st = put(a, id, m, now, answer)) == VV_OK)
            st = keep(a, id, now);
    } else {
        st = stays_alone(st) ? fail_moved(m, id, st) : vv_fail_in(st, "measurements.%s", id);
    }
    if (st != VV_OK && stays_alone(st)) {
        put_failure(a, id, m, &before);
        st = VV_OK;
    }
    vvi_result_close(json, '}');
    vv_object_release(now ? &now->base : NULL);
    vv_answer_release(answer);
    return st;
}

static bool is_wanted(const char *id, const char *const *names, size_t n)
{
    bool wanted = n == 0;
    for (size_t i = 0; i < n; i++)
        wanted |= strcmp(names[i], id) == 0;
    return wanted;
}

static vv_status check_names(const vv_collection *stored, const char *scene, const char *const *names, size_t n)
{
    enum { MOST = 64 };
    const char *ids[MOST];
    size_t n_ids = 0;
    for (; n_ids < stored->n && n_ids < MOST; n_ids++)
        ids[n_ids] = stored->entry[n_ids].id;
    for (size_t i = 0; i < n; i++) {
        if (!vv_collection_find(stored, names[i]))
            return vvi_fail_name(VV_E_NOT_FOUND, NULL, NULL, names[i], &(vvi_known){ids, n_ids, NULL, NULL},
                                 "%s has no measurement '%s'", scene, names[i]);
    }
    return stored->n ? VV_OK
                     : vv_fail(VV_E_NOT_FOUND,
                               "%s has no measurements; 'volvis measure area %s --store NAME' keeps one", scene, scene);
}

/* A plot is of one. */
static vv_status check_plot(const again *a, const vv_collection *stored, const char *const *names, size_t n)
{
    const vv_measurement *one = NULL;
    size_t n_asked = 0;
    if (!cli_plot_wanted(a->command))
        return VV_OK;
    for (size_t i = 0; i < stored->n; i++)
        if (is_wanted(stored->entry[i].id, names, n)) {
            one = vvi_measurement_nth(a->world, i);
            n_asked++;
        }
    if (n_asked != 1)
        return vv_fail(VV_E_ARGUMENT, "-o %s: a plot is of one measurement, and %zu are asked for: name one of %s",
                       a->command->common->output, n_asked, a->scene);
    return vv_measure_kind_of(one)->plot
               ? VV_OK
               : vv_fail(VV_E_ARGUMENT, "-o %s: histograms and profiles have plots, %s has none",
                         a->command->common->output, kind_of(one));
}

static vv_status measure_all(again *a, const char *const *names, size_t n)
{
    vv_world *before = (vv_world *)(void *)vv_object_retain(&a->world->base); /* figures that are kept change it */
    const vv_collection *stored = before->measurements;
    vv_status st = check_names(stored, a->scene, names, n);
    size_t n_asked = 0;
    if (st == VV_OK)
        st = check_plot(a, stored, names, n);
    vvi_result_open(&a->command->json, "measurements", '[');
    for (size_t i = 0; i < stored->n && st == VV_OK; i++)
        if (is_wanted(stored->entry[i].id, names, n)) {
            n_asked++;
            st = measure_again(a, stored->entry[i].id, vvi_measurement_nth(before, i));
        }
    vvi_result_close(&a->command->json, ']');
    vvi_result_unsigned(&a->command->json, "n_changed", a->n_changed);
    vvi_result_unsigned(&a->command->json, "n_failed", a->n_failed);
    if (!a->csv)
        vvi_text_printf(&a->text, "%zu measured, %zu changed", n_asked - a->n_failed, a->n_changed);
    if (!a->csv && a->n_failed)
        vvi_text_printf(&a->text, ", %zu not measured", a->n_failed);
    if (!a->csv)
        vvi_text_add(&a->text, "\n");
    if (st == VV_OK && !a->csv && cli_plot_wanted(a->command) && !a->n_failed) {
        vvi_text_add(&a->text, "plot: ");
        vvi_text_add_clean(&a->text, a->command->common->output);
        vvi_text_add(&a->text, "\n");
    }
    if (st == VV_OK && n_asked == 1 && a->n_failed)
        st = vv_error_last()->status; /* there is no other to tell */
    vv_object_release(&before->base);
    return st;
}

/* The scene's measurements as --set has them: the files that they are of may be elsewhere by now. What --update writes
 * is that scene, since its figures are of nothing else. */
static vv_status open_scene(vv_world **out, cli_command *command, const char *file)
{
    vv_model *model = NULL;
    vvi_recipe recipe;
    vv_status st = vv_model_new(&model, command->runtime);
    if (st == VV_OK && (st = cli_measure_world(model, &recipe, command, file, true)) == VV_OK)
        *out = vv_model_snapshot(model);
    vv_model_release(model);
    return st;
}

bool cli_measure_has_stored(cli_command *command, const char *file)
{
    vv_world *world = NULL;
    vvi_recipe recipe;
    if (cli_input_contents(command, file) == CLI_INPUT_DATA || cli_input_world(&world, &recipe, command, file) != VV_OK)
        return false;
    const bool some = world->measurements->n > 0;
    vv_object_release(&world->base);
    return some;
}

vv_status cli_measure_stored(cli_command *command, const char *file, const char *const *names, size_t n)
{
    const cli_measure_options *o = cli_command_options(command, &cli_measure_class);
    again a = {.command = command, .scene = file, .csv = o->csv};
    vv_status st = VV_OK;
    if (cli_input_contents(command, file) == CLI_INPUT_DATA)
        return vv_fail(VV_E_ARGUMENT, "%s is not a scene; measurements are stored in scenes, SCENE.vv.json", file);
    if (o->update && cli_input_contents(command, file) != CLI_INPUT_SCENE)
        return vv_fail(VV_E_ARGUMENT, "--update: %s is a picture, and its measurements stay as they are", file);
    if (o->update && cli_output_is(command->common->output, file))
        return vv_fail_at(VV_E_ARGUMENT, command->common->output, NULL,
                          "is the scene that --update writes to; give another name to -o");
    if (o->update && strcmp(file, "-") == 0)
        return vv_fail(VV_E_ARGUMENT, "--update: what comes from standard input cannot be written back");
    if ((st = open_scene(&a.world, command, file)) != VV_OK)
        return st;
    vvi_text_add_clean(&a.text, a.csv ? "measurement,quantity,value,error,unit,was,changed" : file);
    vvi_text_add(&a.text, "\n");
    st = measure_all(&a, names, n);
    if (st == VV_OK && o->update && (a.n_changed + a.n_new || cli_word_nth(command->common->set, 0)))
        st = vv_scene_write(file, a.world, command->job);
    if (st == VV_OK) {
        vvi_text_free(&command->text);
        command->text = a.text;
        a.text = (vvi_text){0};
        command->exit_code = a.n_failed                  ? CLI_EXIT_PARTIAL
                             : a.n_changed && !o->update ? CLI_EXIT_DIFFERS
                                                         : command->exit_code;
    }
    vvi_text_free(&a.text);
    vv_object_release(&a.world->base);
    return st;
}
