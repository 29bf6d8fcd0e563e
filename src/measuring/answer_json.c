/* Answers for programs, and what scenes keep of them. */
#include "core/memory.h"
#include "core/status.h"
#include "core/units.h"
#include "measuring/answer.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void add_figure(vvi_result *json, const vv_answer_item *f)
{
    char key[160];
    vvi_result_number(json, f->key, f->value);
    if (!isnan(f->error)) {
        snprintf(key, sizeof key, "%s_error", f->key);
        vvi_result_number(json, key, f->error);
    }
    if (*f->unit) {
        snprintf(key, sizeof key, "%s_unit", f->key);
        vvi_result_string(json, key, f->unit);
    }
}

static void add_rows(vvi_result *json, const vv_answer_item *rows)
{
    vvi_result_open(json, rows->key, '[');
    for (size_t i = 0; i < rows->n; i++)
        if (rows->columns == 1)
            vvi_result_number(json, NULL, rows->numbers[i]);
        else
            vvi_result_numbers(json, NULL, rows->numbers + i * rows->columns, rows->columns);
    vvi_result_close(json, ']');
}

static void add_counts(vvi_result *json, const vv_answer_item *counts)
{
    vvi_text text = {0};
    vvi_text_add(&text, "[");
    for (size_t i = 0; i < counts->n; i++)
        vvi_text_printf(&text, "%s%" PRIu64, i ? ", " : "", counts->counts[i]);
    vvi_text_add(&text, "]");
    if (!text.bad)
        vvi_result_raw(json, counts->key, text.s);
    json->text.bad |= text.bad;
    vvi_text_free(&text);
}

static void add_cell(vvi_result *json, const char *key, vv_cell_kind kind, const vv_cell *cell)
{
    if (kind == VV_CELL_NUMBER)
        vvi_result_number(json, key, cell->number);
    else if (kind == VV_CELL_COUNT)
        vvi_result_unsigned(json, key, cell->count);
    else if (kind == VV_CELL_LABEL || kind == VV_CELL_UNSIGNED_LABEL)
        vvi_result_label(json, key, cell->label, kind == VV_CELL_UNSIGNED_LABEL);
    else if (kind == VV_CELL_TEXT || *cell->text)
        vvi_result_string(json, key, cell->text);
}

/* Numbers of columns that have the same key make an array. */
static void add_row(vvi_result *json, const vv_answer_table *t, const vv_cell *cell)
{
    vvi_result_open(json, NULL, '{');
    for (size_t c = 0, n; c < t->n_columns; c += n) {
        const vv_answer_column *column = &t->columns[c];
        double v[8];
        n = 1;
        if (!column->key)
            continue;
        while (n < 8 && c + n < t->n_columns && column[n].key && strcmp(column[n].key, column->key) == 0)
            n++;
        for (size_t i = 0; i < n; i++)
            v[i] = cell[c + i].number;
        if (n > 1)
            vvi_result_numbers(json, column->key, v, n);
        else
            add_cell(json, column->key, column->kind, &cell[c]);
    }
    vvi_result_close(json, '}');
}

static void add_table(vvi_result *json, const vv_answer_item *item)
{
    const vv_answer_table *t = item->table;
    vvi_result_open(json, item->key, '[');
    for (size_t i = 0; i < t->n_rows; i++)
        add_row(json, t, t->cells + i * t->n_columns);
    vvi_result_close(json, ']');
}

static void add_item(vvi_result *json, const vv_answer_item *item)
{
    switch (item->kind) {
    case VV_ANSWER_FIGURE:
        add_figure(json, item);
        break;
    case VV_ANSWER_NUMBER:
        vvi_result_number(json, item->key, item->value);
        break;
    case VV_ANSWER_COUNT:
        vvi_result_unsigned(json, item->key, item->count);
        break;
    case VV_ANSWER_BOOL:
        vvi_result_bool(json, item->key, item->count != 0);
        break;
    case VV_ANSWER_TEXT:
        vvi_result_string(json, item->key, item->text);
        break;
    case VV_ANSWER_NUMBERS:
        vvi_result_numbers(json, item->key, item->numbers, item->n);
        break;
    case VV_ANSWER_ROWS:
        add_rows(json, item);
        break;
    case VV_ANSWER_COUNTS:
        add_counts(json, item);
        break;
    case VV_ANSWER_OPEN:
        vvi_result_open(json, item->key, *item->text);
        break;
    case VV_ANSWER_CLOSE:
        vvi_result_close(json, *item->text);
        break;
    case VV_ANSWER_TABLE:
        add_table(json, item);
        break;
    case VV_ANSWER_JSON:
        vvi_result_raw(json, item->key, item->text);
        break;
    case VV_ANSWER_LINE:
    case VV_ANSWER_BLOCK:
    case VV_ANSWER_BARS:
        break; /* for people */
    }
}

void vvi_answer_add_json(vvi_result *json, const vv_answer *a)
{
    for (size_t i = 0; i < a->n; i++)
        if (a->item[i].whom & VV_FOR_PROGRAMS)
            add_item(json, &a->item[i]);
}

static vv_status take(char **out, vvi_text *text)
{
    const size_t n = text->n;
    *out = vvi_text_take(text);
    return *out ? VV_OK : vv_fail_memory(n);
}

vv_status vv_answer_json(char **json_out, const vv_answer *a)
{
    vvi_result json = {0};
    vvi_result_open(&json, NULL, '{');
    vvi_answer_add_json(&json, a);
    vvi_result_close(&json, '}');
    return take(json_out, &json.text);
}

static void add_number(vvi_text *out, const char *name, double value)
{
    char number[32];
    if (!isfinite(value))
        return;
    vvi_print_number(number, value);
    vvi_text_printf(out, ", \"%s\": %s", name, number);
}

static void add_path(vvi_text *out, const double *v, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        char x[3][32];
        for (int a = 0; a < 3; a++)
            vvi_print_number(x[a], v[3 * i + (size_t)a]);
        vvi_text_printf(out, "%s[%s, %s, %s]", i ? ", " : ", \"path\": [", x[0], x[1], x[2]);
    }
    vvi_text_add(out, n ? "]" : "");
}

vv_status vv_answer_figures(char **json_out, const vv_answer *a)
{
    vvi_text out = {0};
    vvi_text_add(&out, "[");
    for (size_t i = 0; i < a->n; i++) {
        const vv_answer_item *f = &a->item[i];
        if (f->kind != VV_ANSWER_FIGURE || !(f->whom & VV_FOR_SCENES))
            continue;
        vvi_text_add(&out, out.n > 1 ? ", {\"name\": " : "{\"name\": ");
        vvi_text_json(&out, f->name);
        add_number(&out, "value", f->value);
        add_number(&out, "error", f->error);
        if (*f->unit) {
            vvi_text_add(&out, ", \"unit\": ");
            vvi_text_json(&out, f->unit);
        }
        add_path(&out, f->numbers, f->n);
        vvi_text_add(&out, "}");
    }
    vvi_text_add(&out, "]");
    return take(json_out, &out);
}
