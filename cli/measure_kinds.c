/* What can be measured, and one question answered. */
#include "measure.h"
#include "measure_meshes.h"
#include "mesh.h"
#include "value.h"
#include <string.h>
#include <unistd.h>

static const char *const kinds[] = {"area",     "volume", "box",    "statistics", "histogram", "profile",
                                    "distance", "angle",  "labels", "summary",    "stored"};
enum { N_KINDS = sizeof kinds / sizeof *kinds };

const char *cli_measure_kind(const char *word)
{
    for (size_t i = 0; i < N_KINDS; i++)
        if (strcmp(word, kinds[i]) == 0 && access(word, F_OK) != 0)
            return kinds[i];
    return NULL;
}

vv_status cli_measure_fail_kind(const char *word)
{
    const char *near = vv_nearest_name(word, kinds, N_KINDS);
    return near ? vv_fail(VV_E_ARGUMENT, "measure: no '%s' can be measured; did you mean '%s'?", word, near)
                : vv_fail(VV_E_ARGUMENT,
                          "measure: no '%s' can be measured; area, volume, box, statistics, histogram, profile, "
                          "distance, angle and labels can",
                          word);
}

static vv_status summary(cli_measuring *m)
{
    const vv_status st = cli_measure_values(m, false);
    if (st != VV_OK || vv_field_get_info(m->field)->grid.dims[0] < 2 || vv_field_get_info(m->field)->grid.dims[1] < 2 ||
        vv_field_get_info(m->field)->grid.dims[2] < 2)
        return st;
    return cli_measure_object(m, "summary");
}

static vv_status measure(cli_measuring *m, const char *kind)
{
    static const char *const of_object[] = {"area", "volume", "box"};
    for (int i = 0; i < 3; i++)
        if (strcmp(kind, of_object[i]) == 0)
            return cli_measure_object(m, kind);
    if (strcmp(kind, "statistics") == 0 || strcmp(kind, "histogram") == 0)
        return cli_measure_values(m, kind[0] == 'h');
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
    if (q->file[1])
        return vv_fail(VV_E_ARGUMENT,
                       "distances between two files are those of meshes, and %s is none: --point names "
                       "places of a volume",
                       q->file[0]);
    if ((st = cli_measuring_open(&m, result, q->file[0])) == VV_OK) {
        cli_json_string(&result->command->json, "region", m.region);
        st = measure(&m, q->kind);
    }
    cli_measuring_close(&m);
    return st;
}

static vv_status from_point(cli_result *result, const char *file)
{
    const cli_measure_options *o = cli_command_options(result->command, &cli_measure_class);
    double p[3];
    if (!o->point || o->point->n != 1)
        return vv_fail(VV_E_ARGUMENT, "distance of %s to what? give --point X,Y,Z once, or another mesh", file);
    if (cli_value_numbers(p, 3, cli_word_nth(o->point, 0), false) != VV_OK)
        return vv_fail_in(VV_E_ARGUMENT, "--point");
    return cli_measure_mesh_point(result, file, (vv_vec3){p[0], p[1], p[2]});
}

static vv_status measure_mesh(cli_result *result, const cli_question *q)
{
    static const char *const of_meshes[] = {"summary", "area", "volume", "box"};
    for (int i = 0; i < 4; i++)
        if (strcmp(q->kind, of_meshes[i]) == 0)
            return cli_measure_mesh(result, q->kind, q->file[0]);
    if (strcmp(q->kind, "distance") == 0 && !q->file[1])
        return from_point(result, q->file[0]);
    if (strcmp(q->kind, "distance") == 0 && cli_mesh_is_input(result->command, q->file[1]))
        return cli_measure_mesh_distance(result, q->file[0], q->file[1]);
    return vv_fail(VV_E_ARGUMENT, "%s is a mesh, which has area, volume and box, and a distance to another mesh; no %s",
                   q->file[0], q->kind);
}

vv_status cli_measure_ask(cli_result *result, const cli_question *q)
{
    return cli_mesh_is_input(result->command, q->file[0]) ? measure_mesh(result, q) : measure_volume(result, q);
}
