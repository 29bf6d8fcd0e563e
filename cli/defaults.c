#include "defaults.h"
#include "core/status.h"
#include "options.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_BYTES = 64 << 10, MOST_WORDS = 256 };

char *cli_defaults_path(bool *named)
{
    const char *chosen = getenv("VOLVIS_DEFAULTS"), *config = getenv("XDG_CONFIG_HOME"), *home = getenv("HOME");
    char *path = NULL;
    *named = chosen && *chosen;
    if (*named)
        return strcmp(chosen, "none") == 0 ? NULL : strdup(chosen);
    if (config && config[0] == '/')
        return asprintf(&path, "%s/volvis/defaults", config) < 0 ? NULL : path;
    if (home && home[0] == '/')
        return asprintf(&path, "%s/.config/volvis/defaults", home) < 0 ? NULL : path;
    return NULL;
}

/* NULL where there is none and none has to be. */
static vv_status read_file(char **out, const char *path, bool named)
{
    vv_status st = VV_OK;
    *out = NULL;
    FILE *file = fopen(path, "re");
    if (!file && !named && (errno == ENOENT || errno == ENOTDIR))
        return VV_OK;
    if (!file)
        return vv_fail_at(VV_E_READ, path, NULL, "the file of defaults cannot be read: %s", strerror(errno));
    char *text = calloc(1, MOST_BYTES + 1);
    const size_t n = text ? fread(text, 1, MOST_BYTES, file) : 0;
    if (!text)
        st = vv_fail_memory(MOST_BYTES);
    else if (ferror(file) || fgetc(file) != EOF || memchr(text, 0, n))
        st = vv_fail_at(VV_E_READ, path, NULL, "the file of defaults cannot be read: expected text of at most 64 KiB");
    fclose(file);
    if (st == VV_OK)
        *out = text;
    else
        free(text);
    return st;
}

/* The line is cut in its place into words, as a shell does it: quotes hold what has blanks. */
static vv_status cut_words(char **words, size_t *n_out, char *line)
{
    static const char blanks[] = " \t\r";
    size_t n = 0;
    char *to = line;
    for (char *at = line + strspn(line, blanks); *at;) {
        char quote = 0;
        if (n == MOST_WORDS)
            return vv_fail(VV_E_ARGUMENT, "expected at most %d words in a line; make it several lines", MOST_WORDS);
        words[n++] = to;
        for (; *at && (quote || !strchr(blanks, *at)); at++) {
            if (quote ? *at == quote : *at == '\'' || *at == '"')
                quote = quote ? 0 : *at;
            else
                *to++ = *at;
        }
        if (quote)
            return vv_fail(VV_E_ARGUMENT, "a quote is not closed");
        at += strspn(at, blanks); /* before the end mark, which may stand on the first of them */
        *to++ = 0;
    }
    *n_out = n;
    return VV_OK;
}

/* What makes sense once, not always. */
static vv_status check_given(const cli_args *args)
{
    static const char *const never[] = {"output", "help", "dry_run", "defaults", "watch"};
    if (args->n_words)
        return vv_fail(VV_E_ARGUMENT, "expected options after the verb, found '%s'", args->words[0]);
    for (size_t i = 0; i < args->n_given; i++)
        for (size_t k = 0; k < sizeof never / sizeof never[0]; k++)
            if (strcmp(args->given[i].row->name, never[k]) == 0) {
                char name[64];
                cli_option_name(name, args->given[i].row);
                return vv_fail(VV_E_ARGUMENT, "--%s cannot be a default; give it on the command line", name);
            }
    return VV_OK;
}

/* The verb that a line is for, and its options. */
static vv_status parse_line(cli_args *out, cli_verb *verb, char *line, const vv_registry *registry)
{
    char *words[MOST_WORDS];
    size_t n = 0;
    vv_status st = VV_OK;
    *out = (cli_args){0};
    *verb = (cli_verb){.name = "every verb"};
    if ((st = cut_words(words, &n, line)) != VV_OK)
        return st;
    const size_t first = n > 0 && words[0][0] != '-';
    if (first && (st = cli_verb_find(verb, registry, words[0])) != VV_OK)
        return st;
    if ((st = cli_args_parse(out, verb, (int)(n - first), words + first)) == VV_OK)
        st = check_given(out);
    return st;
}

static bool is_given(const cli_args *args, const cli_given *given)
{
    for (size_t i = 0; i < args->n_given; i++)
        if (args->given[i].row == given->row && !args->given[i].place)
            return true;
    return false;
}

