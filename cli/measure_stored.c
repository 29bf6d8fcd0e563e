/* The measurements of a scene once more, and whether they give what they gave. */
#include "core/memory.h"
#include "core/units.h"
#include "grid/label_id.h"
#include "measure.h"
#include "measure_plot.h"
#include "model/classes.h"
#include "output.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SAME 1e-9 /* what another processor may make of the last digits */

typedef struct again {
    cli_command *command;
    const char *scene;
    vv_world *world;
    size_t n_changed, n_new, n_failed;
    vvi_text text; /* what the program says; the command's own text is that of each measurement meanwhile */
    bool csv;
} again;

/* Back to options -----------------------------------------------------------------------------------------------------
 */

static void add_text(vvi_text *out, const char *name, const char *value)
{
    vvi_text_printf(out, "%s\"%s\": ", out->n > 1 ? ", " : "", name);
    vvi_text_json(out, value);
}

static void print_row(char out[128], const double *v, size_t n)
{
    size_t at = 0;
    for (size_t i = 0; i < n; i++)
        at += (size_t)snprintf(out + at, 128 - at, "%s%.17g", i ? "," : "", v[i]);
}

static void add_row(vvi_text *out, const char *name, const double *v, size_t n)
{
    char row[128];
    print_row(row, v, n);
    add_text(out, name, row);
}

static void add_threshold(vvi_text *out, const vv_measurement *m)
{
    char lo[32] = "", hi[32] = "", both[72];
    const bool from = vv_object_is_set(&m->base, "threshold_lo"), to = vv_object_is_set(&m->base, "threshold_hi");
    if (from)
        vvi_print_number(lo, m->threshold_lo);
    if (to)
        vvi_print_number(hi, m->threshold_hi);
    snprintf(both, sizeof both, "%s,%s", lo, hi);
    if (from || to)
        add_text(out, "threshold", both);
}

static void begin_words(vvi_text *out, const char *name)
{
    vvi_text_printf(out, "%s\"%s\": [", out->n > 1 ? ", " : "", name);
}

static void add_words(vvi_text *out, const vv_measurement *m)
{
    char row[128], normal[128];
    if (m->points && m->points->n) {
        begin_words(out, "point");
        for (size_t i = 0; i + 3 <= m->points->n; i += 3) {
            print_row(row, m->points->v + i, 3);
            vvi_text_printf(out, "%s{\"text\": \"%s\"}", i ? ", " : "", row);
        }
        vvi_text_add(out, "]");
    }
    if (!m->cut_planes->n)
        return;
    begin_words(out, "clip");
    for (size_t i = 0; i < m->cut_planes->n; i++) {
        const vv_cut_plane *p = (const vv_cut_plane *)(const void *)m->cut_planes->entry[i].object;
        print_row(normal, &p->normal.x, 3);
        print_row(row, &p->offset, 1);
        vvi_text_printf(out, "%s{\"text\": \"plane(n=%s d=%s)\"}", i ? ", " : "", normal, row);
    }
    vvi_text_add(out, "]");
}

static void add_same(vvi_text *out, const vv_measurement *m)
{
    static const char *const names[] = {"space", "box", "component", "method", "closed", "bins", "samples"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char *json = NULL;
        if (!vv_object_is_set(&m->base, names[i]))
            continue;
        if (vv_path_get(&json, &m->base, names[i]) == VV_OK)
            vvi_text_printf(out, "%s\"%s\": %s", out->n > 1 ? ", " : "", names[i], json);
        free(json);
    }
}

