/* One volume of the World as renderers see it. */
#include "core/job.h"
#include "core/memory.h"
#include "core/units.h"
#include "model/contents.h"
#include "model/placement.h"
#include "scene/colors.h"
#include "scene/resolve.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static vv_status fail_at(const char *path, const char *property, vv_status status, const char *text)
{
    char where[512];
    snprintf(where, sizeof where, "%s.%s", path, property);
    return vv_fail_at(status, NULL, where, "%s", text);
}

vv_status vvi_find_dataset(const vv_dataset **out, const vv_world *world, const vv_volume *volume, const char *path)
{
    const vv_collection *all = world->datasets;
    if (!volume->data && all->n == 1) {
        *out = (const vv_dataset *)all->entry[0].object;
        return VV_OK;
    }
    if (!volume->data)
        return fail_at(path, "data", VV_E_ARGUMENT,
                       all->n ? "there are several datasets; name the one to show" : "there is no dataset to show");
    *out = (const vv_dataset *)vv_collection_find(all, volume->data);
    if (*out)
        return VV_OK;
    char text[256];
    snprintf(text, sizeof text, "there is no dataset '%.100s'; 'datasets' has %zu", volume->data, all->n);
    return fail_at(path, "data", VV_E_NOT_FOUND, text);
}

/* Data of colours: these stay, and what opacity is looked up with becomes the field. */
static vv_status take_colors(vv_actor *actor, const vv_volume *volume, const char *path, vv_job *job)
{
    const vv_segmentation *s = (const vv_segmentation *)volume->segmentation;
    const vv_color_data *data = (const vv_color_data *)s->colors;
    const vv_field_info *info = vv_field_get_info(actor->field);
    const bool asked = vv_object_is_set(&s->base, "kind"), colors = asked && s->kind == VV_SEGMENT_COLORS;
    const bool solid = asked && s->kind == VV_SEGMENT_THRESHOLD; /* of the same values as surfaces have */
    const bool wanted = colors || ((solid || !asked) && !vv_object_is_set(&volume->base, "component"));
    if (colors && !vvi_field_has_colors(info))
        return fail_at(path, "segmentation.kind", VV_E_ARGUMENT,
                       "colors needs data whose samples are RGB or RGBA; these are not, take transfer");
    if (!wanted || !vvi_field_has_colors(info))
        return VV_OK;
    vv_field *scalar = NULL;
    actor->colors_encoded =
        vv_object_is_set(&data->base, "encoding") ? data->encoding == VV_ENCODING_SRGB : !vv_type_is_float(info->type);
    const vv_status st = vvi_colors_scalar(&scalar, actor->field, actor->colors_encoded, job);
    if (st != VV_OK)
        return vv_fail_in(st, "%s", path);
    actor->colors = actor->field;
    actor->field = scalar;
    actor->component = 0;
    return VV_OK;
}

static vv_status load(vv_actor *actor, double *load_s, const vv_world *world, const vv_volume *volume, const char *path,
                      vv_job *job)
{
    const double start = vvi_render_clock();
    const vv_dataset *dataset = NULL;
    vv_field *field = NULL;
    vv_status st = vvi_find_dataset(&dataset, world, volume, path);
    if (st == VV_OK)
        st = vv_dataset_field(&field, world, dataset, volume->attribute, volume->frame, job);
    if (st != VV_OK) /* a file's error says which file; others must say of which volume they speak */
        return vv_error_last()->file || vv_error_last()->where ? st : vv_fail_in(st, "%s", path);
    actor->field = field;
    const int components = vv_field_get_info(field)->components;
    if (volume->component < 0 || volume->component >= components) {
        char text[128];
        snprintf(text, sizeof text, "the field has %d, counted from 0", components);
        return fail_at(path, "component", VV_E_ARGUMENT, text);
    }
    actor->component = (int)volume->component;
    if ((st = take_colors(actor, volume, path, job)) != VV_OK)
        return st;
    *load_s += vvi_render_clock() - start;
    actor->statistics = vvi_alloc(job, sizeof *actor->statistics, VVI_MEM_DERIVED);
    if (!actor->statistics)
        return vv_fail_memory(sizeof *actor->statistics);
    st = vv_field_statistics(actor->statistics, actor->field, actor->component, job);
    return st == VV_OK ? vvi_resolve_missing(actor, volume, path, job) : st;
}

