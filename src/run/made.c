/* Datasets that are made of others, worked out when they are asked for and kept in the cache. */
#include "run/made.h"
#include "core/cache.h"
#include "core/findings.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/status.h"
#include "grid/field_copy.h"
#include "grid/mesh.h"
#include "model/dataset.h"
#include "registry.h"
#include "scene/load.h"
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* One thing to make: the user of the cache's makers. */
typedef struct request {
    const vv_world *world;
    const vv_dataset *dataset;
    int64_t frame;
} request;

static vv_status get(vvi_cached **out, const char *what, vvi_cache_make_fn *make, void (*drop)(void *value),
                     const request *r, vv_job *job)
{
    vvi_cache_key key = {.what = what};
    const vv_status st = vvi_made_content(&key.parameters, r->world, r->dataset, job);
    key.parameters = vvi_hash(&r->frame, sizeof r->frame, key.parameters);
    return st == VV_OK ? vvi_cache_get(out, &key, make, drop, (void *)(uintptr_t)r, job) : st;
}

/* Planned ---------------------------------------------------------------------------------------------------------- */

static vv_status make_info(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    vvi_made made;
    vv_object *params = NULL;
    vv_field_info *info = NULL;
    vv_status st = vvi_made_open(&made, r->world, r->dataset, job);
    if (st == VV_OK)
        st = vvi_made_params(&params, &made, job);
    if (st == VV_OK && !(info = vvi_alloc(NULL, sizeof *info, VVI_MEM_MODEL)))
        st = vv_fail_memory(sizeof *info);
    if (st == VV_OK)
        st = vvi_made_plan(info, &made, params, job);
    vv_object_release(params);
    vvi_made_close(&made);
    if (st != VV_OK) {
        vvi_free(info);
        return st;
    }
    *value_out = info;
    *bytes_out = sizeof *info;
    return VV_OK;
}

/* What is worked out where a dataset is asked for; one that is switched off may stand for a file. */
static vv_status look_behind(const vv_dataset **dataset, const vv_world *world, vv_job *job)
{
    const char *id = "";
    return vvi_made_behind(dataset, &id, world, job);
}

static vv_status plan(vv_field_info *out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    vvi_cached *cached = NULL;
    vv_status st = look_behind(&dataset, world, job);
    if (st != VV_OK)
        return st;
    if (!vv_dataset_is_made(dataset))
        return vv_dataset_info(out, world, dataset, job);
    const request r = {world, dataset, 0};
    st = get(&cached, "plan of what is made", make_info, vvi_free, &r, job);
    if (st == VV_OK)
        *out = *(const vv_field_info *)vvi_cached_value(cached);
    vvi_cache_release(cached);
    return st;
}

/* Parameters that samples decide ----------------------------------------------------------------------------------- */

/* What is found of an input when it is worked out is not found of what is made of it. */
static vv_status open_frame(vv_field **out, void *user, size_t index, vv_job *job)
{
    const vvi_made *made = user;
    vvi_findings before;
    int64_t frame;
    *out = NULL;
    vvi_findings_keep(&before, job);
    vv_status st = vvi_made_frame(&frame, made, 0, (int64_t)index, job);
    if (st == VV_OK)
        st = vv_dataset_field(out, made->world, made->input[0], NULL, frame, job);
    vv_job_forget_findings(job);
    vvi_findings_tell(job, &before);
    vvi_findings_free(&before);
    return st;
}

/* Once, and of all time steps together: else each would be stretched by itself. */
static vv_status settle(vv_object *params, vvi_made *made, int64_t n_frames, vv_job *job)
{
    const vv_operation *o = made->operation;
    const vv_field_series frames = {open_frame, made, (size_t)n_frames};
    return o->settle && o->looks(params) ? o->settle(params, &frames, job) : VV_OK;
}

static void drop_params(void *value)
{
    vv_object_release(value);
}

static vv_status make_params(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    vvi_made made;
    vv_field_info info;
    vv_object *params = NULL;
    vv_status st = vvi_made_open(&made, r->world, r->dataset, job);
    if (st == VV_OK && (st = vvi_made_params(&params, &made, job)) == VV_OK &&
        (st = vv_dataset_info(&info, r->world, made.input[0], job)) == VV_OK)
        st = settle(params, &made, info.n_frames, job);
    vvi_made_close(&made);
    if (st != VV_OK) {
        vv_object_release(params);
        return st;
    }
    *value_out = params;
    *bytes_out = params->cls->size;
    return VV_OK;
}

/* Samples ---------------------------------------------------------------------------------------------------------- */

/* Inputs as a run has them; what they hold is released by close_inputs(). */
typedef struct inputs {
    vv_run_input input[VVI_RUN_INPUTS];
    vvi_file_labels labels; /* of the first */
    vvi_words words;
    size_t n;
} inputs;

