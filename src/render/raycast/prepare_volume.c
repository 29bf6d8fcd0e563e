/* One volume of a frame: samples, place, light. */
#include "core/job.h"
#include "render/common/cubic_spline.h"
#include "render/common/shade_ref.h"
#include "render/raycast/prepare.h"
#include "scene/resolve.h"
#include <math.h>
#include <string.h>

enum { MOST_STEPS = 1 << 20 };
#define LEAST_SHARE 1e-37 /* of the range of all: its inverse is a float */
#define LEAST_FLAT 1e-18  /* its square is a float */

/* The longest ray's steps; more than MOST_STEPS of them no float counts, and nobody waits for. */
static vv_status check_step(vvi_march_volume *f, const vv_actor *actor, const vv_scene *scene)
{
    const int64_t *n = vv_field_get_info(actor->field)->grid.dims;
    double diagonal = 0;
    for (int a = 0; a < 3; a++)
        diagonal += vvi_length(actor->index_to_world.axis[a]) * (double)n[a];
    if (diagonal / f->step > MOST_STEPS)
        return vv_fail(
            VV_E_ARGUMENT, "render.raycast.step: %g %s makes %.0f steps through the volume; set at least %.3g", f->step,
            scene->world && scene->world->unit ? scene->world->unit : "", diagonal / f->step, diagonal / MOST_STEPS);
    f->steps = (float)(diagonal / f->step);
    return VV_OK;
}

/* Placement ----------------------------------------------------------------------------------------------------- */

static vv_status place(vvi_march_volume *f, const vv_actor *actor)
{
    const vv_affine m = actor->index_to_world;
    vv_affine i;
    if (!vv_affine_invert(&i, m))
        return vv_fail(VV_E_ARGUMENT, "volumes.%s.place: flattens the volume; give it a scale other than 0", actor->id);
    const double forward[3][4] = {{m.axis[0].x, m.axis[1].x, m.axis[2].x, m.origin.x},
                                  {m.axis[0].y, m.axis[1].y, m.axis[2].y, m.origin.y},
                                  {m.axis[0].z, m.axis[1].z, m.axis[2].z, m.origin.z}};
    const double back[3][4] = {{i.axis[0].x, i.axis[1].x, i.axis[2].x, i.origin.x},
                               {i.axis[0].y, i.axis[1].y, i.axis[2].y, i.origin.y},
                               {i.axis[0].z, i.axis[1].z, i.axis[2].z, i.origin.z}};
    memcpy(f->sampler.world_to_index, back, sizeof back);
    for (int a = 0; a < 3; a++) {
        for (int b = 0; b < 4; b++)
            f->sampler.index_to_world[a][b] = (float)forward[a][b];
        for (int b = 0; b < 3; b++)
            f->sampler.gradient_to_world[a][b] = (float)back[b][a];
        /* a flat axis, and nearest samples, own half a voxel to each side */
        const bool thick = actor->nearest || f->sampler.lattice.n[a] == 1;
        f->sampler.lo[a] = thick ? -0.5 : 0;
        f->sampler.hi[a] = f->sampler.lattice.n[a] - (thick ? 0.5 : 1);
    }
    if (actor->n_planes > VVI_RAY_PLANES)
        return vv_fail(VV_E_UNSUPPORTED, "volumes.%s: %zu cut planes; ray casting takes at most %d", actor->id,
                       actor->n_planes, VVI_RAY_PLANES);
    f->sampler.n_planes = actor->n_planes;
    for (size_t p = 0; p < actor->n_planes; p++) {
        const vv_plane *plane = &actor->planes[p];
        const double row[4] = {plane->normal.x, plane->normal.y, plane->normal.z, plane->offset};
        memcpy(f->sampler.planes[p], row, sizeof row);
    }
    return VV_OK;
}

/* Light --------------------------------------------------------------------------------------------------------- */

/* Gradients in ranges of the values a voxel, whatever unit the values have: their squares must be floats as well. Those
 * beside a fill far outside may be many such ranges, and shade() sees to their squares. */
