/* The row of Marching Cubes, and what all methods of triangles do: find the meshes, draw them. */
#include "render/surface/surface.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "gfx/mesh_look.h"
#include "grid/field.h"
#include "registry.h"
#include "surface/marching.h"
#include <math.h>
#include <string.h>

/* Which values ---------------------------------------------------------------------------------------------------- */

static const vvi_surface_params *params_of(const vv_scene *scene)
{
    return (const vvi_surface_params *)scene->params;
}

bool vvi_surface_solid(double *lo, double *hi, const vv_scene *scene, const vv_actor *actor)
{
    const vvi_surface_params *p = (const vvi_surface_params *)vv_actor_params(scene, actor);
    if (actor->classes.kind == VV_SEGMENT_LABELS)
        return false;
    const bool given = vv_object_is_set(&p->base, "iso");
    const bool threshold = !given && actor->classes.kind == VV_SEGMENT_THRESHOLD;
    *lo = given ? p->iso : threshold ? actor->classes.lo : actor->iso;
    *hi = threshold ? actor->classes.hi : INFINITY;
    return true;
}

vv_status vvi_surface_accepts(const vv_scene *scene)
{
    for (size_t i = 0; i < scene->n_actors; i++) {
        const vv_actor *actor = &scene->actors[i];
        if (actor->classes.kind == VV_SEGMENT_LABELS)
            return vv_fail(
                VV_E_UNSUPPORTED,
                "volumes.%s: method '%s' draws surfaces of values, and these are labels; use method=surface or raycast",
                actor->id, scene->renderer->name);
    }
    return VV_OK;
}

/* What a volume asks for and does not get: said, not passed over. */
static void warn(const vv_scene *scene, const vv_actor *actor, vv_job *job)
{
    const char *name = scene->renderer->name;
    if (actor->nearest && actor->classes.kind != VV_SEGMENT_LABELS)
        vvi_log(job, VV_LOG_WARNING, name, "volumes.%s.interpolation: surfaces are linear between samples, not nearest",
                actor->id);
    if (actor->cubic)
        vvi_log(job, VV_LOG_WARNING, name, "volumes.%s.interpolation: surfaces are linear between samples, not cubic",
                actor->id);
    if (actor->texture.kind != VV_TEXTURE_NONE)
        vvi_log(job, VV_LOG_WARNING, name, "volumes.%s.texture: is not drawn on triangles; method raycast draws it",
                actor->id);
    if (actor->paint.field)
        vvi_log(job, VV_LOG_WARNING, name,
                "volumes.%s.paint: is not drawn on the triangles of a volume; method raycast draws it", actor->id);
    else if (actor->colors)
        vvi_log(job, VV_LOG_WARNING, name,
                "volumes.%s: the colours of samples are not drawn on triangles; method raycast draws them", actor->id);
}

enum { SAMPLES_A_PASS = 8 };

/* What the view asks for and does not get. */
static void warn_of_samples(const vv_scene *scene, vv_job *job)
{
    const vv_render_choice *choice = (const vv_render_choice *)scene->view->render;
    const char *name = scene->renderer->name;
    if (choice->noise > 0 || choice->budget > 0)
        vvi_log(job, VV_LOG_WARNING, name,
                "noise and budget apply to rays; triangles are sampled equally often in every pixel");
}

/* Meshes ---------------------------------------------------------------------------------------------------------- */

typedef struct making {
    const vvi_surface_request *request;
    vvi_surface_make_fn *make;
} making;

static void drop_model(void *value)
{
    vvi_surface_model *model = value;
    vv_mesh_release(model->mesh);
    vv_field_release(model->samples);
    vvi_free(model);
}

uint64_t vvi_surface_bytes(const vv_mesh_info *info)
{
    return info->n_vertices * (info->normals ? 24 : 12) + info->n_triangles * 12;
}

static vv_status make_model(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const making *m = user;
    vvi_surface_model *model = vvi_alloc_zeroed(job, sizeof *model, VVI_MEM_DERIVED);
    if (!model)
        return vv_fail_memory(sizeof *model);
    const vv_status st = m->make(model, m->request, job);
    if (st != VV_OK) {
        drop_model(model);
        return st;
    }
    *value_out = model;
    *bytes_out = sizeof *model;
    if (model->mesh)
        *bytes_out += vvi_surface_bytes(vv_mesh_get_info(model->mesh));
    if (model->samples) {
        uint64_t bytes = 0;
        (void)vv_field_info_bytes(&bytes, vv_field_get_info(model->samples));
        *bytes_out += bytes;
    }
    return VV_OK;
}