static vv_status make_options(vv_object **out, const vv_measurement *m)
{
    char digits[VVI_LABEL_DIGITS];
    vvi_text json = {0};
    vvi_text_add(&json, "{");
    if (vv_object_is_set(&m->base, "iso"))
        add_row(&json, "iso", &m->iso, 1);
    if (vv_object_is_set(&m->base, "other_iso"))
        add_row(&json, "other_iso", &m->other_iso, 1);
    add_threshold(&json, m);
    if (vv_object_is_set(&m->base, "label"))
        add_text(&json, "label", vvi_label_print(digits, m->label, false));
    if (vv_object_is_set(&m->base, "other_label"))
        add_text(&json, "other_label", vvi_label_print(digits, m->other_label, false));
    if (m->mask)
        add_text(&json, "mask", m->mask);
    if (m->values)
        add_text(&json, "values", m->values);
    if (m->input_unit)
        add_text(&json, "input_unit", m->input_unit);
    if (vv_object_is_set(&m->base, "seed"))
        add_row(&json, "seed", &m->seed.x, 3);
    if (m->range && m->range->n == 2)
        add_row(&json, "range", m->range->v, 2);
    add_words(&json, m);
    add_same(&json, m);
    vvi_text_add(&json, "}");
    const vv_status st =
        json.bad ? vv_fail_memory(json.n) : vv_object_from_json(out, &cli_measure_class, json.s, json.n, NULL);
    vvi_text_free(&json);
    return st;
}

/* Then and now
 * ---------------------------------------------------------------------------------------------------------- */

static const vv_measured_figure *figure_nth(const vv_collection *figures, size_t i)
{
    return (const vv_measured_figure *)(const void *)figures->entry[i].object;
}

static const vv_measured_figure *figure_of(const vv_collection *figures, const char *name)
{
    for (size_t i = 0; i < figures->n; i++)
        if (strcmp(figure_nth(figures, i)->name ? figure_nth(figures, i)->name : "", name) == 0)
            return figure_nth(figures, i);
    return NULL;
}

static double value_of(const vv_measured_figure *f)
{
    return f && vv_object_is_set(&f->base, "value") ? f->value : NAN;
}

static double error_of(const vv_measured_figure *f)
{
    return f && vv_object_is_set(&f->base, "error") ? f->error : NAN;
}

static bool same(const vv_measured_figure *a, const vv_measured_figure *b)
{
    const double x = value_of(a), y = value_of(b);
    if (!a || !b || isnan(x) != isnan(y) || strcmp(a->unit ? a->unit : "", b->unit ? b->unit : "") != 0)
        return false;
    return isnan(x) || fabs(x - y) <= SAME * fmax(fmax(fabs(x), fabs(y)), fmax(0, error_of(b)));
}

static void print_figure(char out[96], const vv_measured_figure *f)
{
    cli_figure shown = {.value = value_of(f), .error = error_of(f)};
    snprintf(shown.unit, sizeof shown.unit, "%s", f->unit ? f->unit : "");
    cli_figure_print(out, &shown);
}

/* Of many figures a few are told; the others only when they change. */
static bool is_told(const char *name)
{
    static const char *const quiet[] = {"percentile_", "label_"};
    for (size_t i = 0; i < sizeof quiet / sizeof *quiet; i++)
        if (strncmp(name, quiet[i], strlen(quiet[i])) == 0)
            return false;
    return true;
}

static void put_row(vvi_text *out, const char *id, const vv_measured_figure *now, const vv_measured_figure *was)
{
    char number[3][32] = {"", "", ""};
    const double v[3] = {value_of(now), error_of(now), value_of(was)};
    for (int i = 0; i < 3; i++)
        if (isfinite(v[i]))
            vvi_print_number(number[i], v[i]);
    vvi_text_printf(out, "%s,%s,%s,%s,%s,%s,%s\n", id, now->name, number[0], number[1], now->unit ? now->unit : "",
                    number[2],
                    !was             ? "new"
                    : same(was, now) ? "no"
                                     : "yes");
}

/* The figure of the same place along another axis, when both are as they were; NULL: it is not. */
static const vv_measured_figure *along(const vv_collection *now, const vv_collection *then, const char *base, char axis)
{
    char name[208];
    snprintf(name, sizeof name, "%s_%c", base, axis);
    const vv_measured_figure *f = figure_of(now, name), *was = figure_of(then, name);
    return then->n && !same(was, f) ? NULL : f;
}

