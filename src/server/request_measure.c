/* Measurements of data of the World: a question as scenes keep it, and the answer that `volvis measure` gives. */
#include "core/job.h"
#include "core/json_text.h"
#include "core/memory.h"
#include "measure/plot.h"
#include "measuring/answer.h"
#include "model/classes.h"
#include "run/measured.h"
#include "server/request.h"

#include <stdlib.h>
#include <string.h>

enum { ANSWER_MOST = 16 << 20 };

/* Data ------------------------------------------------------------------------------------------------------------- */

/* Samples that are told with those of a volume: their own place alone counts. */
static vv_status open_beside(vvi_measured *out, const vv_measured_data **data, vv_object **question,
                             const char *property, const vvi_request *r, const json_t *inputs, vv_job *job)
{
    const char *id = json_string_value(json_object_get(inputs, property));
    const vv_status st = id ? vvi_measured_dataset(out, r->world, id, property, job) : VV_OK;
    if (!id || st != VV_OK)
        return st;
    *data = &out->volume.data;
    return vv_path_set(question, property, id, NULL);
}

/* A mesh is measured where the World has it, unless its kind has no such form. */
static vv_status open_input(vvi_measured_all *s, const vvi_request *r, const vv_measurement *question, bool two,
                            vv_job *job)
{
    const vv_measure_kind *kind = vv_measure_kind_of(question);
    const size_t n_points = question->points ? question->points->n / 3 : 0;
    const char *id = vvi_measured_volume_id(r->world, r->name);
    if (!id)
        return r->name ? vv_fail(VV_E_NOT_FOUND, "there is no volume '%.64s'", r->name)
                       : vv_fail(VV_E_NOT_FOUND, "nothing is visible that could be measured");
    vv_status st = vvi_measured_shown(&s->input, r->world, id, r->view, job);
    s->inputs.input = &s->input.volume.data;
    s->inputs.n_inputs = 1;
    if (st != VV_OK || !s->input.mesh || two || !vv_measure_form_of(kind, VV_MEASURED_SHOWN, 0, n_points))
        return st;
    st = vvi_measured_meshes_take(&s->shown, r->world, r->name, "the World", job);
    s->inputs.input = s->shown.data;
    s->inputs.n_inputs = s->shown.n;
    return st;
}

static vv_status open_all(vvi_measured_all *s, vv_object **question, const vvi_request *r, const json_t *inputs,
                          vv_job *job)
{
    const char *other = json_string_value(json_object_get(inputs, "other"));
    s->inputs.size = sizeof s->inputs;
    vv_status st = open_input(s, r, (const vv_measurement *)(const void *)*question, other != NULL, job);
    if (st == VV_OK && other) {
        st = vvi_measured_shown(&s->other, r->world, other, r->view, job);
        s->inputs.other = &s->other.volume.data;
    }
    if (st == VV_OK)
        st = open_beside(&s->mask, &s->inputs.mask, question, "mask", r, inputs, job);
    return st == VV_OK ? open_beside(&s->values, &s->inputs.values, question, "values", r, inputs, job) : st;
}

/* As the page has it: options of the verb are properties of the question, or of its region. */
static void put_words(vvi_text *out, const char *text)
{
    vvi_text half = {0};
    vvi_request_words(&half, text, &vvi_measurement_class);
    vvi_request_words(out, half.s ? half.s : text, &vvi_measured_region_class);
    out->bad |= half.bad;
    vvi_text_free(&half);
}

static vv_status reword(vv_status st)
{
    vvi_error_copy error;
    vvi_text text = {0};
    const char *file = vv_error_last()->file;
    if (st == VV_OK || st == VV_E_CANCELLED || file)
        return st;
    vvi_error_take(&error);
    put_words(&text, error.message);
    st = vv_fail_at(st, NULL, error.where, "%s", text.s ? text.s : error.message);
    vvi_text_free(&text);
    vvi_error_copy_free(&error);
    return st;
}

/* Answer ----------------------------------------------------------------------------------------------------------- */

/* As a file of plots has it; null where nothing is to be plotted. */
static vv_status put_plot(vvi_result *out, const vv_answer *answer, vv_job *job)
{
    char title[256], subtitle[256];
    vvi_text document = {0};
    if (!answer->plot) {
        vvi_result_raw(out, "plot", "null");
        return VV_OK;
    }
    vvi_plot plot = *answer->plot;
    plot.title = vvi_plot_words(title, sizeof title, plot.title);
    plot.subtitle = vvi_plot_words(subtitle, sizeof subtitle, plot.subtitle);
    const vv_status st = vvi_plot_svg(&document, &plot, job);
    if (st == VV_OK)
        vvi_result_string(out, "plot", document.s);
    vvi_text_free(&document);
    return st;
}

