/* Meshes of a scene, where it places them and cut as it cuts them. */
#include "core/units.h"
#include "core/vec.h"
#include "measuring/meshes.h"
#include "mesh.h"
#include "render/common/resolve.h"
#include "surface/clip.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Which ----------------------------------------------------------------------------------------------------------- */

static const vv_volume *volume_nth(const vv_world *world, size_t i)
{
    return (const vv_volume *)(const void *)world->volumes->entry[i].object;
}

static bool is_mesh(const vv_world *world, const vv_volume *volume, vv_job *job)
{
    const vv_dataset *dataset = cli_input_dataset(world, volume);
    return dataset && vv_dataset_is_mesh(dataset, job);
}

static bool first_is_mesh(const vv_world *world, vv_job *job)
{
    for (size_t i = 0; i < world->volumes->n; i++)
        if (volume_nth(world, i)->visible)
            return is_mesh(world, volume_nth(world, i), job);
    return false;
}

vv_world *cli_measure_mesh_world(cli_command *command, const char *edited, const char *file)
{
    const vv_collection *set = command->common->set;
    vv_model *model = NULL;
    vv_world *world = NULL;
    vvi_recipe recipe = {0};
    if (strcmp(file, "-") == 0 || cli_mesh_is_input(command, file) ||
        cli_input_contents(command, file) == CLI_INPUT_DATA)
        return NULL;
    const bool edit = set && set->n && edited && strcmp(file, edited) == 0;
    if (vv_model_new(&model, command->runtime) == VV_OK &&
        cli_measuring_world(model, &recipe, command, file, edit) == VV_OK)
        world = vv_model_snapshot(model);
    vv_model_release(model);
    if (world && first_is_mesh(world, command->job))
        return world;
    vv_object_release(world ? &world->base : NULL);
    return NULL;
}

vv_status cli_measure_mesh_scene_check(const char *kind, const char *file)
{
    static const char *const known[] = {"summary", "area", "volume", "box"};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (strcmp(kind, known[i]) == 0)
            return VV_OK;
    return vv_fail(VV_E_ARGUMENT,
                   "%s shows meshes, of which area, volume and box are measured where it places them, and no %s; "
                   "distance and geodesic are of the mesh files themselves: name these",
                   file, kind);
}

/* One ------------------------------------------------------------------------------------------------------------- */

typedef struct shown {
    const char *id;
    vv_mesh *mesh;
    vv_affine place; /* to the World */
    vv_actor look;   /* its planes, in the World */
    char unit[16];   /* there */
} shown;

static void close_shown(shown *s)
{
    vvi_actor_finish(&s->look);
    vv_mesh_release(s->mesh);
}

/* As for samples: the World's unit where both are real ones. */
static void choose_unit(shown *s, const vv_world *world)
{
    const char *own = vv_mesh_get_info(s->mesh)->unit;
    const bool both = world->unit && vvi_length_unit_metres(world->unit) > 0 && vvi_length_unit_metres(own) > 0;
    snprintf(s->unit, sizeof s->unit, "%s", both ? world->unit : own);
}

static vv_status open_shown(shown *out, const vv_world *world, size_t i, vv_job *job)
{
    const vv_volume *volume = volume_nth(world, i);
    const vv_dataset *dataset;
    vv_affine data_to_world;
    char path[256];
    *out = (shown){.id = world->volumes->entry[i].id};
    snprintf(path, sizeof path, "volumes.%s", out->id);
    vv_status st = vvi_find_dataset(&dataset, world, volume, path);
    if (st != VV_OK || (st = vv_dataset_mesh(&out->mesh, dataset, job)) != VV_OK ||
        (st = vvi_place_data(&out->place, &data_to_world, vv_affine_identity(), vv_mesh_get_info(out->mesh)->unit,
                             world, volume, path)) != VV_OK)
        return st;
    choose_unit(out, world);
    return vvi_resolve_planes(&out->look, world, volume, &data_to_world, path, job);
}

/* What the planes keep, in the mesh's own space. */
static vv_status cut(vv_mesh **out, const shown *s, bool cap, vv_job *job)
{
    const size_t n = s->look.n_planes;
    vv_plane *planes = calloc(n + 1, sizeof *planes);
    if (!planes)
        return vv_fail_memory((n + 1) * sizeof *planes);
    for (size_t i = 0; i < n; i++)
        planes[i] = cli_plane_mapped(&s->look.planes[i], &s->place);
    const vv_status st = vvi_mesh_clip(out, s->mesh, planes, n, cap, job);
    free(planes);
    return st;
}

static vv_status measure_cut(vv_mesh_measures *out, const shown *s, bool cap, bool open, vv_job *job)
{
    vv_mesh_measure_options o;
    vv_mesh *kept = NULL;
    vv_mesh_measure_options_init(&o, sizeof o);
    o.to_world = s->place;
    o.open = open;
    snprintf(o.unit, sizeof o.unit, "%s", s->unit);
    vv_status st = cut(&kept, s, cap, job);
    if (st == VV_OK && (st = vv_mesh_measure(out, kept, &o, job)) != VV_OK)
        st = vv_fail_in(st, "volumes.%s", s->id);
    vv_mesh_release(kept);
    return st;
}

