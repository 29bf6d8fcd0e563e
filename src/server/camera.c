#include "server/camera.h"
#include "core/memory.h"
#include "core/status.h"
#include "core/units.h"
#include "model/contents.h"
#include "scene/resolve.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DEGREES (180 / M_PI)

vv_status vvi_camera_stand(vvi_stand *out, vv_world *world, const char *view, vv_job *job)
{
    vv_scene *scene = NULL;
    const vv_status st = vv_scene_resolve(&scene, world, view, job);
    if (st != VV_OK)
        return st;
    const vv_lens *lens = &scene->lens;
    const vvi_aim *aim = &((const vvi_resolved *)(const void *)scene)->aim;
    const double least = fmin(lens->half_width, lens->half_height);
    out->pose = (vvi_pose){.eye = lens->eye,
                           .turn = vvi_turn_of_axes(lens->right, lens->up, vvi_scaled(lens->forward, -1)),
                           .pivot = aim->at,
                           .parallel = lens->parallel,
                           .fov = lens->parallel ? M_PI / 6 : 2 * atan(least),
                           .height = lens->parallel ? 2 * least : 1};
    out->up = aim->up;
    out->y_up = vvi_scene_up(scene) == VV_UP_Y;
    out->anatomical = vvi_scene_space(scene) == VV_SPACE_RAS;
    vv_scene_release(scene);
    return VV_OK;
}

void vvi_camera_angles(double angles_out[2], const vvi_stand *stand)
{
    const vv_vec3 v = vvi_scaled(vvi_pose_forward(&stand->pose), -1);
    const vv_vec3 to_eye = stand->y_up ? vvi_vec(v.x, -v.z, v.y) : v; /* as if z were up */
    const double front = stand->anatomical ? 1 : -1;
    angles_out[0] = atan2(-front * to_eye.x, front * to_eye.y) * DEGREES;
    angles_out[1] = asin(fmin(fmax(to_eye.z, -1), 1)) * DEGREES;
}

/* Of the smaller side to that of the height. */
static double height_by_least(int32_t width, int32_t height)
{
    return height > width ? (double)height / width : 1;
}

static double vertical_fov(const vvi_pose *pose, int32_t width, int32_t height)
{
    return 2 * atan(tan(pose->fov / 2) * height_by_least(width, height));
}

static void tell_vector(vvi_result *out, const char *key, vv_vec3 v)
{
    vvi_result_numbers(out, key, (double[3]){v.x, v.y, v.z}, 3);
}

char *vvi_camera_json(const vvi_pose *pose, int32_t width, int32_t height)
{
    vvi_result json = {.compact = true};
    vvi_result_open(&json, NULL, '{');
    tell_vector(&json, "eye", pose->eye);
    tell_vector(&json, "at", pose->pivot);
    tell_vector(&json, "up", vvi_pose_up(pose));
    if (pose->parallel) {
        vvi_result_string(&json, "projection", "parallel");
        vvi_result_number(&json, "height", pose->height * height_by_least(width, height));
    } else {
        vvi_result_number(&json, "fov", vertical_fov(pose, width, height) * DEGREES);
    }
    vvi_result_close(&json, '}');
    return vvi_text_take(&json.text);
}

void vvi_camera_tell(vvi_result *out, const vvi_pose *pose, int32_t width, int32_t height)
{
    tell_vector(out, "eye", pose->eye);
    tell_vector(out, "at", pose->pivot);
    tell_vector(out, "up", vvi_pose_up(pose));
    vvi_result_bool(out, "parallel", pose->parallel);
    if (pose->parallel)
        vvi_result_number(out, "height", pose->height * height_by_least(width, height));
    else
        vvi_result_number(out, "fov", vertical_fov(pose, width, height) * DEGREES);
}

static vv_status set(vv_object **root, const char *view, const char *what, const char *json)
{
    char *path = vvi_asprintf("views.%s.%s", view, what);
    const vv_status st = path ? vv_path_set(root, path, json, NULL) : vv_fail_memory(64);
    free(path);
    return st;
}

vv_status vvi_camera_world(vv_world **out, const vv_world *world, const char *view, const vvi_pose *pose, int32_t width,
                           int32_t height)
{
    vv_object *root = vv_object_retain(&world->base);
    char number[16];
    vv_status st;
    *out = NULL;
    snprintf(number, sizeof number, "%d", width);
    if ((st = set(&root, view, "width", number)) == VV_OK) {
        snprintf(number, sizeof number, "%d", height);
        st = set(&root, view, "height", number);
    }
    if (st == VV_OK && pose) {
        char *camera = vvi_camera_json(pose, width, height);
        st = camera ? set(&root, view, "camera", camera) : vv_fail_memory(256);
        free(camera);
    }
    if (st == VV_OK)
        *out = (vv_world *)(void *)root;
    else
        vv_object_release(root);
    return st;
}

bool vvi_camera_is_plane(const vv_world *world, const char *view, const vv_registry *registry)
{
    const vv_view *v = vvi_view_named(world, view);
    const char *method = v ? ((const vv_render_choice *)(const void *)v->render)->method : NULL;
    for (size_t i = 0; method && registry->renderers[i]; i++)
        if (strcmp(registry->renderers[i]->name, method) == 0)
            return registry->renderers[i]->plane != NULL;
    return false;
}

vv_status vvi_camera_scale(vv_world **world, const char *view, double scale)
{
    const vv_view *v = vvi_view_named(*world, view);
    vv_object *root = &(*world)->base;
    char size[32];
    if (!v)
        return VV_OK;
    snprintf(size, sizeof size, "%.6g",
             fmax(((const vv_decorations *)(const void *)v->decorations)->size * scale, 0.1));
    const vv_status st = set(&root, view, "decorations.size", size);
    *world = (vv_world *)(void *)root;
    return st;
}

vv_status vvi_camera_quick(vv_world **world, const char *view, double scale)
{
    if (!vv_collection_find((*world)->views, view))
        return VV_OK;
    vv_object *root = &(*world)->base;
    vv_status st = set(&root, view, "render.quality", "draft");
    if (st == VV_OK)
        st = set(&root, view, "render.samples", "1");
    if (st == VV_OK)
        st = set(&root, view, "render.noise", "0");
    *world = (vv_world *)(void *)root;
    return st == VV_OK ? vvi_camera_scale(world, view, scale) : st;
}
