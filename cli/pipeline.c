#include "pipeline.h"
#include "core/units.h"
#include "findings.h"
#include "grid/true_values.h"
#include "output.h"
#include "value.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void report_info(cli_command *command, const char *output, const vv_field_info *info, const vv_run_about *run)
{
    vvi_result *json = &command->json;
    const double dims[3] = {(double)info->grid.dims[0], (double)info->grid.dims[1], (double)info->grid.dims[2]};
    vvi_result_string(json, "output", output);
    vvi_result_numbers(json, "dims", dims, 3);
    vvi_result_string(json, "type", vv_type_name(info->type));
    vvi_result_integer(json, "components", info->components);
    vvi_result_integer(json, "frames", run->n_frames);
    if (run->n_layers > 0)
        vvi_result_integer(json, "layers", (int64_t)run->n_layers);
}

static void report(cli_command *command, const char *output, const vv_run_about *run)
{
    char about[128], scaled[96] = "";
    const vv_field_info *info = &run->result;
    vvi_samples_print(about, &run->written, run->n_frames);
    if (vvi_has_scale(info) && !vvi_has_scale(&run->written))
        vvi_scaled_print(scaled, vv_type_name(info->type), info->value_scale, info->value_offset);
    report_info(command, output, &run->written, run);
    vvi_result_number(&command->json, "load_s", run->load_s);
    vvi_result_number(&command->json, "run_s", run->run_s);
    vvi_result_number(&command->json, "write_s", run->write_s);
    vvi_result_unsigned(&command->json, "peak_bytes", vv_runtime_memory_peak(command->runtime));
    vvi_result_integer(&command->json, "threads", vv_runtime_threads(command->runtime));
    vvi_result_bool(&command->json, "streamed", run->streamed);
    vvi_text_add_clean(&command->text, output);
    vvi_text_printf(&command->text, ": %s%s%s;", about, *scaled ? ", the values of " : "", scaled);
    cli_findings_report(command);
    if (run->streamed)
        vvi_text_printf(&command->text, " streamed in %.2f s\n", run->run_s + run->write_s);
    else
        vvi_text_printf(&command->text, " read %.2f s, %s %.2f s, written %.2f s\n", run->load_s, command->verb.name,
                        run->run_s, run->write_s);
}

/* Files that can be read only once are left alone. */
static void report_time(cli_command *command, const vvi_run_plan *plan, double n_results)
{
    bool once = false;
    for (size_t i = 0; i < plan->n_inputs; i++)
        once |= plan->inputs[i].name && strcmp(plan->inputs[i].name, "-") == 0;
    const double seconds = once ? NAN : n_results * vvi_run_seconds(plan, command->job);
    if (!isfinite(seconds))
        return;
    char told[32];
    cli_value_duration(told, seconds);
    cli_command_line(command, "takes", "about %s of work, by what its middle takes; then reading and writing", told);
    vvi_result_number(&command->json, "seconds", seconds);
}