/* Cut, it is closed with flat faces, which are no part of its area unless they are asked for. */
static vv_status measure_shown(vv_mesh_measures *out, const shown *s, bool open, bool closed, vv_job *job)
{
    vv_mesh_measures without;
    vv_status st = measure_cut(out, s, true, open, job);
    if (st == VV_OK && s->look.n_planes && !closed && (st = measure_cut(&without, s, false, true, job)) == VV_OK)
        out->area = without.area;
    return st;
}

/* All ------------------------------------------------------------------------------------------------------------- */

typedef struct found {
    size_t n;
    vv_mesh_measures *each, total;
    const char **id;
    char unit[16];
} found;

/* Centroids by volume, errors added up. */
static void add(vv_mesh_measures *total, const vv_mesh_measures *m, bool first)
{
    if (first) {
        *total = *m;
        return;
    }
    const double v = total->volume.value, w = m->volume.value;
    for (int a = 0; a < 3; a++) {
        total->centroid[a].value = (v * total->centroid[a].value + w * m->centroid[a].value) / (v + w);
        total->centroid[a].error = (v * total->centroid[a].error + w * m->centroid[a].error) / (v + w);
    }
    total->n_triangles += m->n_triangles;
    total->area.value += m->area.value;
    total->area.error += m->area.error;
    total->volume.value += w;
    total->volume.error += m->volume.error;
    total->bounds.lo = vvi_vec(fmin(total->bounds.lo.x, m->bounds.lo.x), fmin(total->bounds.lo.y, m->bounds.lo.y),
                               fmin(total->bounds.lo.z, m->bounds.lo.z));
    total->bounds.hi = vvi_vec(fmax(total->bounds.hi.x, m->bounds.hi.x), fmax(total->bounds.hi.y, m->bounds.hi.y),
                               fmax(total->bounds.hi.z, m->bounds.hi.z));
    total->closed &= m->closed;
    total->inside_out = false;
    total->n_open_edges += m->n_open_edges;
    total->n_turned_edges += m->n_turned_edges;
}

static vv_status measure_one(found *f, const vv_world *world, size_t i, bool open, bool closed, vv_job *job)
{
    shown s;
    vv_status st = open_shown(&s, world, i, job);
    if (st == VV_OK && f->n && strcmp(s.unit, f->unit) != 0)
        st = vv_fail(VV_E_ARGUMENT, "volumes.%s is in %s and volumes.%s in %s: convert one, or hide one with --set",
                     f->id[0], f->unit, s.id, s.unit);
    if (st == VV_OK && (st = measure_shown(&f->each[f->n], &s, open, closed, job)) == VV_OK) {
        snprintf(f->unit, sizeof f->unit, "%s", s.unit);
        add(&f->total, &f->each[f->n], f->n == 0);
        f->id[f->n++] = s.id;
    }
    close_shown(&s);
    return st;
}

static vv_status measure_all(found *f, const vv_world *world, const char *file, bool open, bool closed, vv_job *job)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < world->volumes->n && st == VV_OK; i++) {
        if (!volume_nth(world, i)->visible)
            continue;
        if (!is_mesh(world, volume_nth(world, i), job))
            return vv_fail(VV_E_ARGUMENT,
                           "%s shows meshes and, as volumes.%s, samples, which are measured apart: hide what is not "
                           "meant, as in --set volumes.%s.visible=false",
                           file, world->volumes->entry[i].id, world->volumes->entry[i].id);
        st = measure_one(f, world, i, open, closed, job);
    }
    return st;
}

static void put_each(cli_result *result, const char *what, const found *f)
{
    cli_command *command = result->command;
    vvi_result_open(&command->json, "meshes", '[');
    for (size_t i = 0; i < f->n; i++) {
        result->part = f->id[i];
        vvi_result_open(&command->json, NULL, '{');
        vvi_result_string(&command->json, "name", f->id[i]);
        if (!result->csv)
            cli_command_line(command, "shown", "%s", f->id[i]);
        cli_mesh_measures_put(result, what, &f->each[i], f->unit);
        vvi_result_close(&command->json, '}');
    }
    vvi_result_close(&command->json, ']');
    result->part = NULL;
}

/* Several are told one by one before all of them together. */
static void put_all(cli_result *result, const char *what, const found *f)
{
    const bool several = f->n > 1;
    if (several)
        put_each(result, what, f);
    else
        vvi_result_string(&result->command->json, "mesh", f->id[0]);
    snprintf(result->object, sizeof result->object, "%zu mesh%s of the scene", f->n, several ? "es" : "");
    if (!result->csv)
        cli_command_line(result->command, several ? "together" : "shown", "%s, where the scene places %s%s",
                         several ? result->object : f->id[0], several ? "them" : "it",
                         several ? "; what overlaps counts twice" : "");
    cli_mesh_measures_put(result, what, &f->total, f->unit);
}

vv_status cli_measure_mesh_scene(cli_result *result, const char *what, const char *file, const vv_world *world)
{
    const cli_measure_options *o = cli_command_options(result->command, &cli_measure_class);
    const size_t n = world->volumes->n;
    found f = {.each = calloc(n, sizeof *f.each), .id = calloc(n, sizeof *f.id)};
    vv_status st = cli_measure_mesh_scene_check(what, file);
    if (st == VV_OK && (!f.each || !f.id))
        st = vv_fail_memory(n * sizeof *f.each);
    if (st == VV_OK)
        st = measure_all(&f, world, file, strcmp(what, "volume") != 0, o->closed, result->command->job);
    if (st == VV_OK)
        put_all(result, what, &f);
    free(f.each);
    free(f.id);
    return st;
}
