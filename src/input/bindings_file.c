/* Bindings laid over those that VolVis has, and the lines that errors name. */
#include "core/job.h"
#include "core/json_text.h"
#include "core/memory.h"
#include "core/property_impl.h"
#include "core/text.h"
#include "input/bindings_impl.h"
#include "io/source.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Printing -------------------------------------------------------------------------------------------------------- */

static json_t *row_of(const vvi_default_binding *d)
{
    json_t *row = json_pack("{s:s}", "device", d->device);
    if (d->when)
        vvi_json_put(&row, "when", json_string(d->when));
    vvi_json_put(&row, "method", json_string(d->method));
    if (d->action)
        vvi_json_put(&row, "action", json_string(d->action));
    if (d->gain != 0)
        vvi_json_put(&row, "gain", json_real(d->gain));
    return row;
}

static json_t *default_rows(void)
{
    json_t *rows = json_object();
    for (const vvi_default_binding *d = vvi_default_rows; d->name; d++)
        vvi_json_put(&rows, d->name, row_of(d));
    return rows;
}

/* A row a line, so that two lists can be compared. */
static char *print(const json_t *rows)
{
    vvi_text text = {0};
    const char *name, *before = "";
    json_t *row;
    vvi_text_add(&text, "{\"bindings\": {");
    json_object_foreach((json_t *)rows, name, row)
    {
        char *line = vvi_json_encode(row, JSON_REAL_PRECISION(15));
        text.bad |= !line;
        vvi_text_printf(&text, "%s\n", before);
        vvi_text_json(&text, name);
        vvi_text_printf(&text, ": %s", line ? line : "");
        free(line);
        before = ",";
    }
    vvi_text_add(&text, "\n}}\n");
    return vvi_text_take(&text);
}

char *vvi_bindings_default(void)
{
    json_t *rows = default_rows();
    char *text = rows ? print(rows) : NULL;
    json_decref(rows);
    return text;
}

/* Lines ----------------------------------------------------------------------------------------------------------- */

typedef struct place {
    const char *text, *end;
    int line;
} place;

static void skip_string(place *p)
{
    for (p->text++; p->text < p->end && *p->text != '"'; p->text++) {
        p->line += *p->text == '\n';
        p->text += *p->text == '\\' && p->text + 1 < p->end;
    }
}

/* The line of the next key of that name, `depth` brackets deep; text that has been parsed. 0: there is none. */
static int find_key(place *p, int *now, int depth, const char *name)
{
    const size_t n = strlen(name);
    for (; p->text < p->end; p->text++) {
        p->line += *p->text == '\n';
        *now += (*p->text == '{' || *p->text == '[') - (*p->text == '}' || *p->text == ']');
        if (*p->text != '"')
            continue;
        const char *begin = p->text + 1;
        const int line = p->line;
        skip_string(p);
        if (*now == depth && (size_t)(p->text - begin) == n && memcmp(begin, name, n) == 0) {
            const char *after = p->text + 1;
            while (after < p->end && strchr(" \t\r\n", *after))
                after++;
            if (after < p->end && *after == ':') {
                p->text++;
                return line;
            }
        }
    }
    return 0;
}

/* Of a binding, or of a property of it. */
static int line_of(const char *text, size_t n, const char *name, const char *property)
{
    place p = {text, text + n, 1};
    int now = 0;
    const int line = find_key(&p, &now, 2, name);
    const int inner = line && property ? find_key(&p, &now, 3, property) : 0;
    return inner ? inner : line;
}

/* The thread's error, said of a line of the file; `shown`: what is between file and sentence, NULL for nothing. */
static vv_status fail_line(const char *file, int line, const char *shown)
{
    vvi_error_copy copy;
    char where[32];
    vvi_error_take(&copy);
    const char *said = copy.message ? copy.message : "";
    const size_t n = copy.where ? strlen(copy.where) : 0;
    if (n && strncmp(said, copy.where, n) == 0 && strncmp(said + n, ": ", 2) == 0)
        said += n + 2;
    snprintf(where, sizeof where, "line %d", line > 0 ? line : 1);
    const vv_status st = copy.status == VV_E_MEMORY || copy.status == VV_E_LIMIT ? copy.status : VV_E_FORMAT;
    if (shown)
        vv_fail_at(st, file, where, "%s: %s", shown, said);
    else
        vv_fail_at(st, file, where, "%s", said);
    vvi_error_copy_free(&copy);
    return st;
}

/* Rows ------------------------------------------------------------------------------------------------------------ */

/* What was bound to the same thing is so no more. */
static void unbind(json_t *rows, const json_t *added)
{
    const char *name;
    json_t *row;
    void *next;
    const json_t *when = json_object_get(added, "when"), *device = json_object_get(added, "device");
    json_object_foreach_safe(rows, next, name, row) if (json_equal(json_object_get(row, "device"), device) &&
                                                        (when ? json_equal(json_object_get(row, "when"), when)
                                                              : !json_object_get(row, "when")))
        json_object_del(rows, name);
}

/* The file that is laid over. */
typedef struct laid {
    const char *text, *file;
    size_t n;
    const vv_registry *registry;
} laid;

static vv_status fail_row(const laid *l, const char *name, const char *property)
{
    return fail_line(l->file, line_of(l->text, l->n, name, property), name);
}

