/* Which options each thing that is measured has: others would change nothing, and the figure would answer another
 * question than the one that was asked. And what -o makes. */
#include "measure.h"
#include "mesh.h"
#include "model/classes.h"
#include "output.h"
#include "pipeline.h"
#include "refusal.h"
#include "value.h"
#include <stdio.h>
#include <string.h>
#include <strings.h>

static vv_status check_histogram(const cli_command *command, const cli_measure_options *o, const vv_object *asked)
{
    const bool iso = vv_object_is_set(asked, "iso");
    const bool marks = iso || vv_object_is_set(asked, "threshold_lo") || vv_object_is_set(asked, "threshold_hi");
    const char *marked = iso ? "iso" : "threshold";
    if (!cli_plot_wanted(command) && o->log && (o->csv || command->common->json))
        return cli_refused(
            command, "log",
            vv_fail(VV_E_ARGUMENT, "--log is of a histogram's bars and plot, and changes no numbers: omit it"));
    if (!cli_plot_wanted(command) && !vv_object_is_set(asked, "seed") && marks)
        return cli_refused(
            command, marked,
            vv_fail(VV_E_ARGUMENT,
                    "--%s is a mark in a histogram's plot, -o FILE.svg; --range LO..HI is where its bins begin and "
                    "end, --mask and --label name an object",
                    marked));
    return VV_OK;
}

/* What the question is of, without opening it. */
static unsigned is_what(cli_command *command, const cli_question *q, int i)
{
    if (!q->file[i])
        return 0;
    if (cli_mesh_is_input(command, q->file[i]))
        return VV_MEASURED_MESH;
    vv_world *world = i == 0 && q->kind ? cli_measure_mesh_world(command, q) : NULL;
    vv_object_release(world ? &world->base : NULL);
    return world ? VV_MEASURED_SHOWN : VV_MEASURED_VOLUME;
}

static const char *name_of(unsigned input, unsigned other)
{
    if (other)
        return input == VV_MEASURED_MESH && other == VV_MEASURED_MESH ? "two meshes" : "two surfaces";
    return input == VV_MEASURED_SHOWN ? "a scene of meshes" : input == VV_MEASURED_MESH ? "a mesh" : "a volume";
}

/* Options that are no properties, and say what becomes of the result. kind NULL: what is stored. */
static bool is_about_result(const char *option, const vv_measure_kind *kind)
{
    return strcmp(option, "csv") == 0 || strcmp(option, kind ? "store" : "update") == 0 ||
           (strcmp(option, "log") == 0 && (!kind || kind->logarithmic));
}

/* uses: properties of the question. name: what the file is. */
static vv_status check_options(const cli_command *command, const cli_question *q, const char *uses, const char *name)
{
    for (size_t i = 0; i < command->args.n_given; i++) {
        const cli_given *given = &command->args.given[i];
        const bool of_region = given->cls == &vvi_measured_region_class;
        const char *property = of_region ? "region" : given->row->name;
        char option[64];
        /* places on a mesh are in the world anyway */
        const bool is_so = strcmp(property, "space") == 0 && q->asked->space == VV_MEASURE_IN_WORLD &&
                           (vvi_measure_has_word(uses, "points") || vvi_measure_has_word(uses, "region"));
        if ((given->cls != &vvi_measurement_class && given->cls != &cli_measure_class && !of_region) || is_so ||
            is_about_result(property, q->kind) || vvi_measure_has_word(uses, property))
            continue;
        cli_option_name(option, given->row);
        return cli_refused(command, option,
                           vv_fail(VV_E_ARGUMENT, "--%s has no effect on the %s of %s, %s; omit it", option,
                                   q->kind ? q->kind->name : CLI_MEASURE_STORED, q->file[0], name));
    }
    return VV_OK;
}

