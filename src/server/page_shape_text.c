/* What a page is told of a shape: where its files are, how they look, and in which light. */
#include "core/vec.h"
#include "server/page_shape_impl.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

static void tell_vector(vvi_result *out, const char *key, vv_vec3 v)
{
    vvi_result_numbers(out, key, (double[3]){v.x, v.y, v.z}, 3);
}

static void tell_floats(vvi_result *out, const char *key, const float *values, size_t n)
{
    double numbers[4];
    for (size_t i = 0; i < n; i++)
        numbers[i] = (double)values[i];
    vvi_result_numbers(out, key, numbers, n);
}

static void tell_look(vvi_result *out, const vv_actor *a, const vv_affine *place)
{
    static const char *const models[] = {"none", "phong", "blinn"};
    const vv_vec3 columns[4] = {place->axis[0], place->axis[1], place->axis[2], place->origin};
    double numbers[12];
    for (size_t i = 0; i < 12; i++)
        numbers[i] = (&columns[i / 3].x)[i % 3];
    vvi_result_numbers(out, "place", numbers, 12);
    tell_floats(out, "color", a->color, 3);
    vvi_result_string(out, "shading", models[a->shading_model]);
    tell_floats(out, "light", (float[4]){a->ambient, a->diffuse, a->specular, a->shininess}, 4);
    vvi_result_open(out, "planes", '[');
    for (size_t i = 0; i < a->n_planes; i++) {
        const vv_plane *p = &a->planes[i];
        vvi_result_numbers(out, NULL, (double[4]){p->normal.x, p->normal.y, p->normal.z, p->offset}, 4);
    }
    vvi_result_close(out, ']');
}

void vvi_shape_tell_part(vvi_result *out, const vvi_page_shape_file *file, const vv_actor *actor, double value,
                         const vv_affine *place)
{
    char url[128];
    snprintf(url, sizeof url, "/files/%" PRId64 "/%.64s", file->number, file->name);
    vvi_result_open(out, NULL, '{');
    vvi_result_string(out, "volume", actor->id);
    vvi_result_string(out, "url", url);
    vvi_result_unsigned(out, "bytes", file->n_bytes);
    vvi_result_unsigned(out, "triangles", file->n_triangles);
    vvi_result_numbers(out, "step", (double[3]){file->step[0], file->step[1], file->step[2]}, 3);
    vvi_result_number(out, "value", value);
    vvi_result_bool(out, "solid", isnan(value) ? file->closed && actor->cap && actor->n_planes > 0 : true);
    tell_look(out, actor, place);
    vvi_result_close(out, '}');
}

static bool is_on_camera(const vv_scene *scene, size_t lamp)
{
    const vv_collection *lights = scene->world->lights;
    size_t n = 0;
    for (size_t i = 0; i < lights->n; i++) {
        const vv_light *light = (const vv_light *)(const void *)lights->entry[i].object;
        if (light->on && light->kind != VV_LIGHT_AMBIENT && n++ == lamp)
            return light->frame == VV_LIGHT_ON_CAMERA;
    }
    return true; /* where there are none, those of the camera shine */
}

/* Camera axes: x right, y up, z towards the viewer. */
static vv_vec3 to_camera(const vv_lens *lens, vv_vec3 v)
{
    return vvi_vec(vvi_dot(v, lens->right), vvi_dot(v, lens->up), -vvi_dot(v, lens->forward));
}

static void tell_lamp(vvi_result *out, const vv_scene *scene, size_t i)
{
    static const char *const kinds[] = {
        [VV_LIGHT_DIRECTIONAL] = "directional", [VV_LIGHT_POINT] = "point", [VV_LIGHT_SPOT] = "spot"};
    const vv_lamp *lamp = &scene->lamps[i];
    const vv_lens *lens = &scene->lens;
    const bool camera = is_on_camera(scene, i);
    vvi_result_open(out, NULL, '{');
    vvi_result_string(out, "kind", kinds[lamp->kind]);
    vvi_result_string(out, "frame", camera ? "camera" : "world");
    tell_floats(out, "color", lamp->color, 3);
    tell_vector(out, "position", camera ? to_camera(lens, vvi_sub(lamp->position, lens->eye)) : lamp->position);
    tell_vector(out, "direction", camera ? to_camera(lens, lamp->direction) : lamp->direction);
    vvi_result_numbers(out, "cone", (double[2]){lamp->cos_outer, lamp->cos_inner}, 2);
    tell_vector(out, "falloff", lamp->falloff);
    vvi_result_close(out, '}');
}

void vvi_shape_tell_light(vvi_result *out, const vv_scene *scene)
{
    vvi_result_open(out, "lights", '[');
    for (size_t i = 0; i < scene->n_lamps; i++)
        tell_lamp(out, scene, i);
    vvi_result_close(out, ']');
    tell_floats(out, "ambient", scene->ambient, 3);
    tell_floats(out, "background", scene->background, 4);
}

void vvi_shape_tell_left_out(vvi_result *out, const vv_scene *scene)
{
    vvi_result_open(out, "left_out", '[');
    for (size_t i = 0; i < scene->n_actors; i++) {
        char text[160];
        if (scene->actors[i].classes.kind != VV_SEGMENT_LABELS)
            continue;
        snprintf(text, sizeof text, "%.64s has labels, and so no value whose surface the page could draw.",
                 scene->actors[i].id);
        vvi_result_string(out, NULL, text);
    }
    vvi_result_close(out, ']');
}
