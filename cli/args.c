#include "args.h"
#include "core/status.h"
#include "core/text.h"
#include "operands.h"
#include "options.h"
#include "usage.h"
#include "value.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { MAX_NAMES = 192 }; /* three classes of at most 64 rows */

void cli_option_name(char out[64], const vv_property *row)
{
    const char *name = row->option ? row->option : row->name;
    size_t n = 0;
    for (; name[n] && n < 63; n++)
        out[n] = name[n] == '_' ? '-' : name[n];
    out[n] = 0;
}

static bool is_named(const vv_property *row, const char *name, size_t n)
{
    char spelled[64];
    cli_option_name(spelled, row);
    if (!*spelled)
        return false;
    return (strlen(spelled) == n && memcmp(spelled, name, n) == 0) ||
           (row->option && strlen(row->name) == n && memcmp(row->name, name, n) == 0);
}

static bool find_named(cli_given *out, const cli_verb *verb, const char *name, size_t n)
{
    for (size_t c = 0; (out->cls = cli_usage_class(verb, c)); c++) {
        for (out->row = out->cls->properties; out->row->name; out->row++) {
            if (is_named(out->row, name, n))
                return true;
        }
    }
    return false;
}

/* Other programs call the order of an array's axes so; verbs with axes of their own mean those. */
static bool find_long(cli_given *out, const cli_verb *verb, const char *name, size_t n)
{
    static const char axes[] = "axes", part[] = "part";
    return find_named(out, verb, name, n) ||
           (n == sizeof axes - 1 && memcmp(name, axes, n) == 0 && find_named(out, verb, part, sizeof part - 1));
}

static bool find_letter(cli_given *out, const cli_verb *verb, char letter)
{
    for (size_t c = 0; (out->cls = cli_usage_class(verb, c)); c++) {
        for (out->row = out->cls->properties; out->row->name; out->row++) {
            if (out->row->letter == letter)
                return true;
        }
    }
    return false;
}

static vv_status fail_unknown(const cli_verb *verb, const char *name, size_t n)
{
    static const char dashes[] = "--";
    char spelled[MAX_NAMES][64];
    const char *names[MAX_NAMES];
    char typed[64];
    size_t n_names = 0;
    const vv_class *cls;
    for (size_t c = 0; (cls = cli_usage_class(verb, c)); c++) {
        for (const vv_property *row = cls->properties; row->name && n_names < MAX_NAMES; row++) {
            cli_option_name(spelled[n_names], row);
            names[n_names] = spelled[n_names];
            n_names++;
        }
    }
    n = n < sizeof typed ? n : sizeof typed - 1;
    memcpy(typed, name, n);
    typed[n] = 0;
    const char *near = vv_nearest_name(typed, names, n_names);
    if (near)
        return vv_fail(VV_E_ARGUMENT, "%s has no option %s%s; did you mean --%s?", verb->name, dashes, typed, near);
    if (!verb->run) /* a line of the defaults without a verb */
        return vv_fail(VV_E_ARGUMENT,
                       "%s%s is no option that every verb has; begin the line with the verb that it is for, "
                       "as in 'render %s%s ...'",
                       dashes, typed, dashes, typed);
    return vv_fail(VV_E_ARGUMENT, "%s has no option %s%s; 'volvis help %s' lists them", verb->name, dashes, typed,
                   verb->name);
}

bool cli_option_is_listed(const vv_property *row)
{
    return !row->hidden && (!row->option || *row->option);
}

bool cli_option_adds_row(const vv_property *row)
{
    return row->kind == VV_KIND_NUMBERS && row->columns > 1 && !row->lone;
}

bool cli_option_is_named(const vv_property *row)
{
    return row->quantity == VV_Q_LABEL || (row->option && strcmp(row->option, "channel") == 0);
}

bool cli_option_alone(const vv_property *row)
{
    return row->kind == VV_KIND_ENUM && strcmp(row->names[0], "none") == 0 && row->names[1] &&
           strcmp(row->names[1], "auto") == 0;
}

static void give(cli_args *args, const cli_given *given, const char *text)
{
    args->given[args->n_given] = *given;
    args->given[args->n_given].text = text;
    args->given[args->n_given].n_before = args->n_words;
    args->n_given++;
}

