#include "refusal.h"
#include "core/names.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static cli_given *find(const cli_command *command, const char *name, size_t n)
{
    for (size_t i = 0; i < command->args.n_given; i++) {
        cli_given *given = &command->args.given[i];
        char spelled[64];
        cli_option_name(spelled, given->row);
        if (given->place && strlen(spelled) == n && memcmp(spelled, name, n) == 0)
            return given;
    }
    return NULL;
}

vv_status cli_refused(const cli_command *command, const char *options, vv_status st)
{
    cli_given *given = NULL;
    for (const char *at = options; st != VV_OK && *at && !given; at += at[0] == ',') {
        const size_t n = strcspn(at, ",");
        given = find(command, at, n);
        at += n;
    }
    if (given)
        given->refused = true;
    return st;
}

vv_status cli_refused_class(const cli_command *command, const vv_class *cls, vv_status st)
{
    for (size_t i = 0; i < command->args.n_given && st != VV_OK; i++)
        if (command->args.given[i].cls == cls && command->args.given[i].place)
            command->args.given[i].refused = true;
    return st;
}

/* Whether one of the properties "pieces|least" is set; as_options: "--pieces or --least". */
static bool any_is_set(vvi_text *as_options, const vv_object *params, const char *names)
{
    bool any = false;
    for (const char *at = names; *at; at += at[0] == '|') {
        char name[64];
        const size_t n = strcspn(at, "|");
        snprintf(name, sizeof name, "%.*s", (int)n, at);
        const vv_property *row = vv_class_find(params->cls, name);
        any |= row && vv_object_is_set(params, name);
        if (row)
            cli_option_name(name, row);
        vvi_text_printf(as_options, "%s--%s", at > names ? " or " : "", name);
        at += n;
    }
    return any;
}

/* "data=labels": of the samples, "labels" or "values". */
static vv_status refuse_for_data(const char *option, const char *wanted, const char *data)
{
    if (!data || strcmp(wanted, data) == 0)
        return VV_OK;
    return vv_fail(VV_E_ARGUMENT, "--%s does nothing to the surface of %s: it is for that of %s; omit it", option, data,
                   wanted);
}

/* "method=range|hysteresis": of another parameter, which has one of these words. */
static vv_status refuse_for_word(const char *option, const vv_property *row, const vv_object *params)
{
    const vv_property *choice = vvi_property_choice(params->cls, row);
    char other[64];
    vvi_text words = {0};
    if (!choice)
        return VV_OK;
    const char *chosen = choice->names[*(const int *)(const void *)((const char *)params + choice->offset)];
    if (vvi_property_acts_with(row, chosen))
        return VV_OK;
    for (const char *at = strchr(row->when, '='); *at; at += strcspn(at + 1, "|") + 1)
        vvi_text_printf(&words, "%s%.*s", *at == '|' ? " or " : "", (int)strcspn(at + 1, "|"), at + 1);
    cli_option_name(other, choice);
    const vv_status st = vv_fail(VV_E_ARGUMENT, "--%s does nothing with --%s %s: it is for %s; omit it", option, other,
                                 chosen, words.bad ? "others" : words.s);
    vvi_text_free(&words);
    return st;
}

/* "pieces|least": of others, one of which is given. */
static vv_status refuse_alone(const char *option, const char *when, const vv_object *params)
{
    vvi_text others = {0};
    vv_status st = VV_OK;
    if (!any_is_set(&others, params, when))
        st = vv_fail(VV_E_ARGUMENT, "--%s does nothing without %s: give that too, or omit it", option, others.s);
    vvi_text_free(&others);
    return st;
}

vv_status cli_refuse_idle(const cli_command *command, const vv_object *params, const char *data)
{
    static const char of_data[] = "data=";
    vv_status st = VV_OK;
    for (const vv_property *row = params->cls->properties; row->name && st == VV_OK; row++) {
        char option[64];
        if (!row->when || !vv_object_is_set(params, row->name))
            continue;
        cli_option_name(option, row);
        st = strncmp(row->when, of_data, sizeof of_data - 1) == 0
                 ? refuse_for_data(option, row->when + sizeof of_data - 1, data)
             : strchr(row->when, '=') ? refuse_for_word(option, row, params)
                                      : refuse_alone(option, row->when, params);
        cli_refused(command, option, st);
    }
    return st;
}

static bool make_again(cli_command *command, const vv_class *cls)
{
    for (size_t i = 0; i < CLI_VERB_CLASSES; i++) {
        if (!command->options[i] || command->options[i]->cls != cls)
            continue;
        vv_object_release(command->options[i]);
        command->options[i] = NULL;
        if (cli_args_object(&command->options[i], &command->args, cls, NULL) != VV_OK)
            return false;
    }
    return true;
}

/* The error's sentence says why. */
static void tell(cli_command *command, const cli_given *given)
{
    vvi_text text = {0};
    cli_defaults_spell(&text, given);
    if (command->common->verbose && !text.bad)
        cli_command_note(command, "%s: %s is left out: %s", given->place, text.s, vv_error_last()->message);
    vvi_text_free(&text);
}

bool cli_refusal_gives_way(cli_command *command)
{
    cli_args *args = &command->args;
    bool any = false, made = true;
    for (size_t i = 0; i < args->n_given && made; i++) {
        const cli_given given = args->given[i];
        if (!given.refused)
            continue;
        tell(command, &given);
        memmove(args->given + i, args->given + i + 1, (args->n_given - i - 1) * sizeof *args->given);
        args->n_given--;
        i--;
        any = true;
        made = make_again(command, given.cls);
    }
    if (any)
        cli_defaults_list(&command->defaults.taken, args);
    return any && made;
}
