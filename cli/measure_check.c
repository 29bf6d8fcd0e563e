/* Which options each thing that is measured has: others would change nothing, and the figure would answer another
 * question than the one that was asked. And what -o makes. */
#include "measure.h"
#include "measuring/meshes.h"
#include "measure_plot.h"
#include "mesh.h"
#include "output.h"
#include "pipeline.h"
#include "refusal.h"
#include <stdio.h>
#include <string.h>
#include <strings.h>

#define OBJECT "iso threshold label mask seed space box clip component "

/* Of volumes, and of meshes; every kind also has --csv. */
static const struct {
    const char *kind, *options, *mesh_options;
} kinds[] = {
    {"summary", OBJECT "method closed", "input_unit"},
    {"area", OBJECT "method closed", "input_unit"},
    {"volume", OBJECT "method", "input_unit"},
    {"box", OBJECT "method", "input_unit"},
    {"statistics", OBJECT, NULL},
    {"histogram", OBJECT "bins range log", NULL},
    {"joint", OBJECT "bins range", NULL},
    {"profile", "point space samples component", NULL},
    {"distance", "point space", "point input_unit"}, /* of two places; others see options_of() */
    {"geodesic", "point space iso label seed component box clip", "point input_unit"},
    {"angle", "point space", NULL},
    {"labels", "values component method box clip", NULL},
    {"stored", "update log", NULL},
};

static bool has_word(const char *list, const char *word)
{
    const size_t n = strlen(word);
    for (const char *at = list; (at = strstr(at, word)) != NULL; at += n)
        if ((at == list || at[-1] == ' ') && (at[n] == ' ' || at[n] == 0))
            return true;
    return false;
}

static vv_status check_histogram(const cli_command *command, const cli_measure_options *o)
{
    const char *marked = o->iso ? "iso" : "threshold";
    if (!cli_plot_wanted(command) && o->log && (o->csv || command->common->json))
        return cli_refused(
            command, "log",
            vv_fail(VV_E_ARGUMENT, "--log is of a histogram's bars and plot, and changes no numbers: omit it"));
    if (!cli_plot_wanted(command) && !o->seed && (o->iso || o->threshold))
        return cli_refused(
            command, marked,
            vv_fail(VV_E_ARGUMENT,
                    "--%s is a mark in a histogram's plot, -o FILE.svg; --range LO..HI is where its bins begin and "
                    "end, --mask and --label name an object",
                    marked));
    return VV_OK;
}

/* Options of a kind of this question; NULL: any. */
static const char *options_of(const cli_command *command, const cli_measure_options *o, const cli_question *q)
{
    const bool mesh = cli_mesh_is_input(command, q->file[0]);
    if (strcmp(q->kind, "distance") == 0 && q->file[1]) {
        const bool second = cli_mesh_is_input(command, q->file[1]);
        return mesh && second   ? "input_unit"
               : mesh || second ? "iso other_iso label other_label component box clip input_unit"
                                : "iso other_iso label other_label component box clip";
    }
    if (strcmp(q->kind, "distance") == 0 && !mesh && o->point && o->point->n == 1)
        return "point space iso label seed component box clip";
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (strcmp(kinds[i].kind, q->kind) == 0)
            return mesh ? kinds[i].mesh_options : kinds[i].options;
    return NULL;
}

static const char *name_of(const cli_command *command, const cli_question *q)
{
    const bool mesh = cli_mesh_is_input(command, q->file[0]);
    if (q->file[1])
        return mesh && cli_mesh_is_input(command, q->file[1]) ? "two meshes" : "two surfaces";
    return mesh ? "a mesh" : "a volume";
}

/* known: of the kind; NULL: any. name: what the file is. */
static vv_status check_options(const cli_command *command, const cli_measure_options *o, const cli_question *q,
                               const char *known, const char *name)
{
    for (const vv_property *p = cli_measure_class.properties; p->name && known; p++) {
        char option[64];
        cli_option_name(option, p);
        const bool any =
            strcmp(p->name, "csv") == 0 || (strcmp(p->name, "store") == 0 && strcmp(q->kind, "stored") != 0);
        /* places on a mesh are in the world anyway */
        const bool is_so = strcmp(p->name, "space") == 0 && o->space == CLI_SPACE_WORLD && has_word(known, "point");
        if (any || is_so || !vv_object_is_set(&o->base, p->name) || has_word(known, p->name))
            continue;
        return cli_refused(command, option,
                           vv_fail(VV_E_ARGUMENT, "--%s has no effect on the %s of %s, %s; omit it", option, q->kind,
                                   q->file[0], name));
    }
    return VV_OK;
}

static bool shows_meshes(cli_command *command, const cli_question *q)
{
    vv_world *world = strcmp(q->kind, "stored") ? cli_measure_mesh_world(command, q->file[0], q->file[0]) : NULL;
    vv_object_release(world ? &world->base : NULL);
    return world != NULL;
}