/* A budget that cannot be met is told, not passed over. */
static void warn_of_triangles(const vvi_surface_request *r, const struct vvi_cached *cached, const char *name,
                              vv_job *job)
{
    const vvi_surface_model *model = cached ? vvi_cached_value(cached) : NULL;
    const int64_t most = r->params->triangles;
    const double memory = r->params->memory;
    if (model && model->mesh && memory > 0 && (double)vvi_surface_bytes(vv_mesh_get_info(model->mesh)) > memory)
        vvi_log(job, VV_LOG_WARNING, name,
                "volumes.%s: at most %.0f bytes of triangles were asked for; this method needs at least %llu",
                r->actor->id, memory, (unsigned long long)vvi_surface_bytes(vv_mesh_get_info(model->mesh)));
    if (model && model->mesh && most > 0 && vv_mesh_get_info(model->mesh)->n_triangles > (size_t)most)
        vvi_log(job, VV_LOG_WARNING, name,
                "volumes.%s: at most %lld triangles were asked for; this method makes at least %zu", r->actor->id,
                (long long)most, vv_mesh_get_info(model->mesh)->n_triangles);
}

static vv_status get_model(struct vvi_cached **out, const vvi_surface_request *r, const char *what,
                           vvi_surface_make_fn *make, vv_job *job)
{
    making m = {r, make};
    const double numbers[6] = {r->value,          r->component,      (double)r->params->triangles,
                               r->params->merged, r->params->memory, r->params->filter};
    const vvi_cache_key key = {what, vv_field_identity(r->field), vvi_hash(numbers, sizeof numbers, 0)};
    return vvi_cache_get(out, &key, make_model, drop_model, &m, job);
}

static vv_status get_labels(struct vvi_cached **out, const vvi_surface_request *r, vv_job *job)
{
    making m = {r, vvi_surface_make_labels};
    const vvi_cache_key key = {"surface labels", vv_field_identity(r->field), vvi_surface_hash_labels(r)};
    const vv_status st = vvi_cache_get(out, &key, make_model, drop_model, &m, job);
    return st == VV_OK ? st : vv_fail_in(st, "volumes.%s", r->actor->id);
}

/* Whether there may be samples on both sides of a value. The statistics leave out infinite ones. */
static bool passes(const vv_statistics *s, double value, bool upper)
{
    if (s->infinite_count)
        return isfinite(value);
    return upper ? value < s->max && value >= s->min : value > s->min && value <= s->max;
}

static vv_status open_volume(vvi_surface_volume *v, const vv_scene *scene, const char *what, vvi_surface_make_fn *make,
                             vv_job *job)
{
    const vv_actor *actor = v->actor;
    const vv_statistics *s = actor->statistics;
    vvi_surface_request r = {
        .actor = actor, .field = actor->field, .component = actor->component, .params = params_of(scene)};
    vv_status st = VV_OK;
    warn(scene, actor, job);
    v->labels = !vvi_surface_solid(&v->lo, &v->hi, scene, actor);
    if (v->labels)
        return get_labels(&v->model[0], &r, job);
    v->border = true;
    r.value = v->lo;
    if (passes(s, v->lo, false))
        st = get_model(&v->model[0], &r, what, make, job);
    warn_of_triangles(&r, v->model[0], scene->renderer->name, job);
    r.value = v->hi;
    if (st == VV_OK && passes(s, v->hi, true))
        st = get_model(&v->model[1], &r, what, make, job);
    warn_of_triangles(&r, v->model[1], scene->renderer->name, job);
    return st == VV_OK ? st : vv_fail_in(st, "volumes.%s", actor->id);
}

