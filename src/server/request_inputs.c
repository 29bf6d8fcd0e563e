/* The inputs of an operation on data of the World: what a message says of them, and the data themselves. */
#include "core/memory.h"
#include "model/context.h"
#include "model/dataset.h"
#include "scene/load.h"
#include "server/request.h"

#include <stdlib.h>
#include <string.h>

/* Messages --------------------------------------------------------------------------------------------------------- */

static vv_status fail_operand(const vv_operation *operation, const char *name)
{
    vvi_text names = {0};
    for (const vv_operand *o = operation->inputs + 1; o[-1].name && o->name; o++)
        vvi_text_printf(&names, "%s%s", names.n ? ", " : "", o->name);
    const vv_status st =
        names.n ? vv_fail(VV_E_ARGUMENT, "%s: has no input '%.64s'; its others are: %s", operation->name, name, names.s)
                : vv_fail(VV_E_ARGUMENT, "%s: takes one input, and no '%.64s'", operation->name, name);
    vvi_text_free(&names);
    return st;
}

static const vv_operand *named_operand(const vv_operation *operation)
{
    for (const vv_operand *o = operation->inputs; o->name; o++)
        if (o->names)
            return o;
    return NULL;
}

static bool has_operand(const vv_operation *operation, const char *name)
{
    for (const vv_operand *o = operation->inputs + 1; o[-1].name && o->name; o++)
        if (strcmp(o->name, name) == 0)
            return true;
    return named_operand(operation) != NULL;
}

static vv_status check_inputs(const vv_operation *operation, json_t *inputs)
{
    const char *name;
    json_t *value;
    if (!json_is_object(inputs))
        return vv_fail(VV_E_ARGUMENT, "'inputs' must be an object: {\"values\": \"ct\"}");
    if (json_object_size(inputs) >= VVI_REQUEST_INPUTS)
        return vv_fail(VV_E_LIMIT, "'inputs' has %zu entries; %d are the most", json_object_size(inputs),
                       VVI_REQUEST_INPUTS - 1);
    json_object_foreach(inputs, name, value)
    {
        if (!json_is_string(value))
            return vv_fail(VV_E_ARGUMENT, "'inputs': '%.64s' must be the name of a dataset", name);
        if (!has_operand(operation, name))
            return fail_operand(operation, name);
    }
    return VV_OK;
}

vv_status vvi_request_take_inputs(vvi_request *r, const json_t *message)
{
    const char *dataset = json_string_value(json_object_get(message, "dataset"));
    json_t *inputs = json_object_get(message, "inputs");
    const double most = vv_class_find(&vv_dataset_class, "inputs")->max;
    if (!dataset)
        return vv_fail(VV_E_ARGUMENT, "'%s' needs a dataset", r->operation->name);
    if (!(r->dataset = vvi_strdup(dataset)))
        return vv_fail_memory(strlen(dataset));
    if (!inputs || json_is_null(inputs) || (json_is_object(inputs) && json_object_size(inputs) == 0))
        return VV_OK;
    const vv_status st = check_inputs(r->operation, inputs);
    if (st != VV_OK)
        return st;
    r->inputs = json_dumps(inputs, JSON_COMPACT);
    if (!r->inputs)
        return vv_fail_memory(256);
    if ((double)strlen(r->inputs) <= most)
        return VV_OK;
    return vv_fail(VV_E_LIMIT, "the inputs are %zu bytes long: at most %.0f are allowed", strlen(r->inputs), most);
}

/* "a,b": of a property of the parameters; without others the dataset is a. */
static char *names_of(const char *inputs)
{
    const char *name;
    json_t *id, *all = inputs ? json_loads(inputs, 0, NULL) : NULL;
    vvi_text text = {0};
    vvi_text_add(&text, "\"");
    if (json_object_size(all) == 0)
        vvi_text_add(&text, "a");
    json_object_foreach(all, name, id) vvi_text_printf(&text, "%s%s", text.n > 1 ? "," : "", name);
    vvi_text_add(&text, "\"");
    json_decref(all);
    return vvi_text_take(&text);
}

vv_status vvi_request_name_inputs(vvi_request *r)
{
    const vv_operand *operand = named_operand(r->operation);
    if (!operand)
        return VV_OK;
    char *names = names_of(r->inputs);
    const vv_status st = names ? vv_path_set(&r->params, operand->names, names, NULL) : vv_fail_memory(64);
    free(names);
    return st;
}

/* Data ------------------------------------------------------------------------------------------------------------- */

vv_status vvi_request_open_origin(vv_file **out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    *out = NULL;
    const bool there = (dataset->path && !dataset->fields) || vv_dataset_is_made(dataset);
    return there ? vvi_dataset_open(out, world, dataset, job) : VV_OK;
}

