#include "command.h"
#include "help.h"
#include "verbs.h"
#include <string.h>
#include <volvis/render.h>

static void describe(cli_command *command, const vv_preset *preset)
{
    vvi_result *json = &command->json;
    vvi_text right = {0};
    vvi_text_add(&right, preset->doc);
    if (preset->value_unit)
        vvi_text_printf(&right, " (values in %s)", preset->value_unit);
    cli_help_entry(&command->text, preset->name, right.bad ? "" : right.s);
    vvi_text_free(&right);
    vvi_result_open(json, NULL, '{');
    vvi_result_string(json, "name", preset->name);
    vvi_result_string(json, "kind", preset->kind);
    vvi_result_string(json, "doc", preset->doc);
    vvi_result_string(json, "value_unit", preset->value_unit);
    vvi_result_close(json, '}');
}

static void list_kind(cli_command *command, const char *title, const char *kind)
{
    const vv_preset *preset;
    vvi_text_printf(&command->text, "%s\n", title);
    for (size_t i = 0; (preset = vv_preset_nth(i)); i++) {
        if (strcmp(preset->kind, kind) == 0)
            describe(command, preset);
    }
}

static vv_status run(cli_command *command)
{
    vvi_result_open(&command->json, "presets", '[');
    list_kind(command, "Transfer functions: opacity and colour by value (render --tf NAME)", "transfer");
    vvi_text_add(&command->text, "\n");
    list_kind(command, "Transfer functions worked out from the data (render --tf NAME)", "proposal");
    vvi_text_add(&command->text, "\n");
    list_kind(command, "Colour maps (render --tf NAME)", "colormap");
    vvi_result_close(&command->json, ']');
    return VV_OK;
}

static const char *const examples[] = {"volvis presets", "volvis presets --json", NULL};

const cli_verb cli_verb_presets = {
    .name = "presets",
    .doc = "the transfer functions and colour maps that have names",
    .examples = examples,
    .run = run,
};