vv_status vvi_surface_prepare(void **state_out, const vv_scene *scene, const char *what, vvi_surface_make_fn *make,
                              vv_job *job)
{
    vv_status st = VV_OK;
    vvi_surface_state *s = vvi_alloc_zeroed(job, sizeof *s, VVI_MEM_SCRATCH);
    *state_out = NULL;
    if (!s)
        return vv_fail_memory(sizeof *s);
    s->scene = scene;
    warn_of_samples(scene, job);
    const size_t bytes = (scene->n_actors + 1) * sizeof *s->volumes;
    s->volumes = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH);
    if (!s->volumes)
        st = vv_fail_memory(bytes);
    else
        st = vvi_mesh_caps_open(&s->caps, scene, job);
    const size_t shown_bytes = (scene->n_mesh_actors + s->caps.n + 1) * sizeof *s->shown;
    if (st == VV_OK && !(s->shown = vvi_alloc_zeroed(job, shown_bytes, VVI_MEM_SCRATCH)))
        st = vv_fail_memory(shown_bytes);
    for (size_t i = 0; i < scene->n_actors && st == VV_OK; i++) {
        vvi_surface_volume *v = &s->volumes[s->n_volumes++];
        v->actor = &scene->actors[i];
        st = open_volume(v, scene, what, make, job);
    }
    if (st != VV_OK) {
        vvi_surface_finish(s);
        return st;
    }
    *state_out = s;
    return VV_OK;
}

void vvi_surface_finish(void *state)
{
    vvi_surface_state *s = state;
    if (!s)
        return;
    for (size_t i = 0; s->volumes && i < s->n_volumes; i++) {
        vvi_cache_release(s->volumes[i].model[0]);
        vvi_cache_release(s->volumes[i].model[1]);
    }
    vvi_free(s->volumes);
    vvi_mesh_caps_close(&s->caps);
    vvi_free(s->shown);
    vvi_free(s);
}

/* Drawing --------------------------------------------------------------------------------------------------------- */

vv_status vvi_surface_place(vv_affine *out, const vv_actor *actor)
{
    vv_affine inverse;
    if (!vv_affine_invert(&inverse, vv_field_get_info(actor->field)->grid.index_to_world))
        return vv_fail(VV_E_UNSUPPORTED, "volumes.%s: has no thickness", actor->id);
    *out = vv_affine_compose(actor->index_to_world, inverse);
    return VV_OK;
}

/* State of what is drawn next. */
static vv_status take_look(vvi_gfx *gfx, const vv_actor *a, uint32_t id)
{
    const vvi_gfx_material material = {.model = a->shading_model,
                                       .ambient = a->ambient,
                                       .diffuse = a->diffuse,
                                       .specular = a->specular,
                                       .shininess = a->shininess,
                                       .sides = VVI_GFX_FACING};
    vvi_gfx_set_material(gfx, &material);
    vvi_gfx_id(gfx, id);
    return vvi_gfx_cuts(gfx, a->planes, a->n_planes);
}

static vv_color color_of(const vv_actor *a, double opacity)
{
    return (vv_color){(double)a->color[0], (double)a->color[1], (double)a->color[2], opacity};
}

static vv_status draw_volume(vvi_gfx *gfx, const vvi_surface_volume *v, uint32_t id)
{
    vvi_gfx_surface surface = {.one_color = !v->labels, .color = color_of(v->actor, 1)};
    vv_status st = vvi_surface_place(&surface.place, v->actor);
    if (st == VV_OK)
        st = take_look(gfx, v->actor, id);
    for (int side = 0; side < 2 && st == VV_OK; side++) {
        const vvi_surface_model *model = v->model[side] ? vvi_cached_value(v->model[side]) : NULL;
        if (!model || !model->mesh)
            continue;
        surface.mesh = vv_mesh_get_info(model->mesh);
        if (surface.mesh->n_triangles)
            st = vvi_gfx_mesh(gfx, &surface);
    }
    return st;
}

/* With colours by value in the place of the mesh's own; `shown` lives as long as the picture. */
static vv_status draw_shape(vvi_gfx *gfx, vv_mesh_info *shown, const vv_mesh_actor *shape, uint32_t id)
{
    const vvi_gfx_surface surface = vvi_gfx_surface_of(shown, shape);
    const vv_status st = take_look(gfx, &shape->look, id);
    return st == VV_OK && shown->n_triangles ? vvi_gfx_mesh(gfx, &surface) : st;
}

static vv_status draw_shapes(vvi_gfx *gfx, const vvi_surface_state *s)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < s->scene->n_mesh_actors && st == VV_OK; i++)
        st = draw_shape(gfx, &s->shown[i], &s->scene->mesh_actors[i], (uint32_t)(s->scene->n_actors + i + 1));
    for (size_t i = 0; i < s->caps.n && st == VV_OK; i++)
        st = draw_shape(gfx, &s->shown[s->scene->n_mesh_actors + i], &s->caps.cap[i].actor,
                        (uint32_t)(s->scene->n_actors + s->caps.cap[i].owner + 1));
    return st;
}