/* Three numbers of a place as one line, with `name`_x; false: they are told one by one. */
static bool put_place(vvi_text *out, const char *name, const vv_collection *now, const vv_collection *then)
{
    char text[3][96], base[192];
    const size_t n = strlen(name);
    if (n < 3 || n >= sizeof base || name[n - 2] != '_' || !strchr("xyz", name[n - 1]) || !is_told(name))
        return false;
    snprintf(base, sizeof base, "%.*s", (int)(n - 2), name);
    for (int a = 0; a < 3; a++) {
        const vv_measured_figure *f = along(now, then, base, "xyz"[a]);
        if (!f)
            return false;
        const cli_figure shown = {.value = value_of(f), .error = error_of(f)};
        cli_figure_print(text[a], &shown);
    }
    if (name[n - 1] != 'x')
        return true;
    const char *unit = figure_of(now, name)->unit;
    vvi_text_printf(out, "  %-16s %s, %s, %s %s\n", base, text[0], text[1], text[2], unit ? unit : "");
    return true;
}

/* compared: there were figures before. */
static void put_line(vvi_text *out, const vv_measured_figure *now, const vv_measured_figure *was, bool compared)
{
    char text[96], before[96] = "";
    print_figure(text, now);
    const bool changed = was && !same(was, now), is_new = compared && !was;
    if (changed)
        print_figure(before, was);
    if (changed || is_new || is_told(now->name))
        vvi_text_printf(out, "  %-16s %s%s%s\n", now->name, text,
                        changed  ? "; it was "
                        : is_new ? "; new"
                                 : "",
                        before);
}

static void put_gone(vvi_text *out, bool csv, const char *id, const vv_measured_figure *was)
{
    char text[96], number[32] = "";
    print_figure(text, was);
    if (isfinite(value_of(was)))
        vvi_print_number(number, value_of(was));
    if (csv)
        vvi_text_printf(out, "%s,%s,,,%s,%s,gone\n", id, was->name, was->unit ? was->unit : "", number);
    else
        vvi_text_printf(out, "  %-16s gone; it was %s\n", was->name, text);
}

/* Telling
 * ----------------------------------------------------------------------------------------------------------------- */

static const char *kind_of(const vv_measurement *m)
{
    return vv_class_find(&vvi_measurement_class, "what")->names[m->what];
}

static void put_change_json(vvi_result *json, const char *name, const vv_measured_figure *was,
                            const vv_measured_figure *now)
{
    vvi_result_open(json, NULL, '{');
    vvi_result_string(json, "name", name);
    vvi_result_number(json, "was", value_of(was));
    vvi_result_number(json, "is", value_of(now));
    vvi_result_close(json, '}');
}

static size_t put_changes_json(vvi_result *json, const vv_collection *then, const vv_collection *now)
{
    size_t n = 0;
    vvi_result_open(json, "changes", '[');
    for (size_t i = 0; i < now->n && then->n; i++) {
        const vv_measured_figure *f = figure_nth(now, i), *was = figure_of(then, f->name);
        if (same(was, f))
            continue;
        n++;
        put_change_json(json, f->name, was, f);
    }
    for (size_t i = 0; i < then->n; i++)
        if (!figure_of(now, figure_nth(then, i)->name)) {
            n++;
            put_change_json(json, figure_nth(then, i)->name, figure_nth(then, i), NULL);
        }
    vvi_result_close(json, ']');
    vvi_result_bool(json, "changed", n > 0);
    return n;
}