/* Options that may be repeated by name come together; of others the command line's replaces the file's. */
static bool is_wanted(const cli_args *args, const cli_given *given, const cli_verb *verb)
{
    const bool common = given->cls == &cli_common_class;
    if (common && strcmp(given->row->name, "set") == 0)
        return verb->world;
    return (common && given->row->kind == VV_KIND_LIST) || !is_given(args, given);
}

void cli_defaults_spell(vvi_text *out, const cli_given *given)
{
    char name[64];
    const bool off = given->row->kind == VV_KIND_BOOL && strcmp(given->text, "false") == 0;
    cli_option_name(name, given->row);
    vvi_text_printf(out, "%s--%s%s", out->n ? " " : "", off ? "no-" : "", name);
    if (given->row->kind != VV_KIND_BOOL)
        vvi_text_printf(out, strpbrk(given->text, " \t") ? " '%s'" : " %s", given->text);
}

/* *n_before: options of the file that stand in `args` by now. */
static vv_status add_line(cli_defaults *d, cli_args *args, size_t *n_before, const cli_args *line, const cli_verb *verb,
                          const char *place)
{
    char **places = realloc(d->places, (d->n_places + 1) * sizeof *places);
    if (places)
        d->places = places;
    cli_given *given = realloc(args->given, (args->n_given + line->n_given + 1) * sizeof *given);
    if (given)
        args->given = given;
    if (!places || !given || !(places[d->n_places] = strdup(place)))
        return vv_fail_memory(strlen(place));
    const char *kept = places[d->n_places++];
    for (size_t i = 0; i < line->n_given; i++) {
        if (!is_wanted(args, &line->given[i], verb))
            continue;
        memmove(given + *n_before + 1, given + *n_before, (args->n_given - *n_before) * sizeof *given);
        given[*n_before] = line->given[i];
        given[*n_before].n_before = 0;
        given[*n_before].place = kept;
        ++*n_before;
        args->n_given++;
    }
    return VV_OK;
}

vv_status cli_defaults_take(cli_defaults *out, cli_args *args, const cli_verb *verb, const vv_registry *registry)
{
    bool named;
    size_t n_before = 0, number = 0;
    *out = (cli_defaults){.path = cli_defaults_path(&named)};
    vv_status st = out->path ? read_file(&out->text, out->path, named) : VV_OK;
    for (char *line = out->text, *next; line && st == VV_OK; line = next) {
        cli_verb of;
        cli_args words = {0};
        char place[4200];
        next = strchr(line, '\n');
        if (next)
            *next++ = 0;
        number++;
        line += strspn(line, " \t\r");
        if (!*line || *line == '#')
            continue;
        /* what is wrong with another verb's options is said when that verb runs */
        const bool every = *line == '-';
        const size_t n = strcspn(line, " \t\r");
        const bool ours = every || !verb || (strlen(verb->name) == n && memcmp(line, verb->name, n) == 0);
        snprintf(place, sizeof place, "%.4096s:%zu", out->path, number);
        if (!ours)
            line[n] = 0;
        if ((st = parse_line(&words, &of, line, registry)) != VV_OK)
            st = vv_fail_in(st, "%s", place);
        else if (ours && verb)
            st = add_line(out, args, &n_before, &words, verb, place);
        cli_args_free(&words);
    }
    if (args)
        cli_defaults_list(&out->taken, args);
    if (!out->text) {
        free(out->path);
        out->path = NULL;
    }
    return st;
}

void cli_defaults_list(vvi_text *out, const cli_args *args)
{
    vvi_text_free(out);
    for (size_t i = 0; i < args->n_given; i++)
        if (args->given[i].place)
            cli_defaults_spell(out, &args->given[i]);
}

void cli_defaults_drop(cli_args *args, const vv_class *cls, const char *row)
{
    size_t n = 0;
    for (size_t i = 0; i < args->n_given; i++) {
        const cli_given *given = &args->given[i];
        if (!given->place || given->cls != cls || (row && strcmp(given->row->name, row) != 0))
            args->given[n++] = *given;
    }
    args->n_given = n;
}

void cli_defaults_free(cli_defaults *defaults)
{
    for (size_t i = 0; i < defaults->n_places; i++)
        free(defaults->places[i]);
    free(defaults->places);
    free(defaults->path);
    free(defaults->text);
    vvi_text_free(&defaults->taken);
    *defaults = (cli_defaults){0};
}
