/* From a World and the name of a view to a scene that a renderer can draw. */
#include "scene/resolve.h"
#include "core/job.h"
#include "core/memory.h"
#include "model/contents.h"
#include "scene/lights.h"
#include "scene/visible_mesh.h"
#include "scene/visible_volume.h"
#include <stdio.h>
#include <string.h>
#include <time.h>

double vvi_render_clock(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static vv_status find_view(vvi_resolved *r, const char *id)
{
    const vv_collection *views = r->scene.world->views;
    if (!views->n)
        return vv_fail_at(VV_E_NOT_FOUND, NULL, "views", "the World has no view to render; add one");
    for (size_t i = 0; i < views->n; i++) {
        if (id && strcmp(views->entry[i].id, id) != 0)
            continue;
        r->view_id = views->entry[i].id;
        r->scene.view = (const vv_view *)views->entry[i].object;
        return VV_OK;
    }
    return vv_fail_at(VV_E_NOT_FOUND, NULL, "views", "there is no view '%s'; the first of %zu is '%s'", id, views->n,
                      views->entry[0].id);
}

unsigned vvi_contents_of(const vv_world *world, vv_job *job)
{
    unsigned contents = 0;
    for (size_t i = 0; i < world->volumes->n; i++) {
        const vv_volume *volume = vvi_volume_nth(world, i);
        if (volume->visible)
            contents |= vvi_volume_is_mesh(world, volume, job) ? VV_CONTENT_MESHES : VV_CONTENT_SAMPLES;
    }
    return contents;
}

const char *vvi_method_of(const vv_world *world, const vv_view *view, vv_job *job)
{
    const vv_render_choice *choice = (const vv_render_choice *)view->render;
    return choice->method ? choice->method
                          : vv_registry_renderer_for(vvi_job_registry(job), vvi_contents_of(world, job))->name;
}

static vv_status find_renderer(vvi_resolved *r, vv_job *job)
{
    const vv_render_choice *choice = (const vv_render_choice *)r->scene.view->render;
    const char *method = vvi_method_of(r->scene.world, r->scene.view, job);
    r->scene.renderer = vv_registry_renderer(r->registry, method);
    if (!r->scene.renderer)
        return vv_fail_in(vv_error_last()->status, "views.%s.render.method", r->view_id);
    r->scene.params = vv_collection_find(choice->methods, method);
    r->scene.quality = choice->quality;
    if (!r->scene.params && r->scene.renderer->params) /* a World made with another registry */
        return vv_fail_at(VV_E_UNSUPPORTED, NULL, "views", "the World was made without the parameters of '%s'", method);
    return VV_OK;
}

static unsigned resolve_layers(const vv_render_choice *choice)
{
    const vv_layer_choice *layers = (const vv_layer_choice *)choice->layers;
    return VV_LAYER_DEPTH | (layers->normal ? VV_LAYER_NORMAL : 0u) | (layers->id ? VV_LAYER_ID : 0u) |
           (layers->samples ? VV_LAYER_SAMPLES : 0u) | (layers->value ? VV_LAYER_VALUE : 0u);
}

/* Whether light through clouds is all there is to see: nothing has a sharp edge. */
static bool shows_clouds(const vv_scene *scene)
{
    const vv_renderer *renderer = scene->renderer;
    bool clouds = renderer->heeds && scene->params;
    if (clouds && !scene->n_actors)
        clouds = renderer->heeds(scene->params, VV_ASPECT_OPACITY);
    for (size_t i = 0; i < scene->n_actors && clouds; i++) {
        const vv_actor *actor = &scene->actors[i];
        clouds = actor->classes.kind == VV_SEGMENT_TRANSFER &&
                 renderer->heeds(vv_actor_params(scene, actor), VV_ASPECT_OPACITY);
    }
    return clouds && !renderer->draw && !scene->n_mesh_actors;
}

/* Surfaces have sharp edges, and more rays cost them little; what layers and slices say of a pixel is true of its
 * middle alone. */
void vvi_resolve_sampling(vv_scene *scene)
{
    const vv_render_choice *choice = (const vv_render_choice *)scene->view->render;
    static const int64_t clouds[] = {
        [VV_QUALITY_DRAFT] = 1, [VV_QUALITY_NORMAL] = 2, [VV_QUALITY_HIGH] = 4, [VV_QUALITY_REFERENCE] = 16};
    static const int64_t surfaces[] = {
        [VV_QUALITY_DRAFT] = 1, [VV_QUALITY_NORMAL] = 4, [VV_QUALITY_HIGH] = 8, [VV_QUALITY_REFERENCE] = 16};
    static const int64_t exact[] = {
        [VV_QUALITY_DRAFT] = 1, [VV_QUALITY_NORMAL] = 1, [VV_QUALITY_HIGH] = 4, [VV_QUALITY_REFERENCE] = 16};
    const unsigned layers = resolve_layers(choice);
    scene->layers |= layers;
    const int64_t *by_quality = layers != VV_LAYER_DEPTH || scene->renderer->plane ? exact
                                : shows_clouds(scene)                              ? clouds
                                                                                   : surfaces;
    const bool open = choice->noise > 0 || choice->budget > 0;
    const bool said = vv_object_is_set(&choice->base, "adaptive");
    scene->samples = vv_object_is_set(&choice->base, "samples") ? choice->samples
                     : open                                     ? 1024
                     : said && choice->adaptive                 ? 1
                                                                : by_quality[choice->quality];
    scene->noise = choice->noise;
    scene->budget_s = choice->budget;
    const bool wanted = said ? choice->adaptive : choice->quality == VV_QUALITY_DRAFT;
    scene->adaptive = wanted && scene->samples == 1 && layers == VV_LAYER_DEPTH && !scene->renderer->plane;
}

static vv_status resolve_actors(vvi_resolved *r, vv_job *job)
{
    const vv_collection *volumes = r->scene.world->volumes;
    const vv_renderer *renderer = r->scene.renderer;
    vv_status st = VV_OK;
    if (!volumes->n)
        return VV_OK;
    const size_t bytes = volumes->n * sizeof *r->scene.actors, shape_bytes = volumes->n * sizeof *r->scene.mesh_actors;
    r->scene.actors = vvi_alloc_zeroed(job, bytes, VVI_MEM_MODEL);
    r->scene.mesh_actors = vvi_alloc_zeroed(job, shape_bytes, VVI_MEM_MODEL);
    if (!r->scene.actors || !r->scene.mesh_actors)
        return vv_fail_memory(bytes + shape_bytes);
    for (size_t i = 0; i < volumes->n && st == VV_OK; i++) {
        const vv_volume *volume = vvi_volume_nth(r->scene.world, i);
        const char *id = volumes->entry[i].id;
        if (!volume->visible)
            continue;
        if (vvi_volume_is_mesh(r->scene.world, volume, job))
            st = vvi_resolve_mesh_actor(&r->scene.mesh_actors[r->scene.n_mesh_actors++], &r->load_s, r->scene.world, id,
                                        volume, job);
        else
            st = vvi_resolve_actor(&r->scene.actors[r->scene.n_actors++], &r->load_s, r->scene.world, id, volume,
                                   renderer, r->scene.params, job);
    }
    if (st == VV_OK && !renderer->plane)
        vvi_veil_amounts(&r->scene, job);
    if (st == VV_OK)
        st = vvi_tell_actors_apart(&r->scene, job);
    for (size_t i = 0; i < r->scene.n_actors && st == VV_OK; i++)
        vvi_resolve_slices(&r->scene, i);
    if (r->scene.n_mesh_actors && r->scene.layers & (VV_LAYER_NORMAL | VV_LAYER_VALUE))
        r->scene.layers |= VV_LAYER_ID; /* tells which pixels are of samples */
    return st;
}

vv_space vvi_scene_space(const vv_scene *scene)
{
    return scene->n_actors        ? vv_field_get_info(scene->actors[0].field)->grid.space
           : scene->n_mesh_actors ? vv_mesh_get_info(scene->mesh_actors[0].mesh)->space
                                  : VV_SPACE_PLAIN;
}

vv_up vvi_scene_up(const vv_scene *scene)
{
    if (vv_object_is_set(&scene->world->base, "up"))
        return (vv_up)scene->world->up;
    return !scene->n_actors && scene->n_mesh_actors ? vv_mesh_get_info(scene->mesh_actors[0].mesh)->up : VV_UP_Z;
}

/* The World's; else a sample, so that slices show samples and no means of two. */
static vv_vec3 cross_hair_of(const vv_scene *scene, const vvi_fit *fit)
{
    if (vv_object_is_set(&scene->world->base, "cross_hair"))
        return scene->world->cross_hair;
    if (!scene->n_actors)
        return vvi_fit_middle(fit);
    const int64_t *n = vv_field_get_info(scene->actors[0].field)->grid.dims;
    const int64_t at[3] = {n[0] / 2, n[1] / 2, n[2] / 2}; /* a sample */
    const vv_vec3 index = {(double)at[0], (double)at[1], (double)at[2]};
    return vv_affine_point(scene->actors[0].index_to_world, index);
}

/* Whether some of it follows from what there is to see. */
static bool fits_visible(const vv_camera *camera)
{
    const bool placed = vv_object_is_set(&camera->base, "eye") && vv_object_is_set(&camera->base, "at");
    return camera->fit == VV_FIT_VISIBLE && !placed;
}

enum { BOX = 8 };

static vv_status gather_shape(vv_vec3 *out, size_t *n_out, const vv_mesh_actor *shape, bool visible, vv_job *job)
{
    if (!visible)
        vvi_shape_corners(out + *n_out, shape);
    const vv_status st = visible ? vvi_visible_mesh_points(out + *n_out, shape, job) : VV_OK;
    *n_out += visible ? VVI_SHAPE_POINTS : BOX;
    return st;
}

/* Boxes that are drawn are in the picture too: of each volume and mesh, and with axes around everything. */
static void gather_boxes(vv_vec3 *out, size_t *n_out, const vv_scene *scene)
{
    const vv_decorations *wanted = (const vv_decorations *)(const void *)scene->view->decorations;
    const size_t begin = *n_out;
    if (!wanted->box && !wanted->cut_planes && !wanted->axes)
        return;
    for (size_t i = 0; i < scene->n_mesh_actors; i++, *n_out += BOX)
        vvi_shape_corners(out + *n_out, &scene->mesh_actors[i]);
    for (size_t i = 0; i < scene->n_actors; i++, *n_out += BOX)
        vvi_actor_corners(out + *n_out, &scene->actors[i]);
    vv_vec3 lo, hi;
    if (!wanted->axes || !vvi_fit_box(&lo, &hi, &(vvi_fit){.corner = out + begin, .n_corners = *n_out - begin}))
        return;
    for (int k = 0; k < BOX; k++)
        out[(*n_out)++] = vvi_vec(k & 1 ? hi.x : lo.x, k & 2 ? hi.y : lo.y, k & 4 ? hi.z : lo.z);
}

/* What is seen of each volume and mesh is in the picture; in slices, all of it. */
static vv_status gather(vv_vec3 *out, size_t *n_out, const vvi_resolved *r, bool visible, vv_job *job)
{
    const vv_scene *scene = &r->scene;
    vv_status st = VV_OK;
    *n_out = 0;
    for (size_t i = 0; i < scene->n_mesh_actors && st == VV_OK; i++)
        st = gather_shape(out, n_out, &scene->mesh_actors[i], visible, job);
    for (size_t i = 0; i < scene->n_actors && st == VV_OK; i++) {
        const vv_actor *actor = &scene->actors[i];
        if (!visible) {
            vvi_actor_corners(out + *n_out, actor);
            *n_out += BOX;
            continue;
        }
        st = vvi_visible_points(out + *n_out, scene, actor, job);
        for (size_t p = 0; p < VVI_VISIBLE_POINTS; p++, ++*n_out)
            out[*n_out] = vv_affine_point(actor->index_to_world, out[*n_out]);
    }
    return st;
}

/* Of half the picture on each side: room for the numbers at axes, which stand outside the box. */
static double margin_of(const vv_scene *scene)
{
    const vv_decorations *wanted = (const vv_decorations *)(const void *)scene->view->decorations;
    return wanted->axes ? 0.16 : VVI_FIT_MARGIN;
}

static vv_status resolve_camera(vvi_resolved *r, vv_job *job)
{
    vv_scene *scene = &r->scene;
    const vv_camera *camera = (const vv_camera *)scene->view->camera;
    const size_t most =
        ((VVI_VISIBLE_POINTS + BOX) * scene->n_actors + (VVI_SHAPE_POINTS + BOX) * scene->n_mesh_actors + BOX) *
        sizeof(vv_vec3);
    vvi_fit fit = {.space = vvi_scene_space(scene), .up = vvi_scene_up(scene)};
    vv_vec3 right, up;
    char path[256];
    vv_vec3 *points = vvi_alloc(job, most, VVI_MEM_SCRATCH);
    if (!points)
        return vv_fail_memory(most);
    fit.corner = points;
    r->planar = scene->renderer->plane && scene->renderer->plane(&right, &up, scene);
    fit.margin = r->planar ? VVI_FIT_MARGIN : margin_of(scene);
    fit.centred = !r->planar && fits_visible(camera);
    vv_status st = gather(points, &fit.n_corners, r, fit.centred, job);
    if (st == VV_OK) {
        if (!r->planar)
            gather_boxes(points, &fit.n_corners, scene);
        snprintf(path, sizeof path, "views.%s.camera", r->view_id);
        scene->cross_hair = cross_hair_of(scene, &fit);
        st = r->planar
                 ? vvi_aim_plane(&r->aim, camera, scene->width, scene->height, &fit, right, up, scene->cross_hair, path)
                 : vvi_aim_camera(&r->aim, camera, scene->width, scene->height, &fit, path);
        scene->lens = r->aim.lens;
    }
    vvi_free(points);
    return st;
}

static vv_status resolve_light(vvi_resolved *r, vv_job *job)
{
    vv_scene *scene = &r->scene;
    const size_t bytes = vvi_lamps_room(scene->world) * sizeof *scene->lamps;
    const vv_color back = scene->world->background;
    scene->lamps = vvi_alloc(job, bytes, VVI_MEM_MODEL);
    if (!scene->lamps)
        return vv_fail_memory(bytes);
    scene->background[0] = (float)(back.r * back.a);
    scene->background[1] = (float)(back.g * back.a);
    scene->background[2] = (float)(back.b * back.a);
    scene->background[3] = (float)back.a;
    return vvi_resolve_lights(scene->lamps, &scene->n_lamps, scene->ambient, scene->world, &scene->lens);
}

vv_status vv_scene_resolve(vv_scene **out, vv_world *world, const char *view_id, vv_job *job)
{
    vv_status st = VV_OK;
    *out = NULL;
    vvi_resolved *r = vvi_alloc_zeroed(job, sizeof *r, VVI_MEM_MODEL);
    if (!r)
        return vv_fail_memory(sizeof *r);
    r->registry = vvi_job_registry(job);
    r->scene.world = (vv_world *)vv_object_retain(&world->base);
    r->scene.seed = (uint64_t)world->seed;
    if ((st = find_view(r, view_id)) != VV_OK || (st = find_renderer(r, job)) != VV_OK)
        goto fail;
    r->scene.width = (int32_t)r->scene.view->width;
    r->scene.height = r->scene.rows = (int32_t)r->scene.view->height;
    r->scene.layers = resolve_layers((const vv_render_choice *)r->scene.view->render);
    if ((st = resolve_actors(r, job)) != VV_OK)
        goto fail;
    vvi_resolve_sampling(&r->scene);
    if ((st = resolve_camera(r, job)) != VV_OK || (st = resolve_light(r, job)) != VV_OK)
        goto fail;
    *out = &r->scene;
    return VV_OK;
fail:
    vv_scene_release(&r->scene);
    return st;
}

void vv_scene_release(vv_scene *scene)
{
    if (!scene)
        return;
    for (size_t i = 0; i < scene->n_actors; i++)
        vvi_actor_finish(&scene->actors[i]);
    vvi_free(scene->actors);
    for (size_t i = 0; i < scene->n_mesh_actors; i++)
        vvi_shape_finish(&scene->mesh_actors[i]);
    vvi_free(scene->mesh_actors);
    vvi_free(scene->lamps);
    vv_object_release(&scene->world->base);
    vvi_free(scene);
}