static void scale_gradients(vvi_raycast_volume *v)
{
    const vv_actor *actor = v->actor;
    const double value_scale = v->hold.value_scale;
    vvi_march_volume *f = &v->ray;
    const double all = (actor->statistics->max - actor->statistics->min) / value_scale;
    const double seen = vvi_shade_range(actor) / fabs(value_scale);
    const double range = copysign(fmax(seen, fabs(all) * LEAST_SHARE), all);
    const double voxel = vvi_actor_voxel(actor);
    /* of values that are all the same, what looks like a gradient is rounding */
    const double factor = range == 0 ? 0 : isfinite(range) ? voxel / range : 1;
    for (int a = 0; a < 9; a++)
        f->sampler.gradient_to_world[a / 3][a % 3] =
            (float)((double)f->sampler.gradient_to_world[a / 3][a % 3] * factor);
    v->gradient_unit = factor != 0 ? factor : 1;
    f->light.flat_gradient = range != 0 && isfinite(range) ? (float)fmax(1e-6 * seen / fabs(range), LEAST_FLAT) : 1e-6f;
    f->solid.unit = all != 0 && isfinite(all) ? (float)(1 / fabs(all)) : 1;
}

static vv_status light(vvi_raycast_volume *v, const vv_scene *scene)
{
    const vv_actor *actor = v->actor;
    vvi_march_volume *f = &v->ray;
    if (scene->n_lamps > VVI_RAY_LAMPS)
        return vv_fail(VV_E_UNSUPPORTED, "lights: %zu are on; ray casting takes at most %d, so switch some off",
                       scene->n_lamps, VVI_RAY_LAMPS);
    const vvi_lighting lighting = vvi_raycast_lighting_of(v->params);
    f->light.unlit = actor->shading_model == VV_SHADING_NONE;
    f->light.shaded = !f->light.unlit || lighting.shadows || lighting.ambient_occlusion;
    f->light.two_sided = actor->two_sided;
    f->light.capped = actor->cap && actor->n_planes > 0;
    f->light.gloss = vvi_gloss_of(actor->shading_model, actor->ambient, actor->diffuse, actor->specular,
                                  actor->shininess, scene->ambient);
    f->light.n_lamps = scene->n_lamps;
    for (size_t i = 0; i < scene->n_lamps; i++)
        f->light.lamps[i] = vvi_lamp_from(&scene->lamps[i], vvi_vec(0, 0, 0));
    return VV_OK;
}

static vv_status check_interpolation(const vvi_raycast_volume *v)
{
    const vv_actor *actor = v->actor;
    if (!actor->cubic)
        return VV_OK;
    if (vvi_raycast_projects(v->params->mode))
        return vv_fail(VV_E_UNSUPPORTED,
                       "volumes.%s.interpolation: cubic is for light through a cloud and for surfaces; modes with one "
                       "value per ray take linear or nearest",
                       actor->id);
    if (actor->classes.kind == VV_SEGMENT_LABELS)
        return vv_fail(
            VV_E_UNSUPPORTED,
            "volumes.%s.interpolation: labels cannot be interpolated cubically; linear gives them smooth borders",
            actor->id);
    if (actor->statistics->nan_count || actor->statistics->infinite_count)
        return vv_fail(VV_E_UNSUPPORTED,
                       "volumes.%s.interpolation: %llu samples are not finite numbers, and a cubic curve through all "
                       "would not be finite anywhere; use linear",
                       actor->id,
                       (unsigned long long)(actor->statistics->nan_count + actor->statistics->infinite_count));
    return VV_OK;
}

vv_status vvi_raycast_open_volume(vvi_raycast_volume *v, const vv_scene *scene, double step, vv_job *job)
{
    const vv_actor *actor = v->actor;
    vvi_march_volume *f = &v->ray;
    vv_status st = check_interpolation(v);
    if (st != VV_OK)
        return st;
    st = actor->cubic    ? vvi_lattice_open_cubic(&v->hold, actor->field, actor->component, job)
         : actor->colors ? vvi_lattice_open(&v->hold, actor->field, actor->component, job) /* and theirs lie likewise */
                         : vvi_lattice_open_somehow(&v->hold, actor->field, actor->component, job);
    if (st != VV_OK)
        return st;
    f->sampler.lattice = v->hold.lattice;
    f->step = step;
    f->light.cap_depth = (float)fmax(1, vvi_actor_voxel(actor) / step);
    v->ray.sampler.nearest = actor->nearest;
    v->ray.sampler.cubic = actor->cubic;
    if ((st = place(f, actor)) != VV_OK || (st = light(v, scene)) != VV_OK)
        return st;
    scale_gradients(v);
    return check_step(f, actor, scene);
}
