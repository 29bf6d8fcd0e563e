/* Simplify: fewer triangles for nearly the same surface, as an operation. */
#include "filter/simplify.h"
#include "core/findings.h"
#include "core/job.h"
#include "filter/simplify_within.h"
#include "registry.h"

#include <math.h>

typedef struct simplify_params {
    vv_object base;
    int64_t triangles;
    double share, error;
    bool fix_border, lock_border;
} simplify_params;

static const vv_property properties[] = {
    {VV_PROP(simplify_params, triangles), .kind = VV_KIND_I64, .limited = true, .min = 1, .max = UINT32_MAX,
     .automatic = "as share says", .doc = "number of triangles to keep, at most"},
    {VV_PROP(simplify_params, share), .kind = VV_KIND_F64, .quantity = VV_Q_RATIO, .limited = true, .min = 0, .max = 1,
     .automatic = "a quarter, unless triangles or error are given", .doc = "share of the triangles to keep, at most"},
    {VV_PROP(simplify_params, error), .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH, .limited = true, .min = 0,
     .max = 1e30, .automatic = "whatever the number of triangles needs",
     .doc = "the largest distance between the new and the old surface (Hausdorff), measured; no piece vanishes, and a "
            "warning says so if the distance cannot be kept"},
    {VV_PROP(simplify_params, fix_border), .kind = VV_KIND_BOOL, .doc = "vertices at open edges stay in place"},
    {VV_PROP(simplify_params, lock_border), .kind = VV_KIND_BOOL, .hidden = true,
     .doc = "the former name of fix_border"},
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

/* Down to a number of triangles; how far the surface has moved is measured then. */
static vv_status simplify_to(vv_mesh **out, vvi_simplify_told *told, const vv_mesh *mesh,
                             const vvi_simplify_options *options, vv_job *job)
{
    vv_mesh_tree *before = NULL, *after = NULL;
    vv_status st = vvi_mesh_simplify(out, &told->result, mesh, options, job);
    if (st == VV_OK && told->result.n_triangles > 0 && (st = vv_mesh_tree_new(&before, mesh, NULL, job)) == VV_OK &&
        (st = vv_mesh_tree_new(&after, *out, NULL, job)) == VV_OK)
        st = vvi_simplify_measure(&told->distance, before, after, job);
    vv_mesh_tree_release(before);
    vv_mesh_tree_release(after);
    if (st == VV_OK)
        return VV_OK;
    vv_mesh_release(*out);
    *out = NULL;
    return st;
}

/* How far the surface is from what it was, and what has vanished. */
static void find(const vvi_simplify_result *r, vv_figure distance, const char *unit, vv_job *job)
{
    if (!isnan(distance.value)) /* of an empty mesh nothing is near */
        vvi_find_phrase(job, "at most %.4g %s from what it was", distance.value + distance.error, unit);
    if (r->n_dropped || r->n_pieces_left != r->n_pieces)
        vvi_find_phrase(job, "%zu piece%s became %zu, %zu vanished", r->n_pieces, r->n_pieces == 1 ? "" : "s",
                        r->n_pieces_left, r->n_dropped);
    vvi_find_number(job, "error_estimate", r->error);
    vvi_find_number(job, "distance", distance.value);
    vvi_find_number(job, "distance_error", isnan(distance.value) ? NAN : distance.error);
    vvi_find_count(job, "pieces_before", r->n_pieces);
    vvi_find_count(job, "pieces_after", r->n_pieces_left);
    vvi_find_count(job, "pieces_dropped", r->n_dropped);
}

static void tell(const vvi_simplify_told *told, const vv_mesh_info *mesh, const vvi_simplify_options *options,
                 vv_job *job)
{
    const vvi_simplify_result *r = &told->result;
    const vv_figure distance = told->distance;
    const double most = distance.value + distance.error;
    find(r, distance, mesh->unit, job);
    vvi_log(job, VV_LOG_INFO, "simplify", "%zu of %zu triangles; the surface has moved by at most %.4g %s",
            r->n_triangles, mesh->n_triangles, most, mesh->unit);
    if (r->over_budget)
        vvi_log(job, VV_LOG_WARNING, "simplify", "%zu %s left of the %llu asked for: no more can be removed %s",
                r->n_triangles, r->n_triangles == 1 ? "triangle is" : "triangles are",
                (unsigned long long)options->triangles,
                options->error > 0 ? "within the error" : "without opening the surface");
    if (mesh->n_textures)
        vvi_log(job, VV_LOG_WARNING, "simplify",
                "images on triangles are left out: other triangles have no places on them");
    if (r->n_crowded)
        vvi_log(job, VV_LOG_WARNING, "simplify", "%zu %s more than two triangles: the surface touches itself there",
                r->n_crowded, r->n_crowded == 1 ? "edge has" : "edges have");
    if (options->error > 0 && most > options->error)
        vvi_log(job, VV_LOG_WARNING, "simplify",
                "the surface is up to %.4g %s away from the original, more than the error of %.4g that was asked for",
                most, mesh->unit, options->error);
}

static vv_status make(vv_data *out, const vv_data *inputs, size_t n_inputs, const vv_object *params, vv_job *job)
{
    const simplify_params *p = (const simplify_params *)params;
    const vv_mesh *mesh = inputs[0].mesh;
    const vvi_simplify_options options = {
        .triangles = budget_of(p, mesh), .error = p->error, .fix_border = p->fix_border || p->lock_border};
    vvi_simplify_told told = {.distance.value = NAN};
    if (!vv_mesh_get_info(mesh)->n_triangles) { /* nothing to do, and no budget that says so */
        out->mesh = vv_mesh_retain(inputs[0].mesh);
        find(&told.result, told.distance, "", job);
        return VV_OK;
    }
    if (p->lock_border)
        vvi_log(job, VV_LOG_WARNING, "simplify", "lock_border is called fix_border now, as in smooth");
    const vv_status st = options.error > 0 ? vvi_simplify_within(&out->mesh, &told, mesh, &options, job)
                                           : simplify_to(&out->mesh, &told, mesh, &options, job);
    if (st == VV_OK)
        tell(&told, vv_mesh_get_info(mesh), &options, job);
    return st;
}

const vv_operation vvi_operation_simplify = {
    .api = VV_OPERATION_API,
    .name = "simplify",
    .component = "surface",
    .group = "surfaces",
    .doc = "a mesh with fewer triangles and nearly the same surface (quadric error)",
    .example = "volvis simplify skin.ply -o small.ply --share 20%",
    .params = &simplify_class,
    .inputs = VV_ONE_MESH,
    .make = make,
    .makes = VV_IS_MESH,
};
