/* Objects as options of a command line, and words as a shell takes them. */
#include "core/json_text.h"
#include "core/memory.h"
#include "core/names.h"
#include "core/units.h"
#include "server/command.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void vvi_command_quote(vvi_text *out, const char *s)
{
    vvi_text_add(out, "'");
    for (; *s; s++)
        vvi_text_add(out, *s == '\'' ? "'\\''" : (char[2]){*s, 0});
    vvi_text_add(out, "'");
}

/* Whether a text without its marks would be read as something else, or says nothing. */
static bool needs_marks(const char *inside, size_t n)
{
    return n == 0 || memchr(inside, '\\', n) || strchr("{[\"", *inside) || (n == 4 && memcmp(inside, "null", n) == 0);
}

/* "\"text\"" is typed as it is meant, and "[1, 2, \"3\"]" as 1,2,3. */
static void put_value(vvi_text *out, const char *json, vvi_command_word *put)
{
    const size_t n = strlen(json);
    const bool text = n > 1 && *json == '"';
    char *typed = vvi_strdup(json), *to = typed;
    if (!typed || (text ? needs_marks(json + 1, n - 2) : strchr(json, '{') != NULL)) {
        put(out, json);
    } else if (text) {
        typed[n - 1] = 0;
        put(out, typed + 1);
    } else {
        for (const char *from = json; *from; from++)
            if (!strchr("[]\" ", *from))
                *to++ = *from;
        *to = 0;
        put(out, typed);
    }
    free(typed);
}

/* " --name", as the option is called. */
static void put_name(vvi_text *out, const vv_property *row, const char *before)
{
    vvi_text_printf(out, " --%s", before);
    for (const char *at = row->option ? row->option : row->name; *at; at++)
        vvi_text_add(out, *at == '_' ? "-" : (char[2]){*at, 0});
}

/* Of a table each row by itself. */
static void put_rows(vvi_text *out, const vv_property *row, const vv_numbers *rows)
{
    for (size_t i = 0; rows && i < rows->n; i++) {
        char number[32];
        const bool first = i % (size_t)row->columns == 0;
        vvi_print_number(number, rows->v[i]);
        if (first)
            put_name(out, row, "");
        vvi_text_printf(out, "%s%s", first ? "=" : ",", number);
    }
}

/* LO..HI, of which this row is LO and the next one HI. */
static void put_range(vvi_text *out, const vv_property *row, const vv_object *params)
{
    char end[2][32] = {"", ""};
    for (int i = 0; i < 2; i++)
        if (vv_object_is_set(params, row[i].name))
            vvi_print_number(end[i], *(const double *)(const void *)((const char *)params + row[i].offset));
    if (!*end[0] && !*end[1])
        return;
    put_name(out, row, "");
    vvi_text_printf(out, "=%s..%s", end[0], end[1]);
}

static void put_option(vvi_text *out, const vv_property *row, const char *json, vvi_command_word *put)
{
    const bool is_bool = row->kind == VV_KIND_BOOL;
    put_name(out, row, is_bool && strcmp(json, "true") != 0 ? "no-" : "");
    if (is_bool)
        return;
    vvi_text_add(out, "=");
    put_value(out, json, put);
}

/* Whether it says nothing beside a choice that is another, as in "kind=box|ellipse". */
static bool is_idle(const vv_property *row, const vv_object *params)
{
    const vv_property *choice = vvi_property_choice(params->cls, row);
    return choice && !vvi_property_acts_with(
                         row, choice->names[*(const int *)(const void *)((const char *)params + choice->offset)]);
}

/* A length as somebody wrote it with its unit, which files of another unit need; false: it has none. */
static bool put_length(vvi_text *out, const vv_property *row, const json_t *written, vvi_command_word *put)
{
    const char *text = json_string_value(json_object_get(written, row->name));
    double bare;
    if (!text || row->quantity != VV_Q_LENGTH || row->kind != VV_KIND_F64 || vvi_parse_number(&bare, text))
        return false;
    put_name(out, row, "");
    vvi_text_add(out, "=");
    put(out, text);
    return true;
}

static vv_status put_options(vvi_text *out, const vv_object *params, const json_t *written, vvi_command_word *put)
{
    for (const vv_property *row = params ? params->cls->properties : NULL; row && row->name; row++) {
        char *json = NULL;
        if (row->ranged)
            put_range(out, row, params);
        if (row->ranged || (row->option && !*row->option) || !vv_object_is_set(params, row->name) ||
            is_idle(row, params) || put_length(out, row, written, put))
            continue;
        if (row->kind == VV_KIND_NUMBERS && row->columns > 1 && !row->lone) {
            put_rows(out, row, *(vv_numbers *const *)(const void *)((const char *)params + row->offset));
            continue;
        }
        const vv_status st = vv_path_get(&json, params, row->name);
        if (st != VV_OK)
            return st;
        put_option(out, row, json, put);
        free(json);
    }
    return VV_OK;
}

vv_status vvi_command_options(vvi_text *out, const vv_object *params, vvi_command_word *put)
{
    return put_options(out, params, NULL, put);
}

vv_status vvi_command_parameters(vvi_text *out, const vvi_made *made, const vv_object *params, vvi_command_word *put)
{
    const char *said = made->dataset->parameters;
    json_t *written = vvi_json_of_own(said ? said : "{}");
    const vv_status st = written ? put_options(out, params, written, put) : vv_fail_memory(sizeof *made);
    json_decref(written);
    return st;
}
