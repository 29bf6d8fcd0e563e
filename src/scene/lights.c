#include "scene/lights.h"
#include "scene/lens.h"
#include <math.h>
#include <stdio.h>

/* A key from the upper left and a weak fill from the right: shape without black shadows. Both go with the camera, so
 * that every view of a turning object is lit. The same two stand in the default World. */
static const vvi_default_light defaults[] = {
    {"key", {0.5, -0.6, -0.8}, 0.9},
    {"fill", {-0.8, 0.1, -0.6}, 0.3},
};
#define N_DEFAULTS (sizeof defaults / sizeof defaults[0])

const vvi_default_light *vvi_default_light_nth(size_t index)
{
    return index < N_DEFAULTS ? &defaults[index] : NULL;
}

size_t vvi_lamps_room(const vv_world *world)
{
    return world->lights->n > N_DEFAULTS ? world->lights->n : N_DEFAULTS;
}

/* Camera axes: x right, y up, z towards the viewer. */
static vv_vec3 from_camera(const vv_lens *lens, vv_vec3 v)
{
    return vvi_add(vvi_add(vvi_scaled(lens->right, v.x), vvi_scaled(lens->up, v.y)), vvi_scaled(lens->forward, -v.z));
}

static void add_defaults(vv_lamp *lamps, const vv_lens *lens)
{
    for (size_t i = 0; i < N_DEFAULTS; i++) {
        const float power = (float)defaults[i].intensity;
        lamps[i] = (vv_lamp){.kind = VV_LIGHT_DIRECTIONAL, .color = {power, power, power}, .falloff = {1, 0, 0}};
        lamps[i].direction = from_camera(lens, defaults[i].direction);
        vvi_unit(&lamps[i].direction);
    }
}

static vv_status fail(const char *id, const char *property, const char *text)
{
    char where[256];
    snprintf(where, sizeof where, "lights.%s.%s", id, property);
    return vv_fail_at(VV_E_ARGUMENT, NULL, where, "%s", text);
}

static vv_status resolve_one(vv_lamp *lamp, const vv_light *light, const char *id, const vv_lens *lens)
{
    const bool camera = light->frame == VV_LIGHT_ON_CAMERA;
    *lamp = (vv_lamp){.kind = light->kind, .falloff = light->falloff};
    lamp->color[0] = (float)(light->color.r * light->intensity);
    lamp->color[1] = (float)(light->color.g * light->intensity);
    lamp->color[2] = (float)(light->color.b * light->intensity);
    lamp->position = camera ? vvi_add(lens->eye, from_camera(lens, light->position)) : light->position;
    lamp->direction = camera ? from_camera(lens, light->direction) : light->direction;
    lamp->cos_outer = cos(light->cone / 2);
    lamp->cos_inner = cos(light->cone / 2 * (1 - light->softness));
    if (light->kind != VV_LIGHT_POINT && !vvi_unit(&lamp->direction))
        return fail(id, "direction",
                    "has no length; give the direction in which the light travels, such as [0, 0, -1]");
    const vv_vec3 f = light->falloff;
    if (light->kind != VV_LIGHT_DIRECTIONAL && !(f.x >= 0 && f.y >= 0 && f.z >= 0 && f.x + f.y + f.z > 0))
        return fail(id, "falloff", "must not have negative numbers or be all 0");
    return VV_OK;
}

vv_status vvi_resolve_lights(vv_lamp *lamps, size_t *n_out, float ambient[3], const vv_world *world,
                             const vv_lens *lens)
{
    double sum[3] = {world->ambient.r, world->ambient.g, world->ambient.b};
    vv_status st = VV_OK;
    *n_out = 0;
    if (!world->lights->n) {
        add_defaults(lamps, lens);
        *n_out = N_DEFAULTS;
    }
    for (size_t i = 0; i < world->lights->n; i++) {
        const vv_light *light = (const vv_light *)world->lights->entry[i].object;
        if (!light->on)
            continue;
        if (light->kind == VV_LIGHT_AMBIENT) {
            sum[0] += light->color.r * light->intensity;
            sum[1] += light->color.g * light->intensity;
            sum[2] += light->color.b * light->intensity;
        } else if ((st = resolve_one(&lamps[(*n_out)++], light, world->lights->entry[i].id, lens)) != VV_OK) {
            return st;
        }
    }
    for (int c = 0; c < 3; c++)
        ambient[c] = (float)sum[c];
    return VV_OK;
}
