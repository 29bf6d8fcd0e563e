#include "render/common/shade_ref.h"
#include "render/common/lens.h"
#include <math.h>

double vvi_shade_flat(const vv_actor *actor)
{
    double voxel = INFINITY;
    for (int i = 0; i < 3; i++)
        voxel = fmin(voxel, vvi_length(actor->index_to_world.axis[i]));
    return 1e-6 * (actor->statistics->max - actor->statistics->min) / voxel;
}

/* Hermite between the edges of the cone, so that the rim has no line. */
static double cone(const vv_lamp *lamp, vv_vec3 to_lamp)
{
    const double c = -vvi_dot(to_lamp, lamp->direction);
    if (c <= lamp->cos_outer)
        return 0;
    if (c >= lamp->cos_inner)
        return 1;
    const double t = (c - lamp->cos_outer) / (lamp->cos_inner - lamp->cos_outer);
    return t * t * (3 - 2 * t);
}

void vvi_lamp_at(vv_vec3 *to_lamp, double light[3], const vv_lamp *lamp, vv_vec3 position)
{
    double share = 1;
    if (lamp->kind == VV_LIGHT_DIRECTIONAL) {
        *to_lamp = vvi_scaled(lamp->direction, -1);
    } else {
        *to_lamp = vvi_sub(lamp->position, position);
        const double d = vvi_length(*to_lamp);
        *to_lamp = d > 0 ? vvi_scaled(*to_lamp, 1 / d) : vvi_vec(0, 0, 1);
        share = 1 / (lamp->falloff.x + d * (lamp->falloff.y + d * lamp->falloff.z));
        if (lamp->kind == VV_LIGHT_SPOT)
            share *= cone(lamp, *to_lamp);
    }
    for (int c = 0; c < 3; c++)
        light[c] = share * lamp->color[c];
}

static double highlight(const vv_actor *actor, vv_vec3 n, vv_vec3 l, vv_vec3 v, double n_l)
{
    double s = 0;
    if (actor->shading_model == VV_SHADING_PHONG) {
        s = vvi_dot(vvi_sub(vvi_scaled(n, 2 * n_l), l), v);
    } else {
        vv_vec3 h = vvi_add(l, v);
        if (!vvi_unit(&h))
            return 0;
        s = vvi_dot(n, h) * (n_l < 0 ? -1 : 1);
    }
    return s > 0 ? pow(s, actor->shininess) : 0;
}

void vvi_shade_ref(double out[3], const vv_scene *scene, const vv_actor *actor, const double color[3], vv_vec3 position,
                   vv_vec3 gradient, vv_vec3 to_eye, double flat)
{
    vv_vec3 n = vvi_scaled(gradient, -1);
    double diffuse[3] = {0}, specular[3] = {0};
    if (actor->shading_model == VV_SHADING_NONE) {
        for (int c = 0; c < 3; c++)
            out[c] = color[c];
        return;
    }
    const bool surface = vvi_length(gradient) >= flat && vvi_unit(&n);
    if (!surface)
        n = to_eye;
    for (size_t i = 0; i < scene->n_lamps; i++) {
        vv_vec3 l;
        double light[3];
        vvi_lamp_at(&l, light, &scene->lamps[i], position);
        const double n_l = vvi_dot(n, l);
        if (!actor->two_sided && n_l <= 0)
            continue;
        const double s = surface ? highlight(actor, n, l, to_eye, n_l) : 0;
        for (int c = 0; c < 3; c++) {
            diffuse[c] += light[c] * fabs(n_l);
            specular[c] += light[c] * s;
        }
    }
    for (int c = 0; c < 3; c++)
        out[c] = color[c] * (actor->ambient * scene->ambient[c] + actor->diffuse * diffuse[c]) +
                 actor->specular * specular[c];
}
