/* Operations of the registry as verbs. */
#include "channel_names.h"
#include "command.h"
#include "mesh_pipeline.h"
#include "operands.h"
#include "output.h"
#include "pipeline.h"
#include "refusal.h"
#include "verbs.h"
#include "watch.h"
#include <stdlib.h>

static vv_status open_inputs(cli_input **out, cli_command *command)
{
    vv_status st = VV_OK;
    const size_t n = command->args.n_words;
    *out = calloc(n, sizeof **out);
    if (!*out)
        return vv_fail_memory(n * sizeof **out);
    for (size_t i = 0; i < n && st == VV_OK; i++)
        st = cli_input_open(&(*out)[i], command, command->args.words[i]);
    return st;
}

/* Whose labels options name. */
static const cli_input *input_of_labels(const cli_command *command, const cli_input *inputs)
{
    for (size_t i = 1; i < command->args.n_words; i++)
        if (vv_operation_operand(command->verb.operation, i)->names_labels)
            return &inputs[i];
    return &inputs[0];
}

static vv_status run_on_fields(cli_command *command)
{
    const cli_writing *writing = cli_command_options(command, &cli_writing_class);
    vv_step step = {.operation = command->verb.operation};
    cli_input *inputs = NULL;
    const char *output;
    vv_status st;
    if ((st = cli_output_need(&output, command, "the result")) != VV_OK ||
        (st = cli_output_check(command, output, CLI_OUTPUT_VOLUME, writing->output_format)) != VV_OK ||
        (st = cli_command_start(command)) != VV_OK)
        return st;
    if ((st = open_inputs(&inputs, command)) == VV_OK) {
        const cli_label_names labels = cli_label_names_of(command, input_of_labels(command, inputs));
        st = cli_operation_params(&step.params, command, &command->args, step.operation->params,
                                  vv_file_info(inputs[0].file), &inputs[0], &labels);
    }
    if (st == VV_OK)
        st = cli_refuse_idle(command, step.params, NULL);
    if (st == VV_OK)
        st = cli_pipeline_run(command, inputs, command->args.n_words, &step, 1);
    if (st == VV_E_ARGUMENT)
        cli_refused_class(command, step.operation->params, st);
    vv_object_release(step.params);
    for (size_t i = 0; inputs && i < command->args.n_words; i++)
        cli_input_close(&inputs[i]);
    free(inputs);
    return st;
}

static bool makes_mesh(const vv_operation *operation)
{
    return vv_operation_makes(operation) == VV_IS_MESH;
}

static vv_status run(cli_command *command)
{
    return makes_mesh(command->verb.operation) ? cli_mesh_pipeline_run(command) : run_on_fields(command);
}

cli_verb cli_verb_of_operation(const vv_operation *operation)
{
    return (cli_verb){
        .name = operation->name,
        .doc = operation->doc,
        .words = cli_operands_usage(operation),
        .choices = "files",
        .min_words = vv_operation_least(operation),
        .max_words = vv_operation_most(operation),
        .options = {operation->params,
                    vv_class_find(operation->params, "missing") ? &cli_reading_rest_class : &cli_reading_class,
                    &cli_writing_class, &cli_watching_class, makes_mesh(operation) ? &cli_timing_class : NULL},
        .own = operation->params,
        .makes_file = true,
        .each_input = vv_operation_least(operation) == 1 && operation->inputs[0].most == 1,
        .in_out = vv_operation_most(operation) == 1,
        .run = run,
        .operation = operation,
    };
}
