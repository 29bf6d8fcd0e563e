/* Whether the words of a command line, its inputs and output, are those that the verb takes. */
#include "command_words.h"
#include "io/mesh_file.h"
#include "watch.h"
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The value of an option that may stand alone, without = before it. */
static vv_status check_stray_value(const cli_command *command, const char *extra)
{
    const cli_verb *verb = &command->verb;
    for (size_t i = 0; i < command->args.n_given; i++) {
        const vv_property *row = command->args.given[i].row;
        char name[64];
        cli_option_name(name, row);
        for (size_t w = 0; cli_option_alone(row) && row->names[w]; w++)
            if (strcmp(row->names[w], extra) == 0)
                return vv_fail(VV_E_ARGUMENT, "%s takes only %s, but '%s' follows; did you mean --%s=%s?", verb->name,
                               verb->words, extra, name, extra);
    }
    return VV_OK;
}

/* What people forget most: -o before the output. */
static vv_status fail_extra_word(const cli_command *command)
{
    const cli_verb *verb = &command->verb;
    const char *extra = command->args.words[verb->max_words];
    const vv_status st = check_stray_value(command, extra);
    if (st != VV_OK)
        return st;
    const bool there = access(extra, F_OK) == 0; /* nobody is to be led to write over an input */
    if (verb->makes_file && !command->common->output && there && verb->each_input)
        return vv_fail(VV_E_ARGUMENT,
                       "%s takes only %s, but '%s' follows, which is there already: for one result of each input, give "
                       "-o with {stem} in its name, as in -o '{stem}-new.nrrd'",
                       verb->name, verb->words, extra);
    if (verb->makes_file && !command->common->output && !there)
        return vv_fail(VV_E_ARGUMENT, "%s takes only %s, but '%s' follows; did you mean -o %s?", verb->name,
                       verb->words, extra, extra);
    return vv_fail(VV_E_ARGUMENT, "%s takes only %s, but '%s' follows; omit it", verb->name, verb->words, extra);
}

/* Behind volumes a name of a mesh can only be that of the one to be made. */
static bool is_mesh_to_make(const cli_args *args, const cli_verb *verb, const vv_registry *registry)
{
    return verb->operation && vv_operation_makes(verb->operation) == VV_IS_MESH &&
           verb->operation->inputs[0].is == VV_IS_FIELD && args->n_words > verb->min_words &&
           vvi_mesh_format_of_path(args->words[args->n_words - 1], registry);
}

const char *cli_command_output_word(const cli_args *args, const cli_verb *verb, const vv_registry *registry)
{
    const bool one_more = verb->in_out && args->n_words == verb->max_words + 1;
    return one_more || is_mesh_to_make(args, verb, registry) ? args->words[args->n_words - 1] : NULL;
}

vv_status cli_command_take_output(cli_command *command)
{
    const char *output =
        command->common->output ? NULL : cli_command_output_word(&command->args, &command->verb, command->registry);
    /* whether it is still what the last run made of it, cli_watch_begin() asks */
    const bool made = command->watch && command->watch->n_runs > 0;
    if (!output)
        return VV_OK;
    command->args.n_words--;
    if (!made && !command->common->overwrite && access(output, F_OK) == 0)
        return vv_fail_at(VV_E_ARGUMENT, output, NULL,
                          "already exists; to replace it, give --overwrite or name it with -o");
    command->keeps_existing = !made && !command->common->overwrite;
    vv_object *common = &command->common->base;
    const vv_status st = vv_path_set(&common, "output", output, NULL);
    command->common = (cli_common *)(void *)common;
    return st;
}

/* Of an operation that has some of its inputs, the one that it lacks. */
static vv_status fail_missing_word(const cli_verb *verb, size_t n)
{
    if (verb->operation && n > 0) {
        const vv_operand *lacks = vv_operation_operand(verb->operation, n);
        return vv_fail(VV_E_ARGUMENT, "%s needs one more input, %s: add %s=FILE", verb->name, lacks->doc, lacks->name);
    }
    return vv_fail(VV_E_ARGUMENT, "%s needs %s: 'volvis help %s' shows how", verb->name, verb->words, verb->name);
}

vv_status cli_command_check_words(const cli_command *command)
{
    const cli_verb *verb = &command->verb;
    const size_t n = command->args.n_words;
    vv_status st;
    if (n < verb->min_words)
        return fail_missing_word(verb, n);
    if (n > verb->max_words && verb->max_words == 0)
        return vv_fail(VV_E_ARGUMENT, "%s takes options only, found '%s'", verb->name, command->args.words[0]);
    if (n > verb->max_words)
        return fail_extra_word(command);
    for (size_t i = verb->min_words; i < n; i++)
        if (access(command->args.words[i], F_OK) != 0 &&
            (st = check_stray_value(command, command->args.words[i])) != VV_OK)
            return st;
    if (command->common->set && command->common->set->n && !verb->world)
        return vv_fail(VV_E_ARGUMENT, "--set changes a World, and %s does not use one; omit --set", verb->name);
    if (command->common->output && verb->makes_file && command->common->json &&
        strcmp(command->common->output, "-") == 0)
        return vv_fail(VV_E_ARGUMENT, "-o - and --json would both write to standard output; name a file with -o");
    return VV_OK;
}