vv_status cli_measure_check(cli_command *command, const cli_question *q)
{
    const cli_measure_options *o = cli_command_options(command, &cli_measure_class);
    if (o->csv && command->common->json)
        return cli_refused(command, "csv,json",
                           vv_fail(VV_E_ARGUMENT, "--json and --csv: the result has one form, omit one"));
    if (command->common->set && command->common->set->n && cli_mesh_is_input(command, q->file[0]))
        return vv_fail(VV_E_ARGUMENT, "--set: %s is a mesh file, which is measured in its own space: omit it",
                       q->file[0]);
    const unsigned input = is_what(command, q, 0), other = is_what(command, q, 1);
    if (!q->kind)
        return check_options(command, q, "", name_of(input, 0));
    const vv_numbers *points = q->asked->points;
    const vv_measure_form *form = vv_measure_form_of(q->kind, input, other, points ? points->n / 3 : 0);
    if (!form)
        return input == VV_MEASURED_SHOWN ? vvi_measure_refuse(q->kind, input, q->file[0]) : VV_OK;
    const vv_status st = check_options(command, q, form->uses, name_of(input, other));
    return st == VV_OK && q->kind->marks ? check_histogram(command, o, &q->asked->base) : st;
}

/* Output ---------------------------------------------------------------------------------------------------------- */

/* Nothing that is read is replaced, by a plot or by figures. */
static vv_status check_file(cli_command *command)
{
    const char *output = command->common->output;
    const char *const read[] = {cli_measure_typed(command, "mask"), cli_measure_typed(command, "values")};
    vv_status st =
        cli_plot_wanted(command) ? cli_plot_check(command) : cli_output_check(command, output, CLI_OUTPUT_TEXT, NULL);
    for (size_t i = 0; i < sizeof read / sizeof *read && st == VV_OK; i++)
        st = read[i] ? cli_output_spare(command, output, read[i]) : VV_OK;
    return st;
}

vv_status cli_measure_output(cli_command *command, const vv_measure_kind *kind)
{
    cli_measure_options *o = (cli_measure_options *)(uintptr_t)cli_command_options(command, &cli_measure_class);
    const char *output = command->common->output;
    const bool plots = !kind || kind->plot;
    vv_status st;
    if (!output || strcmp(output, "-") == 0)
        return VV_OK;
    const char *suffix = cli_suffix_of(output);
    const bool json = strcasecmp(suffix, ".json") == 0, csv = strcasecmp(suffix, ".csv") == 0;
    if ((json && o->csv) || (csv && command->common->json))
        return vv_fail(VV_E_ARGUMENT, "-o %s: --%s is not what its suffix says", output, json ? "csv" : "json");
    command->common->json = command->common->json || json;
    o->csv = o->csv || csv;
    if (cli_plot_wanted(command))
        return plots ? check_file(command)
                     : vv_fail(VV_E_ARGUMENT,
                               "-o %s: histograms and profiles have plots, %s has none; .json, .csv "
                               "and .txt are there",
                               output, kind->name);
    if (json || csv || strcasecmp(suffix, ".txt") == 0 || (!*suffix && (o->csv || command->common->json)))
        return (st = cli_output_check_text(command, output)) != VV_OK ? st : check_file(command);
    return vv_fail(VV_E_ARGUMENT, "-o %s: the result is written as .json, .csv or .txt%s", output,
                   plots ? ", its plot as .svg, .png or another image" : "");
}

vv_status cli_measure_plan(cli_command *command, const cli_question *q)
{
    const char *file = q->file[0], *second = q->file[1];
    const unsigned is = is_what(command, q, 0);
    cli_input input = {0};
    char about[128];
    snprintf(about, sizeof about, "%s", name_of(is, 0));
    const vv_status st = is == VV_MEASURED_VOLUME ? cli_input_open(&input, command, file) : VV_OK;
    if (st == VV_OK && input.file)
        vvi_samples_print(about, vv_file_info(input.file), vv_file_info(input.file)->n_frames);
    cli_input_close(&input);
    if (st != VV_OK)
        return st;
    cli_command_line(command, "reads", "%s: %s", file, about);
    if (second)
        cli_command_line(command, "", "%s", second);
    cli_command_line(command, "measures", "%s",
                     !q->kind          ? CLI_MEASURE_STORED
                     : q->kind->covers ? q->kind->covers
                                       : q->kind->name);
    vvi_result_bool(&command->json, "dry_run", true);
    return VV_OK;
}
