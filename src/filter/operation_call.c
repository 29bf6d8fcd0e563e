/* What a program needs that runs an operation by name. */
#include "core/job.h"
#include "model/context.h"
#include <volvis/operation.h>
#include <volvis/sys/registry.h>

const vv_operation *vv_operation_find(const char *name, const vv_job *job)
{
    return vv_registry_operation(vvi_job_registry(job), name);
}

vv_status vv_operation_new_params(vv_object **out, const vv_operation *operation)
{
    const vv_property_context context = vvi_registry_context(NULL);
    return vv_object_new(out, operation->params, &context);
}

vv_property_context vv_data_context(const vv_data *data)
{
    vv_property_context context = vvi_registry_context(NULL);
    if (data->mesh)
        context.length_unit = vv_mesh_get_info(data->mesh)->unit;
    if (data->field) {
        const vv_grid *grid = &vv_field_get_info(data->field)->grid;
        context.length_unit = grid->unit;
        context.voxel = vv_grid_voxel(grid);
    }
    return context;
}
