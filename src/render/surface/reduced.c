/* The rows of the Navigator's two coarse representations. */
#include "surface/reduced.h"
#include "core/job.h"
#include "registry.h"
#include "render/surface/surface.h"
#include "surface/boxes.h"
#include <volvis/model.h>

#define TRIANGLES 200000 /* what a computer without a graphics card turns smoothly */
#define BOX_TRIANGLES 50000

/* Budgets --------------------------------------------------------------------------------------------------------- */

/* Makes a mesh of at most so many triangles (0: no limit). */
typedef vv_status make_within(vvi_surface_model *out, const vvi_surface_request *r, size_t triangles, vv_job *job);

static void drop(vvi_surface_model *model)
{
    vv_mesh_release(model->mesh);
    vv_field_release(model->samples);
    model->mesh = NULL;
    model->samples = NULL;
}

/* How many vertices so many triangles have is known afterwards: too large a mesh is made again of fewer, until it fits
 * or is the coarsest that there is. */
static vv_status make_budget(vvi_surface_model *out, const vvi_surface_request *r, make_within *make, vv_job *job)
{
    size_t most = (size_t)r->params->triangles, before = SIZE_MAX;
    vv_status st = make(out, r, most, job);
    while (st == VV_OK && out->mesh && r->params->memory > 0) {
        const vv_mesh_info *info = vv_mesh_get_info(out->mesh);
        const double excess = (double)vvi_surface_bytes(info) / r->params->memory;
        if (excess <= 1 || info->n_triangles >= before)
            break;
        before = info->n_triangles;
        most = (size_t)((double)before / excess);
        drop(out);
        st = make(out, r, most ? most : 1, job);
    }
    return st;
}

/* A surface that takes four places an edge ------------------------------------------------------------------------ */

static const char *const filters[] = {"smooth", "high", "low", NULL};

static const vv_property reduced_rows[] = {
    {VV_PROP(vvi_surface_params, iso), .kind = VV_KIND_F64, .unit = "value",
     .automatic = "the threshold's limits, or a valley of the histogram between the background and the object",
     .doc = "value of the surface"},
    {VV_PROP(vvi_surface_params, triangles), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = 4294967295.0,
     .def = TRIANGLES, .doc = "per surface, at most: samples are skipped until it fits; 0: no limit"},
    {VV_PROP(vvi_surface_params, memory), .kind = VV_KIND_F64, .quantity = VV_Q_BYTES, .limited = true, .min = 0,
     .max = 1e15, .doc = "memory for the triangles of each surface, at most, as in 20M; 0: no limit"},
    {VV_PROP(vvi_surface_params, filter), .kind = VV_KIND_ENUM, .names = filters,
     .doc = "how skipped samples are combined: to their mean; high keeps the highest, so that thin parts of high "
            "values stay and all of them grow; low keeps the lowest"},
    {0},
};
const vv_class vvi_reduced_class = {
    .name = "reduced",
    .doc = "parameters of reduced",
    .size = sizeof(vvi_surface_params),
    .properties = reduced_rows,
};

/* Half of the samples change little; with fewer, what is thinner than their distance is gone. */
static void tell_steps(const vvi_surface_request *r, const vvi_reduced *reduced, const vv_job *job)
{
    const int32_t *s = reduced->step, most = s[0] > s[1] ? (s[0] > s[2] ? s[0] : s[2]) : s[1] > s[2] ? s[1] : s[2];
    vvi_log(job, VV_LOG_INFO, "reduced",
            "volumes.%s: %zu triangles of one sample in %d x %d x %d, %zu bytes of records", r->actor->id,
            reduced->n_triangles, s[0], s[1], s[2], reduced->n_bytes);
    const bool coarse = most >= 4 || (most > 1 && reduced->n_triangles == 0);
    if (coarse && r->params->filter == VVI_REDUCED_SMOOTH)
        vvi_log(job, VV_LOG_WARNING, "reduced",
                "volumes.%s: one sample in %d is used to stay within the budget: thinner parts are lost; "
                "render.reduced.filter=high keeps them, and makes them thicker",
                r->actor->id, most);
}

static vv_status reduced_within(vvi_surface_model *out, const vvi_surface_request *r, size_t triangles, vv_job *job)
{
    const vvi_reduced_options o = {.value = r->value,
                                   .component = r->component,
                                   .max_triangles = triangles,
                                   .filter = (vvi_reduced_filter)r->params->filter,
                                   .keep = true};
    vvi_reduced *reduced;
    vv_status st = vvi_reduced_make(&reduced, r->field, &o, job);
    if (st != VV_OK)
        return st;
    st = vvi_reduced_mesh(&out->mesh, reduced, job);
    tell_steps(r, reduced, job);
    out->samples = reduced->samples ? vv_field_retain(reduced->samples) : NULL;
    vvi_reduced_free(reduced);
    return st;
}

