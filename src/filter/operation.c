/* Running a row of the operation table: whether it takes what it is given, and which of its functions does it. */
#include "filter/operation.h"
#include "core/status.h"
#include <string.h>

enum { FIELDS_MOST = 16 };

size_t vv_operation_least(const vv_operation *operation)
{
    size_t n = 0;
    for (const vv_operand *o = operation->inputs; o->name; o++)
        n += o->least;
    return n;
}

size_t vv_operation_most(const vv_operation *operation)
{
    size_t n = 0;
    for (const vv_operand *o = operation->inputs; o->name; o++)
        n += o->most;
    return n;
}

const vv_operand *vv_operation_operand(const vv_operation *operation, size_t index)
{
    for (const vv_operand *o = operation->inputs; o->name; o++) {
        if (index < o->most)
            return o;
        index -= o->most;
    }
    return NULL;
}

vv_data_is vv_operation_makes(const vv_operation *operation)
{
    return operation->make ? operation->makes : VV_IS_FIELD;
}

void vv_data_release(vv_data *data)
{
    vv_field_release(data->field);
    vv_mesh_release(data->mesh);
    *data = (vv_data){0};
}

static vv_status fail_count(const vv_operation *operation, size_t n)
{
    const size_t least = vv_operation_least(operation), most = vv_operation_most(operation);
    if (least == most)
        return vv_fail(VV_E_ARGUMENT, "%s: takes %zu input%s, there are %zu", operation->name, most,
                       most == 1 ? "" : "s", n);
    return vv_fail(VV_E_ARGUMENT, "%s: takes %zu to %zu inputs, there are %zu", operation->name, least, most, n);
}

static unsigned sort_of(const vv_data *data)
{
    return data->field ? VV_IS_FIELD : data->mesh ? VV_IS_MESH : 0;
}

static const char *word_of(unsigned is)
{
    return is == VV_IS_FIELD ? "a volume" : is == VV_IS_MESH ? "a mesh" : "a volume or a mesh";
}

/* Each in its place, and none missing. */
static vv_status check_inputs(const vv_operation *operation, const vv_data *inputs, size_t n)
{
    size_t i = 0;
    if (n > vv_operation_most(operation))
        return fail_count(operation, n);
    if (operation->joins && n > 1)
        return vv_fail(VV_E_ARGUMENT, "%s: makes time steps, and one volume has none: vv_run_new() runs it",
                       operation->name);
    for (const vv_operand *o = operation->inputs; o->name; o++) {
        size_t given = 0;
        for (const size_t end = i + o->most; i < end && i < n; i++) {
            const unsigned is = sort_of(&inputs[i]);
            if (is && !(is & o->is))
                return vv_fail(VV_E_ARGUMENT, "%s: %s is %s; it must be %s", operation->name, o->name, word_of(is),
                               word_of(o->is));
            given += is != 0;
        }
        if (operation->joins && given == 1)
            continue;
        if (given < o->least && vv_operation_most(operation) == 1)
            return fail_count(operation, given);
        if (given < o->least)
            return vv_fail(VV_E_ARGUMENT, "%s: %s is missing: %s", operation->name, o->name, o->doc);
    }
    return VV_OK;
}

vv_status vvi_operation_plan(vv_field_info *out, const vv_operation *operation, const vv_field *const *inputs,
                             size_t n_inputs, const vv_object *params)
{
    vv_field_info infos[FIELDS_MOST] = {0};
    if (n_inputs > FIELDS_MOST)
        return vv_fail(VV_E_ARGUMENT, "%s: at most %d inputs can be streamed", operation->name, FIELDS_MOST);
    for (size_t i = 0; i < n_inputs; i++)
        if (inputs[i])
            infos[i] = *vv_field_get_info(inputs[i]);
    return operation->plan(out, infos, n_inputs, params);
}

vv_status vv_carry_values(vv_carry *carry, const vv_object *params)
{
    return VV_OK;
}

vv_status vvi_operation_check(vv_field **out, const vv_field *const *inputs, size_t n_inputs, vv_status st)
{
    for (size_t i = 0; i < n_inputs && st == VV_OK; i++)
        if (inputs[i])
            st = vv_field_health(inputs[i]);
    if (st != VV_OK && *out) {
        vv_field_release(*out);
        *out = NULL;
    }
    return st;
}

static vv_status run_fields(vv_field **out, const vv_operation *operation, const vv_field *const *inputs,
                            size_t n_inputs, const vv_object *params, vv_job *job)
{
    vv_field_info info;
    if (operation->run)
        return operation->run(out, inputs, n_inputs, params, job);
    vv_status st = vvi_operation_plan(&info, operation, inputs, n_inputs, params);
    if (st != VV_OK)
        return st;
    vv_box all = {{0, 0, 0}, {0, 0, 0}};
    memcpy(all.n, info.grid.dims, sizeof all.n);
    return operation->run_box(out, inputs, n_inputs, params, &all, job);
}

vv_status vv_operation_make(vv_data *out, const vv_operation *operation, const vv_data *inputs, size_t n_inputs,
                            const vv_object *params, vv_job *job)
{
    const vv_field *fields[FIELDS_MOST] = {NULL};
    *out = (vv_data){0};
    vv_status st = check_inputs(operation, inputs, n_inputs);
    if (st != VV_OK)
        return st;
    for (size_t i = 0; i < n_inputs && i < FIELDS_MOST; i++)
        fields[i] = inputs[i].field;
    st = operation->make ? operation->make(out, inputs, n_inputs, params, job)
                         : run_fields(&out->field, operation, fields, n_inputs, params, job);
    for (size_t i = 0; i < n_inputs && st == VV_OK; i++)
        if (inputs[i].field)
            st = vv_field_health(inputs[i].field);
    if (st != VV_OK)
        vv_data_release(out);
    return st;
}

vv_status vv_operation_run(vv_field **out, const vv_operation *operation, const vv_field *const *inputs,
                           size_t n_inputs, const vv_object *params, vv_job *job)
{
    vv_data given[FIELDS_MOST] = {{0}}, made;
    *out = NULL;
    if (operation->make && operation->makes != VV_IS_FIELD)
        return vv_fail(VV_E_ARGUMENT, "%s: makes a mesh, and no samples", operation->name);
    if (n_inputs > FIELDS_MOST)
        return fail_count(operation, n_inputs);
    for (size_t i = 0; i < n_inputs; i++)
        given[i].field = (vv_field *)(uintptr_t)inputs[i];
    const vv_status st = vv_operation_make(&made, operation, given, n_inputs, params, job);
    *out = made.field;
    return st;
}
