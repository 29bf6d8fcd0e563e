#include "render/common/shade_ref.h"
#include "grid/lattice.h"
#include "scene/lens.h"
#include "scene/transfer.h"
#include <math.h>

static bool inside(double value, const vv_statistics *s)
{
    return value > s->min && value < s->max;
}

/* A threshold's ends that lie in the data count as nodes do. */
static bool find_ends(double *first, double *last, const vv_actor *actor)
{
    const vv_classification *c = &actor->classes;
    const vv_statistics *s = actor->statistics;
    if (!vvi_transfer_nodes(first, last, c))
        return false;
    if (c->kind == VV_SEGMENT_THRESHOLD) {
        const bool low = inside(*first, s), high = inside(*last, s);
        *first = low ? *first : *last;
        *last = high ? *last : *first;
        return low || high;
    }
    *first = fmin(fmax(*first, s->min), s->max);
    *last = fmin(fmax(*last, s->min), s->max);
    return true;
}

double vvi_shade_range(const vv_actor *actor)
{
    const vv_statistics *s = actor->statistics;
    const double all = s->max - s->min;
    double first, last;
    if (actor->cubic || actor->classes.kind == VV_SEGMENT_LABELS || !find_ends(&first, &last, actor))
        return all;
    const double zero = vvi_lattice_zero(vv_field_get_info(actor->field), s);
    const double most = fmax(last - first, fmax(fabs(first - zero), fabs(last - zero)));
    return most > 0 ? fmin(most, all) : all;
}

double vvi_shade_flat(const vv_actor *actor)
{
    double voxel = INFINITY;
    for (int i = 0; i < 3; i++)
        voxel = fmin(voxel, vvi_length(actor->index_to_world.axis[i]));
    return 1e-6 * vvi_shade_range(actor) / voxel;
}

void vvi_shade_ref(double out[3], const vv_scene *scene, const vv_actor *actor, const double color[3], vv_vec3 position,
                   vv_vec3 gradient, vv_vec3 to_eye, double flat, const vvi_light_volume *volume)
{
    vv_vec3 n = vvi_scaled(gradient, -1);
    double arrives[VVI_LIGHT_SHARES];
    const bool surface = vvi_length(gradient) >= flat && vvi_unit(&n);
    const vv_vec3 seen = vvi_scaled(n, !surface ? 0 : vvi_dot(n, to_eye) < 0 ? -1 : 1);
    const bool unlit = actor->shading_model == VV_SHADING_NONE;
    const double left = unlit && volume ? vvi_light_scattered(volume, position, seen) : 1;
    if (!unlit && volume)
        vvi_light_volume_at(arrives, volume, position, seen);
    for (int c = 0; c < 3; c++)
        out[c] = color[c] * left;
    if (unlit)
        return;
    const vvi_lit_point point = {.position = position,
                                 .normal = surface ? n : to_eye,
                                 .to_eye = to_eye,
                                 .surface = surface,
                                 .two_sided = actor->two_sided,
                                 .arrives = volume ? arrives : NULL,
                                 .n_arrive = VVI_LIGHT_SHARES};
    const vvi_gloss gloss = vvi_gloss_of(actor->shading_model, actor->ambient, actor->diffuse, actor->specular,
                                         actor->shininess, scene->ambient);
    vvi_light_ref(out, &point, &gloss, scene->lamps, scene->n_lamps);
}