static void close_inputs(inputs *in)
{
    for (size_t i = 0; i < in->n; i++) {
        vv_field_release((vv_field *)(uintptr_t)in->input[i].field);
        vv_mesh_release((vv_mesh *)(uintptr_t)in->input[i].mesh);
        vv_file_close(in->input[i].file);
    }
    vvi_words_close(&in->words);
}

static bool is_grid_only(const vvi_made *made, size_t index)
{
    return vv_operation_operand(made->operation, index)->grid_only;
}

vv_status vvi_made_frame(int64_t *out, const vvi_made *made, size_t index, int64_t frame, vv_job *job)
{
    vv_field_info info;
    *out = 0;
    if (is_grid_only(made, index))
        return VV_OK;
    const vv_status st = vv_dataset_info(&info, made->world, made->input[index], job);
    if (st == VV_OK && info.n_frames > 1)
        *out = frame;
    return st;
}

static vv_status open_samples(vv_run_input *out, const vvi_made *made, size_t index, int64_t frame, vv_job *job)
{
    vv_field *field = NULL;
    if (!made->input[index]->fields && is_grid_only(made, index))
        return vvi_dataset_open(&out->file, made->world, made->input[index], job);
    const vv_status st = vv_dataset_field(&field, made->world, made->input[index], NULL, frame, job);
    out->field = field;
    return st;
}

static vv_status open_field(vv_run_input *out, const vvi_made *made, size_t index, int64_t frame, vv_job *job)
{
    int64_t own;
    const vv_status st = vvi_made_frame(&own, made, index, frame, job);
    return st == VV_OK ? open_samples(out, made, index, own, job) : st;
}

static vv_status open_mesh(vv_run_input *out, const vvi_made *made, size_t index, vv_job *job)
{
    vv_mesh *mesh = NULL;
    const vv_status st = vv_dataset_mesh(&mesh, made->world, made->input[index], job);
    out->mesh = mesh;
    return st;
}

/* Of inputs that are joined the one that has the time step. */
static vv_status open_joined(inputs *in, const vvi_made *made, int64_t frame, vv_job *job)
{
    vv_run_input *input = &in->input[0];
    vv_field_info info;
    vv_status st = VV_OK;
    size_t i = 0;
    for (; i < made->n; frame -= info.n_frames, i++)
        if ((st = vv_dataset_info(&info, made->world, made->input[i], job)) != VV_OK || frame < info.n_frames)
            break;
    if (st != VV_OK)
        return st;
    in->n = 1;
    input->name = made->input_id[i];
    return open_samples(input, made, i, frame, job);
}

static vv_status open_inputs(inputs *in, const vvi_made *made, int64_t frame, vv_job *job)
{
    vv_status st = VV_OK;
    if (made->operation->joins)
        return open_joined(in, made, frame, job);
    in->n = made->n;
    for (size_t i = 0; i < made->n && st == VV_OK; i++) {
        vv_run_input *input = &in->input[i];
        input->name = made->input_id[i];
        if (!made->input[i])
            continue;
        st = vv_dataset_is_mesh(made->input[i], job) ? open_mesh(input, made, i, job)
                                                     : open_field(input, made, i, frame, job);
    }
    return st;
}

/* More than should be held at once: what is read and what is made of it. */
static vv_status is_large(bool *out, const vvi_made *made, const vv_field_info *result, vv_job *job)
{
    uint64_t bytes, all;
    vv_status st = vv_field_info_bytes(&all, result);
    for (size_t i = 0; i < made->n && st == VV_OK; i++) {
        vv_field_info info;
        if (made->input[i] && (st = vv_dataset_info(&info, made->world, made->input[i], job)) == VV_OK &&
            (st = vv_field_info_bytes(&bytes, &info)) == VV_OK)
            all += bytes;
    }
    *out = st == VV_OK && vvi_stream_needed(all, job);
    return st;
}

/* What a checksum is of is read whole. */
static bool streams(const vvi_made_run *all)
{
    bool parts = all->n_steps > 0;
    for (size_t s = 0; s < all->n_steps; s++)
        parts = parts && all->step[s].operation->run_box;
    for (size_t i = 0; i < all->n_inputs; i++)
        parts = parts && !all->of_input[i]->checksum;
    return parts;
}

static vv_status take_field(vv_field **out, vv_run *run, int64_t frame, vv_job *job)
{
    const vv_field *field = vv_run_field(run, frame);
    const vv_box all = vv_field_box(field);
    if (vv_run_get_about(run)->streamed)
        return vvi_field_copy_box(out, field, &all, job);
    *out = vv_field_retain((vv_field *)(uintptr_t)field);
    return VV_OK;
}

