#include "choices.h"
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

static bool is_named(const vv_preset *preset, const char *name)
{
    return !name || strcmp(preset->name, name) == 0 || (preset->alias && strcmp(preset->alias, name) == 0);
}

/* Those of a kind, or of all kinds, with a name, or with any. */
static size_t list(cli_command *command, const char *kind, const char *name)
{
    const vv_preset *preset;
    size_t n = 0;
    for (size_t i = 0; (preset = vv_preset_nth(i)); i++) {
        if (kind && strcmp(preset->kind, kind) != 0)
            continue;
        if (is_named(preset, name)) {
            describe(command, preset);
            n++;
        }
    }
    return n;
}

static void list_kind(cli_command *command, const char *title, const char *kind)
{
    vvi_text_printf(&command->text, "%s\n", title);
    list(command, kind, NULL);
}

static vv_status fail_unknown(const cli_command *command, const char *typed)
{
    return cli_choice_fail(VV_E_NOT_FOUND, command->registry, "presets", "there is no preset", typed);
}

static vv_status run_one(cli_command *command, const char *name)
{
    vvi_result_open(&command->json, "presets", '[');
    const size_t n = list(command, NULL, name);
    vvi_result_close(&command->json, ']');
    return n ? VV_OK : fail_unknown(command, name);
}

static vv_status run(cli_command *command)
{
    if (cli_command_word(command, 0))
        return run_one(command, cli_command_word(command, 0));
    vvi_result_open(&command->json, "presets", '[');
    list_kind(command, "Transfer functions: opacity and colour by value (render --tf NAME)", "transfer");
    vvi_text_add(&command->text, "\n");
    list_kind(command, "Transfer functions worked out from the data (render --tf NAME)", "proposal");
    vvi_text_add(&command->text, "\n");
    list_kind(command, "Colour maps (render --tf NAME, or map:NAME where a transfer function has the name, too)",
              "colormap");
    vvi_result_close(&command->json, ']');
    return VV_OK;
}

static const char *const examples[] = {"volvis presets", "volvis presets bone", "volvis presets --json", NULL};

const cli_verb cli_verb_presets = {
    .name = "presets",
    .doc = "the transfer functions and colour maps that have names",
    .words = "NAME",
    .choices = "presets",
    .max_words = 1,
    .examples = examples,
    .run = run,
};
