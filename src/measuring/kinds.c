/* What can be measured, and one question answered. */
#include "core/names.h"
#include "measure.h"
#include "measuring/meshes.h"
#include "measuring/surfaces.h"
#include "mesh.h"
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const char *const kinds[] = {"area",  "volume", "box",      "statistics", "histogram", "profile", "distance",
                                    "angle", "labels", "geodesic", "summary",    "stored",    "joint"};
enum { N_KINDS = sizeof kinds / sizeof *kinds };

const char *cli_measure_kind(const char *word)
{
    for (size_t i = 0; i < N_KINDS; i++)
        if (strcmp(word, kinds[i]) == 0 && access(word, F_OK) != 0)
            return kinds[i];
    return NULL;
}

const char *cli_measure_kind_nth(size_t index)
{
    return index < N_KINDS ? kinds[index] : NULL;
}

/* Other words for them, and beginnings of them. */
static const char *nearest_kind(const char *word)
{
    static const char *const other[][2] = {
        {"stats", "statistics"},       {"centroid", "box"},         {"hausdorff", "distance"},
        {"mean", "statistics"},        {"deviation", "statistics"}, {"line", "profile"},
        {"percentiles", "statistics"}, {"surface", "area"},         {"path", "geodesic"}};
    for (size_t i = 0; i < sizeof other / sizeof *other; i++)
        if (strcmp(word, other[i][0]) == 0)
            return other[i][1];
    for (size_t i = 0; i < N_KINDS; i++)
        if (strlen(word) > 2 && strncmp(word, kinds[i], strlen(word)) == 0)
            return kinds[i];
    return vv_nearest_name(word, kinds, N_KINDS);
}

vv_status cli_measure_fail_kind(const char *word)
{
    const char *near = nearest_kind(word); /* as if it had been typed: other words are near to none */
    return vvi_fail_name(VV_E_ARGUMENT, NULL, NULL, near ? near : word, &(vvi_known){kinds, N_KINDS, NULL, NULL},
                         "measure: no '%s' can be measured", word);
}

static vv_status summary(cli_measuring *m)
{
    const vv_status st = cli_measure_values(m, false);
    const int64_t *dims = vv_field_get_info(m->field)->grid.dims;
    const bool thin = dims[0] < 2 || dims[1] < 2 || dims[2] < 2;
    if (st == VV_OK && thin && m->choice.method == VV_MEASURE_CUBES) {
        cli_command_note(m->command,
                         "%s is one sample thick, and Marching Cubes needs two along every axis: area and volume are "
                         "left out; --method count counts voxels",
                         m->input.path);
        return VV_OK;
    }
    return st == VV_OK ? cli_measure_object(m, "summary") : st;
}

static vv_status measure(cli_measuring *m, const char *kind)
{
    static const char *const of_object[] = {"area", "volume", "box"};
    for (int i = 0; i < 3; i++)
        if (strcmp(kind, of_object[i]) == 0)
            return cli_measure_object(m, kind);
    if (strcmp(kind, "statistics") == 0 || strcmp(kind, "histogram") == 0)
        return cli_measure_values(m, kind[0] == 'h');
    if (strcmp(kind, "joint") == 0)
        return cli_measure_joint(m);
    if (strcmp(kind, "profile") == 0)
        return cli_measure_profile(m);
    if (strcmp(kind, "distance") == 0 || strcmp(kind, "angle") == 0)
        return cli_measure_points(m, kind[0] == 'a');
    if (strcmp(kind, "labels") == 0)
        return cli_measure_labels(m);
    return summary(m);
}

static vv_status measure_volume(cli_result *result, const cli_question *q)
{
    cli_measuring m;
    vv_status st = VV_OK;
    if ((st = cli_measuring_open(&m, result, q->file[0])) == VV_OK) {
        vvi_result_string(&result->command->json, "region", m.region);
        st = measure(&m, q->kind);
        snprintf(result->object, sizeof result->object, "%s", m.object);
        snprintf(result->region, sizeof result->region, "%s", strcmp(m.region, "all") ? m.region : "");
    }
    cli_measuring_close(&m);
    return st;
}

static vv_status measure_mesh(cli_result *result, const cli_question *q)
{
    static const char *const of_meshes[] = {"summary", "area", "volume", "box"};
    for (int i = 0; i < 4; i++)
        if (strcmp(q->kind, of_meshes[i]) == 0)
            return cli_measure_mesh(result, q->kind, q->file[0]);
    return vv_fail(VV_E_ARGUMENT, "%s is a mesh, which has area, volume, box, distance and geodesic; no %s", q->file[0],
                   q->kind);
}

/* A place of a volume is known to be one when there are two; one alone is measured to a surface. */
static bool is_between_places(const cli_result *result, const cli_question *q)
{
    const cli_measure_options *o = cli_command_options(result->command, &cli_measure_class);
    return !q->file[1] && !cli_mesh_is_input(result->command, q->file[0]) && !(o->point && o->point->n == 1);
}

vv_status cli_measure_ask(cli_result *result, const cli_question *q)
{
    vv_world *meshes = cli_measure_mesh_world(result->command, result->edited, q->file[0]);
    if (meshes) {
        const vv_status st = cli_measure_mesh_scene(result, q->kind, q->file[0], meshes);
        vv_object_release(&meshes->base);
        return st;
    }
    if (strcmp(q->kind, "geodesic") == 0)
        return cli_measure_geodesic(result, q->file[0]);
    if (strcmp(q->kind, "distance") == 0 && !is_between_places(result, q))
        return q->file[1] ? cli_measure_two_surfaces(result, q->file[0], q->file[1])
                          : cli_measure_point_to_surface(result, q->file[0]);
    return cli_mesh_is_input(result->command, q->file[0]) ? measure_mesh(result, q) : measure_volume(result, q);
}
