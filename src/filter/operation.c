/* Running a row of the operation table: whether it takes what it is given, and which of its functions does it. */
#include "filter/operation.h"
#include "core/status.h"
#include <string.h>

static vv_status check_count(const vv_operation *operation, size_t n)
{
    if (n >= operation->min_inputs && n <= operation->max_inputs)
        return VV_OK;
    return vv_fail(VV_E_ARGUMENT, "%s: takes %zu to %zu inputs, there are %zu", operation->name, operation->min_inputs,
                   operation->max_inputs, n);
}

static vv_status refuse(const vv_operation *operation, const char *makes)
{
    return vv_fail(VV_E_ARGUMENT, "%s: is not an operation that makes %s", operation->name, makes);
}

vv_status vvi_operation_plan(vv_field_info *out, const vv_operation *operation, const vv_field *const *inputs,
                             size_t n_inputs, const vv_object *params)
{
    enum { MOST = 16 };
    vv_field_info infos[MOST];
    if (n_inputs > MOST)
        return vv_fail(VV_E_ARGUMENT, "%s: at most %d inputs can be streamed", operation->name, MOST);
    for (size_t i = 0; i < n_inputs; i++)
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
        st = vv_field_health(inputs[i]);
    if (st != VV_OK && *out) {
        vv_field_release(*out);
        *out = NULL;
    }
    return st;
}

vv_status vv_operation_run(vv_field **out, const vv_operation *operation, const vv_field *const *inputs,
                           size_t n_inputs, const vv_object *params, vv_job *job)
{
    vv_field_info info;
    *out = NULL;
    vv_status st = check_count(operation, n_inputs);
    if (st != VV_OK)
        return st;
    if (!operation->plan)
        return refuse(operation, "samples of samples");
    if (operation->run) {
        st = operation->run(out, inputs, n_inputs, params, job);
        return vvi_operation_check(out, inputs, n_inputs, st);
    }
    if ((st = vvi_operation_plan(&info, operation, inputs, n_inputs, params)) != VV_OK)
        return st;
    vv_box all = {{0, 0, 0}, {0, 0, 0}};
    memcpy(all.n, info.grid.dims, sizeof all.n);
    st = operation->run_box(out, inputs, n_inputs, params, &all, job);
    return vvi_operation_check(out, inputs, n_inputs, st);
}

vv_status vv_operation_mesh_of_fields(vv_mesh **out, const vv_operation *operation, const vv_field *const *inputs,
                                      size_t n_inputs, const vv_object *params, vv_job *job)
{
    *out = NULL;
    if (!operation->mesh_of_fields)
        return refuse(operation, "a mesh of samples");
    vv_status st = check_count(operation, n_inputs);
    if (st == VV_OK)
        st = operation->mesh_of_fields(out, inputs, n_inputs, params, job);
    for (size_t i = 0; i < n_inputs && st == VV_OK; i++)
        st = vv_field_health(inputs[i]);
    if (st != VV_OK && *out) {
        vv_mesh_release(*out);
        *out = NULL;
    }
    return st;
}

vv_status vv_operation_mesh_of_meshes(vv_mesh **out, const vv_operation *operation, const vv_mesh *const *inputs,
                                      size_t n_inputs, const vv_object *params, vv_job *job)
{
    *out = NULL;
    if (!operation->mesh_of_meshes)
        return refuse(operation, "a mesh of a mesh");
    const vv_status st = check_count(operation, n_inputs);
    return st == VV_OK ? operation->mesh_of_meshes(out, inputs, n_inputs, params, job) : st;
}
