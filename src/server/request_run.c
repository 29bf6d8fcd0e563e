/* Operations on data of the World: the result is written beside the session's journal, so that it is there after a
 * crash and a saved scene can name it. */
#include "core/job.h"
#include "core/memory.h"
#include "model/context.h"
#include "model/dataset.h"
#include "server/request.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/run.h>

static const vv_dataset *dataset_of(const vvi_request *r)
{
    const vv_object *data = vv_collection_find(r->world->datasets, r->dataset);
    if (!data)
        vv_fail(VV_E_NOT_FOUND, "the dataset '%.64s' no longer exists", r->dataset);
    return (const vv_dataset *)(const void *)data;
}

vv_status vvi_request_parameters(vv_object **out, const vv_operation *operation, const char *json,
                                 const vv_world *world, const vv_dataset *dataset, const vv_registry *registry,
                                 vv_job *job)
{
    vv_property_context context = vvi_registry_context(registry);
    vv_field_info info;
    vv_mesh *mesh = NULL;
    vv_status st;
    if (vv_dataset_is_mesh(dataset, job)) {
        if ((st = vv_dataset_mesh(&mesh, world, dataset, job)) == VV_OK)
            context.length_unit = vv_mesh_get_info(mesh)->unit;
    } else if ((st = vv_dataset_info(&info, world, dataset, job)) == VV_OK) {
        context.length_unit = info.grid.unit;
        context.voxel = vv_grid_voxel(&info.grid);
    }
    json = json ? json : "{}";
    if (st == VV_OK)
        st = vv_object_from_json(out, operation->params, json, strlen(json), &context);
    vv_mesh_release(mesh);
    return st;
}

/* Results ---------------------------------------------------------------------------------------------------------- */

static bool makes_volume(const vv_operation *operation)
{
    return vv_operation_makes(operation) == VV_IS_FIELD;
}

/* Quickly written and mapped, unless that would lose what a header says. */
static const char *volume_suffix(const vv_file *origin, vv_job *job)
{
    const vv_format *format = origin ? vv_registry_format(vvi_job_registry(job), vv_file_format(origin)) : NULL;
    return format && format->takes_origin && format->write ? format->suffixes[0] : ".nrrd";
}

vv_status vvi_request_suffix(const char **out, const vv_operation *operation, const vv_world *world,
                             const vv_dataset *dataset, vv_job *job)
{
    vv_file *origin = NULL;
    *out = ".ply";
    if (!makes_volume(operation))
        return VV_OK;
    const vv_status st = vvi_request_open_origin(&origin, world, dataset, job);
    *out = volume_suffix(origin, job);
    vv_file_close(origin);
    return st;
}

static vv_status name_file(vvi_request *r, const char *suffix)
{
    char *whole = vvi_asprintf("%s%s", r->path, suffix);
    if (!whole)
        return vv_fail_memory(strlen(r->path));
    free(r->path);
    r->path = whole;
    return VV_OK;
}

static vv_status field_bytes(uint64_t *out, const vv_run_about *about)
{
    const uint64_t layers = about->n_layers ? about->n_layers : 1;
    const vv_status st = vv_field_info_bytes(out, &about->info);
    if (st == VV_OK &&
        (__builtin_mul_overflow(*out, (uint64_t)about->n_frames, out) || __builtin_mul_overflow(*out, layers, out)))
        *out = UINT64_MAX;
    return st;
}

/* Of .ply: places, normals and colours; three corners and how many they are. */
enum { VERTEX_BYTES = 28, TRIANGLE_BYTES = 13 };

/* A surface of nothing would be shown as nothing, and nobody would know why. */
static vv_status check_mesh(uint64_t *bytes_out, const vvi_request *r, const vv_mesh *mesh)
{
    const vv_mesh_info *info = vv_mesh_get_info(mesh);
    *bytes_out = (uint64_t)VERTEX_BYTES * info->n_vertices + (uint64_t)TRIANGLE_BYTES * info->n_triangles;
    if (info->n_triangles > 0)
        return VV_OK;
    return vv_fail(VV_E_ARGUMENT, "%s leaves no triangles; try other parameters", r->operation->name);
}

