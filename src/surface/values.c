#include "surface/values.h"
#include "core/job.h"
#include "grid/mesh.h"

#include <math.h>
#include <string.h>

static vv_status check(const vv_mesh *mesh, const vv_field *field, int component)
{
    const vv_field_info *info = vv_field_get_info(field);
    const char *unit = vv_mesh_get_info(mesh)->unit;
    if (component < 0 || component >= info->components)
        return vv_fail(VV_E_ARGUMENT, "channel %d does not exist; there are 0 to %d", component, info->components - 1);
    if (strcmp(unit, info->grid.unit) != 0)
        return vv_fail(VV_E_ARGUMENT, "the surface is in %s and the field in %s: give both the same unit", unit,
                       info->grid.unit);
    return VV_OK;
}

static void tell_outside(const float *values, size_t n_vertices, const char *name, const vv_job *job)
{
    size_t n = 0;
    for (size_t i = 0; i < n_vertices; i++)
        n += !isfinite(values[i]);
    if (n)
        vvi_log(job, VV_LOG_WARNING, "isosurface",
                "%zu of %zu vertices lie outside the samples of %s: their value is NaN", n, n_vertices, name);
}

vv_status vvi_mesh_sample(vv_mesh *mesh, const vv_field *field, int component, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    vv_affine to_index;
    float *values;
    vv_status st = check(mesh, field, component);
    if (st == VV_OK && !vv_affine_invert(&to_index, info->grid.index_to_world))
        st = vv_fail(VV_E_ARGUMENT, "the grid's axes lie in one plane: it has no values at vertices");
    if (st == VV_OK)
        st = vvi_mesh_add_values(&values, mesh, *info->name ? info->name : "value", info->value_unit, job);
    if (st == VV_OK)
        st = vvi_mesh_values_of(values, vv_mesh_get_info(mesh), &to_index, field, component,
                                info->meaning == VV_MEANING_LABEL, job);
    if (st != VV_OK)
        return st;
    tell_outside(values, vv_mesh_get_info(mesh)->n_vertices, *info->name ? info->name : "the second volume", job);
    return vv_field_health(field);
}
