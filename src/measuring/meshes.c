/* Area, volume and box of mesh files, and distances between two of them. */
#include "measuring/meshes.h"
#include "core/vec.h"
#include "io/mesh_file.h"
#include "measure.h"
#include "mesh.h"
#include "value.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <volvis/measure_mesh.h>
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
    const double error[3] = {m->centroid[0].error, m->centroid[1].error, m->centroid[2].error};
    cli_vector_put(result, "centroid", centre, error, unit);
    vvi_result_numbers(&command->json, "centroid_error", error, 3);
    cli_vector_put(result, "box_lo", (double[]){lo.x, lo.y, lo.z}, NULL, unit);
    cli_vector_put(result, "box_hi", (double[]){hi.x, hi.y, hi.z}, NULL, unit);
    cli_vector_put(result, "box_size", size, NULL, unit);
    if (result->csv)
        return;
    char text[CLI_FIGURE_TEXT];
    cli_place_print(text, centre, error);
    if (!isnan(centre[0]))
        cli_command_line(command, "centroid", "%s %s", text, unit);
    if (empty) {
        cli_command_line(command, "box", "empty");
        return;
    }
    cli_command_line(command, "box", "%.6g .. %.6g, %.6g .. %.6g, %.6g .. %.6g %s", lo.x, hi.x, lo.y, hi.y, lo.z, hi.z,
                     unit);
    cli_command_line(command, "", "%.6g x %.6g x %.6g %s", size[0], size[1], size[2], unit);
}

void cli_mesh_measures_put(cli_result *result, const char *what, const vv_mesh_measures *m, const char *unit)
{
    cli_command *command = result->command;
    const bool all = strcmp(what, "summary") == 0;
    vvi_result_string(&command->json, "unit", unit);
    vvi_result_string(&command->json, "method", "triangles");
    vvi_result_unsigned(&command->json, "triangles", m->n_triangles);
    vvi_result_bool(&command->json, "closed", m->closed);
    vvi_result_unsigned(&command->json, "turned_edges", m->n_turned_edges);
    if (!result->csv && all)
        cli_command_line(command, "mesh", "%zu %s, %s", m->n_triangles,
                         cli_plural(m->n_triangles, "triangle", "triangles"),
                         m->closed                              ? "closed"
                         : m->n_turned_edges == m->n_open_edges ? "no holes, but turned triangles: it has no volume"
                                                                : "open: it has no volume");
    if (all || strcmp(what, "area") == 0)
        put(result, "area", "area", &m->area);
    if ((all && m->closed) || strcmp(what, "volume") == 0)
        put(result, "volume", "volume", &m->volume);
    if (all || strcmp(what, "box") == 0)
        put_place(result, m, unit);
    if (m->inside_out)
        cli_command_note(command, "the triangles face inwards; the volume is given as if they faced outwards");
}

vv_status cli_measure_mesh(cli_result *result, const char *what, const char *path)
{
    cli_command *command = result->command;
    const cli_measure_options *options = cli_command_options(command, &cli_measure_class);
    vv_mesh *mesh = NULL;
    vv_mesh_measure_options o;
    vv_mesh_measures m;
    vv_mesh_measure_options_init(&o, sizeof o);
    o.open = strcmp(what, "volume") != 0;
    vv_status st = cli_mesh_read(&mesh, command, path, options->input_unit);
    if (st == VV_OK && (st = vv_mesh_measure(&m, mesh, &o, command->job)) == VV_OK)
        cli_mesh_measures_put(result, what, &m, vv_mesh_get_info(mesh)->unit);
    else if (st != VV_OK && mesh)
        st = vv_fail_in(st, "%s", path);
    vv_mesh_release(mesh);
    return st;
}