/* Lengths of the data in the World's unit, where both are real ones. */
static double unit_factor(const char *unit, const vv_world *world)
{
    const double metres = vvi_length_unit_metres(unit);
    const double world_metres = world->unit ? vvi_length_unit_metres(world->unit) : 0;
    return metres > 0 && world_metres > 0 && metres != world_metres ? metres / world_metres : 1;
}

/* What moves data, in their own place, to where they stand. */
static vv_affine placed(vv_affine own, const char *unit, const vv_affine *data_to_world, const vv_world *world)
{
    const double factor = unit_factor(unit, world);
    if (factor != 1) {
        for (int i = 0; i < 3; i++)
            own.axis[i] = vvi_scaled(own.axis[i], factor);
        own.origin = vvi_scaled(own.origin, factor);
    }
    return vv_affine_compose(*data_to_world, own);
}

vv_status vvi_place_data(vv_affine *out, vv_affine *data_to_world, vv_affine own, const char *unit,
                         const vv_world *world, const vv_volume *volume, const char *path)
{
    vv_affine inverse;
    *data_to_world = vvi_placement_matrix((const vv_placement *)volume->place);
    const vv_affine m = *out = placed(own, unit, data_to_world, world);
    if (!vv_affine_invert(&inverse, *data_to_world) || !vvi_finite(inverse.axis[0]) || !vvi_finite(inverse.axis[1]) ||
        !vvi_finite(inverse.axis[2]))
        return fail_at(path, "place", VV_E_ARGUMENT, "flattens the volume: its matrix has no inverse");
    if (!vvi_finite(m.axis[0]) || !vvi_finite(m.axis[1]) || !vvi_finite(m.axis[2]) || !vvi_finite(m.origin))
        return fail_at(path, "place", VV_E_ARGUMENT, "moves the volume too far away to compute with");
    return VV_OK;
}

static vv_status place(vv_actor *actor, vv_affine *data_to_world, const vv_world *world, const vv_volume *volume,
                       const char *path)
{
    const vv_grid *grid = &vv_field_get_info(actor->field)->grid;
    return vvi_place_data(&actor->index_to_world, data_to_world, grid->index_to_world, grid->unit, world, volume, path);
}

/* A plane through data brought to the World: p_data = inverse p_world. */
static vv_plane plane_in_world(vv_plane plane, const vv_affine *inverse)
{
    vv_plane out = {.offset = plane.offset - vvi_dot(plane.normal, inverse->origin)};
    out.normal = vvi_vec(vvi_dot(plane.normal, inverse->axis[0]), vvi_dot(plane.normal, inverse->axis[1]),
                         vvi_dot(plane.normal, inverse->axis[2]));
    const double length = vvi_length(out.normal);
    out.normal = vvi_scaled(out.normal, 1 / length);
    out.offset /= length;
    return out;
}

static vv_status add_planes(vv_actor *actor, const vv_collection *planes, const vv_affine *inverse, const char *path)
{
    for (size_t i = 0; i < planes->n; i++) {
        const vv_cut_plane *from = (const vv_cut_plane *)planes->entry[i].object;
        vv_plane plane = {from->normal, from->offset};
        if (!from->on)
            continue;
        if (!vvi_unit(&plane.normal)) {
            char where[512];
            snprintf(where, sizeof where, "%s%scut_planes.%zu.normal", path, *path ? "." : "", i);
            return vv_fail_at(VV_E_ARGUMENT, NULL, where, "has no length: give a direction");
        }
        actor->planes[actor->n_planes++] = inverse ? plane_in_world(plane, inverse) : plane;
    }
    return VV_OK;
}