static vv_status check_row(const json_t *row, const char *name, const laid *l)
{
    char *json = vvi_json_encode(row, JSON_ENCODE_ANY | JSON_REAL_PRECISION(17));
    vv_object *object = NULL;
    if (!json)
        return vv_fail_memory(256);
    const vv_status st = vv_object_from_json(&object, &vvi_binding_class, json, strlen(json), NULL);
    free(json);
    if (st == VV_OK) {
        const char *action = ((const vvi_binding *)(const void *)object)->action;
        const vv_status found = action ? vvi_action_check_name(action, l->registry) : VV_OK;
        vv_object_release(object);
        return found == VV_OK ? VV_OK : fail_row(l, name, "action");
    }
    char property[64] = "";
    const char *where = vv_error_last()->where, *quoted = strchr(vv_error_last()->message, '\'');
    if (where)
        snprintf(property, sizeof property, "%.*s", (int)strcspn(where, ".[ "), where);
    else if (quoted) /* of a property that is unknown the sentence alone has the name */
        snprintf(property, sizeof property, "%.*s", (int)strcspn(quoted + 1, "'"), quoted + 1);
    return fail_row(l, name, *property ? property : NULL);
}

static const char *text_of(const json_t *row, const char *key)
{
    const char *text = json_string_value(json_object_get(row, key));
    return text ? text : "";
}

static bool is_same_place(const json_t *a, const json_t *b)
{
    return strcmp(text_of(a, "device"), text_of(b, "device")) == 0 &&
           vvi_binding_meets(text_of(a, "when"), text_of(a, "method"), text_of(b, "when"), text_of(b, "method"));
}

/* Rows that have been checked. */
static vv_status check_twice(const json_t *over, const char *name, const json_t *row, const laid *l)
{
    const char *other;
    json_t *before;
    json_object_foreach((json_t *)over, other, before)
    {
        if (before == row)
            break;
        if (json_is_null(before) || !is_same_place(before, row))
            continue;
        vv_fail(VV_E_FORMAT, "%s is already bound to \"%.60s\"", text_of(row, "when"), other);
        return fail_row(l, name, "when");
    }
    return VV_OK;
}

static vv_status fail_removed(const char *name, const json_t *rows, const laid *l)
{
    const char *names[256], *known;
    size_t count = 0;
    json_t *row;
    json_object_foreach((json_t *)rows, known, row) if (count < 256) names[count++] = known;
    const char *near = vv_nearest_name(name, names, count);
    vv_fail(VV_E_FORMAT, "there is no such binding to remove%s%s", near ? "; the nearest is " : "", near ? near : "");
    return fail_row(l, name, NULL);
}

/* Those of the file are checked first, and take places of VolVis' own only: a file may have one button drag and click.
 */
static vv_status lay(json_t *rows, const json_t *over, const laid *l)
{
    const char *name;
    json_t *row;
    vv_status st = VV_OK;
    json_object_foreach((json_t *)over, name, row)
    {
        if (st == VV_OK && json_is_null(row) && !json_object_get(rows, name))
            st = fail_removed(name, rows, l);
        else if (st == VV_OK && !json_is_null(row) && (st = check_row(row, name, l)) == VV_OK)
            st = check_twice(over, name, row, l);
    }
    json_object_foreach((json_t *)over, name, row)
    {
        json_object_del(rows, name);
        if (!json_is_null(row))
            unbind(rows, row);
    }
    json_object_foreach((json_t *)over, name, row)
    {
        if (st == VV_OK && !json_is_null(row) && json_object_set(rows, name, row) != 0)
            st = vv_fail_memory(strlen(name));
    }
    return st;
}

static vv_status check_top(const json_t *all, const char *file)
{
    const char *name;
    json_t *value;
    json_object_foreach((json_t *)all, name, value) if (strcmp(name, "bindings") != 0) return vv_fail_at(
        VV_E_FORMAT, file, NULL, "expected \"bindings\" only, found \"%.40s\"", name);
    if (!json_is_object(json_object_get(all, "bindings")))
        return vv_fail_at(VV_E_FORMAT, file, NULL,
                          "expected {\"bindings\": {...}}, as volvis view --print-bindings shows it");
    return VV_OK;
}

vv_status vvi_bindings_lay_over(char **out, const char *text, size_t n, const char *name, const vv_registry *registry)
{
    const laid l = {text, name, n, registry};
    json_t *all = NULL, *rows = default_rows();
    *out = NULL;
    vv_status st = rows ? vvi_json_parse(&all, text, n, NULL) : vv_fail_memory(256);
    if (rows && st != VV_OK)
        st = fail_line(name, vv_error_last()->where ? atoi(vv_error_last()->where) : 1, NULL);
    if (st == VV_OK)
        st = check_top(all, name);
    if (st == VV_OK)
        st = lay(rows, json_object_get(all, "bindings"), &l);
    if (st == VV_OK && !(*out = print(rows)))
        st = vv_fail_memory(256);
    json_decref(all);
    json_decref(rows);
    return st;
}

vv_status vvi_bindings_read(char **out, const char *path, vv_job *job)
{
    enum { MOST = 1 << 20 };
    vv_source *source = NULL;
    size_t n = 0;
    char *text = vvi_calloc(1, MOST);
    *out = NULL;
    vv_status st = text ? vvi_source_open(&source, path, job) : vv_fail_memory(MOST);
    if (st == VV_OK)
        st = vvi_source_read_some(source, text, MOST, &n);
    if (st == VV_OK && n == MOST)
        st = vv_fail_at(VV_E_LIMIT, path, NULL, "bindings are at most 1 MiB of text");
    if (st == VV_OK)
        st = vvi_bindings_lay_over(out, text, n, path, vvi_job_registry(job));
    vvi_source_close(source);
    free(text);
    return st;
}
