/* Simplify: fewer triangles for nearly the same surface, as an operation. */
#include "core/job.h"
#include "registry.h"
#include "surface/simplify.h"

typedef struct simplify_params {
    vv_object base;
    int64_t triangles;
    double share, error;
    bool lock_border;
} simplify_params;

static const vv_property properties[] = {
    {VV_PROP(simplify_params, triangles), .kind = VV_KIND_I64, .limited = true, .min = 1, .max = UINT32_MAX,
     .automatic = "as share says", .doc = "that are left, at most"},
    {VV_PROP(simplify_params, share), .kind = VV_KIND_F64, .quantity = VV_Q_RATIO, .limited = true, .min = 0, .max = 1,
     .automatic = "a quarter, unless triangles or error are given", .doc = "of the triangles that is left, at most"},
    {VV_PROP(simplify_params, error), .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH, .limited = true, .min = 0,
     .max = 1e30, .automatic = "as much as the number of triangles asks for",
     .doc = "how far the surface may move, about"},
    {VV_PROP(simplify_params, lock_border), .kind = VV_KIND_BOOL, .doc = "vertices at open edges stay where they are"},
    {0},
};

static const vv_class simplify_class = {
    .name = "simplify",
    .doc = "parameters of simplify",
    .size = sizeof(simplify_params),
    .properties = properties,
};

static uint64_t budget_of(const simplify_params *p, const vv_mesh *mesh)
{
    const double n = (double)vv_mesh_get_info(mesh)->n_triangles;
    if (vv_object_is_set(&p->base, "triangles"))
        return (uint64_t)p->triangles;
    if (vv_object_is_set(&p->base, "share"))
        return (uint64_t)(n * p->share) + 1;
    return vv_object_is_set(&p->base, "error") ? 0 : (uint64_t)(n / 4) + 1;
}

static vv_status mesh_of_meshes(vv_mesh **out, const vv_mesh *const *inputs, size_t n_inputs, const vv_object *params,
                                vv_job *job)
{
    (void)n_inputs;
    const simplify_params *p = (const simplify_params *)params;
    const vvi_simplify_options options = {
        .triangles = budget_of(p, inputs[0]), .error = p->error, .lock_border = p->lock_border};
    const vv_mesh_info *mesh = vv_mesh_get_info(inputs[0]);
    vvi_simplify_result result;
    if (!mesh->n_triangles) { /* nothing to do, and no budget that says so */
        *out = vv_mesh_retain(inputs[0]);
        return VV_OK;
    }
    const vv_status st = vvi_mesh_simplify(out, &result, inputs[0], &options, job);
    if (st != VV_OK)
        return st;
    vvi_log(job, VV_LOG_INFO, "simplify", "%zu of %zu triangles; the surface has moved by about %.3g %s",
            result.n_triangles, mesh->n_triangles, result.error, mesh->unit);
    if (result.over_budget)
        vvi_log(job, VV_LOG_WARNING, "simplify", "%zu triangles are left of the %llu asked for: no more can go %s",
                result.n_triangles, (unsigned long long)options.triangles,
                options.error > 0 ? "within the error" : "without opening the surface");
    if (result.n_crowded)
        vvi_log(job, VV_LOG_WARNING, "simplify",
                "%zu edges have more than two triangles: the surface touches itself there", result.n_crowded);
    return VV_OK;
}

const vv_operation vvi_operation_simplify = {
    .api = VV_OPERATION_API,
    .name = "simplify",
    .component = "surface",
    .doc = "a mesh of fewer triangles, nearly the same surface (quadric error)",
    .example = "volvis simplify skin.ply -o small.ply --share 20%",
    .params = &simplify_class,
    .min_inputs = 1,
    .max_inputs = 1,
    .mesh_of_meshes = mesh_of_meshes,
};