static vv_status put_answer(vvi_result *out, const vv_answer *answer, bool plotted, vv_job *job)
{
    char *figures = NULL;
    vv_status st = vv_answer_figures(&figures, answer);
    if (st != VV_OK)
        return st;
    vvi_result_open(out, NULL, '{');
    vvi_result_open(out, "answer", '{');
    vvi_answer_add_json(out, answer);
    vvi_result_close(out, '}');
    vvi_result_open(out, "notes", '[');
    for (size_t i = 0; vv_answer_note(answer, i); i++) {
        vvi_text note = {0};
        put_words(&note, vv_answer_note(answer, i));
        vvi_result_string(out, NULL, note.s ? note.s : "");
        vvi_text_free(&note);
    }
    vvi_result_close(out, ']');
    vvi_result_raw(out, "figures", figures);
    if (plotted)
        st = put_plot(out, answer, job);
    vvi_result_close(out, '}');
    free(figures);
    if (st != VV_OK)
        return st;
    if (out->text.bad)
        return vv_fail_memory(out->text.n);
    return out->text.n <= ANSWER_MOST
               ? VV_OK
               : vv_fail(VV_E_LIMIT, "the answer is %zu bytes long, and %d are the most that a page is sent",
                         out->text.n, ANSWER_MOST);
}

static vv_status run(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    json_t *inputs = vvi_json_of_own(r->inputs);
    vvi_measured_all s = {0};
    vv_answer *answer = NULL;
    vv_status st = inputs ? open_all(&s, &r->params, r, inputs, job) : vv_fail_memory(strlen(r->inputs));
    if (st == VV_OK)
        st = vv_measure_run(&answer, (const vv_measurement *)(const void *)r->params, &s.inputs, job);
    if (st == VV_OK)
        st = put_answer(&r->value, answer, r->add, job);
    if (st != VV_OK)
        vvi_text_free(&r->value.text);
    vv_answer_release(answer);
    vvi_measured_close(&s);
    json_decref(inputs);
    return reword(st);
}

/* Question --------------------------------------------------------------------------------------------------------- */

/* Data are named by the message alone: paths of files, which a scene's measurements have, are none of a page's. */
static vv_status check_question(const vv_object *question)
{
    static const char *const files[] = {"file", "other", "mask", "values", "input_unit"};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++)
        if (vv_object_is_set(question, files[i]))
            return vv_fail(VV_E_ARGUMENT,
                           "'question' has '%s': data are named beside it, as 'volume', 'other', 'mask' and 'values'",
                           files[i]);
    return VV_OK;
}

static vv_status take_question(vvi_request *r, const json_t *question)
{
    if (!json_is_object(question))
        return vv_fail(VV_E_ARGUMENT, "'measure' needs a question: {\"what\": \"area\", \"iso\": 90}");
    char *text = vvi_json_encode(question, JSON_COMPACT | JSON_REAL_PRECISION(17));
    vv_status st =
        text ? vv_object_from_json(&r->params, &vvi_measurement_class, text, strlen(text), NULL) : vv_fail_memory(256);
    free(text);
    return st == VV_OK ? check_question(r->params) : st;
}

static vv_status take_inputs(vvi_request *r, const json_t *message)
{
    static const char *const names[] = {"other", "mask", "values"};
    json_t *inputs = json_object();
    vv_status st = VV_OK;
    for (size_t i = 0; i < sizeof names / sizeof *names && st == VV_OK; i++) {
        json_t *id = json_object_get(message, names[i]);
        if (id && !json_is_string(id))
            st = vv_fail(VV_E_ARGUMENT, "'%s' must be a name: of a %s", names[i], i ? "dataset" : "volume");
        else if (id)
            vvi_json_put(&inputs, names[i], json_incref(id));
    }
    if (st == VV_OK && !(r->inputs = inputs ? vvi_json_encode(inputs, JSON_COMPACT) : NULL))
        st = vv_fail_memory(256);
    json_decref(inputs);
    return st;
}

vv_status vvi_request_measure(vvi_client *client, int64_t id, const json_t *message)
{
    vvi_request *r;
    vv_status st = vvi_request_new(&r, client, id, "measure", run);
    if (st != VV_OK)
        return st;
    r->task.done = vvi_request_done_slowly;
    r->add = json_is_true(json_object_get(message, "plot"));
    if ((st = vvi_request_take_text(&r->name, message, "volume")) == VV_OK &&
        (st = take_question(r, json_object_get(message, "question"))) == VV_OK)
        st = take_inputs(r, message);
    return vvi_request_add_slow(r, st);
}