static vv_status need_value(const char **text_out, const cli_given *given, int argc, char **argv, int *at)
{
    char name[64];
    cli_option_name(name, given->row);
    if (*at + 1 >= argc)
        return vv_fail(VV_E_ARGUMENT, "--%s needs a value after it", name);
    *text_out = argv[++*at];
    return VV_OK;
}

static vv_status take_long(cli_args *args, const cli_verb *verb, int argc, char **argv, int *at)
{
    const char *name = argv[*at] + 2;
    const size_t n = strcspn(name, "=");
    const char *text = name[n] ? name + n + 1 : NULL;
    cli_given given = {0};
    vv_status st;
    if (!find_long(&given, verb, name, n)) {
        if (n > 3 && !text && memcmp(name, "no-", 3) == 0 && find_long(&given, verb, name + 3, n - 3) &&
            given.row->kind == VV_KIND_BOOL) {
            give(args, &given, "false");
            return VV_OK;
        }
        return fail_unknown(verb, name, n);
    }
    if (!text && given.row->kind == VV_KIND_BOOL)
        text = "true";
    if (!text && cli_option_alone(given.row))
        text = "auto";
    if (!text && (st = need_value(&text, &given, argc, argv, at)) != VV_OK)
        return st;
    give(args, &given, text);
    return VV_OK;
}

/* A word may be a formula, where a verb takes one. */
static vv_status fail_letter(const cli_verb *verb, char letter, const char *word)
{
    const vv_class *cls = verb->own ? verb->own : verb->options[0];
    for (const vv_property *row = cls ? cls->properties : NULL; row && row->name; row++)
        if (row->positional)
            return vv_fail(VV_E_ARGUMENT, "%s has no option -%c; as its %s write '0%s'", verb->name, letter, row->name,
                           word);
    return vv_fail(VV_E_ARGUMENT, "%s has no option -%c; 'volvis help %s' lists them, and './%s' is a file", verb->name,
                   letter, verb->name, word);
}

/* "-q", "-qv", "-o FILE", "-oFILE" */
static vv_status take_letters(cli_args *args, const cli_verb *verb, int argc, char **argv, int *at)
{
    vv_status st;
    for (const char *letter = argv[*at] + 1; *letter; letter++) {
        cli_given given = {0};
        if (!find_letter(&given, verb, *letter))
            return fail_letter(verb, *letter, argv[*at]);
        if (given.row->kind == VV_KIND_BOOL) {
            give(args, &given, "true");
            continue;
        }
        const char *text = letter + 1;
        if (!*text && (st = need_value(&text, &given, argc, argv, at)) != VV_OK)
            return st;
        give(args, &given, text);
        break;
    }
    return VV_OK;
}

vv_status cli_args_parse(cli_args *out, const cli_verb *verb, int argc, char **argv)
{
    vv_status st = VV_OK;
    size_t letters = 0; /* "-qv" is two options */
    for (int i = 0; i < argc; i++)
        letters += argv[i][0] == '-' ? strlen(argv[i]) : 1;
    *out =
        (cli_args){.given = calloc(letters + 3, sizeof *out->given), .words = calloc((size_t)argc + 1, sizeof(char *))};
    if (!out->given || !out->words)
        return vv_fail_memory((letters + 3) * sizeof *out->given);
    bool only_words = false;
    for (int i = 0; i < argc && st == VV_OK; i++) {
        if (only_words || argv[i][0] != '-' || !argv[i][1])
            out->words[out->n_words++] = argv[i];
        else if (strcmp(argv[i], "--") == 0)
            only_words = true;
        else if (argv[i][1] == '-')
            st = take_long(out, verb, argc, argv, &i);
        else
            st = take_letters(out, verb, argc, argv, &i);
    }
    return st == VV_OK ? cli_operands_take(out, verb) : st;
}

void cli_args_free(cli_args *args)
{
    free(args->given);
    free(args->words);
    free(args->names);
    *args = (cli_args){0};
}

/* An end without a limit may be said, too. */
static void leave_out(char end[64], bool is_hi)
{
    if (strcasecmp(end, is_hi ? "inf" : "-inf") == 0 || (is_hi && strcasecmp(end, "+inf") == 0))
        *end = 0;
}

