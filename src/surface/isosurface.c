/* Isosurface: the surface where samples have a value, as an operation. */
#include "grid/value_fit.h"
#include "registry.h"
#include "surface/marching.h"

typedef struct isosurface_params {
    vv_object base;
    double value;
    int64_t component;
    int topology;
    bool cap, normals;
} isosurface_params;

static const char *const topologies[] = {"decided", "apart", NULL};

static const vv_property properties[] = {
    {VV_PROP(isosurface_params, value), .kind = VV_KIND_F64, .unit = "value",
     .automatic = "the value that best splits the histogram in two",
     .doc = "of the surface; samples from it on are inside"},
    {VV_PROP(isosurface_params, component), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = 1 << 20,
     .doc = "which one of several, from 0"},
    {VV_PROP(isosurface_params, topology), .kind = VV_KIND_ENUM, .names = topologies,
     .doc =
         "where a face of a cell has two meanings: as its bilinear function decides, or what is inside always apart"},
    {VV_PROP(isosurface_params, cap), .kind = VV_KIND_BOOL, .doc = "close the surface where it leaves the volume"},
    {VV_PROP(isosurface_params, normals), .kind = VV_KIND_BOOL, .def = 1,
     .doc = "the gradient's direction at each vertex"},
    {0},
};

static const vv_class isosurface_class = {
    .name = "isosurface",
    .doc = "parameters of isosurface",
    .size = sizeof(isosurface_params),
    .properties = properties,
};

static vv_status automatic_value(double *out, const vv_field *field, int component, vv_job *job)
{
    vv_statistics statistics;
    vvi_value_fit fit;
    const vv_status st = vv_field_statistics(&statistics, field, component, job);
    if (st != VV_OK)
        return st;
    vvi_fit_values(&fit, &statistics);
    *out = fit.split;
    return fit.empty ? vv_fail(VV_E_ARGUMENT, "isosurface: no sample is a number: there is no surface") : VV_OK;
}

static vv_status mesh_of_fields(vv_mesh **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                                vv_job *job)
{
    (void)n_inputs;
    const isosurface_params *p = (const isosurface_params *)params;
    vvi_marching_options options = {.value = p->value,
                                    .component = (int)p->component,
                                    .topology = (vvi_marching_topology)p->topology,
                                    .no_normals = !p->normals,
                                    .cap = p->cap};
    vv_status st = VV_OK;
    if (!vv_object_is_set(params, "value"))
        st = automatic_value(&options.value, inputs[0], options.component, job);
    return st == VV_OK ? vvi_marching_cubes(out, inputs[0], &options, job) : st;
}

const vv_operation vvi_operation_isosurface = {
    .api = VV_OPERATION_API,
    .name = "isosurface",
    .component = "surface",
    .doc = "the surface where samples have a value, as triangles (Marching Cubes)",
    .example = "volvis isosurface head.nrrd -o skin.ply --value 50",
    .params = &isosurface_class,
    .min_inputs = 1,
    .max_inputs = 1,
    .mesh_of_fields = mesh_of_fields,
};
