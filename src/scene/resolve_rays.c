/* How rays show one volume: as the view says, but for what the volume's own `rays` say. */
#include "model/contents.h"
#include "scene/resolve.h"
#include <stdlib.h>

vv_status vvi_volume_params(vv_object **out, const vv_object *params, const vv_volume *volume)
{
    static const char *const names[] = {"mode", "iso", "threshold", "step"};
    vv_status st = VV_OK;
    *out = vv_object_retain((vv_object *)(uintptr_t)params);
    for (size_t i = 0; i < sizeof names / sizeof *names && st == VV_OK; i++) {
        char *json = NULL;
        if (!vv_object_is_set(volume->rays, names[i]) || !params || !vv_class_find(params->cls, names[i]))
            continue;
        st = vv_path_get(&json, volume->rays, names[i]);
        if (st == VV_OK)
            st = vv_path_set(out, names[i], json, NULL);
        free(json);
    }
    if (st != VV_OK) {
        vv_object_release(*out);
        *out = NULL;
    }
    return st;
}

vv_ray_value vvi_renderer_projects(const vv_renderer *renderer, const vv_object *params)
{
    return renderer && renderer->projects && params ? renderer->projects(params) : VV_PROJECTS_NOTHING;
}

bool vvi_actor_projects(const vv_scene *scene, const vv_actor *actor)
{
    return vvi_renderer_projects(scene->renderer, vv_actor_params(scene, actor)) != VV_PROJECTS_NOTHING;
}

bool vvi_scene_projects(const vv_scene *scene)
{
    for (size_t i = 0; i < scene->n_actors; i++)
        if (!vvi_actor_projects(scene, &scene->actors[i]))
            return false;
    return scene->n_actors && !scene->n_mesh_actors;
}

vv_ray_layer vvi_ray_layer_of(const vv_volume *volume)
{
    const vv_volume_rays *rays = (const vv_volume_rays *)(const void *)volume->rays;
    const vv_segmentation *segmentation = (const vv_segmentation *)(const void *)volume->segmentation;
    const vv_transfer *transfer = (const vv_transfer *)(const void *)segmentation->transfer;
    vv_ray_layer layer = {.blend = vvi_is_channel(transfer) ? VV_SLICE_ADD : VV_SLICE_OVER, .opacity = rays->opacity};
    if (vv_object_is_set(&rays->base, "blend"))
        layer.blend = rays->blend;
    return layer;
}