/* From the files on, slab by slab, where nothing in between is held. *out stays NULL where that cannot be. */
static vv_status run_in_parts(vv_field **out, const vvi_made *made, int64_t frame, vv_job *job)
{
    vvi_made_run all;
    vv_run *run = NULL;
    vv_status st = vvi_made_run_open(&all, made->world, made->dataset, job);
    const vvi_run_plan plan = vvi_made_run_plan(&all, made->operation->name);
    if (st == VV_OK && streams(&all) && (st = vvi_run_new(&run, &plan, &(vv_run_output){.path = NULL}, job)) == VV_OK &&
        vv_run_get_about(run)->streamed && (st = vv_run_make(run)) == VV_OK)
        st = take_field(out, run, frame, job);
    vv_run_release(run);
    vvi_made_run_close(&all);
    return st;
}

/* Of inputs that are kept. */
static vv_status run_field(vv_field **out, const request *r, const vvi_made *made, vv_job *job)
{
    const request all = {r->world, r->dataset, 0};
    inputs in = {.n = 0};
    vvi_cached *params = NULL;
    vv_run *run = NULL;
    vv_status st = open_inputs(&in, made, r->frame, job);
    vv_job_forget_findings(job);
    if (st == VV_OK)
        st = get(&params, "parameters of what is made", make_params, drop_params, &all, job);
    if (st == VV_OK) {
        const vv_step step = {made->operation, vvi_cached_value(params)};
        const vvi_run_plan plan = {.inputs = in.input,
                                   .n_inputs = in.n,
                                   .steps = &step,
                                   .n_steps = 1,
                                   .name = made->operation->name,
                                   .settled = true};
        st = vvi_run_new(&run, &plan, &(vv_run_output){.path = NULL}, job);
    }
    if (st == VV_OK && (st = vvi_run_make(run)) == VV_OK)
        st = take_field(out, run, 0, job);
    vv_run_release(run);
    vvi_cache_release(params);
    close_inputs(&in);
    return st;
}

/* What was made, and what was found when it was. */
typedef struct result {
    vv_field *field;
    vv_mesh *mesh;
    vvi_findings found;
} result;

static void drop_result(void *value)
{
    result *made = value;
    vv_field_release(made->field);
    vv_mesh_release(made->mesh);
    vvi_findings_free(&made->found);
    vvi_free(made);
}

/* Takes both references in any case. */
static vv_status keep_result(void **value_out, vv_field *field, vv_mesh *mesh, const vv_job *job)
{
    result *made = vvi_alloc(NULL, sizeof *made, VVI_MEM_MODEL);
    if (!made) {
        vv_field_release(field);
        vv_mesh_release(mesh);
        return vv_fail_memory(sizeof *made);
    }
    *made = (result){.field = field, .mesh = mesh};
    vvi_findings_keep(&made->found, job);
    *value_out = made;
    return VV_OK;
}

static vv_status make_field(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    vvi_made made;
    vv_field_info info;
    vv_field *field = NULL;
    bool large = false;
    vv_status st = vvi_made_open(&made, r->world, r->dataset, job);
    if (st == VV_OK)
        st = vv_dataset_info(&info, r->world, r->dataset, job);
    if (st == VV_OK && (r->frame < 0 || r->frame >= info.n_frames))
        st = vv_fail(VV_E_ARGUMENT, "there is no time step %" PRId64 ": expected 0 to %" PRId64, r->frame,
                     info.n_frames - 1);
    if (st == VV_OK && (st = is_large(&large, &made, &info, job)) == VV_OK && large)
        st = run_in_parts(&field, &made, r->frame, job);
    if (st == VV_OK && !field)
        st = run_field(&field, r, &made, job);
    if (st == VV_OK)
        st = vv_field_info_bytes(bytes_out, vv_field_get_info(field));
    st = vvi_made_fail(&made, NULL, st);
    vvi_made_close(&made);
    if (st == VV_OK)
        return keep_result(value_out, field, NULL, job);
    vv_field_release(field);
    return st;
}

static vv_status get_field(vvi_cached **out, const vv_world *world, const vv_dataset *dataset, int64_t frame,
                           vv_job *job)
{
    const request r = {world, dataset, frame};
    return get(out, "samples that are made", make_field, drop_result, &r, job);
}

static vv_status field_of(vv_field **out, const vv_world *world, const vv_dataset *dataset, int64_t frame, vv_job *job)
{
    vvi_cached *cached = NULL;
    vv_status st = look_behind(&dataset, world, job);
    if (st != VV_OK)
        return st;
    if (!vv_dataset_is_made(dataset))
        return vv_dataset_field(out, world, dataset, NULL, frame, job);
    st = get_field(&cached, world, dataset, frame, job);
    if (st == VV_OK)
        *out = vv_field_retain(((const result *)vvi_cached_value(cached))->field);
    vvi_cache_release(cached);
    return st;
}

/* Meshes ----------------------------------------------------------------------------------------------------------- */