static vv_status draw_all(vvi_gfx *gfx, const vvi_surface_state *s)
{
    vvi_gfx_camera(gfx, &s->scene->lens);
    vv_status st = vvi_gfx_lights(gfx, s->scene->lamps, s->scene->n_lamps, s->scene->ambient);
    for (size_t i = 0; i < s->n_volumes && st == VV_OK; i++)
        st = draw_volume(gfx, &s->volumes[i], (uint32_t)i + 1);
    return st == VV_OK ? draw_shapes(gfx, s) : st;
}

/* Places of a later pass: other rows of the pattern; from the ninth pass on other places in its 64 parts of a pixel,
 * along the sequence R2 (Roberts 2018). */
static vv_status draw_pass(vv_image *image, const vvi_surface_state *s, int samples, int64_t pass, vv_job *job)
{
    const int64_t round = pass / 8;
    vvi_gfx_target target = {.image = image, .samples = samples, .turn = (int)(pass % 8)};
    vvi_gfx *gfx = NULL;
    if (round) {
        target.shift[0] = (fmod(0.5 + 0.7548776662466927 * (double)round, 1) - 0.5) / 8;
        target.shift[1] = (fmod(0.5 + 0.5698402909980532 * (double)round, 1) - 0.5) / 8;
    }
    vv_status st = vvi_gfx_begin(&gfx, &vvi_gfx_software, &target, job);
    if (st == VV_OK && (st = draw_all(gfx, s)) == VV_OK)
        return vvi_gfx_end(gfx);
    vvi_gfx_abandon(gfx);
    return st;
}

/* The mean of many passes in the image, whose other layers are the first one's. */
typedef struct many {
    vv_image *image, *pass, *caps;
    double *sum;
} many;

static vv_status begin_many(many *m, vv_image *image, vv_job *job)
{
    const size_t n = 4 * (size_t)image->width * (size_t)image->height;
    vv_status st = vv_image_new(&m->caps, image->width, image->height, VV_LAYER_DEPTH, job);
    if (st == VV_OK)
        st = vv_image_new(&m->pass, image->width, image->height, VV_LAYER_DEPTH, job);
    if (st == VV_OK && !(m->sum = vvi_alloc_zeroed(job, n * sizeof *m->sum, VVI_MEM_SCRATCH)))
        st = vv_fail_memory(n * sizeof *m->sum);
    if (st != VV_OK)
        return st;
    m->image = image;
    memcpy(m->caps->rgba, image->rgba, n * sizeof(float));
    if (image->depth)
        memcpy(m->caps->depth, image->depth, n / 4 * sizeof(float));
    return VV_OK;
}

static void add_to_sum(many *m, const vv_image *image)
{
    const size_t n = 4 * (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < n; i++)
        m->sum[i] += (double)image->rgba[i];
}

static vv_status draw_many(vv_image *image, const vvi_surface_state *s, int64_t passes, vv_job *job)
{
    const size_t n = 4 * (size_t)image->width * (size_t)image->height;
    many m = {.image = NULL};
    vv_status st = begin_many(&m, image, job);
    if (st == VV_OK && (st = draw_pass(image, s, SAMPLES_A_PASS, 0, job)) == VV_OK)
        add_to_sum(&m, image);
    for (int64_t pass = 1; pass < passes && st == VV_OK; pass++) {
        memcpy(m.pass->rgba, m.caps->rgba, n * sizeof(float));
        memcpy(m.pass->depth, m.caps->depth, n / 4 * sizeof(float));
        if ((st = draw_pass(m.pass, s, SAMPLES_A_PASS, pass, job)) == VV_OK)
            add_to_sum(&m, m.pass);
    }
    for (size_t i = 0; i < n && st == VV_OK; i++)
        image->rgba[i] = (float)(m.sum[i] / (double)passes);
    vv_image_release(m.caps);
    vv_image_release(m.pass);
    vvi_free(m.sum);
    return st;
}