static vv_status make_reduced(vvi_surface_model *out, const vvi_surface_request *r, vv_job *job)
{
    return make_budget(out, r, reduced_within, job);
}

static vv_status prepare_reduced(void **state_out, const vv_scene *scene, vv_job *job)
{
    return vvi_surface_prepare(state_out, scene, "surface reduced", make_reduced, job);
}

static uint64_t memory_reduced(const vv_object *params, const vv_volume *volume, const vv_field_info *info)
{
    const size_t triangles = (size_t)((const vvi_surface_params *)(const void *)params)->triangles;
    (void)volume;
    (void)info;
    return vvi_surface_bytes(&(vv_mesh_info){.n_triangles = triangles, .n_vertices = triangles / 2});
}

const vv_renderer vvi_renderer_reduced = {
    .api = VV_RENDERER_API,
    .name = "reduced",
    .label = "Reduced surface",
    .doc = "a coarser surface for navigation: Marching Cubes with four possible vertex positions on an edge, at a "
           "resolution that keeps to a number of triangles; closed where it is cut",
    .params = &vvi_reduced_class,
    .takes = VV_CONTENT_SAMPLES,
    .memory = memory_reduced,
    .accepts = vvi_surface_accepts,
    .prepare = prepare_reduced,
    .finish = vvi_surface_finish,
    .solid = vvi_surface_solid,
    .draw = vvi_surface_draw,
    .figure = vvi_surface_figure,
    .heeds = vvi_surface_heeds,
};

/* Boxes ----------------------------------------------------------------------------------------------------------- */

static const vv_property boxes_rows[] = {
    {VV_PROP(vvi_surface_params, iso), .kind = VV_KIND_F64, .unit = "value",
     .automatic = "the threshold's limits, or a valley of the histogram between the background and the object",
     .doc = "value of the surface that the boxes enclose"},
    {VV_PROP(vvi_surface_params, triangles), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = 4294967295.0,
     .def = BOX_TRIANGLES, .doc = "at most: boxes become larger until it fits; 0: no limit"},
    {VV_PROP(vvi_surface_params, memory), .kind = VV_KIND_F64, .quantity = VV_Q_BYTES, .limited = true, .min = 0,
     .max = 1e15, .doc = "memory for the triangles of each surface, at most, as in 20M; 0: no limit"},
    {VV_PROP(vvi_surface_params, merged), .kind = VV_KIND_BOOL, .def = 1,
     .doc = "merge adjacent faces into rectangles: the same picture with fewer triangles"},
    {0},
};
const vv_class vvi_boxes_class = {
    .name = "boxes",
    .doc = "parameters of boxes",
    .size = sizeof(vvi_surface_params),
    .properties = boxes_rows,
};

static vv_status boxes_within(vvi_surface_model *out, const vvi_surface_request *r, size_t triangles, vv_job *job)
{
    const vvi_surface_boxes_options o = {
        .value = r->value, .component = r->component, .max_triangles = triangles, .merged = r->params->merged};
    out->blocks = true;
    out->least = 0.5;
    out->most = 1.5;
    return vvi_surface_boxes_solid(&out->mesh, &out->samples, r->field, &o, job);
}

static vv_status make_boxes(vvi_surface_model *out, const vvi_surface_request *r, vv_job *job)
{
    return make_budget(out, r, boxes_within, job);
}

static vv_status prepare_boxes(void **state_out, const vv_scene *scene, vv_job *job)
{
    return vvi_surface_prepare(state_out, scene, "surface boxes", make_boxes, job);
}

const vv_renderer vvi_renderer_boxes = {
    .api = VV_RENDERER_API,
    .name = "boxes",
    .label = "Boxes",
    .doc = "the boxes that enclose a surface, for navigation: the outer faces of PARC's blocks of cells; closed where "
           "they are cut",
    .params = &vvi_boxes_class,
    .takes = VV_CONTENT_SAMPLES,
    .accepts = vvi_surface_accepts,
    .prepare = prepare_boxes,
    .finish = vvi_surface_finish,
    .solid = vvi_surface_solid,
    .draw = vvi_surface_draw,
    .figure = vvi_surface_figure,
    .heeds = vvi_surface_heeds,
    .can = VV_CAN_NORMALS,
};