/* Room is kept before the work, as far as what it makes is known by then. */
static vv_status keep_room(uint64_t *kept_out, const vvi_request *r, const vv_run *run)
{
    uint64_t bytes = 0;
    vv_status st = VV_OK;
    if (vv_run_get_about(run)->makes == VV_IS_FIELD)
        st = field_bytes(&bytes, vv_run_get_about(run));
    else if (vv_run_mesh(run))
        st = check_mesh(&bytes, r, vv_run_mesh(run));
    if (st == VV_OK)
        st = vvi_session_keep_room(r->session, bytes);
    *kept_out = st == VV_OK ? bytes : 0;
    return st;
}

static vv_status write_result(vvi_request *r, vv_run *run)
{
    uint64_t kept = 0;
    const bool volume = vv_run_get_about(run)->makes == VV_IS_FIELD;
    vv_status st = volume ? keep_room(&kept, r, run) : VV_OK;
    if (st == VV_OK && (st = vv_run_make(run)) == VV_OK && !volume)
        st = keep_room(&kept, r, run);
    if (st == VV_OK)
        st = vv_run_write(run);
    vvi_session_give_room(r->session, kept);
    return st;
}

static void add_note(vvi_request *r, const char *text)
{
    char *before = r->note;
    r->note = vvi_asprintf("%s%s%s", before ? before : "", before ? "; " : "", text);
    free(before);
}

static void take_notes(vvi_request *r, const vv_job *job)
{
    vv_finding found;
    for (size_t i = 0; vv_job_finding(&found, job, i); i++)
        if (found.note || found.phrase)
            add_note(r, found.note ? found.note : found.phrase);
}

/* As `volvis NAME` does it: all time steps, and with them what the file says. */
static vv_status run_on(vvi_request *r, vv_job *job)
{
    const vv_step step = {r->operation, r->params};
    vvi_request_inputs inputs;
    vv_run *run = NULL;
    vv_status st = vvi_request_open_inputs(&inputs, r, job);
    if (st == VV_OK)
        st = name_file(r, makes_volume(r->operation) ? volume_suffix(inputs.input[0].file, job) : ".ply");
    if (st == VV_OK && (st = vv_run_new(&run, inputs.input, inputs.n, &step, 1, &(vv_run_output){.path = r->path},
                                        r->operation->name, job)) == VV_OK)
        st = write_result(r, run);
    if (st == VV_OK)
        take_notes(r, job);
    vv_run_release(run);
    vvi_request_close_inputs(&inputs);
    return st;
}

static vv_status run(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const vv_operation *o = r->operation;
    const vv_dataset *dataset = dataset_of(r);
    if (!dataset)
        return VV_E_NOT_FOUND;
    vv_status st = vvi_request_parameters(&r->params, o, r->parameters, r->world, dataset,
                                          vv_runtime_registry(r->session->options.runtime), job);
    if (st == VV_OK)
        st = vvi_request_name_inputs(r);
    return st == VV_OK ? run_on(r, job) : st;
}

/* "head-gaussian", "head-gaussian-2": what is not there yet. */
static void name_result(char out[64], const vv_world *world, const char *dataset, const char *operation)
{
    snprintf(out, 64, "%.36s-%.20s", dataset, operation);
    for (int i = 2; vv_collection_find(world->datasets, out) && i < 10000; i++)
        snprintf(out, 64, "%.36s-%.20s-%d", dataset, operation, i);
}

