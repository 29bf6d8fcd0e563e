#include "measuring/world_data.h"
#include "core/memory.h"
#include "core/status.h"
#include "core/units.h"
#include "core/vec.h"
#include "grid/field.h"
#include "measuring/measuring.h"
#include "model/classes.h"
#include "model/contents.h"
#include "model/placement.h"
#include "scene/resolve.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NO_LIMIT 1e308 /* the largest value that scenes write */

const char *vvi_measured_volume_id(const vv_world *world, const char *named)
{
    return !named ? vvi_first_visible_id(world) : vvi_volume_named(world, named) ? named : NULL;
}

bool vvi_world_shows_meshes(const vv_world *world, vv_job *job)
{
    const vv_volume *volume = vvi_first_visible(world);
    return volume && vvi_volume_is_mesh(world, volume, job);
}

/* Volumes --------------------------------------------------------------------------------------------------------- */

/* Planes of the World, and of a volume, whose own are in its data's space. */
static void take_planes(vvi_measured_volume *out, const vv_collection *planes, const vv_affine *place)
{
    for (size_t i = 0; planes && i < planes->n; i++) {
        const vv_cut_plane *p = (const vv_cut_plane *)(const void *)planes->entry[i].object;
        if (!p->on || out->data.n_planes == VVI_MEASURED_PLANES)
            continue;
        vv_vec3 n = p->normal;
        vvi_unit(&n);
        vv_plane *to = &out->planes[out->data.n_planes++];
        vv_affine inverse;
        *to = (vv_plane){n, p->offset};
        if (place && vv_affine_invert(&inverse, *place))
            *to = vvi_plane_mapped(to, &inverse);
    }
}

static bool get(char out[64], const vv_world *world, const char *view, const char *name)
{
    char *path = vvi_asprintf("views.%s.render.%s", view, name), *json = NULL;
    const bool found = path && vv_path_get(&json, &world->base, path) == VV_OK;
    snprintf(out, 64, "%s", found ? json : "");
    free(json);
    free(path);
    return found;
}

bool vvi_world_surface_value(double *out, const vv_world *world, const char *view, vv_job *job)
{
    char mode[64], iso[64], name[128];
    if (!*view && world->views->n)
        view = world->views->entry[0].id;
    const vv_view *seen = vvi_view_named(world, view);
    if (!seen)
        return false;
    const char *method = vvi_method_of(world, seen, job);
    snprintf(name, sizeof name, "%s.mode", method);
    if (get(mode, world, view, name) && strcmp(mode, "\"isosurface\"") != 0) /* without modes all is surfaces */
        return false;
    snprintf(name, sizeof name, "%s.iso", method);
    return get(iso, world, view, name) && vvi_parse_number(out, iso);
}

/* How samples are shown, where people said so. */
static int says_labels(const vv_volume *volume)
{
    const vv_segmentation *segmentation = (const vv_segmentation *)(const void *)volume->segmentation;
    if (!vv_object_is_set(&segmentation->base, "kind"))
        return 0;
    return segmentation->kind == VV_SEGMENT_LABELS ? 1 : -1;
}

/* A label between two others is none of the values between them. */
static bool shows_labels(const vv_field *field, const vv_volume *volume)
{
    const vv_segmentation *segmentation = (const vv_segmentation *)(const void *)volume->segmentation;
    return vv_object_is_set(&segmentation->base, "kind") ? segmentation->kind == VV_SEGMENT_LABELS
                                                         : vv_field_get_info(field)->meaning == VV_MEANING_LABEL;
}

static void take_threshold(vv_measured_data *out, const vv_volume *v)
{
    const vv_segmentation *segmentation = (const vv_segmentation *)(const void *)v->segmentation;
    const vv_threshold *threshold = (const vv_threshold *)(const void *)segmentation->threshold;
    if (segmentation->kind != VV_SEGMENT_THRESHOLD || !vv_object_is_set(&threshold->base, "lo") || out->ranged)
        return;
    const bool limited = vv_object_is_set(&threshold->base, "hi") && threshold->hi < NO_LIMIT;
    out->ranged = true;
    out->lo = threshold->lo;
    out->hi = limited ? threshold->hi : INFINITY;
}

void vvi_grid_take_unit(vv_grid *grid, const char *unit)
{
    const double from = vvi_length_unit_metres(grid->unit), to = vvi_length_unit_metres(unit);
    if (!(from > 0) || !(to > 0) || strcmp(grid->unit, unit) == 0)
        return;
    for (int a = 0; a < 3; a++)
        grid->index_to_world.axis[a] = vvi_scaled(grid->index_to_world.axis[a], from / to);
    grid->index_to_world.origin = vvi_scaled(grid->index_to_world.origin, from / to);
    snprintf(grid->unit, sizeof grid->unit, "%s", unit);
}

