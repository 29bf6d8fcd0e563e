#include "measuring/answer.h"
#include "core/memory.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Room ------------------------------------------------------------------------------------------------------------ */

static bool keep(vv_answer *a, void *memory)
{
    if (a->n_kept == a->kept_room) {
        const size_t room = 2 * a->kept_room + 16;
        void **more = vvi_realloc_plain(a->kept, room * sizeof *more);
        if (!more)
            return false;
        a->kept = more;
        a->kept_room = room;
    }
    a->kept[a->n_kept++] = memory;
    return true;
}

void *vvi_answer_room(vv_answer *a, size_t n, size_t bytes)
{
    void *memory = vvi_calloc(n + 1, bytes);
    if (memory && keep(a, memory))
        return memory;
    free(memory);
    a->bad = true;
    return NULL;
}

const char *vvi_answer_copy(vv_answer *a, const char *text)
{
    char *copy = *text ? vvi_strdup(text) : NULL;
    if (!*text || (copy && keep(a, copy)))
        return copy ? copy : "";
    free(copy);
    a->bad = true;
    return "";
}

void vv_answer_release(vv_answer *a)
{
    if (!a)
        return;
    for (size_t i = 0; i < a->n_kept; i++)
        free(a->kept[i]);
    free(a->kept);
    free(a->item);
    free(a->note);
    free(a);
}

/* Items ----------------------------------------------------------------------------------------------------------- */

static vv_answer_item *add(vv_answer *a, vv_answer_kind kind, unsigned whom, const char *key)
{
    if (a->n == a->room) {
        const size_t room = 2 * a->room + 32;
        vv_answer_item *more = vvi_realloc_plain(a->item, room * sizeof *more);
        if (!more) {
            a->bad = true;
            return &a->lost;
        }
        a->item = more;
        a->room = room;
    }
    vv_answer_item *item = &a->item[a->n++];
    *item = (vv_answer_item){.kind = kind, .whom = whom, .unit = "", .error = NAN};
    item->key = key ? vvi_answer_copy(a, key) : NULL;
    return item;
}

/* "box_area" of the part "box". */
static const char *name_of(vv_answer *a, const char *key, const char *end)
{
    char name[192];
    snprintf(name, sizeof name, "%s%s%s%s", a->part ? a->part : "", a->part ? "_" : "", key, end);
    return vvi_answer_copy(a, name);
}

void vvi_tell_figure_for(vv_answer *a, const vvi_figure *f, unsigned whom)
{
    vv_answer_item *item = add(a, VV_ANSWER_FIGURE, whom, whom & VV_FOR_PROGRAMS ? f->key : NULL);
    item->name = name_of(a, f->key, "");
    item->label = vvi_answer_copy(a, f->label ? f->label : "");
    item->unit = vvi_answer_copy(a, f->unit);
    item->value = f->value;
    item->error = f->error;
    item->chance = f->chance;
}

void vvi_tell_figure(vv_answer *a, const vvi_figure *f)
{
    vvi_tell_figure_for(a, f, VV_FOR_ALL);
}

void vvi_tell(vv_answer *a, const char *key, const char *label, double value, double error, const char *unit)
{
    vvi_figure f = {.key = key, .label = label, .value = value, .error = error};
    snprintf(f.unit, sizeof f.unit, "%s", unit);
    vvi_tell_figure(a, &f);
}

void vvi_tell_rare(vv_answer *a, const char *key, const char *label, uint64_t count)
{
    vvi_tell_figure_for(a, &(vvi_figure){.key = key, .label = label, .value = (double)count, .error = NAN},
                        count ? VV_FOR_ALL : VV_FOR_TABLES);
}

void vvi_tell_place(vv_answer *a, const char *key, const double v[3], const double error[3], const char *unit)
{
    vvi_tell_numbers(a, key, v, 3);
    for (int i = 0; i < 3; i++) {
        char name[128];
        vvi_figure f = {.key = name, .value = v[i], .error = error ? error[i] : NAN};
        snprintf(name, sizeof name, "%s_%c", key, "xyz"[i]);
        snprintf(f.unit, sizeof f.unit, "%s", unit);
        vvi_tell_figure_for(a, &f, VV_FOR_TABLES | VV_FOR_SCENES);
    }
}

void vvi_tell_text(vv_answer *a, const char *key, const char *text)
{
    add(a, VV_ANSWER_TEXT, VV_FOR_PROGRAMS, key)->text = text ? vvi_answer_copy(a, text) : NULL;
}

void vvi_tell_json(vv_answer *a, const char *key, const char *json)
{
    add(a, VV_ANSWER_JSON, VV_FOR_PROGRAMS, key)->text = vvi_answer_copy(a, json);
}

void vvi_tell_number(vv_answer *a, const char *key, double value)
{
    add(a, VV_ANSWER_NUMBER, VV_FOR_PROGRAMS, key)->value = value;
}

void vvi_tell_count(vv_answer *a, const char *key, uint64_t count)
{
    add(a, VV_ANSWER_COUNT, VV_FOR_PROGRAMS, key)->count = count;
}

