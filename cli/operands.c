#include "operands.h"
#include "core/status.h"
#include "core/text.h"
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { WORDS_MOST = CLI_PLACES_MOST };

static const vv_property *positional_of(const vv_class *cls)
{
    const vv_property *row = cls->properties;
    while (row->name && !row->positional)
        row++;
    return row->name ? row : NULL;
}

const char *cli_operands_usage(const vv_operation *operation)
{
    if (positional_of(operation->params))
        return "FORMULA [NAME=]INPUT...";
    return vv_operation_most(operation) > 1 ? "INPUT..." : "INPUT";
}

void cli_operand_usage(vvi_text *out, const vv_operation *operation, const vv_operand *operand)
{
    if (operand != operation->inputs)
        vvi_text_printf(out, "%s=FILE", operand->name);
    else
        vvi_text_printf(out, "%sINPUT%s", operand->names ? "[NAME=]" : "", operand->most > 1 ? "..." : "");
}

void cli_operands_line(vvi_text *out, const vv_operation *operation)
{
    if (positional_of(operation->params))
        vvi_text_add(out, " FORMULA");
    for (const vv_operand *o = operation->inputs; o->name; o++) {
        vvi_text_add(out, o->least > 0 ? " " : " [");
        cli_operand_usage(out, operation, o);
        vvi_text_add(out, o->least > 0 ? "" : "]");
    }
}

static bool is_given(const cli_args *args, const vv_property *row)
{
    for (size_t i = 0; i < args->n_given; i++)
        if (args->given[i].row == row)
            return true;
    return false;
}

static void give(cli_args *args, const vv_class *cls, const vv_property *row, const char *text)
{
    args->given[args->n_given++] = (cli_given){.cls = cls, .row = row, .text = text};
}

/* Bytes of NAME in "NAME=FILE"; 0: it is a file. "./a=b.nrrd" is one. */
static size_t name_length(const char *word)
{
    const size_t n = strspn(word, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789");
    return word[n] == '=' ? n : 0;
}

/* Where the operand of a name begins among the inputs; WORDS_MOST: there is none. */
static size_t place_of(const vv_operation *operation, const char *name, size_t n)
{
    size_t place = 0;
    for (const vv_operand *o = operation->inputs; o->name; o++) {
        if (strlen(o->name) == n && memcmp(o->name, name, n) == 0)
            return place;
        place += o->most;
    }
    return WORDS_MOST;
}

static vv_status fail_name(const cli_verb *verb, const char *word, size_t n)
{
    vvi_text names = {0};
    for (const vv_operand *o = verb->operation->inputs; o->name; o++)
        vvi_text_printf(&names, "%s%s", names.n ? ", " : "", o->name);
    const vv_status st = vv_fail(VV_E_ARGUMENT, "%s has no input '%.*s', and there is no file '%s'; its inputs are: %s",
                                 verb->name, (int)n, word, word, names.s ? names.s : "");
    vvi_text_free(&names);
    return st;
}

static vv_status put_in_places(cli_args *args, const cli_verb *verb)
{
    const char *at[WORDS_MOST] = {NULL};
    bool named[WORDS_MOST] = {false};
    size_t n = 0, last = 0;
    for (size_t w = 0; w < args->n_words; w++) {
        const size_t length = name_length(args->words[w]);
        const size_t place = length ? place_of(verb->operation, args->words[w], length) : WORDS_MOST;
        if (place == WORDS_MOST && length && access(args->words[w], F_OK) != 0)
            return fail_name(verb, args->words[w], length);
        if (place == WORDS_MOST)
            continue;
        if (at[place])
            return vv_fail(VV_E_ARGUMENT, "%s: '%s' and '%s=%s' are the same input; omit one", verb->name,
                           args->words[w], verb->operation->inputs[place].name, at[place]);
        at[place] = args->words[w] + length + 1;
        named[place] = place > 0;
        args->words[w] = NULL;
    }
    for (size_t w = 0; w < args->n_words; w++) {
        while (args->words[w] && n < WORDS_MOST && at[n])
            n++;
        if (args->words[w])
            at[n++] = args->words[w];
    }
    for (size_t i = 0; i < WORDS_MOST; i++)
        last = at[i] ? i + 1 : last;
    args->n_words = 0;
    for (size_t i = 0; i < last; i++) {
        const vv_operand *operand = vv_operation_operand(verb->operation, i);
        if (!at[i] && operand->least > 0)
            return vv_fail(VV_E_ARGUMENT, "%s: %s is missing: %s", verb->name, operand->name, operand->doc);
        if (!at[i])
            continue;
        args->placed |= args->n_words != i;
        args->place[args->n_words] = i;
        args->named[args->n_words] = named[i];
        args->words[args->n_words++] = at[i];
    }
    return VV_OK;
}

/* Names that people choose; what has none is called by its letter. */
static vv_status take_names(cli_args *args, const cli_verb *verb)
{
    const vv_class *cls = verb->operation->params;
    const vv_property *row = vv_class_find(cls, verb->operation->inputs[0].names);
    vvi_text names = {0};
    bool any = false;
    for (size_t w = 0; w < args->n_words; w++) {
        const size_t n = name_length(args->words[w]);
        any |= n > 0;
        if (n > 0)
            vvi_text_printf(&names, "%s%.*s", w ? "," : "", (int)n, args->words[w]);
        else
            vvi_text_printf(&names, "%s%c", w ? "," : "", (char)('a' + w));
        args->words[w] += n > 0 ? n + 1 : 0;
    }
    if (any && is_given(args, row)) {
        vvi_text_free(&names);
        return vv_fail(VV_E_ARGUMENT, "--%s and NAME=FILE both name the inputs; give one of them", row->name);
    }
    if (names.bad)
        return vv_fail_memory(names.n);
    if (any)
        give(args, cls, row, args->names = vvi_text_take(&names));
    vvi_text_free(&names);
    return VV_OK;
}

vv_status cli_operands_take(cli_args *args, const cli_verb *verb)
{
    const vv_operation *operation = verb->operation;
    if (!operation)
        return VV_OK;
    const vv_property *row = positional_of(operation->params);
    if (row && args->n_words > 0 && !is_given(args, row)) {
        give(args, operation->params, row, args->words[0]);
        memmove(args->words, args->words + 1, --args->n_words * sizeof *args->words);
        for (size_t i = 0; i < args->n_given; i++)
            args->given[i].n_before -= args->given[i].n_before > 0;
    }
    if (args->n_words == 0 || args->n_words > WORDS_MOST)
        return VV_OK;
    return operation->inputs[0].names ? take_names(args, verb) : put_in_places(args, verb);
}
