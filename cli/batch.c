#include "batch.h"
#include "core/names.h"
#include "core/status.h"
#include "core/text.h"
#include "edits.h"
#include "input.h"
#include "options.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const char mark[] = "{stem}";

static cli_given *output_of(const cli_args *args)
{
    cli_given *found = NULL;
    for (size_t i = 0; i < args->n_given; i++)
        if (args->given[i].cls == &cli_common_class && args->given[i].row->letter == 'o')
            found = &args->given[i];
    return found;
}

/* A further input, which is for each of the runs. */
static bool is_shared(const cli_args *args, size_t word)
{
    return word < CLI_PLACES_MOST && args->named[word];
}

size_t cli_batch_count(const cli_args *args, const cli_verb *verb)
{
    const cli_given *output = output_of(args);
    size_t n = 0;
    for (size_t i = 0; i < args->n_words; i++)
        n += !is_shared(args, i);
    return verb->each_input && output && strstr(output->text, mark) ? n : 0;
}

/* "data/head.nii.gz" is "head": without folder, packing and suffix. */
static vv_status add_stem(vvi_text *out, const char *word)
{
    static const char *const packed[] = {".gz", ".bz2", ".zst", ".xz"};
    cli_input_name name;
    const vv_status st = cli_input_split(&name, word);
    if (st != VV_OK)
        return st;
    size_t end = strlen(name.path);
    while (end > 1 && name.path[end - 1] == '/')
        end--;
    size_t begin = end;
    while (begin > 0 && name.path[begin - 1] != '/')
        begin--;
    for (size_t i = 0; i < sizeof packed / sizeof packed[0]; i++) {
        const size_t n = strlen(packed[i]);
        if (end - begin > n && strncasecmp(name.path + end - n, packed[i], n) == 0)
            end -= n;
    }
    size_t dot = end;
    while (dot > begin && name.path[dot - 1] != '.')
        dot--;
    if (dot > begin + 1)
        end = dot - 1;
    vvi_text_printf(out, "%.*s", (int)(end - begin), name.path + begin);
    cli_input_name_free(&name);
    return VV_OK;
}

vv_status cli_batch_name(char **out, const char *pattern, const char *word)
{
    vvi_text text = {0};
    vv_status st = VV_OK;
    const char *at;
    *out = NULL;
    for (; st == VV_OK && (at = strstr(pattern, mark)); pattern = at + sizeof mark - 1) {
        vvi_text_printf(&text, "%.*s", (int)(at - pattern), pattern);
        st = add_stem(&text, word);
    }
    vvi_text_add(&text, pattern);
    if (st == VV_OK && text.bad)
        st = vv_fail_memory(text.n);
    if (st == VV_OK)
        *out = vvi_text_take(&text);
    vvi_text_free(&text);
    return st;
}

/* A file may be called "{a, b}.png", but a word in braces is meant to be replaced. */
static vv_status check_placeholder(const char *pattern, const char *brace, const cli_verb *verb)
{
    static const char *const names[] = {"stem"};
    const size_t n = strspn(brace + 1, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_");
    char name[64];
    snprintf(name, sizeof name, "%.*s", (int)(n < 60 ? n : 60), brace + 1);
    const bool closed = n > 0 && brace[n + 1] == '}', stem = strcmp(name, names[0]) == 0;
    if (!closed && stem)
        return vv_fail(VV_E_ARGUMENT, "-o %s: {stem has no closing brace", pattern);
    if (!closed)
        return VV_OK;
    if (!stem)
        return vvi_fail_name(VV_E_ARGUMENT, NULL, NULL, name, &(vvi_known){names, 1, NULL, NULL},
                             "-o %s: there is no placeholder {%s}", pattern, name);
    if (!verb->each_input)
        return vv_fail(VV_E_ARGUMENT,
                       "-o %s: %s makes one result of all its inputs, and {stem} is the name of one; give "
                       "a name without it",
                       pattern, verb->name);
    return VV_OK;
}

static vv_status check_placeholders(const char *pattern, const cli_verb *verb)
{
    vv_status st = VV_OK;
    for (const char *brace = strchr(pattern, '{'); brace && st == VV_OK; brace = strchr(brace + 1, '{'))
        st = check_placeholder(pattern, brace, verb);
    return st;
}

/* Each of several goes on from a file of its own. */
static vv_status check_resume(const cli_args *args)
{
    for (size_t i = 0; i < args->n_given; i++)
        if (!strcmp(args->given[i].row->name, "resume") && !strstr(args->given[i].text, mark))
            return vv_fail(VV_E_ARGUMENT,
                           "--resume %s: each of several pictures goes on from a file of its own; put {stem} into the "
                           "name",
                           args->given[i].text);
    return VV_OK;
}

vv_status cli_batch_check(const cli_args *args, const cli_verb *verb)
{
    const cli_given *output = output_of(args);
    const char *pattern = output ? output->text : "";
    vv_status checked = check_placeholders(pattern, verb);
    if (checked != VV_OK || cli_batch_count(args, verb) == 0)
        return checked;
    if ((checked = check_resume(args)) != VV_OK)
        return checked;
    char **outputs = calloc(args->n_words + 1, sizeof *outputs);
    vv_status st = outputs ? VV_OK : vv_fail_memory(args->n_words * sizeof *outputs);
    for (size_t i = 0; i < args->n_words && st == VV_OK; i++) {
        st = is_shared(args, i) ? VV_OK : cli_batch_name(&outputs[i], pattern, args->words[i]);
        for (size_t j = 0; j < i && st == VV_OK && outputs[i]; j++)
            if (outputs[j] && strcmp(outputs[i], outputs[j]) == 0)
                st = vv_fail(VV_E_ARGUMENT, "-o %s would be '%s' for both '%s' and '%s'", pattern, outputs[i],
                             args->words[j], args->words[i]);
    }
    for (size_t i = 0; outputs && i < args->n_words; i++)
        free(outputs[i]);
    free(outputs);
    return st;
}

/* As in one picture of several inputs: an option about values that stands between two is for the one before it, and so
 * is one after the last where others were given before. */
static bool is_for(const cli_args *args, const cli_given *given, size_t index)
{
    const bool one = cli_edit_is_each(given) && given->n_before > 0 && cli_edit_given_between(args, args->n_words);
    return !one || given->n_before == index + 1;
}

/* What stands anywhere else is for each of them. */
static void take_options(cli_args *args, size_t index)
{
    size_t n = 0;
    for (size_t i = 0; i < args->n_given; i++) /* looked at whole, then cut */
        args->given[i].skip = !is_for(args, &args->given[i], index);
    for (size_t i = 0; i < args->n_given; i++) {
        if (args->given[i].skip)
            continue;
        args->given[n] = args->given[i];
        args->given[n++].n_before = 0;
    }
    args->n_given = n;
}

vv_status cli_batch_take(char **output_out, cli_args *args, size_t index)
{
    cli_given *output = output_of(args);
    size_t word = 0, n = 1;
    for (size_t left = index; left > 0 || is_shared(args, word); word++)
        left -= !is_shared(args, word);
    const vv_status st = cli_batch_name(output_out, output->text, args->words[word]);
    if (st != VV_OK)
        return st;
    output->text = *output_out;
    take_options(args, index);
    const char *input = args->words[word];
    args->placed = false;
    for (size_t i = 0; i < args->n_words; i++)
        if (is_shared(args, i)) {
            args->placed |= args->place[i] != n;
            args->place[n] = args->place[i];
            args->words[n++] = args->words[i];
        }
    args->words[0] = input;
    args->place[0] = 0;
    args->n_words = n;
    return VV_OK;
}
