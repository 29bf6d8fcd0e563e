#include "command.h"
#include "help.h"
#include "properties.h"
#include "verbs.h"
#include <string.h>

static void describe(cli_command *command, const vv_operation *row, bool in_full)
{
    cli_json *json = &command->json;
    cli_help_entry(&command->text, row->name, row->doc);
    if (in_full) {
        vvi_text_add(&command->text, "\nParameters\n");
        cli_properties_text(&command->text, "", row->params, true);
        vvi_text_printf(&command->text, "\nExample\n  %s\n", row->example);
    }
    cli_json_open(json, NULL, '{');
    cli_json_string(json, "name", row->name);
    cli_json_string(json, "component", row->component);
    cli_json_string(json, "doc", row->doc);
    cli_json_string(json, "example", row->example);
    cli_json_unsigned(json, "min_inputs", row->min_inputs);
    cli_json_unsigned(json, "max_inputs", row->max_inputs);
    cli_properties_json(json, "parameters", row->params);
    cli_json_close(json, '}');
}

static vv_status run(cli_command *command)
{
    const char *only = cli_command_word(command, 0);
    if (only && !vv_registry_operation(command->registry, only))
        return vv_error_last()->status;
    cli_json_open(&command->json, "operations", '[');
    for (size_t i = 0; command->registry->operations[i]; i++) {
        const vv_operation *row = command->registry->operations[i];
        if (!only || strcmp(only, row->name) == 0)
            describe(command, row, only != NULL);
    }
    cli_json_close(&command->json, ']');
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