void vvi_request_close_inputs(vvi_request_inputs *inputs)
{
    for (size_t i = 0; i < inputs->n; i++) {
        vv_field_release((vv_field *)(uintptr_t)inputs->input[i].field);
        vv_mesh_release((vv_mesh *)(uintptr_t)inputs->input[i].mesh);
        vv_file_close(inputs->input[i].file);
    }
    *inputs = (vvi_request_inputs){.n = 0};
}

static const char *word_of(unsigned is)
{
    return is == VV_IS_MESH ? "a mesh" : is == VV_IS_FIELD ? "a volume" : "a volume or a mesh";
}

/* What is shown is in memory; of a series all time steps go through, where samples are made of it. */
static vv_status open_data(vv_run_input *out, const vv_world *world, const vv_dataset *dataset, bool series,
                           vv_job *job)
{
    vv_mesh *mesh = NULL;
    vv_field *field = NULL;
    if (vv_dataset_is_mesh(dataset, job)) {
        const vv_status st = vv_dataset_mesh(&mesh, world, dataset, job);
        out->mesh = mesh;
        return st;
    }
    vv_status st = vvi_request_open_origin(&out->file, world, dataset, job);
    if (st == VV_OK && (!out->file || !series || vv_file_info(out->file)->n_frames == 1))
        st = vv_dataset_field(&field, world, dataset, NULL, 0, job);
    out->field = field;
    return st;
}

/* Which lives as long as the World does. */
static const char *own_name(const vv_collection *all, const vv_object *data)
{
    for (size_t i = 0; i < all->n; i++)
        if (all->entry[i].object == data)
            return all->entry[i].id;
    return "";
}

static vv_status open_input(vvi_request_inputs *out, const vvi_request *r, const vv_operand *operand, const char *id,
                            vv_job *job)
{
    const vv_collection *all = r->world->datasets;
    const vv_object *data = vv_collection_find(all, id);
    vv_run_input *input = &out->input[out->n];
    if (!data)
        return vv_fail(VV_E_NOT_FOUND, "the dataset '%.64s' no longer exists", id);
    const vv_dataset *dataset = (const vv_dataset *)(const void *)data;
    const unsigned is = vv_dataset_is_mesh(dataset, job) ? VV_IS_MESH : VV_IS_FIELD;
    if (!(is & operand->is))
        return vv_fail(VV_E_ARGUMENT, "%s takes %s, and '%.64s' is %s", r->operation->name, word_of(operand->is), id,
                       word_of(is));
    *input = (vv_run_input){.frame = -1, .name = own_name(all, data)};
    out->n++;
    return open_data(input, r->world, dataset, vv_operation_makes(r->operation) == VV_IS_FIELD, job);
}

/* All of those that have names of their own, the dataset among them by any of them. */
static vv_status open_named(vvi_request_inputs *out, const vvi_request *r, const vv_operand *operand, json_t *inputs,
                            vv_job *job)
{
    const char *name;
    json_t *id;
    vv_status st = VV_OK;
    if (json_object_size(inputs) == 0) {
        return open_input(out, r, operand, r->dataset, job);
    }
    json_object_foreach(inputs, name, id)
    {
        if (st == VV_OK)
            st = open_input(out, r, operand, json_string_value(id), job);
    }
    return st;
}

static vv_status open_all(vvi_request_inputs *out, const vvi_request *r, json_t *inputs, vv_job *job)
{
    vv_status st = VV_OK;
    size_t gaps = 0;
    for (const vv_operand *o = r->operation->inputs; o->name && st == VV_OK; o++) {
        const char *id = o == r->operation->inputs ? r->dataset : json_string_value(json_object_get(inputs, o->name));
        if (o->names)
            return open_named(out, r, o, inputs, job);
        if (!id) {
            gaps++;
            continue;
        }
        out->n += gaps;
        gaps = 0;
        st = open_input(out, r, o, id, job);
    }
    return st;
}

vv_status vvi_request_open_inputs(vvi_request_inputs *out, const vvi_request *r, vv_job *job)
{
    json_t *inputs = r->inputs ? json_loads(r->inputs, 0, NULL) : NULL;
    *out = (vvi_request_inputs){.n = 0};
    if (vv_operation_most(r->operation) > VVI_REQUEST_INPUTS)
        return vv_fail(VV_E_UNSUPPORTED, "%s takes more inputs than the page has; use the command line",
                       r->operation->name);
    const vv_status st = open_all(out, r, inputs, job);
    json_decref(inputs);
    return st;
}