vv_status vvi_resolve_planes(vv_actor *actor, const vv_world *world, const vv_volume *volume,
                             const vv_affine *data_to_world, const char *path, vv_job *job)
{
    const size_t most = world->cut_planes->n + volume->cut_planes->n;
    vv_affine inverse;
    if (!most)
        return VV_OK;
    actor->planes = vvi_alloc(job, most * sizeof *actor->planes, VVI_MEM_MODEL);
    if (!actor->planes)
        return vv_fail_memory(most * sizeof *actor->planes);
    vv_affine_invert(&inverse, *data_to_world); /* place() has seen that it can */
    const vv_status st = add_planes(actor, world->cut_planes, NULL, "");
    return st == VV_OK ? add_planes(actor, volume->cut_planes, &inverse, path) : st;
}

/* The volume's where it is set, else the World's where that is set, else the default: which the World's unset
 * property has. */
void vvi_resolve_shading(vv_actor *actor, const vv_world *world, const vv_volume *volume)
{
    const vv_shading *own = (const vv_shading *)volume->shading, *global = (const vv_shading *)world->shading;
#define FROM(name) (vv_object_is_set(&own->base, #name) ? own : global)->name
    actor->shading_model = FROM(model);
    actor->ambient = (float)FROM(ambient);
    actor->diffuse = (float)FROM(diffuse);
    actor->specular = (float)FROM(specular);
    actor->shininess = (float)FROM(shininess);
    actor->two_sided = FROM(two_sided);
    actor->cap = FROM(cap);
#undef FROM
    actor->color[0] = (float)volume->color.r;
    actor->color[1] = (float)volume->color.g;
    actor->color[2] = (float)volume->color.b;
}

vv_status vvi_load_paint(vvi_cast *cast, const vv_affine *data_to_world, vv_job *job)
{
    const vv_volume_paint *paint = (const vv_volume_paint *)cast->volume->paint;
    vv_paint *out = &cast->actor->paint;
    char text[256];
    if (!paint->data)
        return VV_OK;
    const vv_dataset *dataset = vvi_dataset_named(cast->world, paint->data);
    if (!dataset) {
        snprintf(text, sizeof text, "there is no dataset '%.100s'; 'datasets' has %zu", paint->data,
                 cast->world->datasets->n);
        return fail_at(cast->path, "paint.data", VV_E_NOT_FOUND, text);
    }
    vv_field *field = NULL;
    vv_status st = vv_dataset_field(&field, cast->world, dataset, paint->attribute, paint->frame, job);
    if (st != VV_OK)
        return vv_error_last()->file || vv_error_last()->where ? st : vv_fail_in(st, "%s.paint", cast->path);
    out->field = field;
    const vv_field_info *info = vv_field_get_info(field);
    if (paint->component >= info->components) {
        snprintf(text, sizeof text, "the field has %d, counted from 0", info->components);
        return fail_at(cast->path, "paint.component", VV_E_ARGUMENT, text);
    }
    out->component = (int)paint->component;
    out->nearest = info->meaning == VV_MEANING_LABEL;
    out->index_to_world = placed(info->grid.index_to_world, info->grid.unit, data_to_world, cast->world);
    bool done = false;
    if ((st = vvi_sense_label_paint(cast, job)) == VV_OK)
        st = vvi_resolve_label_paint(&done, cast, dataset, job);
    return st == VV_OK && !done ? vvi_resolve_paint(cast, job) : st;
}

/* Labels are never mixed; and one slice has thickness only where values reach half a sample beyond it. */
static bool wants_nearest(const vv_actor *actor, const vv_volume *volume)
{
    const vv_field_info *info = vv_field_get_info(actor->field);
    const int64_t *n = info->grid.dims;
    if (vv_object_is_set(&volume->base, "interpolation"))
        return volume->interpolation == VV_INTERPOLATE_NEAREST;
    return actor->classes.kind == VV_SEGMENT_LABELS || info->meaning == VV_MEANING_LABEL || n[0] < 2 || n[1] < 2 ||
           n[2] < 2;
}