/* LO..HI; what is left out has no limit. */
static vv_status apply_range(vv_object **object, const vv_property *row, const char *typed,
                             const vv_property_context *context)
{
    char end[2][64];
    vv_status st = cli_value_split_range(end[0], end[1], typed) ? VV_OK : VV_E_ARGUMENT;
    leave_out(end[0], false);
    leave_out(end[1], true);
    if (!*end[0] && !*end[1])
        st = VV_E_ARGUMENT;
    for (int i = 0; i < 2 && st == VV_OK; i++)
        st = *end[i] ? vv_path_set(object, row[i].name, end[i], context) : vv_path_unset(object, row[i].name, context);
    if (st == VV_E_ARGUMENT)
        return vv_fail(st, "expected LO..HI, as in 90..300, 90.. or 90, found '%s'", typed);
    if (st != VV_OK || !*end[0] || !*end[1])
        return st;
    const double *lo = (const void *)((const char *)*object + row[0].offset);
    const double *hi = (const void *)((const char *)*object + row[1].offset);
    return *lo <= *hi ? VV_OK : vv_fail(VV_E_ARGUMENT, "LO is above HI in '%s'; exchange them", typed);
}

static vv_status apply(vv_object **object, const cli_given *given, const vv_property_context *context)
{
    const vv_property *row = given->row;
    vvi_text json = {0};
    if (!given->text[0]) /* a script's variable that was never set: the default may not be what was meant */
        return vv_fail(VV_E_ARGUMENT, "needs a value, found an empty one; leave the option out for its default");
    if (row->ranged)
        return apply_range(object, row, given->text, context);
    if (cli_option_adds_row(row))
        return vv_path_add(object, row->name, NULL, given->text, context);
    if (row->kind != VV_KIND_LIST)
        return vv_path_set(object, row->name, given->text, context);
    vvi_text_add(&json, "{\"text\":");
    vvi_text_json(&json, given->text);
    vvi_text_add(&json, "}");
    const vv_status st = json.bad ? vv_fail_memory(json.n) : vv_path_add(object, row->name, NULL, json.s, context);
    vvi_text_free(&json);
    return st;
}

/* Whether a row of plain numbers is wanted, and something else was typed: the engine would say so of JSON. */
static const char *missed_shape(const vv_property *row, const char *typed)
{
    const bool table = row->kind == VV_KIND_NUMBERS && row->columns > 1, point = row->kind == VV_KIND_VEC3;
    const size_t n = point ? 3 : (size_t)row->columns;
    double v[3];
    if ((!table && !point) || row->quantity != VV_Q_NONE || n > 3 || !*typed ||
        cli_value_numbers(v, n, typed, false) == VV_OK)
        return NULL;
    return n == 3 ? "X,Y,Z, as in 80,90,60" : "LO..HI, as in 0..300";
}

/* The engine's sentence begins with the property's path; people typed an option. */
static void fail_option(vv_status st, const cli_given *given)
{
    const vv_property *row = given->row;
    char name[64], text[512];
    const size_t n = strlen(row->name);
    const char *message = vv_error_last()->message, *shape = missed_shape(row, given->text);
    const char *behind = strncmp(message, row->name, n) == 0 ? strstr(message + n, ": ") : NULL;
    cli_option_name(name, row);
    if (behind && message[n] == ':')
        message = behind + 2;
    if (shape)
        snprintf(text, sizeof text, "expected %s, found '%s'", shape, given->text);
    else
        snprintf(text, sizeof text, "%s", message);
    vv_fail(st, "--%s: %s", name, text);
}

void cli_args_hide(const cli_args *args, const char *name)
{
    for (size_t i = 0; i < args->n_given; i++)
        if (strcmp(args->given[i].row->name, name) == 0)
            memset((char *)args->given[i].text, '*', strlen(args->given[i].text));
}

vv_status cli_args_object(vv_object **out, const cli_args *args, const vv_class *cls,
                          const vv_property_context *context)
{
    vv_status st = vv_object_new(out, cls, context);
    for (size_t i = 0; i < args->n_given && st == VV_OK; i++) {
        if (args->given[i].cls == cls && (st = apply(out, &args->given[i], context)) != VV_OK) {
            fail_option(st, &args->given[i]);
            if (args->given[i].place)
                vv_fail_in(st, "%s", args->given[i].place);
        }
    }
    if (st != VV_OK) {
        vv_object_release(*out);
        *out = NULL;
    }
    return st;
}
