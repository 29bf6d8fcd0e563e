#include "refusal.h"
#include <stdio.h>
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

/* Of "method=hysteresis|range": whether the enumeration has one of these values, or is none of the class. */
static bool acts(const vv_object *params, const char *when, char name_out[64], const char **value_out)
{
    const size_t length = strcspn(when, "=");
    snprintf(name_out, 64, "%.*s", (int)length, when);
    const vv_property *row = vv_class_find(params->cls, name_out);
    if (!row || row->kind != VV_KIND_ENUM)
        return true;
    *value_out = row->names[*(const int *)((const char *)params + row->offset)];
    const size_t n = strlen(*value_out);
    cli_option_name(name_out, row);
    for (const char *at = when + length + 1;; at += strcspn(at, "|") + 1) {
        if (strcspn(at, "|") == n && memcmp(at, *value_out, n) == 0)
            return true;
        if (!strchr(at, '|'))
            return false;
    }
}

vv_status cli_refuse_idle(const cli_command *command, const vv_object *params, const char *data)
{
    static const char of_data[] = "data=";
    vv_status st = VV_OK;
    for (const vv_property *row = params->cls->properties; row->name && st == VV_OK; row++) {
        const bool asks_data = row->when && strncmp(row->when, of_data, sizeof of_data - 1) == 0;
        const char *wanted = asks_data ? row->when + sizeof of_data - 1 : NULL;
        char option[64], name[64];
        const char *value = "";
        vvi_text others = {0};
        cli_option_name(option, row);
        if (!row->when || !vv_object_is_set(params, row->name))
            continue;
        if (wanted && data && strcmp(wanted, data) != 0)
            st = vv_fail(VV_E_ARGUMENT, "--%s does nothing to the surface of %s: it is for that of %s; omit it", option,
                         data, wanted);
        else if (!asks_data && strchr(row->when, '=') && !acts(params, row->when, name, &value))
            st = vv_fail(VV_E_ARGUMENT, "--%s does nothing with --%s %s: it is for %s; omit it", option, name, value,
                         strchr(row->when, '=') + 1);
        else if (!strchr(row->when, '=') && !any_is_set(&others, params, row->when))
            st = vv_fail(VV_E_ARGUMENT, "--%s does nothing without %s: give that too, or omit it", option, others.s);
        vvi_text_free(&others);
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
