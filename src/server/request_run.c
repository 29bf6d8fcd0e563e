/* An operation on data of the World: a dataset is made of them, worked out once before it is there. */
#include "core/job.h"
#include "core/json_text.h"
#include "core/memory.h"
#include "io/source.h"
#include "run/made.h"
#include "server/preview.h"
#include "server/request.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A surface of nothing would be shown as nothing, and nobody would know why. */
static vv_status check_mesh(const vv_operation *operation, const vv_mesh *mesh)
{
    if (!mesh || vv_mesh_get_info(mesh)->n_triangles > 0)
        return VV_OK;
    return vv_fail(VV_E_ARGUMENT, "%s leaves no triangles; try other parameters", operation->name);
}

static void add_note(vvi_request *r, const char *text)
{
    char *before = r->note;
    r->note = vvi_asprintf("%s%s%s", before ? before : "", before ? "; " : "", text);
    free(before);
}

void vvi_request_take_notes(vvi_request *r, const vv_job *job)
{
    vv_finding found;
    for (size_t i = 0; vv_job_finding(&found, job, i); i++)
        if (found.note || found.phrase)
            add_note(r, found.note ? found.note : found.phrase);
}

/* Volumes that say nothing show the only dataset. */
static bool shows(const vv_world *world, const vv_volume *volume, const char *dataset)
{
    return volume->data ? strcmp(volume->data, dataset) == 0 : world->datasets->n == 1;
}

/* The first volume that shows a dataset; world->volumes->n: none does. */
static size_t first_shown(const vv_world *world, const char *dataset)
{
    size_t i = 0;
    while (i < world->volumes->n && !shows(world, vvi_volume_nth(world, i), dataset))
        i++;
    return i;
}

/* The time step that will be looked at. */
static int64_t shown_frame(const vv_world *world, const char *dataset)
{
    const size_t i = first_shown(world, dataset);
    return i < world->volumes->n ? vvi_volume_nth(world, i)->frame : 0;
}

/* What cannot be made, and what makes nothing, does not come to be. */
static vv_status run(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    char id[VVI_REQUEST_ID];
    vv_data data = {0};
    vv_world *world = NULL;
    if (!vv_collection_find(r->world->datasets, r->dataset))
        return vv_fail(VV_E_NOT_FOUND, "the dataset '%.64s' no longer exists", r->dataset);
    vvi_request_free_id(id, r->world, r->operation->name);
    vv_status st = vvi_request_make_world(&world, r, id);
    const unsigned faults = vvi_mapping_faults();
    if (st == VV_OK) {
        const vv_dataset *made = vvi_dataset_named(world, id);
        st = vvi_made_work_out(&data, world, made, shown_frame(world, r->dataset), job);
    }
    if (st == VV_OK)
        st = vvi_mapping_check_since(faults);
    if (st == VV_OK && (st = check_mesh(r->operation, data.mesh)) == VV_OK)
        vvi_request_take_notes(r, job);
    st = vvi_request_fail_made(r->operation, id, st);
    vv_data_release(&data);
    vv_object_release(&world->base);
    return st;
}

/* Others have gone on while it was worked out. */
static vv_status check_inputs(const vv_world *world, const json_t *recipe)
{
    const char *name;
    json_t *id;
    json_object_foreach(json_object_get(recipe, "inputs"), name, id)
    {
        if (!vv_collection_find(world->datasets, json_string_value(id)))
            return vv_fail(VV_E_NOT_FOUND, "the dataset '%.64s' no longer exists", json_string_value(id));
    }
    return VV_OK;
}

static void add_shown(json_t **edits, const vv_world *world, size_t volume, const char *dataset)
{
    char path[160];
    snprintf(path, sizeof path, "volumes.%s.data", world->volumes->entry[volume].id);
    vvi_json_append(edits, json_pack("{s:s, s:s, s:s}", "op", "set", "path", path, "value", dataset));
}

static void add_unset(json_t **edits, const char *volume, const vv_object *labels, const char *name)
{
    char path[160];
    snprintf(path, sizeof path, "volumes.%s." VVI_LABELS_PATH "%s", volume, name);
    if (vv_object_is_set(labels, name))
        vvi_json_append(edits, json_pack("{s:s, s:s}", "op", "unset", "path", path));
}

/* New labels have neither the names nor the colours of those that they are made of. */
static void add_forgotten(json_t **edits, const vv_volume *volume, const char *id)
{
    const vv_segmentation *segmentation = (const vv_segmentation *)(const void *)volume->segmentation;
    if (!segmentation)
        return;
    for (const char *const *name = vvi_label_properties; *name; name++)
        add_unset(edits, id, segmentation->labels, *name);
}

/* Shown in the place of the first volume that showed what it is made of; others that said nothing show the only dataset
 * that there was. Takes the recipe. */
static json_t *edits_for(const vvi_request *r, const vv_world *world, json_t *recipe, const char *id)
{
    json_t *edits = json_pack("[{s:s, s:s, s:s, s:o}]", "op", "add", "path", "datasets", "id", id, "value", recipe);
    const size_t first = first_shown(world, r->dataset);
    for (size_t i = first; edits && i < world->volumes->n; i++) {
        const vv_volume *volume = vvi_volume_nth(world, i);
        if (i == first || !volume->data)
            add_shown(&edits, world, i, i == first ? id : r->dataset);
        if (i == first && !r->operation->carry)
            add_forgotten(&edits, volume, world->volumes->entry[i].id);
    }
    return edits;
}

static vv_status add_to_world(vvi_request *r, char id[VVI_REQUEST_ID])
{
    char wanted[VVI_REQUEST_ID];
    vv_world *world = vv_model_snapshot(r->session->model);
    json_t *recipe = vvi_request_recipe(r), *edits = NULL;
    vv_status st = recipe ? check_inputs(world, recipe) : vv_fail_memory(256);
    snprintf(wanted, sizeof wanted, "%.36s-%.19s", r->dataset, r->operation->name);
    vvi_request_free_id(id, world, wanted);
    if (st == VV_OK) {
        edits = edits_for(r, world, json_incref(recipe), id);
        st = edits ? vvi_session_edit(r->session, r->view, edits, false) : vv_fail_memory(256);
    }
    json_decref(edits);
    json_decref(recipe);
    vv_object_release(&world->base);
    return st;
}

static void done(vvi_task *task, vv_status st)
{
    vvi_request *r = (vvi_request *)(void *)task;
    char id[VVI_REQUEST_ID];
    vvi_session_note_end(r->session, r->asked, st);
    if (st == VV_OK && (st = add_to_world(r, id)) == VV_OK) {
        vvi_result_open(&r->value, NULL, '{');
        vvi_result_string(&r->value, "dataset", id);
        if (r->note)
            vvi_result_string(&r->value, "note", r->note);
        vvi_result_close(&r->value, '}');
    }
    vvi_request_done_slowly(task, st);
}

vv_status vvi_request_run(vvi_client *client, int64_t id, const json_t *message)
{
    vvi_request *r;
    vv_status st = vvi_request_new(&r, client, id, "run", run);
    if (st != VV_OK)
        return st;
    r->task.done = done;
    r->changes = r->task.stays = true;
    if ((st = vvi_request_take_operation(r, message)) == VV_OK)
        r->task.name = r->operation->name;
    if (st == VV_OK && !vvi_session_disk_holds(r->session, VVI_FILE_LEAST)) /* before the work, not after it */
        st = vv_fail(VV_E_WRITE, "nothing is run whose result could not be kept: the server's disk is full; make room "
                                 "on it and try again");
    return vvi_request_add_slow(r, st);
}
