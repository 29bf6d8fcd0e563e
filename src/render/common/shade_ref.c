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

void vvi_shade_ref(double out[3], const vv_scene *scene, const vv_actor *actor, const double color[3], vv_vec3 position,
                   vv_vec3 gradient, vv_vec3 to_eye, double flat)
{
    vv_vec3 n = vvi_scaled(gradient, -1);
    for (int c = 0; c < 3; c++)
        out[c] = color[c];
    if (actor->shading_model == VV_SHADING_NONE)
        return;
    const bool surface = vvi_length(gradient) >= flat && vvi_unit(&n);
    const vvi_lit_point point = {.position = position,
                                 .normal = surface ? n : to_eye,
                                 .to_eye = to_eye,
                                 .surface = surface,
                                 .two_sided = actor->two_sided};
    const vvi_gloss gloss = vvi_gloss_of(actor->shading_model, actor->ambient, actor->diffuse, actor->specular,
                                         actor->shininess, scene->ambient);
    vvi_light_ref(out, &point, &gloss, scene->lamps, scene->n_lamps);
}
