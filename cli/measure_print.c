/* Answers for people, and as tables. One question asked. */
#include "core/units.h"
#include "grid/label_id.h"
#include "histogram.h"
#include "label_layers.h"
#include "measure.h"
#include "refusal.h"
#include <inttypes.h>
#include <math.h>
#include <string.h>

/* Text ------------------------------------------------------------------------------------------------------------ */

static void print_item(cli_command *command, const vv_answer_item *item, bool logarithmic)
{
    char text[VVI_FIGURE_TEXT];
    if (item->kind == VV_ANSWER_BLOCK) {
        vvi_text_add(&command->text, item->text);
    } else if (item->kind == VV_ANSWER_BARS) {
        cli_histogram_text(&command->text, item->bars, logarithmic);
    } else if (item->kind == VV_ANSWER_LINE) {
        cli_command_line(command, item->label, "%s", item->text);
    } else if (item->kind == VV_ANSWER_FIGURE) {
        vvi_figure_print(text, item->value, item->error, item->chance, item->unit);
        cli_command_line(command, item->label, "%s", text);
    }
}

/* Tables ---------------------------------------------------------------------------------------------------------- */

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

/* The table that it has, or its figures. */
static void print_csv(vvi_text *out, const vv_answer *answer)
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

void cli_answer_print(cli_command *command, const vv_answer *answer, bool csv, bool logarithmic)
{
    const vv_answer_item *item;
    vvi_answer_add_json(&command->json, answer);
    if (csv)
        print_csv(&command->text, answer);
    for (size_t i = 0; !csv && (item = vv_answer_nth(answer, i)); i++)
        if (item->whom & VV_FOR_PEOPLE)
            print_item(command, item, logarithmic);
}

/* Asking ---------------------------------------------------------------------------------------------------------- */

/* What people typed may be refused for what the file of defaults says. */
static vv_status refuse_objects(const cli_command *command, vv_status st)
{
    static const char *const objects[] = {"iso", "threshold_lo", "label", "mask"};
    size_t given = 0;
    for (size_t i = 0; i < sizeof objects / sizeof *objects; i++)
        given += cli_measure_typed(command, objects[i]) != NULL;
    return given > 1 ? cli_refused(command, "iso,threshold,label,mask", st) : st;
}

/* What is stored names its labels by number. */
static vv_status check_layer(const cli_command *command, const cli_measured_inputs *in, const vv_measurement *asked)
{
    return in->first.volume.field && vv_object_is_set(&asked->base, "label")
               ? cli_label_layer_check(command, &in->first.input, asked->label)
               : VV_OK;
}

vv_status cli_measure_ask(vv_answer **out, vv_measurement **asked_out, cli_command *command, const cli_question *q)
{
    cli_measured_inputs in = {0};
    *out = NULL;
    *asked_out = (vv_measurement *)(void *)vv_object_retain(&q->asked->base);
    vv_status st = cli_measured_open(&in, command, q);
    if (st == VV_OK)
        st = q->typed ? cli_measure_names(asked_out, command, &in) : check_layer(command, &in, q->asked);
    if (st == VV_OK && (st = cli_measured_open_beside(&in, command, *asked_out)) == VV_OK)
        st = vv_measure_run(out, *asked_out, &in.all, command->job);
    for (size_t i = 0; *out && vv_answer_note(*out, i); i++)
        cli_command_note(command, "%s", vv_answer_note(*out, i));
    cli_measured_close(&in);
    return st == VV_OK || !q->typed ? st : refuse_objects(command, st);
}
