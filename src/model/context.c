#include "model/context.h"
#include "core/job.h"
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
    const vv_format *row = registry->formats ? registry->formats[index] : NULL;
    if (!row)
        return NULL;
    *name_out = row->name;
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
