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

/* Those of a kind with a name, or with any, under a title. */
static size_t list_kind(cli_command *command, const char *kind, const char *title, const char *name)
{
    const vv_preset *preset;
    size_t n = 0;
    for (size_t i = 0; (preset = vv_preset_nth(i)); i++) {
        if (strcmp(preset->kind, kind) != 0 || !is_named(preset, name))
            continue;
        if (n++ == 0)
            vvi_text_printf(&command->text, "%s%s\n", command->text.n ? "\n" : "", title);
        describe(command, preset);
    }
    return n;
}

static vv_status fail_unknown(const cli_command *command, const char *typed)
{
    return cli_choice_fail(VV_E_NOT_FOUND, command->registry, "presets", "there is no preset", typed);
}

static vv_status run(cli_command *command)
{
    static const char *const kinds[][2] = {
        {"transfer", "Transfer functions: opacity and colour by value (render --tf NAME)"},
        {"proposal", "Transfer functions worked out from the data (render --tf NAME)"},
        {"colormap", "Colour maps (render --tf NAME, or map:NAME where a transfer function has the name, too)"},
    };
    const char *name = cli_command_word(command, 0);
    size_t n = 0;
    vvi_result_open(&command->json, "presets", '[');
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++)
        n += list_kind(command, kinds[i][0], kinds[i][1], name);
    vvi_result_close(&command->json, ']');
    return n ? VV_OK : fail_unknown(command, name);
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