/* Names and colours of labels, as they still hold for the first input. */
static vv_status lend_labels(inputs *in, const vvi_made *made, vv_job *job)
{
    if (!made->operation->take_looks || !made->input[0] || vv_dataset_is_mesh(made->input[0], job))
        return VV_OK;
    const vv_status st = vvi_words_open(&in->words, made->world, made->input[0], job);
    in->labels = (vvi_file_labels){in->words.options.labels, in->words.options.n_labels};
    if (in->words.file && !vv_dataset_is_made(made->input[0])) /* whole numbers may name things that a file lists */
        in->labels.label = vv_file_labels(in->words.file, &in->labels.n);
    in->input[0].look = vvi_label_look_of_file;
    in->input[0].look_user = &in->labels;
    return st;
}

static vv_status run_mesh(vv_mesh **out, const vvi_made *made, vv_object *params, vv_job *job)
{
    inputs in = {.n = 0};
    vv_run *run = NULL;
    const vv_step step = {made->operation, params};
    vv_status st = open_inputs(&in, made, 0, job);
    if (st == VV_OK)
        st = lend_labels(&in, made, job);
    if (st == VV_OK)
        st = vv_run_new(&run, in.input, in.n, &step, 1, &(vv_run_output){.path = NULL}, made->operation->name, job);
    if (st == VV_OK && (st = vv_run_make(run)) == VV_OK)
        *out = vv_mesh_retain((vv_mesh *)(uintptr_t)vv_run_mesh(run));
    vv_run_release(run);
    close_inputs(&in);
    return st;
}

/* Of a series the first time step is taken. */
static vv_status note_first(const vvi_made *made, vv_job *job)
{
    vv_field_info info;
    if (!made->input[0] || vv_dataset_is_mesh(made->input[0], job))
        return VV_OK;
    const vv_status st = vv_dataset_info(&info, made->world, made->input[0], job);
    if (st == VV_OK)
        vvi_run_note_first(info.n_frames, job);
    return st;
}

static vv_status make_mesh(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    vvi_made made;
    vv_field_info none;
    vv_object *params = NULL;
    vv_mesh *mesh = NULL;
    vv_status st = vvi_made_open(&made, r->world, r->dataset, job);
    if (st == VV_OK && (st = vvi_made_params(&params, &made, job)) == VV_OK &&
        (st = vvi_made_plan(&none, &made, params, job)) == VV_OK && (st = run_mesh(&mesh, &made, params, job)) == VV_OK)
        st = note_first(&made, job);
    st = vvi_made_fail(&made, NULL, st);
    vv_object_release(params);
    vvi_made_close(&made);
    if (st == VV_OK) {
        *bytes_out = vvi_mesh_bytes(mesh);
        return keep_result(value_out, NULL, mesh, job);
    }
    vv_mesh_release(mesh);
    return st;
}

static vv_status get_mesh(vvi_cached **out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    const request r = {world, dataset, 0};
    return get(out, "mesh that is made", make_mesh, drop_result, &r, job);
}

static vv_status mesh_of(vv_mesh **out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    vvi_cached *cached = NULL;
    vv_status st = look_behind(&dataset, world, job);
    if (st != VV_OK)
        return st;
    if (!vv_dataset_is_made(dataset))
        return vv_dataset_mesh(out, world, dataset, job);
    st = get_mesh(&cached, world, dataset, job);
    if (st == VV_OK)
        *out = vv_mesh_retain(((const result *)vvi_cached_value(cached))->mesh);
    vvi_cache_release(cached);
    return st;
}

static bool is_mesh(const vv_dataset *dataset, vv_job *job)
{
    const vv_operation *const *row = vvi_job_registry(job)->operations;
    while (row && *row && strcmp((*row)->name, dataset->operation) != 0)
        row++;
    return row && *row && vv_operation_makes(*row) == VV_IS_MESH;
}

vv_status vvi_made_work_out(vv_data *out, const vv_world *world, const vv_dataset *dataset, int64_t frame, vv_job *job)
{
    vvi_cached *cached = NULL;
    *out = (vv_data){0};
    const vv_status st =
        is_mesh(dataset, job) ? get_mesh(&cached, world, dataset, job) : get_field(&cached, world, dataset, frame, job);
    if (st == VV_OK) {
        const result *made = vvi_cached_value(cached);
        out->field = made->field ? vv_field_retain(made->field) : NULL;
        out->mesh = made->mesh ? vv_mesh_retain(made->mesh) : NULL;
        vv_job_forget_findings(job);
        vvi_findings_tell(job, &made->found);
    }
    vvi_cache_release(cached);
    return st;
}

const vvi_made_data vvi_made_data_by_runs = {
    .info = plan,
    .field = field_of,
    .mesh = mesh_of,
    .is_mesh = is_mesh,
    .open = vvi_made_open_file,
};