double vvi_actor_voxel(const vv_actor *actor)
{
    const int64_t *n = vv_field_get_info(actor->field)->grid.dims;
    const bool one = n[0] < 2 && n[1] < 2 && n[2] < 2;
    double least = INFINITY;
    for (int i = 0; i < 3; i++)
        if (n[i] > 1 || one)
            least = fmin(least, vvi_length(actor->index_to_world.axis[i]));
    return least;
}

void vvi_actor_corners(vv_vec3 out[8], const vv_actor *actor)
{
    const int64_t *n = vv_field_get_info(actor->field)->grid.dims;
    const double reach = actor->nearest ? 0.5 : 0;
    for (int c = 0; c < 8; c++) {
        const vv_vec3 index = {c & 1 ? (double)n[0] - 1 + reach : -reach, c & 2 ? (double)n[1] - 1 + reach : -reach,
                               c & 4 ? (double)n[2] - 1 + reach : -reach};
        out[c] = vv_affine_point(actor->index_to_world, index);
    }
}

/* Whether the surface of an amount is shown. */
static bool shows_solid(const vv_renderer *renderer, const vv_object *params)
{
    const vv_actor any = {.classes = {.kind = VV_SEGMENT_TRANSFER}};
    const vv_scene scene = {.renderer = renderer, .params = params};
    double lo, hi;
    return renderer && renderer->solid && renderer->solid(&lo, &hi, &scene, &any);
}

vv_status vvi_resolve_actor(vv_actor *actor, double *load_s, const vv_world *world, const char *id,
                            const vv_volume *volume, const vv_renderer *renderer, const vv_object *params, vv_job *job)
{
    char path[256];
    vv_affine data_to_world;
    vv_object *own = NULL;
    vv_status st = vvi_volume_params(&own, params, volume);
    if (st != VV_OK)
        return st;
    snprintf(path, sizeof path, "volumes.%s", id);
    actor->id = id;
    actor->params = own;
    actor->layer = vvi_ray_layer_of(volume);
    if ((st = load(actor, load_s, world, volume, path, job)) != VV_OK ||
        (st = place(actor, &data_to_world, world, volume, path)) != VV_OK ||
        (st = vvi_resolve_planes(actor, world, volume, &data_to_world, path, job)) != VV_OK)
        return st;
    vvi_resolve_shading(actor, world, volume);
    vvi_cast cast = {.world = world, .volume = volume, .actor = actor, .path = path};
    cast.projects = vvi_renderer_projects(renderer, own);
    cast.amounts = cast.projects != VV_PROJECTS_NOTHING || shows_solid(renderer, own);
    cast.voxel = vvi_actor_voxel(actor);
    if ((st = vvi_resolve_classes(&cast, job)) != VV_OK || (st = vvi_load_paint(&cast, &data_to_world, job)) != VV_OK ||
        (st = vvi_resolve_texture(&cast, &data_to_world, job)) != VV_OK)
        return st;
    actor->nearest = wants_nearest(actor, volume);
    actor->cubic = volume->interpolation == VV_INTERPOLATE_CUBIC;
    return VV_OK;
}

void vvi_actor_finish(vv_actor *actor)
{
    vv_field_release((vv_field *)actor->field);
    vvi_free(actor->statistics);
    vvi_free(actor->planes);
    vvi_free((void *)actor->classes.opacity);
    vvi_free((void *)actor->classes.color);
    vvi_free((void *)actor->classes.labels);
    vvi_free((void *)actor->classes.label_ids);
    vvi_free((void *)actor->classes.regions);
    vv_field_release((vv_field *)actor->colors);
    vv_field_release((vv_field *)actor->paint.field);
    vvi_free((void *)actor->paint.color);
    vv_image_release(actor->texture.image);
    vv_object_release((vv_object *)(uintptr_t)actor->params);
}