/* What was measured: the object, with its value where VolVis chose it, and the part. */
static void put_subject(vvi_text *out, const cli_result *result, const vv_measurement *m)
{
    if (*result->object)
        vvi_text_printf(out, "  %-16s %s\n", "object", result->object);
    if (*result->region)
        vvi_text_printf(out, "  %-16s %s\n", "region", result->region);
    for (size_t i = 0; i < m->cut_planes->n; i++) {
        const vv_cut_plane *p = (const vv_cut_plane *)(const void *)m->cut_planes->entry[i].object;
        vvi_text_printf(out, "  %-16s plane(n=%g,%g,%g d=%g)\n", i ? "" : "cut planes", p->normal.x, p->normal.y,
                        p->normal.z, p->offset);
    }
    if (m->mask)
        vvi_text_printf(out, "  %-16s %s\n", "mask", m->mask);
    if (m->values)
        vvi_text_printf(out, "  %-16s %s\n", "values", m->values);
}

static void put(again *a, const char *id, const vv_measurement *then, const vv_measurement *now,
                const cli_result *result)
{
    const size_t n = put_changes_json(&a->command->json, then->figures, now->figures);
    a->n_changed += n > 0;
    a->n_new += then->figures->n == 0;
    if (!a->csv)
        vvi_text_printf(&a->text, "%s: %s%s%s, %s\n", id, kind_of(then), then->file ? " of " : "",
                        then->file ? then->file : "",
                        then->figures->n == 0 ? "for the first time"
                        : n                   ? "CHANGED"
                                              : "as before");
    if (!a->csv)
        put_subject(&a->text, result, then);
    for (size_t i = 0; i < now->figures->n; i++) {
        const vv_measured_figure *f = figure_nth(now->figures, i), *was = figure_of(then->figures, f->name);
        if (a->csv)
            put_row(&a->text, id, f, was);
        else if (!put_place(&a->text, f->name, now->figures, then->figures))
            put_line(&a->text, f, was, then->figures->n > 0);
    }
    for (size_t i = 0; i < then->figures->n; i++)
        if (!figure_of(now->figures, figure_nth(then->figures, i)->name))
            put_gone(&a->text, a->csv, id, figure_nth(then->figures, i));
}

/* Asking
 * ----------------------------------------------------------------------------------------------------------------- */

static size_t place_of_options(const cli_command *command)
{
    size_t i = 0;
    while (command->options[i]->cls != &cli_measure_class)
        i++;
    return i;
}

/* Its options take the place of the command's while it is asked; what it says as text is left aside. */
static vv_status ask(cli_result *result, const again *a, const vv_measurement *m)
{
    cli_command *command = result->command;
    const size_t at = place_of_options(command);
    vv_object *const given = command->options[at];
    const vvi_text text = command->text;
    const cli_question question = {kind_of(m), {m->file ? m->file : a->scene, m->other}};
    vv_object *options = NULL;
    vv_status st = make_options(&options, m);
    if (st != VV_OK)
        return st;
    ((cli_measure_options *)(void *)options)->log = ((const cli_measure_options *)(const void *)given)->log;
    command->options[at] = options;
    command->text = (vvi_text){0};
    st = cli_measure_ask(result, &question);
    vvi_text_free(&command->text);
    command->text = text;
    command->options[at] = given;
    vv_object_release(options);
    return st;
}

