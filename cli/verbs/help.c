#include "help.h"
#include "choices.h"
#include "command.h"
#include "properties.h"
#include "usage.h"
#include "verbs.h"
#include <string.h>

static void describe_verb(vvi_result *json, const cli_verb *verb)
{
    vvi_text usage = {0};
    const char *example;
    cli_usage_line(&usage, verb);
    vvi_result_open(json, NULL, '{');
    vvi_result_string(json, "name", verb->name);
    vvi_result_string(json, "doc", verb->doc);
    vvi_result_string(json, "usage", usage.s);
    vvi_result_bool(json, "operation", verb->operation != NULL);
    vvi_result_open(json, "examples", '[');
    for (size_t i = 0; (example = cli_usage_example(verb, i)); i++)
        vvi_result_string(json, NULL, example);
    vvi_result_close(json, ']');
    vvi_result_open(json, "options", '{');
    for (size_t i = 0; i < CLI_VERB_CLASSES; i++) {
        if (verb->options[i])
            cli_properties_json(json, verb->options[i]->name, verb->options[i]);
    }
    vvi_result_close(json, '}');
    vvi_result_close(json, '}');
    vvi_text_free(&usage);
}

static void describe_all(cli_command *command)
{
    cli_verb verb;
    vvi_result_open(&command->json, "verbs", '[');
    for (size_t i = 0; cli_verb_nth(&verb, command->registry, i); i++) {
        if (!verb.hidden)
            describe_verb(&command->json, &verb);
    }
    vvi_result_close(&command->json, ']');
    cli_properties_json(&command->json, "common", &cli_common_class);
}

static vv_status help_word(cli_command *command, const char *word)
{
    cli_verb verb;
    vv_status st = cli_verb_find(&verb, command->registry, word);
    if (st == VV_OK) {
        cli_help_verb(&command->text, &verb, command->registry);
        vvi_result_open(&command->json, "verbs", '[');
        describe_verb(&command->json, &verb);
        vvi_result_close(&command->json, ']');
        return VV_OK;
    }
    st = cli_help_path(&command->text, word, command->registry);
    return st == VV_OK || strchr(word, '.')
               ? st
               : cli_choice_fail(VV_E_ARGUMENT, command->registry, "verbs", "no verb or property", word);
}

static vv_status run(cli_command *command)
{
    const char *word = cli_command_word(command, 0);
    if (word)
        return help_word(command, word);
    cli_help_overview(&command->text, command->registry);
    describe_all(command);
    return VV_OK;
}

static const char *const examples[] = {"volvis help", "volvis help render", "volvis help lights.key.intensity",
                                       "volvis help --json", NULL};

const cli_verb cli_verb_help = {
    .name = "help",
    .doc = "what a verb or a property does and takes",
    .words = "VERB|PATH",
    .choices = "verbs",
    .max_words = 1,
    .examples = examples,
    .plain = true,
    .run = run,
};
