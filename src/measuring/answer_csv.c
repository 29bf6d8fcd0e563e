/* Answers as tables of comma-separated values. */
#include "core/units.h"
#include "grid/label_id.h"
#include "measuring/answer.h"
#include <inttypes.h>
#include <math.h>
#include <string.h>

static void add_number(vvi_text *out, double value)
{
    char number[32] = "";
    if (isfinite(value))
        vvi_print_number(number, value);
    vvi_text_add(out, number);
}

/* In quotes, and those in it twice (RFC 4180). */
static void add_name(vvi_text *out, const char *name)
{
    const char *quote;
    vvi_text clean = {0};
    vvi_text_add_clean(&clean, name);
    if (clean.n) {
        vvi_text_add(out, "\"");
        for (name = clean.s; (quote = strchr(name, '"')); name = quote + 1)
            vvi_text_printf(out, "%.*s\"\"", (int)(quote - name), name);
        vvi_text_printf(out, "%s\"", name);
    }
    out->bad |= clean.bad;
    vvi_text_free(&clean);
}

static void add_cell(vvi_text *out, vv_cell_kind kind, const vv_cell *cell)
{
    char digits[VVI_LABEL_DIGITS];
    switch (kind) {
    case VV_CELL_NUMBER:
        vvi_text_printf(out, "%.17g", cell->number);
        break;
    case VV_CELL_COUNT:
        vvi_text_printf(out, "%" PRIu64, cell->count);
        break;
    case VV_CELL_LABEL:
    case VV_CELL_UNSIGNED_LABEL:
        vvi_text_add(out, vvi_label_print(digits, cell->label, kind == VV_CELL_UNSIGNED_LABEL));
        break;
    case VV_CELL_TEXT:
        vvi_text_add(out, cell->text);
        break;
    case VV_CELL_NAME:
        add_name(out, cell->text);
        break;
    }
}

/* cells: of a row; NULL: the names of the columns. */
static void add_row(vvi_text *out, const vv_answer_table *table, const vv_cell *cells)
{
    const char *between = "";
    for (size_t c = 0; c < table->n_columns; c++) {
        const vv_answer_column *column = &table->columns[c];
        if (!column->name)
            continue;
        vvi_text_add(out, between);
        if (cells)
            add_cell(out, column->kind, &cells[c]);
        else
            vvi_text_add(out, column->name);
        between = ",";
    }
    vvi_text_add(out, "\n");
}

static void print_table(vvi_text *out, const vv_answer_table *table)
{
    add_row(out, table, NULL);
    for (size_t i = 0; i < table->n_rows; i++)
        add_row(out, table, table->cells + i * table->n_columns);
}

static void print_figures(vvi_text *out, const vv_answer *answer)
{
    const vv_answer_item *item;
    vvi_text_add(out, "quantity,value,error,unit\n");
    for (size_t i = 0; (item = vv_answer_nth(answer, i)); i++) {
        if (item->kind != VV_ANSWER_FIGURE || !(item->whom & VV_FOR_TABLES))
            continue;
        vvi_text_printf(out, "%s,", item->name);
        add_number(out, item->value);
        vvi_text_add(out, ",");
        add_number(out, item->error);
        vvi_text_printf(out, ",%s\n", item->unit);
    }
}

void vvi_answer_add_csv(vvi_text *out, const vv_answer *answer)
{
    const vv_answer_item *item;
    bool any = false;
    for (size_t i = 0; (item = vv_answer_nth(answer, i)); i++)
        if (item->kind == VV_ANSWER_TABLE) {
            print_table(out, item->table);
            any = true;
        }
    if (!any)
        print_figures(out, answer);
}