vv_status vvi_measured_volume_take(vvi_measured_volume *out, const vv_field *field, const vv_file *file, int64_t frame,
                                   const char *name, const vv_world *world, const vv_volume *v, const char *view,
                                   vv_job *job)
{
    vv_field_info info = *vv_field_get_info(field);
    vv_measured_data *data = &out->data;
    *out = (vvi_measured_volume){.data = {.name = name,
                                          .place = vv_affine_identity(),
                                          .planes = out->planes,
                                          .hi = INFINITY,
                                          .frame = frame,
                                          .n_frames = info.n_frames}};
    data->labels = file ? vv_file_labels(file, &data->n_labels) : NULL;
    take_planes(out, world->cut_planes, NULL);
    if (v)
        data->says_labels = says_labels(v);
    if (v && !shows_labels(field, v))
        data->ranged = vvi_world_surface_value(&data->lo, world, view, job);
    if (v) {
        data->place = vvi_placement_matrix((const vv_placement *)(const void *)v->place);
        data->component = (int)v->component;
        take_planes(out, v->cut_planes, &data->place);
        take_threshold(data, v);
        if (world->unit)
            vvi_grid_take_unit(&info.grid, world->unit);
    }
    info.grid.index_to_world = vv_affine_compose(data->place, info.grid.index_to_world);
    const vv_status st = vvi_field_relabel(&out->field, field, &info);
    data->field = out->field;
    return st;
}

void vvi_measured_volume_finish(vvi_measured_volume *volume)
{
    vv_field_release(volume->field);
    *volume = (vvi_measured_volume){0};
}

/* Meshes ---------------------------------------------------------------------------------------------------------- */

struct vvi_measured_mesh {
    vv_mesh *mesh;
    vv_actor look; /* its planes, in the World */
    char unit[16]; /* there */
};

/* As for samples: the World's unit where both are real ones. */
static void choose_unit(struct vvi_measured_mesh *m, const vv_world *world)
{
    const char *own = vv_mesh_get_info(m->mesh)->unit;
    const bool both = world->unit && vvi_length_unit_metres(world->unit) > 0 && vvi_length_unit_metres(own) > 0;
    snprintf(m->unit, sizeof m->unit, "%s", both ? world->unit : own);
}

static vv_status take_mesh(vvi_measured_meshes *out, const vv_world *world, size_t i, vv_job *job)
{
    const vv_volume *volume = vvi_volume_nth(world, i);
    struct vvi_measured_mesh *m = &out->mesh[out->n];
    vv_measured_data *data = &out->data[out->n++];
    const vv_dataset *dataset;
    vv_affine data_to_world;
    char path[256];
    data->shown = world->volumes->entry[i].id;
    snprintf(path, sizeof path, "volumes.%s", data->shown);
    vv_status st = vvi_find_dataset(&dataset, world, volume, path);
    if (st != VV_OK || (st = vv_dataset_mesh(&m->mesh, world, dataset, job)) != VV_OK ||
        (st = vvi_place_data(&data->place, &data_to_world, vv_affine_identity(), vv_mesh_get_info(m->mesh)->unit, world,
                             volume, path)) != VV_OK ||
        (st = vvi_resolve_planes(&m->look, world, volume, &data_to_world, path, job)) != VV_OK)
        return st;
    choose_unit(m, world);
    data->mesh = m->mesh;
    data->planes = m->look.planes;
    data->n_planes = m->look.n_planes;
    data->unit = m->unit;
    return VV_OK;
}

vv_status vvi_measured_meshes_take(vvi_measured_meshes *out, const vv_world *world, const char *only, const char *file,
                                   vv_job *job)
{
    const size_t n = world->volumes->n;
    vv_status st = VV_OK;
    *out = (vvi_measured_meshes){vvi_calloc(n + 1, sizeof *out->data), vvi_calloc(n + 1, sizeof *out->mesh), 0};
    if (!out->data || !out->mesh)
        return vv_fail_memory(n * sizeof *out->mesh);
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        if (only ? strcmp(only, world->volumes->entry[i].id) != 0 : !vvi_volume_nth(world, i)->visible)
            continue;
        if (!vvi_volume_is_mesh(world, vvi_volume_nth(world, i), job))
            return vv_fail(VV_E_ARGUMENT,
                           "%s shows meshes and, as volumes.%s, samples, which are measured apart: hide what is not "
                           "meant, as in --set volumes.%s.visible=false",
                           file, world->volumes->entry[i].id, world->volumes->entry[i].id);
        out->data[out->n].name = file;
        st = take_mesh(out, world, i, job);
    }
    return st;
}

void vvi_measured_meshes_finish(vvi_measured_meshes *meshes)
{
    for (size_t i = 0; i < meshes->n; i++) {
        vvi_actor_finish(&meshes->mesh[i].look);
        vv_mesh_release(meshes->mesh[i].mesh);
    }
    free(meshes->data);
    free(meshes->mesh);
    *meshes = (vvi_measured_meshes){0};
}
