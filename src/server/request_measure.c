/* Measurements of data of the World: a question as scenes keep it, and the answer that `volvis measure` gives. */
#include "core/job.h"
#include "core/memory.h"
#include "io/file_stream.h"
#include "measure/plot.h"
#include "measuring/answer.h"
#include "measuring/world_data.h"
#include "model/classes.h"
#include "server/request.h"

#include <stdlib.h>
#include <string.h>

enum { ANSWER_MOST = 16 << 20 };

/* Data ------------------------------------------------------------------------------------------------------------- */

/* Something of the World, open. */
typedef struct source {
    vv_file *file; /* NULL: it was made in memory */
    vvi_measured_volume volume;
    vv_mesh *mesh;
    vv_measured_data data;
} source;

typedef struct sources {
    source input, other, mask, values;
    vvi_measured_meshes shown;
    vv_measured_inputs all;
} sources;

static void close_source(source *s)
{
    vvi_measured_volume_finish(&s->volume);
    vv_mesh_release(s->mesh);
    vv_file_close(s->file);
}

static void close_all(sources *s)
{
    close_source(&s->input);
    close_source(&s->other);
    close_source(&s->mask);
    close_source(&s->values);
    vvi_measured_meshes_finish(&s->shown);
}

/* Samples where a scene says which are missing are read anew. */
static vv_status read_samples(vv_field **out, const source *s, const vv_world *world, const vv_dataset *dataset,
                              const vv_volume *volume, vv_job *job)
{
    const vv_numbers *missing = volume ? volume->missing : NULL;
    const char *attribute = volume ? volume->attribute : NULL;
    const int64_t frame = volume ? volume->frame : 0;
    if (!s->file || !missing || attribute)
        return vv_dataset_field(out, world, dataset, attribute, frame, job);
    vvi_job_keep_fills(job);
    const vv_status st = vvi_file_leave_out(s->file, missing->v, missing->n);
    return st == VV_OK || st == VV_E_ARGUMENT ? vv_file_read(out, s->file, frame, NULL, job) : st;
}

/* What a volume of the World shows. */
static vv_status open_shown(source *s, const vvi_request *r, const vv_volume *volume, const vv_dataset *dataset,
                            const char *name, vv_job *job)
{
    vv_field *field = NULL;
    if (vv_dataset_is_mesh(dataset, job)) {
        const vv_status st = vv_dataset_mesh(&s->mesh, r->world, dataset, job);
        s->data = (vv_measured_data){.name = name, .mesh = s->mesh, .place = vv_affine_identity()};
        return st;
    }
    vv_status st = vvi_request_open_origin(&s->file, r->world, dataset, job);
    if (st == VV_OK && (st = read_samples(&field, s, r->world, dataset, volume, job)) == VV_OK)
        st = vvi_measured_volume_take(&s->volume, field, s->file, name, r->world, volume, r->view, job);
    s->data = s->volume.data;
    vv_field_release(field);
    return st;
}

/* Samples that are told with those of a volume: their own place alone counts. */
static vv_status open_beside(source *s, const vv_measured_data **data, vv_object **question, const char *property,
                             const vvi_request *r, const json_t *inputs, vv_job *job)
{
    const json_t *id = json_object_get(inputs, property);
    if (!id)
        return VV_OK;
    const char *name = json_string_value(id);
    const vv_dataset *dataset = vvi_dataset_named(r->world, name);
    if (!dataset)
        return vv_fail(VV_E_NOT_FOUND, "%s: the dataset '%.64s' no longer exists", property, name);
    if (vv_dataset_is_mesh(dataset, job))
        return vv_fail(VV_E_ARGUMENT, "%s: '%.64s' is a mesh; samples are needed", property, name);
    const vv_status st = read_samples(&s->volume.field, s, r->world, dataset, NULL, job);
    s->data = (vv_measured_data){.name = name, .field = s->volume.field};
    *data = &s->data;
    return st == VV_OK ? vv_path_set(question, property, name, NULL) : st;
}

static vv_status open_volume(source *s, const vvi_request *r, const char *id, const char *name, vv_job *job)
{
    const vv_dataset *dataset;
    const vv_volume *volume = vvi_request_volume(r->world, id, &dataset);
    return volume ? open_shown(s, r, volume, dataset, name, job) : VV_E_NOT_FOUND;
}

/* A mesh is measured where the World has it, unless its kind has no such form. */
static vv_status open_input(sources *s, const vvi_request *r, const vv_measurement *question, bool two, vv_job *job)
{
    const vv_measure_kind *kind = vv_measure_kind_of(question);
    const size_t n_points = question->points ? question->points->n / 3 : 0;
    const char *id = vvi_measured_volume_id(r->world, r->name);
    if (!id)
        return r->name ? vv_fail(VV_E_NOT_FOUND, "there is no volume '%.64s'", r->name)
                       : vv_fail(VV_E_NOT_FOUND, "nothing is visible that could be measured");
    vv_status st = open_volume(&s->input, r, id, id, job);
    s->all.input = &s->input.data;
    s->all.n_inputs = 1;
    if (st != VV_OK || !s->input.mesh || two || !vv_measure_form_of(kind, VV_MEASURED_SHOWN, 0, n_points))
        return st;
    st = vvi_measured_meshes_take(&s->shown, r->world, r->name, "the World", job);
    s->all.input = s->shown.data;
    s->all.n_inputs = s->shown.n;
    return st;
}

static vv_status open_all(sources *s, vv_object **question, const vvi_request *r, const json_t *inputs, vv_job *job)
{
    const char *other = json_string_value(json_object_get(inputs, "other"));
    s->all.size = sizeof s->all;
    vv_status st = open_input(s, r, (const vv_measurement *)(const void *)*question, other != NULL, job);
    if (st == VV_OK && other) {
        st = open_volume(&s->other, r, other, other, job);
        s->all.other = &s->other.data;
    }
    if (st == VV_OK)
        st = open_beside(&s->mask, &s->all.mask, question, "mask", r, inputs, job);
    return st == VV_OK ? open_beside(&s->values, &s->all.values, question, "values", r, inputs, job) : st;
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
    for (size_t i = 0; vv_answer_note(answer, i); i++)
        vvi_result_string(out, NULL, vv_answer_note(answer, i));
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
    json_t *inputs = json_loads(r->inputs, 0, NULL);
    sources s = {0};
    vv_answer *answer = NULL;
    vv_status st = open_all(&s, &r->params, r, inputs, job);
    if (st == VV_OK)
        st = vv_measure_run(&answer, (const vv_measurement *)(const void *)r->params, &s.all, job);
    if (st == VV_OK)
        st = put_answer(&r->value, answer, r->add, job);
    if (st != VV_OK)
        vvi_text_free(&r->value.text);
    vv_answer_release(answer);
    close_all(&s);
    json_decref(inputs);
    return st;
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
    char *text = json_dumps(question, JSON_COMPACT | JSON_REAL_PRECISION(17));
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
            json_object_set(inputs, names[i], id);
    }
    if (st == VV_OK && !(r->inputs = json_dumps(inputs, JSON_COMPACT)))
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