/* Noise and time do not end a picture of triangles: what was not asked for by number is one pass. */
static int64_t passes_for(const vv_scene *scene, int64_t samples)
{
    const vv_render_choice *choice = (const vv_render_choice *)scene->view->render;
    const bool counted = vv_object_is_set(&choice->base, "samples") || !(choice->noise > 0 || choice->budget > 0);
    return counted ? (samples + SAMPLES_A_PASS - 1) / SAMPLES_A_PASS : 1;
}

vv_status vvi_surface_draw(void *state, vv_image *image, int64_t samples, int64_t *samples_out,
                           vv_render_counts *counts, vv_job *job)
{
    const vvi_surface_state *s = state;
    const int each = samples > 4 ? SAMPLES_A_PASS : samples > 1 ? 4 : 1;
    const int64_t passes = passes_for(s->scene, samples);
    const double side = ceil(sqrt((double)(passes * each)));
    *samples_out = passes * each;
    counts->rays = (uint64_t)image->width * (uint64_t)image->height * (uint64_t)*samples_out;
    const vv_status st = vvi_surface_caps(image, s, side < 8 ? (int)side : 8, job);
    if (st != VV_OK)
        return st;
    return passes > 1 ? draw_many(image, s, passes, job) : draw_pass(image, s, each, 0, job);
}

vv_status vvi_surface_figure(void *state, vvi_gfx *gfx, vv_image *under, vv_job *job)
{
    const vvi_surface_state *s = state;
    const vv_status st = vvi_surface_caps(under, s, 3, job);
    return st == VV_OK ? draw_all(gfx, s) : st;
}

/* The row --------------------------------------------------------------------------------------------------------- */

static const vv_property properties[] = {
    {VV_PROP(vvi_surface_params, iso), .kind = VV_KIND_F64, .unit = "value",
     .automatic = "the threshold's limits, or a valley of the histogram between the background and the object",
     .doc = "value of the surface"},
    {VV_PROP(vvi_surface_params, smoothing), .kind = VV_KIND_F64, .unit = "voxels", .limited = true, .min = 0, .max = 8,
     .def = 1, .doc = "for labels: how far their borders are smoothed; 0: not at all, as steps"},
    {0},
};
const vv_class vvi_surface_class = {
    .name = "surface",
    .doc = "parameters of surface",
    .size = sizeof(vvi_surface_params),
    .properties = properties,
};

static vv_status make_surface(vvi_surface_model *out, const vvi_surface_request *r, vv_job *job)
{
    const vvi_marching_options o = {.value = r->value, .component = r->component};
    return vvi_marching_cubes(&out->mesh, r->field, &o, job);
}

static vv_status prepare(void **state_out, const vv_scene *scene, vv_job *job)
{
    return vvi_surface_prepare(state_out, scene, "surface", make_surface, job);
}

bool vvi_surface_heeds(const vv_object *params, vv_aspect aspect)
{
    (void)params;
    return aspect == VV_ASPECT_THRESHOLD || aspect == VV_ASPECT_SHADING || aspect == VV_ASPECT_CUTS ||
           aspect == VV_ASPECT_DIRECTION || aspect == VV_ASPECT_COLOR;
}

/* A surface crosses some times as many cells as a face of the volume has: two dozen in a head. */
static uint64_t memory(const vv_object *params, const vv_volume *volume, const vv_field_info *info)
{
    const double n = (double)info->grid.dims[0] * (double)info->grid.dims[1] * (double)info->grid.dims[2];
    const size_t triangles = (size_t)(24 * cbrt(n) * cbrt(n));
    (void)params;
    (void)volume;
    return vvi_surface_bytes(&(vv_mesh_info){.n_triangles = triangles, .n_vertices = triangles / 2});
}

const vv_renderer vvi_renderer_surface = {
    .api = VV_RENDERER_API,
    .name = "surface",
    .label = "Surface",
    .doc = "Marching Cubes triangles at full resolution, computed once and drawn from any side: the surface of a "
           "value, closed where it is cut, or smooth surfaces of labels; and meshes from files",
    .params = &vvi_surface_class,
    .takes = VV_CONTENT_SAMPLES | VV_CONTENT_MESHES,
    .best_for = VV_CONTENT_MESHES,
    .memory = memory,
    .prepare = prepare,
    .finish = vvi_surface_finish,
    .solid = vvi_surface_solid,
    .draw = vvi_surface_draw,
    .figure = vvi_surface_figure,
    .heeds = vvi_surface_heeds,
};
