/* An operation on data of the World: what a message says of it, and the World with the dataset that it would make. */
#include "core/json_text.h"
#include "core/memory.h"
#include "core/status.h"
#include "model/dataset.h"
#include "scene/load.h"
#include "server/request.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { INPUTS_MOST = 16 }; /* as a run takes */

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
    if (json_object_size(inputs) >= INPUTS_MOST)
        return vv_fail(VV_E_LIMIT, "'inputs' has %zu entries; %d are the most", json_object_size(inputs),
                       INPUTS_MOST - 1);
    json_object_foreach(inputs, name, value)
    {
        if (!json_is_string(value))
            return vv_fail(VV_E_ARGUMENT, "'inputs': '%.64s' must be the name of a dataset", name);
        if (!has_operand(operation, name))
            return fail_operand(operation, name);
    }
    return VV_OK;
}

static vv_status take_inputs(vvi_request *r, const json_t *message)
{
    json_t *inputs = json_object_get(message, "inputs");
    const double most = vv_class_find(&vv_dataset_class, "inputs")->max;
    if (!inputs || json_is_null(inputs) || (json_is_object(inputs) && json_object_size(inputs) == 0))
        return VV_OK;
    const vv_status st = check_inputs(r->operation, inputs);
    if (st != VV_OK)
        return st;
    r->inputs = vvi_json_encode(inputs, JSON_COMPACT);
    if (!r->inputs)
        return vv_fail_memory(256);
    if ((double)strlen(r->inputs) <= most)
        return VV_OK;
    return vv_fail(VV_E_LIMIT, "the inputs are %zu bytes long: at most %.0f are allowed", strlen(r->inputs), most);
}

static vv_status take_parameters(vvi_request *r, const json_t *message)
{
    const json_t *parameters = json_object_get(message, "parameters");
    const double most = vv_class_find(&vv_dataset_class, "parameters")->max;
    if (parameters && !json_is_object(parameters))
        return vv_fail(VV_E_ARGUMENT, "expected an object of parameters, as in {\"sigma\": \"1mm\"}");
    r->parameters = parameters ? vvi_json_encode(parameters, JSON_COMPACT | JSON_REAL_PRECISION(17)) : vvi_strdup("{}");
    if (!r->parameters)
        return vv_fail_memory(256);
    if ((double)strlen(r->parameters) <= most)
        return VV_OK;
    return vv_fail(VV_E_LIMIT, "the parameters are %zu bytes long: at most %.0f are allowed", strlen(r->parameters),
                   most);
}

vv_status vvi_request_take_operation(vvi_request *r, const json_t *message)
{
    const char *operation = json_string_value(json_object_get(message, "operation"));
    vv_status st = vvi_request_take_text(&r->dataset, message, "dataset");
    if (st == VV_OK && (!operation || !r->dataset))
        st = vv_fail(VV_E_ARGUMENT, "'%s' needs an operation and a dataset", r->task.name);
    if (st != VV_OK)
        return st;
    r->operation = vv_registry_operation(vv_runtime_registry(r->session->options.runtime), operation);
    st = r->operation ? take_parameters(r, message) : VV_E_NOT_FOUND;
    return st == VV_OK ? take_inputs(r, message) : st;
}

/* What would be made ----------------------------------------------------------------------------------------------- */

/* The dataset is the first input; of those that people name it is among the others, or all there is. NULL: there is no
 * memory. */
static json_t *inputs_of(const vvi_request *r)
{
    const vv_operand *first = r->operation->inputs;
    json_t *inputs = json_object(), *others = vvi_json_of_own(r->inputs ? r->inputs : "{}");
    if (!first->names)
        vvi_json_put(&inputs, first->name, json_string(r->dataset));
    if (json_object_update(inputs, others) != 0) {
        json_decref(inputs);
        inputs = NULL;
    }
    if (inputs && first->names && json_object_size(inputs) == 0)
        vvi_json_put(&inputs, "a", json_string(r->dataset));
    json_decref(others);
    return inputs;
}