/* Shown in the place of the first volume that showed what it was made of. */
static json_t *edits_for(const vvi_request *r, const vv_world *world, const char *id)
{
    json_t *edits =
        json_pack("[{s:s, s:s, s:s, s:{s:s, s:s, s:s, s:s}}]", "op", "add", "path", "datasets", "id", id, "value",
                  "path", r->path, "source", r->dataset, "operation", r->operation->name, "parameters", r->parameters);
    json_t *value = json_object_get(json_array_get(edits, 0), "value");
    if (!makes_volume(r->operation))
        json_object_set_new(value, "kind", json_string("mesh"));
    if (r->inputs)
        json_object_set_new(value, "inputs", json_string(r->inputs));
    for (size_t i = 0; i < world->volumes->n; i++) {
        const vv_volume *volume = (const vv_volume *)(const void *)world->volumes->entry[i].object;
        char path[160];
        if (!volume->data || strcmp(volume->data, r->dataset) != 0)
            continue;
        snprintf(path, sizeof path, "volumes.%s.data", world->volumes->entry[i].id);
        json_array_append_new(edits, json_pack("{s:s, s:s, s:s}", "op", "set", "path", path, "value", id));
        break;
    }
    return edits;
}

static void done(vvi_task *task, vv_status st)
{
    vvi_request *r = (vvi_request *)(void *)task;
    vvi_session_note_end(r->session, r->asked, st);
    if (st == VV_OK) {
        char id[64];
        vv_world *world = vv_model_snapshot(r->session->model);
        name_result(id, world, r->dataset, r->operation->name);
        json_t *edits = edits_for(r, world, id);
        st = edits ? vvi_session_edit(r->session, r->view, edits, false) : vv_fail_memory(256);
        json_decref(edits);
        vv_object_release(&world->base);
        vvi_result_open(&r->value, NULL, '{');
        vvi_result_string(&r->value, "dataset", id);
        if (r->note)
            vvi_result_string(&r->value, "note", r->note);
        vvi_result_close(&r->value, '}');
    }
    vvi_request_done_slowly(task, st);
}

/* A file without its suffix, in a folder that was not there. */
static vv_status name_new(vvi_request *r, vvi_session *s)
{
    char *folder;
    const vv_status st = vvi_files_make_folder(&folder, s, "result", &s->results);
    if (st != VV_OK)
        return st;
    r->path = vvi_asprintf("%s/result-%" PRId64, folder, s->results);
    free(folder);
    r->own_folder = true;
    return r->path ? VV_OK : vv_fail_memory(256);
}

/* The result says what it was made with: better now than after the work. */
static vv_status check_parameters(const char *text)
{
    const double most = vv_class_find(&vv_dataset_class, "parameters")->max;
    if ((double)strlen(text) <= most)
        return VV_OK;
    return vv_fail(VV_E_LIMIT, "the parameters are %zu bytes long: at most %.0f are allowed", strlen(text), most);
}

vv_status vvi_request_run(vvi_client *client, int64_t id, const json_t *message)
{
    const char *operation = json_string_value(json_object_get(message, "operation"));
    const char *dataset = json_string_value(json_object_get(message, "dataset"));
    const json_t *parameters = json_object_get(message, "parameters");
    const vv_registry *registry = vv_runtime_registry(client->session->options.runtime);
    vvi_request *r;
    if (!operation || !dataset)
        return vv_fail(VV_E_ARGUMENT, "'run' needs an operation and a dataset");
    const vv_operation *row = vv_registry_operation(registry, operation);
    if (!row)
        return VV_E_NOT_FOUND;
    if (!client->session->uploads)
        return vv_fail(VV_E_UNSUPPORTED, "this server keeps no files, and so no results");
    vv_status st = vvi_request_new(&r, client, id, row->name, run);
    if (st != VV_OK)
        return st;
    r->operation = row;
    r->task.done = done;
    r->task.stays = true;
    r->parameters = parameters ? json_dumps(parameters, JSON_COMPACT | JSON_ENCODE_ANY | JSON_REAL_PRECISION(17))
                               : vvi_strdup("{}");
    st = r->parameters ? check_parameters(r->parameters) : vv_fail_memory(256);
    if (st == VV_OK)
        st = vvi_request_take_inputs(r, message);
    if (st == VV_OK)
        st = vvi_session_make_room(client->session, 1);
    if (st == VV_OK)
        st = name_new(r, client->session);
    if (st != VV_OK) {
        r->task.drop(&r->task);
        return st;
    }
    return vvi_request_add_slow(r);
}
