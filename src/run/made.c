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
    vvi_findings_keep(&before, job);
    const vv_status st = vv_dataset_field(out, made->world, made->input[0], NULL, (int64_t)index, job);
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
    if (st == VV_OK && (st = vvi_made_params(&params, &made, job)) == VV_OK && made.input[0] &&
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

vv_status vvi_made_settled(vv_object **out, const vvi_made *made, vv_job *job)
{
    const request r = {made->world, made->dataset, 0};
    vvi_cached *cached = NULL;
    *out = NULL;
    const vv_status st = get(&cached, "parameters of what is made", make_params, drop_params, &r, job);
    if (st == VV_OK)
        *out = vv_object_retain(vvi_cached_value(cached));
    vvi_cache_release(cached);
    return st;
}

/* Results ---------------------------------------------------------------------------------------------------------- */

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
static bool may_stream(const vvi_made_run *all)
{
    bool parts = true;
    for (size_t i = 0; i < all->n_inputs; i++)
        parts = parts && !all->of_input[i]->checksum;
    return parts;
}

static vv_status take_result(vv_data *out, vv_run *run, int64_t frame, vv_job *job)
{
    const vv_field *field = vv_run_field(run, frame);
    const vv_mesh *mesh = vv_run_mesh(run);
    if (field && vv_run_get_about(run)->streamed) {
        const vv_box all = vv_field_box(field);
        return vvi_field_copy_box(&out->field, field, &all, job);
    }
    out->field = field ? vv_field_retain((vv_field *)(uintptr_t)field) : NULL;
    out->mesh = mesh ? vv_mesh_retain((vv_mesh *)(uintptr_t)mesh) : NULL;
    return VV_OK;
}

/* From the files on, slab by slab, where nothing in between is held. *out stays empty where that cannot be. */
static vv_status run_in_parts(vv_data *out, const vvi_made *made, int64_t frame, vv_job *job)
{
    vvi_made_run all;
    vv_run *run = NULL;
    vv_status st = vvi_made_run_open(&all, made->world, made->dataset, -1, job);
    const vvi_run_plan plan = vvi_made_run_plan(&all, made->operation->name);
    if (st == VV_OK && may_stream(&all) &&
        (st = vvi_run_new(&run, &plan, &(vv_run_output){.path = NULL}, job)) == VV_OK &&
        vv_run_get_about(run)->streamed && (st = vv_run_make(run)) == VV_OK)
        st = take_result(out, run, frame, job);
    vv_run_release(run);
    vvi_made_run_close(&all);
    return st;
}

/* Names and colours of labels, as they still hold for the first input. */
static vv_status lend_labels(vv_run_input *first, vvi_words *words, vvi_file_labels *labels, const vvi_made *made,
                             vv_job *job)
{
    if (!made->operation->take_looks || !made->input[0] || vv_dataset_is_mesh(made->input[0], job))
        return VV_OK;
    const vv_status st = vvi_words_open(words, made->world, made->input[0], job);
    *labels = (vvi_file_labels){words->options.labels, words->options.n_labels};
    if (words->file && !vv_dataset_is_made(made->input[0])) /* whole numbers may name things that a file lists */
        labels->label = vv_file_labels(words->file, &labels->n);
    first->look = vvi_label_look_of_file;
    first->look_user = labels;
    return st;
}

/* Of inputs that are kept. */
static vv_status run_kept(vv_data *out, const vvi_made *made, int64_t frame, vv_job *job)
{
    vvi_made_run all;
    vvi_words words = {.n = 0};
    vvi_file_labels labels;
    vv_run *run = NULL;
    vv_status st = vvi_made_run_open(&all, made->world, made->dataset, frame, job);
    const vvi_run_plan plan = vvi_made_run_plan(&all, made->operation->name);
    if (st == VV_OK && (st = lend_labels(&all.input[0], &words, &labels, made, job)) == VV_OK &&
        (st = vvi_run_new(&run, &plan, &(vv_run_output){.path = NULL}, job)) == VV_OK &&
        (st = vvi_run_make(run)) == VV_OK)
        st = take_result(out, run, 0, job);
    vv_run_release(run);
    vvi_made_run_close(&all);
    vvi_words_close(&words);
    return st;
}

/* What was made, and what was found when it was. */
typedef struct result {
    vv_data data;
    vvi_findings found;
} result;

static void drop_result(void *value)
{
    result *made = value;
    vv_data_release(&made->data);
    vvi_findings_free(&made->found);
    vvi_free(made);
}

/* Takes the data in any case. */
static vv_status keep_result(void **value_out, vv_data *data, const vv_job *job)
{
    result *made = vvi_alloc(NULL, sizeof *made, VVI_MEM_MODEL);
    if (!made) {
        vv_data_release(data);
        return vv_fail_memory(sizeof *made);
    }
    *made = (result){.data = *data};
    vvi_findings_keep(&made->found, job);
    *value_out = made;
    return VV_OK;
}

static vv_status make_field(vv_data *out, uint64_t *bytes_out, const request *r, const vvi_made *made, vv_job *job)
{
    vv_field_info info;
    bool large = false;
    vv_status st = vv_dataset_info(&info, r->world, r->dataset, job);
    if (st == VV_OK && (r->frame < 0 || r->frame >= info.n_frames))
        st = vv_fail(VV_E_ARGUMENT, "there is no time step %" PRId64 ": expected 0 to %" PRId64, r->frame,
                     info.n_frames - 1);
    if (st == VV_OK && (st = is_large(&large, made, &info, job)) == VV_OK && large)
        st = run_in_parts(out, made, r->frame, job);
    if (st == VV_OK && !out->field)
        st = run_kept(out, made, r->frame, job);
    return st == VV_OK ? vv_field_info_bytes(bytes_out, vv_field_get_info(out->field)) : st;
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

static vv_status make_mesh(vv_data *out, uint64_t *bytes_out, const vvi_made *made, vv_job *job)
{
    vv_field_info none;
    vv_status st = vvi_made_plan(&none, made, NULL, job);
    if (st == VV_OK && (st = run_kept(out, made, 0, job)) == VV_OK)
        st = note_first(made, job);
    *bytes_out = st == VV_OK ? vvi_mesh_bytes(out->mesh) : 0;
    return st;
}

static vv_status make_result(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    vvi_made made;
    vv_data data = {0};
    vv_status st = vvi_made_open(&made, r->world, r->dataset, job);
    if (st == VV_OK)
        st = vv_operation_makes(made.operation) == VV_IS_MESH ? make_mesh(&data, bytes_out, &made, job)
                                                              : make_field(&data, bytes_out, r, &made, job);
    st = vvi_made_fail(&made, NULL, st);
    vvi_made_close(&made);
    if (st == VV_OK)
        return keep_result(value_out, &data, job);
    vv_data_release(&data);
    return st;
}

static vv_status get_result(vvi_cached **out, const request *r, vv_job *job)
{
    return get(out, "what is made", make_result, drop_result, r, job);
}

static vv_status field_of(vv_field **out, const vv_world *world, const vv_dataset *dataset, int64_t frame, vv_job *job)
{
    vvi_cached *cached = NULL;
    vv_status st = look_behind(&dataset, world, job);
    if (st != VV_OK)
        return st;
    if (!vv_dataset_is_made(dataset))
        return vv_dataset_field(out, world, dataset, NULL, frame, job);
    st = get_result(&cached, &(request){world, dataset, frame}, job);
    if (st == VV_OK)
        *out = vv_field_retain(((const result *)vvi_cached_value(cached))->data.field);
    vvi_cache_release(cached);
    return st;
}

static vv_status mesh_of(vv_mesh **out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    vvi_cached *cached = NULL;
    vv_status st = look_behind(&dataset, world, job);
    if (st != VV_OK)
        return st;
    if (!vv_dataset_is_made(dataset))
        return vv_dataset_mesh(out, world, dataset, job);
    st = get_result(&cached, &(request){world, dataset, 0}, job);
    if (st == VV_OK)
        *out = vv_mesh_retain(((const result *)vvi_cached_value(cached))->data.mesh);
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
    const vv_status st = get_result(&cached, &(request){world, dataset, is_mesh(dataset, job) ? 0 : frame}, job);
    if (st == VV_OK) {
        const result *made = vvi_cached_value(cached);
        out->field = made->data.field ? vv_field_retain(made->data.field) : NULL;
        out->mesh = made->data.mesh ? vv_mesh_retain(made->data.mesh) : NULL;
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
