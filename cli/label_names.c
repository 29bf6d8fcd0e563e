#include "label_names.h"
#include "core/names.h"
#include "core/units.h"
#include "grid/label_id.h"
#include "label_layers.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

cli_label_names cli_label_names_of(const cli_command *command, const cli_input *input)
{
    cli_label_names names = {.command = command, .input = input};
    if (!input->file)
        return (cli_label_names){0};
    names.label = vv_file_labels(input->file, &names.n);
    names.is_unsigned = vvi_label_is_unsigned(vv_file_info(input->file)->type);
    return names;
}

static const vv_label *find(const cli_label_names *names, const char *word, size_t n)
{
    for (size_t i = 0; i < names->n; i++)
        if (strlen(names->label[i].name) == n && strncasecmp(names->label[i].name, word, n) == 0)
            return &names->label[i];
    return NULL;
}

static vv_status fail_name(const cli_label_names *names, const char *option, const char *typed)
{
    enum { MOST = 256 };
    const char *known[MOST];
    size_t n = 0;
    for (size_t i = 0; i < names->n && n < MOST; i++)
        if (names->label[i].name[0])
            known[n++] = names->label[i].name;
    return vvi_fail_name(VV_E_NOT_FOUND, NULL, NULL, typed, &(vvi_known){known, n, "volvis info", NULL},
                         "--%s: there is no label '%s'", option, typed);
}

static bool any_has_name(const cli_label_names *names)
{
    for (size_t i = 0; i < names->n; i++)
        if (names->label[i].name[0])
            return true;
    return false;
}

vv_status cli_label_find(vv_label_id *out, bool *known_out, const cli_label_names *names, const char *option,
                         const char *word, size_t n)
{
    char typed[80];
    vv_status st = VV_OK;
    snprintf(typed, sizeof typed, "%.*s", (int)(n < 79 ? n : 79), word);
    *known_out = vvi_label_parse(out, typed, names->is_unsigned);
    const vv_label *found = *known_out || n == 0 ? NULL : find(names, word, n);
    if (found) {
        *out = found->value;
        *known_out = true;
    }
    if (*known_out || n == 0 || strchr("+-.0123456789", typed[0]))
        return VV_OK;
    if (names->input && (st = cli_label_layer_check_name(names->command, names->input, typed)) != VV_OK)
        return st;
    return any_has_name(names) ? fail_name(names, option, typed) : VV_OK;
}

/* Parameters ------------------------------------------------------------------------------------------------------ */

/* "PTV,3" to "1,3"; a name may have commas itself. What is no label is left to the parameter. */
static vv_status to_numbers(vvi_text *out, const cli_label_names *names, const char *option, const char *typed)
{
    char digits[VVI_LABEL_DIGITS];
    const bool whole = find(names, typed, strlen(typed)) != NULL;
    for (const char *at = typed;; at++) {
        vv_label_id id;
        bool known;
        const size_t n = whole ? strlen(at) : strcspn(at, ",");
        const char *first = at + strspn(at, " ");
        size_t left = n - (size_t)(first - at < (long)n ? first - at : (long)n);
        while (left > 0 && first[left - 1] == ' ')
            left--;
        const vv_status st = cli_label_find(&id, &known, names, option, first, left);
        if (st != VV_OK)
            return st;
        if (!known)
            return vv_fail(VV_E_ARGUMENT,
                           "--%s: expected labels, whole numbers%s, with commas between them, found '%s'", option,
                           any_has_name(names) ? " or names" : "", typed);
        vvi_text_printf(out, "%s%s", out->n ? "," : "", vvi_label_print(digits, id, names->is_unsigned));
        at += n;
        if (!*at)
            return out->bad ? vv_fail_memory(out->n) : VV_OK;
    }
}

/* Numbers alone are left to the operation, which says more of those that there are not. */
static bool has_name(const cli_given *given, const vv_class *cls)
{
    double number;
    const char *at = given->text, *end;
    if (given->cls != cls || given->row->quantity != VV_Q_LABEL)
        return false;
    for (; vvi_scan_number(&number, at, &end); at = end + 1) {
        end += strspn(end, " ");
        if (*end != ',')
            return *end != 0 && *end != '.'; /* a range is refused by the property */
    }
    return true;
}

vv_status cli_label_params(vv_object **out, const cli_args *args, const vv_class *cls,
                           const vv_property_context *context, const cli_label_names *names)
{
    cli_args own = *args;
    vvi_text numbers = {0};
    vv_status st = VV_OK;
    *out = NULL;
    own.given = calloc(args->n_given + 1, sizeof *own.given);
    if (!own.given)
        return vv_fail_memory(args->n_given * sizeof *own.given);
    for (size_t i = 0; i < args->n_given && st == VV_OK; i++) {
        own.given[i] = args->given[i];
        if (!has_name(&args->given[i], cls))
            continue;
        char option[64];
        cli_option_name(option, args->given[i].row);
        vvi_text_free(&numbers); /* the last one that is given holds */
        st = to_numbers(&numbers, names, option, args->given[i].text);
        own.given[i].text = numbers.s;
        for (size_t k = 0; k < i; k++)
            if (own.given[k].row == own.given[i].row)
                own.given[k].text = numbers.s;
    }
    if (st == VV_OK)
        st = cli_args_object(out, &own, cls, context);
    vvi_text_free(&numbers);
    free(own.given);
    return st;
}