void vvi_tell_bool(vv_answer *a, const char *key, bool value)
{
    add(a, VV_ANSWER_BOOL, VV_FOR_PROGRAMS, key)->count = value;
}

static void set_numbers(vv_answer *a, vv_answer_item *item, const double *v, size_t n, size_t columns)
{
    double *numbers = vvi_answer_room(a, n * columns, sizeof *numbers);
    if (numbers)
        memcpy(numbers, v, n * columns * sizeof *v);
    item->numbers = numbers;
    item->n = numbers ? n : 0;
    item->columns = columns;
}

static void add_numbers(vv_answer *a, vv_answer_kind kind, const char *key, const double *v, size_t n, size_t columns)
{
    set_numbers(a, add(a, kind, VV_FOR_PROGRAMS, key), v, n, columns);
}

void vvi_tell_path(vv_answer *a, const char *key, const double *v, size_t n)
{
    for (size_t i = 0; i < a->n; i++) {
        vv_answer_item *item = &a->item[i];
        if (item->kind == VV_ANSWER_FIGURE && item->key && strcmp(item->key, key) == 0)
            set_numbers(a, item, v, n, 3);
    }
}

void vvi_tell_numbers(vv_answer *a, const char *key, const double *v, size_t n)
{
    add_numbers(a, VV_ANSWER_NUMBERS, key, v, n, 1);
}

void vvi_tell_rows(vv_answer *a, const char *key, const double *v, size_t n, size_t columns)
{
    add_numbers(a, VV_ANSWER_ROWS, key, v, n, columns);
}

void vvi_tell_counts(vv_answer *a, const char *key, const uint64_t *v, size_t n)
{
    uint64_t *counts = vvi_answer_room(a, n, sizeof *counts);
    vv_answer_item *item = add(a, VV_ANSWER_COUNTS, VV_FOR_PROGRAMS, key);
    if (counts)
        memcpy(counts, v, n * sizeof *v);
    item->counts = counts;
    item->n = counts ? n : 0;
}

void vvi_tell_open(vv_answer *a, const char *key, const char *bracket)
{
    add(a, VV_ANSWER_OPEN, VV_FOR_PROGRAMS, key)->text = bracket;
}

void vvi_tell_close(vv_answer *a, const char *bracket)
{
    add(a, VV_ANSWER_CLOSE, VV_FOR_PROGRAMS, NULL)->text = bracket;
}

/* What printf makes, as room of the answer. */
static const char *print(vv_answer *a, const char *format, va_list arguments) VV_PRINTF(2, 0);
static const char *print(vv_answer *a, const char *format, va_list arguments)
{
    char *text = NULL;
    if (vasprintf(&text, format, arguments) >= 0 && keep(a, text))
        return text;
    free(text);
    a->bad = true;
    return "";
}

void vvi_tell_line(vv_answer *a, const char *label, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const char *text = print(a, format, arguments);
    va_end(arguments);
    vv_answer_item *item = add(a, VV_ANSWER_LINE, VV_FOR_PEOPLE, NULL);
    item->label = vvi_answer_copy(a, label);
    item->text = text;
}

void vvi_tell_block(vv_answer *a, vvi_text *text)
{
    if (!text->n && !text->bad)
        return;
    char *whole = vvi_text_take(text);
    if (whole && keep(a, whole)) {
        add(a, VV_ANSWER_BLOCK, VV_FOR_PEOPLE, NULL)->text = whole;
        return;
    }
    free(whole);
    a->bad = true;
}

void vvi_tell_note(vv_answer *a, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const char *text = print(a, format, arguments);
    va_end(arguments);
    char **more = vvi_realloc_plain(a->note, (a->n_notes + 1) * sizeof *more);
    if (more) {
        a->note = more;
        more[a->n_notes++] = (char *)(uintptr_t)text;
    }
    a->bad |= !more;
}

void vvi_tell_bars(vv_answer *a, const vv_statistics *bars)
{
    add(a, VV_ANSWER_BARS, VV_FOR_PEOPLE, NULL)->bars = bars;
}

void vvi_tell_table(vv_answer *a, const char *key, const vv_answer_column *columns, size_t n_columns,
                    const vv_cell *cells, size_t n_rows)
{
    vv_answer_table *table = vvi_answer_room(a, 1, sizeof *table);
    if (!table)
        return;
    *table = (vv_answer_table){columns, n_columns, n_rows, cells};
    add(a, VV_ANSWER_TABLE, VV_FOR_TABLES | (key ? VV_FOR_PROGRAMS : 0), key)->table = table;
}

/* Reading --------------------------------------------------------------------------------------------------------- */

const vv_answer_item *vv_answer_nth(const vv_answer *a, size_t index)
{
    return index < a->n ? &a->item[index] : NULL;
}

const char *vv_answer_note(const vv_answer *a, size_t index)
{
    return index < a->n_notes ? a->note[index] : NULL;
}

const char *vv_answer_object(const vv_answer *a)
{
    return a->object;
}

const char *vv_answer_region(const vv_answer *a)
{
    return a->region;
}
