/* Operations on data of the World: the result is written beside the session's journal, so that it is there after a
 * crash and a saved scene can name it. */
#include "core/memory.h"
#include "model/context.h"
#include "server/request.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/mesh_file.h>

static const vv_dataset *dataset_of(const vvi_request *r)
{
    const vv_object *data = vv_collection_find(r->world->datasets, r->dataset);
    if (!data)
        vv_fail(VV_E_NOT_FOUND, "the dataset '%.64s' no longer exists", r->dataset);
    return (const vv_dataset *)(const void *)data;
}

vv_status vvi_request_parameters(vv_object **out, const vv_operation *operation, const char *json,
                                 const vv_dataset *dataset, const vv_registry *registry, vv_job *job)
{
    vv_property_context context = vvi_registry_context(registry);
    vv_field_info info;
    vv_mesh *mesh = NULL;
    vv_status st;
    if (vv_dataset_is_mesh(dataset, job)) {
        if ((st = vv_dataset_mesh(&mesh, dataset, job)) == VV_OK)
            context.length_unit = vv_mesh_get_info(mesh)->unit;
    } else if ((st = vv_dataset_info(&info, dataset, job)) == VV_OK) {
        context.length_unit = info.grid.unit;
        context.voxel = vv_grid_voxel(&info.grid);
    }
    json = json ? json : "{}";
    if (st == VV_OK)
        st = vv_object_from_json(out, operation->params, json, strlen(json), &context);
    vv_mesh_release(mesh);
    return st;
}

static vv_status run_on_field(vvi_request *r, const vv_dataset *dataset, vv_job *job)
{
    vv_field *input = NULL, *made = NULL;
    vv_status st = vv_dataset_field(&input, dataset, NULL, 0, job);
    if (st == VV_OK)
        st = vv_operation_run(&made, r->operation, (const vv_field *const *)&input, 1, r->params, job);
    if (st == VV_OK)
        st = vv_field_write(r->path, (const vv_field *const *)&made, 1, NULL, job);
    vv_field_release(made);
    vv_field_release(input);
    return st;
}

/* A surface of nothing would be shown as nothing, and nobody would know why. */
static vv_status write_mesh(const vvi_request *r, const vv_mesh *mesh, vv_job *job)
{
    if (vv_mesh_get_info(mesh)->n_triangles == 0)
        return vv_fail(VV_E_ARGUMENT, "%s leaves no triangles; try other parameters", r->operation->name);
    return vv_mesh_write(r->path, mesh, NULL, job);
}

static vv_status run_to_mesh(vvi_request *r, const vv_dataset *dataset, vv_job *job)
{
    vv_field *field = NULL;
    vv_mesh *mesh = NULL, *made = NULL;
    vv_status st;
    if (r->operation->mesh_of_fields) {
        if ((st = vv_dataset_field(&field, dataset, NULL, 0, job)) == VV_OK)
            st = vv_operation_mesh_of_fields(&made, r->operation, (const vv_field *const *)&field, 1, r->params, job);
    } else if ((st = vv_dataset_mesh(&mesh, dataset, job)) == VV_OK) {
        st = vv_operation_mesh_of_meshes(&made, r->operation, (const vv_mesh *const *)&mesh, 1, r->params, job);
    }
    if (st == VV_OK)
        st = write_mesh(r, made, job);
    vv_mesh_release(made);
    vv_mesh_release(mesh);
    vv_field_release(field);
    return st;
}

static vv_status run(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const vv_operation *o = r->operation;
    const vv_dataset *dataset = dataset_of(r);
    if (!dataset)
        return VV_E_NOT_FOUND;
    if (vv_dataset_is_mesh(dataset, job) != (o->mesh_of_meshes != NULL))
        return vv_fail(VV_E_ARGUMENT, "%s takes %s, and '%.64s' is %s", o->name,
                       o->mesh_of_meshes ? "a mesh" : "a volume", r->dataset,
                       o->mesh_of_meshes ? "a volume" : "a mesh");
    const vv_status st = vvi_request_parameters(&r->params, o, r->parameters, dataset,
                                                vv_runtime_registry(r->session->options.runtime), job);
    if (st != VV_OK)
        return st;
    return o->run || o->run_box ? run_on_field(r, dataset, job) : run_to_mesh(r, dataset, job);
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
    if (!r->operation->run && !r->operation->run_box)
        json_object_set_new(json_object_get(json_array_get(edits, 0), "value"), "kind", json_string("mesh"));
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
    vvi_session_note_end(r->session, st);
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
        vvi_result_close(&r->value, '}');
    }
    vvi_request_done_slowly(task, st);
}

const char *vvi_request_suffix(const vv_operation *operation)
{
    return operation->run || operation->run_box ? ".nrrd" : ".ply";
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
    if (row->min_inputs > 1)
        return vv_fail(VV_E_UNSUPPORTED, "%s takes several inputs; use the command line", operation);
    if (!client->session->uploads)
        return vv_fail(VV_E_UNSUPPORTED, "this server keeps no files, and so no results");
    vv_status st = vvi_request_new(&r, client, id, row->name, run);
    if (st != VV_OK)
        return st;
    r->operation = row;
    r->task.done = done;
    r->dataset = vvi_strdup(dataset);
    r->parameters = parameters ? json_dumps(parameters, JSON_COMPACT | JSON_REAL_PRECISION(17)) : vvi_strdup("{}");
    r->path = vvi_asprintf("%s/result-%" PRId64 "%s", client->session->uploads, ++client->session->results,
                           vvi_request_suffix(row));
    if (!r->dataset || !r->parameters || !r->path) {
        r->task.drop(&r->task);
        return vv_fail_memory(256);
    }
    return vvi_request_add_slow(r);
}
