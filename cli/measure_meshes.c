/* Area, volume and box of mesh files, and distances between two of them. */
#include "measure_meshes.h"
#include "core/vec.h"
#include "io/mesh_file.h"
#include "measure.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <volvis/measure_distance.h>
#include <volvis/mesh_file.h>

static void put(cli_result *result, const char *key, const char *label, const vv_figure *f)
{
    cli_figure out = {.key = key, .label = label, .value = f->value, .error = f->error};
    snprintf(out.unit, sizeof out.unit, "%s", f->unit);
    cli_figure_put(result, &out);
}

static void put_place(cli_result *result, const vv_mesh_measures *m, const char *unit)
{
    const bool empty = m->bounds.lo.x > m->bounds.hi.x;
    const vv_vec3 none = {NAN, NAN, NAN}, lo = empty ? none : m->bounds.lo, hi = empty ? none : m->bounds.hi;
    cli_command *command = result->command;
    const double centre[3] = {m->centroid[0].value, m->centroid[1].value, m->centroid[2].value};
    const double size[3] = {hi.x - lo.x, hi.y - lo.y, hi.z - lo.z};
    cli_vector_put(result, "centroid", centre, unit);
    cli_vector_put(result, "box_lo", (double[]){lo.x, lo.y, lo.z}, unit);
    cli_vector_put(result, "box_hi", (double[]){hi.x, hi.y, hi.z}, unit);
    cli_vector_put(result, "box_size", size, unit);
    if (result->csv)
        return;
    if (!isnan(centre[0]))
        cli_command_line(command, "centroid", "%.7g, %.7g, %.7g %s", centre[0], centre[1], centre[2], unit);
    if (empty) {
        cli_command_line(command, "box", "empty");
        return;
    }
    cli_command_line(command, "box", "%.7g .. %.7g, %.7g .. %.7g, %.7g .. %.7g %s", lo.x, hi.x, lo.y, hi.y, lo.z, hi.z,
                     unit);
    cli_command_line(command, "", "%.7g x %.7g x %.7g %s", size[0], size[1], size[2], unit);
}

static void put_measures(cli_result *result, const char *what, const vv_mesh_measures *m, const char *unit)
{
    cli_command *command = result->command;
    const bool all = strcmp(what, "summary") == 0;
    cli_json_string(&command->json, "unit", unit);
    cli_json_string(&command->json, "method", "triangles");
    cli_json_unsigned(&command->json, "triangles", m->n_triangles);
    cli_json_bool(&command->json, "closed", m->closed);
    if (!result->csv && all)
        cli_command_line(command, "mesh", "%zu triangles, %s", m->n_triangles,
                         m->closed ? "closed" : "open: it has no volume");
    if (all || strcmp(what, "area") == 0)
        put(result, "area", "area", &m->area);
    if ((all && m->closed) || strcmp(what, "volume") == 0)
        put(result, "volume", "volume", &m->volume);
    if (all || strcmp(what, "box") == 0)
        put_place(result, m, unit);
    if (m->inside_out)
        cli_command_note(command, "the triangles face inwards; the volume is told as if they did not");
}

vv_status cli_measure_mesh(cli_result *result, const char *what, const char *path)
{
    cli_command *command = result->command;
    vv_mesh *mesh = NULL;
    vv_mesh_measure_options o;
    vv_mesh_measures m;
    vv_mesh_measure_options_init(&o, sizeof o);
    o.open = strcmp(what, "volume") != 0;
    vv_status st = vv_mesh_read(&mesh, path, NULL, command->job);
    if (st == VV_OK && (st = vv_mesh_measure(&m, mesh, &o, command->job)) == VV_OK)
        put_measures(result, what, &m, vv_mesh_get_info(mesh)->unit);
    else if (st != VV_OK && mesh)
        st = vv_fail_in(st, "%s", path);
    vv_mesh_release(mesh);
    return st;
}

/* Two surfaces ---------------------------------------------------------------------------------------------------- */

static vv_status read_tree(vv_mesh_tree **out, char unit[16], cli_command *command, const char *path)
{
    vv_mesh *mesh = NULL;
    vv_status st = vv_mesh_read(&mesh, path, NULL, command->job);
    if (st == VV_OK) {
        snprintf(unit, 16, "%s", vv_mesh_get_info(mesh)->unit);
        st = vv_mesh_tree_new(out, mesh, NULL, command->job);
    }
    vv_mesh_release(mesh);
    return st;
}

static void put_deviation(cli_result *result, const char *from, const vv_mesh_deviation *d)
{
    char key[48], label[32];
    const struct {
        const char *name;
        const vv_figure *figure;
    } figures[] = {{"mean", &d->mean}, {"rms", &d->rms}, {"max", &d->max}};
    for (int i = 0; i < 3; i++) {
        snprintf(key, sizeof key, "%s_%s", from, figures[i].name);
        snprintf(label, sizeof label, "%s %s", strcmp(from, "a_to_b") == 0 ? "A to B" : "B to A", figures[i].name);
        put(result, key, label, figures[i].figure);
    }
}

vv_status cli_measure_mesh_distance(cli_result *result, const char *path_a, const char *path_b)
{
    cli_command *command = result->command;
    vv_mesh_tree *a = NULL, *b = NULL;
    vv_mesh_foot on_a, on_b;
    vv_mesh_distances d;
    char unit[16], unit_b[16];
    vv_status st = read_tree(&a, unit, command, path_a);
    if (st == VV_OK && (st = read_tree(&b, unit_b, command, path_b)) == VV_OK && strcmp(unit, unit_b) != 0)
        st = vv_fail(VV_E_ARGUMENT, "%s is in %s and %s in %s: convert one", path_a, unit, path_b, unit_b);
    if (st == VV_OK && (st = vv_mesh_least_distance(&on_a, &on_b, a, b, command->job)) == VV_OK &&
        (st = vv_mesh_distance(&d, a, b, NULL, command->job)) == VV_OK) {
        cli_figure least = {.key = "distance", .label = "least", .value = on_a.distance, .error = NAN};
        snprintf(least.unit, sizeof least.unit, "%s", unit);
        cli_json_string(&command->json, "unit", unit);
        cli_figure_put(result, &least);
        put_deviation(result, "a_to_b", &d.a_to_b);
        put_deviation(result, "b_to_a", &d.b_to_a);
        put(result, "hausdorff", "Hausdorff", &d.hausdorff);
    }
    vv_mesh_tree_release(a);
    vv_mesh_tree_release(b);
    return st;
}

vv_status cli_measure_mesh_point(cli_result *result, const char *path, vv_vec3 point)
{
    cli_command *command = result->command;
    vv_mesh_tree *tree = NULL;
    vv_mesh_foot foot;
    char unit[16];
    const vv_status st = read_tree(&tree, unit, command, path);
    if (st == VV_OK) {
        vv_mesh_tree_nearest(&foot, tree, point);
        cli_figure f = {.key = "distance", .label = "distance", .value = foot.distance, .error = NAN};
        snprintf(f.unit, sizeof f.unit, "%s", unit);
        cli_json_string(&command->json, "unit", unit);
        cli_figure_put(result, &f);
        cli_json_number(&command->json, "signed_distance", foot.signed_distance);
        cli_json_numbers(&command->json, "nearest", (double[]){foot.at.x, foot.at.y, foot.at.z}, 3);
        if (!result->csv)
            cli_command_line(command, "nearest", "%.7g, %.7g, %.7g%s", foot.at.x, foot.at.y, foot.at.z,
                             foot.signed_distance < 0 ? ": the place is inside" : "");
    }
    vv_mesh_tree_release(tree);
    return st;
}
