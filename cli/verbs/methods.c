#include "command.h"
#include "help.h"
#include "properties.h"
#include "verbs.h"
#include <stdio.h>
#include <string.h>

static void describe(cli_command *command, const vv_renderer *row, bool in_full)
{
    char prefix[96];
    vvi_result *json = &command->json;
    cli_help_entry(&command->text, row->name, row->doc);
    if (in_full) {
        snprintf(prefix, sizeof prefix, "views.VIEW.render.%s.", row->name);
        vvi_text_add(&command->text, "\nParameters\n");
        cli_properties_text(&command->text, prefix, row->params, false);
    }
    vvi_result_open(json, NULL, '{');
    vvi_result_string(json, "name", row->name);
    vvi_result_string(json, "doc", row->doc);
    cli_properties_json(json, "parameters", row->params);
    vvi_result_close(json, '}');
}

static vv_status run(cli_command *command)
{
    const char *only = cli_command_word(command, 0);
    if (only && !vv_registry_renderer(command->registry, only))
        return vv_error_last()->status;
    vvi_result_open(&command->json, "methods", '[');
    for (size_t i = 0; command->registry->renderers[i]; i++) {
        const vv_renderer *row = command->registry->renderers[i];
        if (!only || strcmp(only, row->name) == 0)
            describe(command, row, only != NULL);
    }
    vvi_result_close(&command->json, ']');
    return VV_OK;
}

static const char *const examples[] = {"volvis methods", "volvis methods raycast", NULL};

const cli_verb cli_verb_methods = {
    .name = "methods",
    .doc = "the rendering methods and their parameters",
    .words = "NAME",
    .choices = "renderers",
    .max_words = 1,
    .examples = examples,
    .run = run,
};
