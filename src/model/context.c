#include "model/context.h"
#include "core/job.h"
#include "core/units.h"
#include <string.h>

/* Stands for the parameters of rows that have none. */
static const vv_property no_properties[] = {{0}};
static const vv_class no_parameters = {
    .name = "none",
    .doc = "no parameters",
    .size = sizeof(vv_object),
    .properties = no_properties,
};

static const vv_class *renderer_row(const vv_registry *registry, size_t index, const char **name_out)
{
    const vv_renderer *row = registry->renderers ? registry->renderers[index] : NULL;
    if (!row)
        return NULL;
    *name_out = row->name;
    return row->params ? row->params : &no_parameters;
}

static const vv_class *data_kind_row(const vv_registry *registry, size_t index, const char **name_out)
{
    const vv_data_kind *row = registry->data_kinds ? registry->data_kinds[index] : NULL;
    if (!row)
        return NULL;
    *name_out = row->name;
    return &no_parameters;
}

static const vv_class *format_row(const vv_registry *registry, size_t index, const char **name_out)
{
    size_t n = 0;
    while (registry->formats && n < index && registry->formats[n])
        n++;
    const vv_format *row = registry->formats ? registry->formats[n] : NULL;
    const vv_mesh_format *mesh = !row && registry->mesh_formats ? registry->mesh_formats[index - n] : NULL;
    if (!row && !mesh)
        return NULL;
    *name_out = row ? row->name : mesh->name;
    return &no_parameters;
}

static const vv_class *variant(const void *user, const char *table, size_t index, const char **name_out)
{
    const vv_registry *registry = user;
    if (!strcmp(table, "renderers"))
        return renderer_row(registry, index, name_out);
    if (!strcmp(table, "data_kinds"))
        return data_kind_row(registry, index, name_out);
    if (!strcmp(table, "formats"))
        return format_row(registry, index, name_out);
    return NULL;
}

vv_property_context vvi_registry_context(const vv_registry *registry)
{
    return (vv_property_context){
        .variant = variant,
        .user = registry ? registry : vv_registry_builtin(),
    };
}

/* A grid's voxel in the World's unit: the numbers as they are where either has no unit of the real world. */
static double voxel_in(const char *unit, const vv_grid *grid)
{
    const double from = vvi_length_unit_metres(grid->unit), to = vvi_length_unit_metres(unit);
    return vv_grid_voxel(grid) * (from > 0 && to > 0 && strcmp(unit, grid->unit) != 0 ? from / to : 1);
}

/* Of the first dataset whose grid can be learned; 0 when there is none. */
static double find_voxel(const vv_world *world, vv_job *job)
{
    const vv_collection *datasets = world->datasets;
    for (size_t i = 0; i < datasets->n; i++) {
        vv_field_info info;
        const vv_dataset *dataset = (const vv_dataset *)datasets->entry[i].object;
        if (!vv_dataset_is_mesh(dataset, job) && vv_dataset_info(&info, world, dataset, job) == VV_OK)
            return voxel_in(world->unit, &info.grid);
    }
    return 0;
}

vv_property_context vvi_world_context(const vv_world *world, vv_job *job)
{
    vv_property_context context = vvi_registry_context(vvi_job_registry(job));
    context.length_unit = world->unit;
    context.voxel = find_voxel(world, job);
    return context;
}
