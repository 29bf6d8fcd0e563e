/* Answers for people, and as tables. One question asked. */
#include "histogram.h"
#include "label_layers.h"
#include "measure.h"
#include "refusal.h"
#include <stdlib.h>

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

void cli_answer_print(cli_command *command, const vv_answer *answer, bool csv, bool logarithmic)
{
    const vv_answer_item *item;
    vvi_answer_add_json(&command->json, answer);
    if (csv)
        vvi_answer_add_csv(&command->text, answer);
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
static vv_status check_layer(const cli_command *command, const cli_measured *in, const vv_measurement *asked)
{
    return in->of.input.volume.field && vv_object_is_set(&asked->base, "label")
               ? cli_label_layer_check(command, &in->file[0], asked->label)
               : VV_OK;
}

static vv_status take_figures(vv_measurement **asked, const vv_answer *answer)
{
    vv_object *object = &(*asked)->base;
    char *figures = NULL;
    vv_status st = vv_answer_figures(&figures, answer);
    if (st == VV_OK)
        st = vv_path_set(&object, "figures", figures, NULL);
    *asked = (vv_measurement *)(void *)object;
    free(figures);
    return st;
}

vv_status cli_measure_ask(vv_answer **out, vv_measurement **asked_out, cli_command *command, const cli_question *q)
{
    cli_measured in = {0};
    *out = NULL;
    *asked_out = (vv_measurement *)(void *)vv_object_retain(&q->asked->base);
    vv_status st = cli_measured_open(&in, command, q);
    if (st == VV_OK)
        st = q->typed ? cli_measure_names(asked_out, command, &in) : check_layer(command, &in, q->asked);
    if (st == VV_OK && (st = cli_measured_open_beside(&in, command, *asked_out)) == VV_OK)
        st = vv_measure_run(out, *asked_out, &in.of.inputs, command->job);
    if (st == VV_OK)
        st = take_figures(asked_out, *out);
    for (size_t i = 0; *out && vv_answer_note(*out, i); i++)
        cli_command_note(command, "%s", vv_answer_note(*out, i));
    cli_measured_close(&in);
    return st == VV_OK || !q->typed ? st : refuse_objects(command, st);
}
