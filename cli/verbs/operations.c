#include "command.h"
#include "help.h"
#include "properties.h"
#include "usage.h"
#include "verbs.h"
#include <string.h>

static const char *word_of(unsigned is)
{
    return is == VV_IS_FIELD ? "volume" : is == VV_IS_MESH ? "mesh" : "volume or mesh";
}

static void describe_inputs(vvi_result *json, const vv_operation *row)
{
    vvi_result_open(json, "inputs", '[');
    for (const vv_operand *o = row->inputs; o->name; o++) {
        vvi_result_open(json, NULL, '{');
        vvi_result_string(json, "name", o->name);
        vvi_result_string(json, "takes", word_of(o->is));
        vvi_result_unsigned(json, "least", o->least);
        vvi_result_unsigned(json, "most", o->most);
        vvi_result_string(json, "doc", o->doc);
        vvi_result_close(json, '}');
    }
    vvi_result_close(json, ']');
    vvi_result_string(json, "makes", word_of(vv_operation_makes(row)));
}

static void describe(cli_command *command, const vv_operation *row, bool in_full)
{
    vvi_result *json = &command->json;
    cli_help_entry(&command->text, row->name, row->doc);
    if (in_full) {
        const cli_verb verb = cli_verb_of_operation(row);
        cli_usage_inputs(&command->text, &verb, "\nInputs\n", cli_help_entry);
        vvi_text_add(&command->text, row->params->properties->name ? "\nParameters\n" : "");
        cli_properties_text(&command->text, "", row->params, true);
        vvi_text_printf(&command->text, "\nExample\n  %s\n", row->example);
    }
    vvi_result_open(json, NULL, '{');
    vvi_result_string(json, "name", row->name);
    vvi_result_string(json, "component", row->component);
    vvi_result_string(json, "doc", row->doc);
    vvi_result_string(json, "example", row->example);
    vvi_result_unsigned(json, "min_inputs", vv_operation_least(row));
    vvi_result_unsigned(json, "max_inputs", vv_operation_most(row));
    describe_inputs(json, row);
    cli_properties_json(json, "parameters", row->params);
    vvi_result_close(json, '}');
}

static vv_status run(cli_command *command)
{
    const char *only = cli_command_word(command, 0);
    if (only && !vv_registry_operation(command->registry, only))
        return vv_error_last()->status;
    vvi_result_open(&command->json, "operations", '[');
    for (size_t i = 0; command->registry->operations[i]; i++) {
        const vv_operation *row = command->registry->operations[i];
        if (!only || strcmp(only, row->name) == 0)
            describe(command, row, only != NULL);
    }
    vvi_result_close(&command->json, ']');
    return VV_OK;
}

static const char *const examples[] = {"volvis operations", "volvis operations gaussian --json", NULL};

const cli_verb cli_verb_operations = {
    .name = "operations",
    .doc = "what can be done to data, each a verb of its own",
    .words = "NAME",
    .choices = "operations",
    .max_words = 1,
    .examples = examples,
    .run = run,
};