static void report_plan(cli_command *command, const char *output, const vvi_run_plan *plan, const vv_run_about *run)
{
    char about[128], needed[32], working[32], scratch[32];
    uint64_t bytes = 0;
    const uint64_t n_results = run->n_layers > 0 ? run->n_layers : (uint64_t)run->n_frames;
    vvi_samples_print(about, &run->info, run->n_frames);
    const uint64_t limit = vv_runtime_memory_limit(vv_job_runtime(command->job));
    vvi_print_bytes(needed, run->streamed ? limit : run->bytes);
    vvi_print_bytes(working, run->working);
    vvi_print_bytes(scratch, run->scratch);
    for (size_t i = 0; i < plan->n_inputs; i++) {
        const vv_run_input *in = &plan->inputs[i];
        const vv_field_info *info = in->file ? vv_file_info(in->file) : NULL;
        char from[128];
        if (!info)
            continue;
        vvi_samples_print(from, info, info->n_frames);
        cli_command_line(command, "reads", "%s: %s", in->name, from);
    }
    cli_command_line(command, "makes", "%s: %s%s", output, about,
                     run->finds_type ? ", as values: in the smallest type that holds them" : "");
    cli_command_line(command, "needs", "%s%s%s%s%s%s", run->streamed ? "at most " : "", needed,
                     run->streamed ? ", the limit, slab by slab" : " for samples and results",
                     run->scratch   ? "; temporary files of "
                     : run->working ? "; about "
                                    : "",
                     run->scratch   ? scratch
                     : run->working ? working
                                    : "",
                     run->working ? " to work with" : "");
    report_time(command, plan, (double)n_results);
    report_info(command, output, &run->info, run);
    if (vv_field_info_bytes(&bytes, &run->info) == VV_OK)
        vvi_result_unsigned(&command->json, "output_bytes", bytes * n_results);
    vvi_result_unsigned(&command->json, "working_bytes", run->working);
    vvi_result_unsigned(&command->json, "memory_bytes", run->streamed ? limit : run->bytes + run->working);
    vvi_result_unsigned(&command->json, "scratch_bytes", run->scratch);
    vvi_result_bool(&command->json, "streamed", run->streamed);
    vvi_result_bool(&command->json, "dry_run", true);
}

/* Runs and reports what is planned. */
static vv_status finish(cli_command *command, const char *output, const vvi_run_plan *plan, vv_run *run)
{
    const vv_run_about *about = vv_run_get_about(run);
    if (about->n_layers > 0)
        cli_command_note(command, "%s: all %zu layers go into %s", plan->inputs[0].name, about->n_layers, output);
    const vv_status st = command->common->dry_run ? vvi_run_try(run) : vv_run_write(run);
    if (st == VV_OK && command->common->dry_run)
        report_plan(command, output, plan, about);
    else if (st == VV_OK)
        report(command, output, about);
    return st;
}

/* A type that was asked for is that of the numbers in the file, also where a scale makes values of them: as --stored.
 * True: nobody asked for that. */
static bool keep_type(vv_write_options *options, const cli_command *command, const vv_step *last)
{
    const vv_format *format;
    if (options->stored || !last || !last->params || !vv_object_is_set(last->params, "type") ||
        cli_output_format(&format, command, command->common->output, options->format) != VV_OK || format->keeps_scale)
        return false;
    options->stored = true;
    return true;
}

vv_status cli_pipeline_run_plan(cli_command *command, const vvi_run_plan *plan)
{
    vv_write_options options;
    const vv_run_output output = {command->common->output, &options};
    vv_run *run = NULL;
    cli_output_options(&options, command);
    const bool kept = keep_type(&options, command, plan->n_steps ? &plan->steps[plan->n_steps - 1] : NULL);
    vv_status st = vvi_run_new(&run, plan, &output, command->job);
    if (st == VV_OK)
        st = finish(command, output.path, plan, run);
    if (st == VV_OK && kept && vvi_has_scale(&vv_run_get_about(run)->written) && !command->common->dry_run)
        cli_command_note(command,
                         "%s: numbers of the type that was asked for, and beside them the scale that makes values of "
                         "them, which other programs may not know",
                         output.path);
    vv_run_release(run);
    return st;
}

vv_status cli_pipeline_run(cli_command *command, const cli_input *inputs, size_t n_inputs, const vv_step *steps,
                           size_t n_steps)
{
    const cli_args *args = &command->args;
    vv_run_input files[VVI_RUN_INPUTS] = {{0}};
    vvi_run_plan plan = {
        .inputs = files, .n_inputs = n_inputs, .steps = steps, .n_steps = n_steps, .name = command->verb.name};
    for (size_t i = 0; i < n_inputs && n_inputs <= VVI_RUN_INPUTS; i++) {
        const cli_input *in = &inputs[i];
        const size_t place = args->placed ? args->place[i] : i; /* what is left out is a gap */
        files[place] =
            (vv_run_input){.file = in->file, .frame = in->frame, .name = in->path, .path = in->path, .part = in->part};
        plan.n_inputs = place + 1 > n_inputs ? place + 1 : n_inputs;
    }
    return cli_pipeline_run_plan(command, &plan);
}