json_t *vvi_request_recipe(const vvi_request *r)
{
    json_t *recipe = json_pack("{s:s, s:o}", "operation", r->operation->name, "inputs", inputs_of(r));
    json_t *parameters = vvi_json_of_own(r->parameters ? r->parameters : "{}");
    if (parameters && json_object_size(parameters) == 0)
        json_decref(parameters);
    else
        vvi_json_put(&recipe, "parameters", parameters);
    return recipe;
}

vv_status vvi_request_make_world(vv_world **out, const vvi_request *r, const char *id)
{
    json_t *recipe = vvi_request_recipe(r);
    char *text = recipe ? vvi_json_encode(recipe, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    vv_object *root = vv_object_retain(&r->world->base);
    const vv_status st = text ? vv_path_add(&root, "datasets", id, text, NULL) : vv_fail_memory(256);
    *out = (vv_world *)(void *)root;
    json_decref(recipe);
    free(text);
    return st;
}

void vvi_request_free_id(char out[VVI_REQUEST_ID], const vv_world *world, const char *wanted)
{
    snprintf(out, VVI_REQUEST_ID, "%.*s", VVI_REQUEST_ID - 8, wanted);
    for (int i = 2; vv_collection_find(world->datasets, out) && i < 10000; i++)
        snprintf(out, VVI_REQUEST_ID, "%.*s-%d", VVI_REQUEST_ID - 8, wanted, i);
}

/* "--min-size", as a page has it: Min size. Bytes of the option; 0: it is none of these. */
static size_t put_label(vvi_text *out, const char *text, const vv_class *cls)
{
    const size_t n = strspn(text + 2, "abcdefghijklmnopqrstuvwxyz0123456789-");
    for (const vv_property *row = cls->properties; row->name; row++) {
        const char *name = row->option && *row->option ? row->option : row->name;
        size_t same = 0;
        while (same < n && (name[same] == text[2 + same] || (name[same] == '_' && text[2 + same] == '-')))
            same++;
        if (same < n || name[same] || n == 0)
            continue;
        vvi_text_printf(out, "%c",
                        row->name[0] >= 'a' && row->name[0] <= 'z' ? row->name[0] - 'a' + 'A' : row->name[0]);
        for (const char *c = row->name + 1; *c; c++)
            vvi_text_printf(out, "%c", *c == '_' ? ' ' : *c);
        return n + 2;
    }
    return 0;
}

void vvi_request_words(vvi_text *out, const char *text, const vv_class *cls)
{
    bool quoted = false;
    while (*text) {
        quoted ^= *text == '`';
        const size_t n = !quoted && strncmp(text, "--", 2) == 0 ? put_label(out, text, cls) : 0;
        if (!n)
            vvi_text_printf(out, "%c", *text);
        text += n ? n : 1;
    }
}

/* Nobody has heard of the dataset that would be made: "datasets.ID.parameters.sigma" is "parameters.sigma". */
vv_status vvi_request_fail_made(const vv_operation *operation, const char *id, vv_status st)
{
    vvi_error_copy error;
    char place[VVI_REQUEST_ID + 16];
    const size_t n = (size_t)snprintf(place, sizeof place, "datasets.%s", id);
    const vv_error *last = vv_error_last();
    if (st == VV_OK || st == VV_E_CANCELLED || last->file || !last->where || strncmp(last->where, place, n) != 0 ||
        (last->where[n] && last->where[n] != '.'))
        return st;
    vvi_error_take(&error);
    const char *inside = error.where + n, *text = error.message;
    if (strncmp(text, error.where, strlen(error.where)) == 0)
        text += strlen(error.where) + strspn(text + strlen(error.where), ": ");
    const bool named = strchr(inside + (*inside == '.'), '.') != NULL; /* "parameters" alone says nothing */
    vvi_text sentence = {0};
    vvi_request_words(&sentence, text, operation->params);
    st = vv_fail_at(st, NULL, named ? inside + 1 : NULL, "%s", sentence.s ? sentence.s : text);
    vvi_text_free(&sentence);
    vvi_error_copy_free(&error);
    return st;
}