static vv_status check_mesh_scene(const cli_command *command, const cli_measure_options *o, const cli_question *q)
{
    const bool area = strcmp(q->kind, "summary") == 0 || strcmp(q->kind, "area") == 0;
    const vv_status st = cli_measure_mesh_scene_check(q->kind, q->file[0]);
    return st == VV_OK ? check_options(command, o, q, area ? "closed" : "", "a scene of meshes") : st;
}

vv_status cli_measure_check(cli_command *command, const cli_question *q)
{
    const cli_measure_options *o = cli_command_options(command, &cli_measure_class);
    const char *known = options_of(command, o, q);
    if (o->csv && command->common->json)
        return cli_refused(command, "csv,json",
                           vv_fail(VV_E_ARGUMENT, "--json and --csv: the result has one form, omit one"));
    if (command->common->set && command->common->set->n && cli_mesh_is_input(command, q->file[0]))
        return vv_fail(VV_E_ARGUMENT, "--set: %s is a mesh file, which is measured in its own space: omit it",
                       q->file[0]);
    if (shows_meshes(command, q))
        return check_mesh_scene(command, o, q);
    const vv_status st = check_options(command, o, q, known, name_of(command, q));
    return st == VV_OK && known && strcmp(q->kind, "histogram") == 0 ? check_histogram(command, o) : st;
}

/* Output ---------------------------------------------------------------------------------------------------------- */

static const char *suffix_of(const char *path)
{
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');
    return dot ? dot : "";
}

/* Nothing that is read is replaced, by a plot or by figures. */
static vv_status check_file(cli_command *command, const cli_measure_options *o)
{
    const char *output = command->common->output;
    const char *const read[] = {o->mask, o->values};
    vv_status st =
        cli_plot_wanted(command) ? cli_plot_check(command) : cli_output_check(command, output, CLI_OUTPUT_TEXT, NULL);
    for (size_t i = 0; i < sizeof read / sizeof *read && st == VV_OK; i++)
        st = read[i] ? cli_output_spare(command, output, read[i]) : VV_OK;
    return st;
}

bool cli_measure_has_plot(const char *kind)
{
    return strcmp(kind, "histogram") == 0 || strcmp(kind, "joint") == 0 || strcmp(kind, "profile") == 0;
}

vv_status cli_measure_output(cli_command *command, const char *kind)
{
    cli_measure_options *o = (cli_measure_options *)(void *)command->options[0];
    const char *output = command->common->output;
    const bool plots = cli_measure_has_plot(kind) || strcmp(kind, "stored") == 0;
    vv_status st;
    if (!output || strcmp(output, "-") == 0)
        return VV_OK;
    const char *suffix = suffix_of(output);
    const bool json = strcasecmp(suffix, ".json") == 0, csv = strcasecmp(suffix, ".csv") == 0;
    if ((json && o->csv) || (csv && command->common->json))
        return vv_fail(VV_E_ARGUMENT, "-o %s: --%s is not what its suffix says", output, json ? "csv" : "json");
    command->common->json = command->common->json || json;
    o->csv = o->csv || csv;
    if (cli_plot_wanted(command))
        return plots ? check_file(command, o)
                     : vv_fail(VV_E_ARGUMENT,
                               "-o %s: histograms and profiles have plots, %s has none; .json, .csv "
                               "and .txt are there",
                               output, kind);
    if (json || csv || strcasecmp(suffix, ".txt") == 0 || (!*suffix && (o->csv || command->common->json)))
        return (st = cli_output_check_text(command, output)) != VV_OK ? st : check_file(command, o);
    return vv_fail(VV_E_ARGUMENT, "-o %s: the result is written as .json, .csv or .txt%s", output,
                   plots ? ", its plot as .svg, .png or another image" : "");
}

vv_status cli_measure_plan(cli_command *command, const cli_question *q)
{
    const char *kind = q->kind, *file = q->file[0], *second = q->file[1];
    cli_input input = {0};
    char about[128] = "a mesh";
    const bool meshes = shows_meshes(command, q);
    vv_status st = VV_OK;
    if (meshes)
        snprintf(about, sizeof about, "a scene of meshes");
    if (!meshes && !cli_mesh_is_input(command, file) && (st = cli_input_open(&input, command, file)) == VV_OK)
        cli_describe_info(about, vv_file_info(input.file), vv_file_info(input.file)->n_frames);
    cli_input_close(&input);
    if (st != VV_OK)
        return st;
    cli_command_line(command, "reads", "%s: %s", file, about);
    if (second)
        cli_command_line(command, "", "%s", second);
    cli_command_line(command, "measures", "%s", strcmp(kind, "summary") != 0 ? kind : "statistics, area, volume, box");
    vvi_result_bool(&command->json, "dry_run", true);
    return VV_OK;
}