static vv_status keep(again *a, const char *id, const char *figures)
{
    const cli_measure_options *o = cli_command_options(a->command, &cli_measure_class);
    if (!o->update)
        return VV_OK;
    vv_object *root = &a->world->base;
    char *path = vvi_asprintf("measurements.%s.figures", id);
    const vv_status st = path ? vv_path_set(&root, path, figures, NULL) : vv_fail_memory(strlen(id));
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

static vv_status measure_again(again *a, const char *id, const vv_measurement *m)
{
    vvi_result *json = &a->command->json;
    cli_result result = {.command = a->command, .edited = a->scene};
    vv_object *now = NULL;
    vvi_text figures = {0};
    vvi_result_open(json, NULL, '{');
    vvi_result_string(json, "name", id);
    vvi_result_string(json, "measured", kind_of(m));
    const vvi_result before = *json;
    vv_status st = ask(&result, a, m);
    if (st == VV_OK) {
        vvi_text_printf(&figures, "{\"figures\": [%s]}", result.figures.n ? result.figures.s : "");
        st = figures.bad || result.figures.bad
                 ? vv_fail_memory(figures.n)
                 : vv_object_from_json(&now, &vvi_measurement_class, figures.s, figures.n, NULL);
    }
    if (st == VV_OK) {
        put(a, id, m, (const vv_measurement *)(const void *)now, &result);
        figures.s[figures.n - 1] = 0;
        st = keep(a, id, figures.s + strlen("{\"figures\": "));
    } else {
        st = vv_fail_in(st, "measurements.%s", id);
    }
    if (st != VV_OK && stays_alone(st)) {
        put_failure(a, id, m, &before);
        st = VV_OK;
    }
    vvi_result_close(json, '}');
    vv_object_release(now);
    vvi_text_free(&figures);
    cli_result_free(&result);
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
        const char *near = vv_collection_find(stored, names[i]) ? names[i] : vv_nearest_name(names[i], ids, n_ids);
        if (near != names[i])
            return vv_fail(VV_E_NOT_FOUND, "%s has no measurement '%s'%s%s%s", scene, names[i],
                           near ? "; did you mean '" : "", near ? near : "", near ? "'?" : "");
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
            one = (const vv_measurement *)(const void *)stored->entry[i].object;
            n_asked++;
        }
    if (n_asked != 1)
        return vv_fail(VV_E_ARGUMENT, "-o %s: a plot is of one measurement, and %zu are asked for: name one of %s",
                       a->command->common->output, n_asked, a->scene);
    return cli_measure_has_plot(kind_of(one))
               ? VV_OK
               : vv_fail(VV_E_ARGUMENT, "-o %s: histograms and profiles have plots, %s has none",
                         a->command->common->output, kind_of(one));
}

static vv_status measure_all(again *a, const char *const *names, size_t n)
{
    const vv_object *before = vv_object_retain(&a->world->base); /* the World changes where figures are kept */
    const vv_collection *stored = ((const vv_world *)(const void *)before)->measurements;
    vv_status st = check_names(stored, a->scene, names, n);
    size_t n_asked = 0;
    if (st == VV_OK)
        st = check_plot(a, stored, names, n);
    vvi_result_open(&a->command->json, "measurements", '[');
    for (size_t i = 0; i < stored->n && st == VV_OK; i++)
        if (is_wanted(stored->entry[i].id, names, n)) {
            n_asked++;
            st = measure_again(a, stored->entry[i].id, (const vv_measurement *)(const void *)stored->entry[i].object);
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
    vv_object_release((vv_object *)(uintptr_t)before);
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
    vvi_recipe recipe;
    vv_status st = VV_OK;
    if (cli_input_contents(command, file) == CLI_INPUT_DATA)
        return vv_fail(VV_E_ARGUMENT, "%s is not a scene; measurements are stored in scenes, SCENE.vv.json", file);
    if (o->update && cli_input_contents(command, file) != CLI_INPUT_SCENE)
        return vv_fail(VV_E_ARGUMENT, "--update: %s is a picture, and its measurements stay as they are", file);
    if (o->update && command->common->set && command->common->set->n)
        return vv_fail(VV_E_ARGUMENT, "--update keeps figures of the scene as it is: leave --set out");
    if (o->update && cli_output_is(command->common->output, file))
        return vv_fail_at(VV_E_ARGUMENT, command->common->output, NULL,
                          "is the scene that --update writes to; give another name to -o");
    if (o->update && strcmp(file, "-") == 0)
        return vv_fail(VV_E_ARGUMENT, "--update: what comes from standard input cannot be written back");
    if ((st = cli_input_world(&a.world, &recipe, command, file)) != VV_OK)
        return st;
    vvi_text_printf(&a.text, a.csv ? "measurement,quantity,value,error,unit,was,changed\n" : "%s\n", file);
    st = measure_all(&a, names, n);
    if (st == VV_OK && o->update && a.n_changed + a.n_new)
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
