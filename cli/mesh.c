#include "mesh.h"
#include "core/units.h"
#include "grid/mesh.h"
#include "input.h"
#include "io/format.h"
#include "io/mesh_file.h"
#include "output.h"
#include "refusal.h"
#include "value.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <volvis/measure_mesh.h>

bool cli_mesh_is_output(const cli_command *command, const char *output, const char *format)
{
    return format ? vvi_mesh_format_find(format, command->registry) != NULL
                  : vvi_mesh_format_of_path(output, command->registry) != NULL;
}

typedef bool is_head_fn(const uint8_t *head, size_t n, const char *path, const vv_registry *registry);

/* What the first bytes of FILE[:PART][@N] say. */
static bool head_says(is_head_fn *is, const cli_command *command, const char *word)
{
    unsigned char head[4096];
    cli_input_name name;
    if (cli_input_split(&name, word) != VV_OK)
        return false;
    const size_t n = cli_input_peek(head, sizeof head, name.path);
    const bool answer = is(head, n, name.path, command->registry);
    cli_input_name_free(&name);
    return answer;
}

bool cli_mesh_is_input(const cli_command *command, const char *word)
{
    const cli_reading *reading = cli_command_options(command, &cli_reading_class);
    if (reading->raw || vv_job_cancelled(command->job))
        return false;
    if (reading->input_format)
        return vvi_mesh_format_find(reading->input_format, command->registry) != NULL;
    return head_says(vvi_mesh_is_head, command, word);
}

static bool is_certain(const uint8_t *head, size_t n, const char *path, const vv_registry *registry)
{
    return n > 0 && vvi_format_is_certain(head, n, path, registry);
}

bool cli_mesh_is_volume(const cli_command *command, const char *word)
{
    const cli_reading *reading = cli_command_options(command, &cli_reading_class);
    if (reading->input_format || vv_job_cancelled(command->job) || cli_mesh_is_input(command, word))
        return false;
    return head_says(is_certain, command, word);
}

/* Reading --------------------------------------------------------------------------------------------------------- */

typedef struct mesh_input {
    vv_mesh *mesh;
    const vv_mesh_format *format;
    vv_notes *notes;
    double read_s;
} mesh_input;

static void finish(mesh_input *in)
{
    vv_mesh_release(in->mesh);
    vvi_notes_free(in->notes);
}

/* "0.5mm": what one unit of the file is. *factor: 0.5, the rest is the unit. */
static vv_status split_unit(double *factor, const char **unit)
{
    const char *end;
    *factor = 1;
    if (!*unit || !vvi_scan_number(factor, *unit, &end) || end == *unit)
        return VV_OK;
    if (!(*factor > 0 && *factor < 1e30))
        return vv_fail(VV_E_ARGUMENT, "--input-unit: '%.20s' is not a valid length", *unit);
    *unit = end;
    return VV_OK;
}

static vv_status check_unit(const char *unit, const char *option)
{
    if (!unit || vvi_length_unit_metres(unit) > 0)
        return VV_OK;
    return vv_fail(VV_E_ARGUMENT,
                   "--%s: '%.20s' is not a unit of length; expected m, cm, mm, um, nm, pm, A, km, in or ft", option,
                   unit);
}

/* What the file itself says stays. */
static vv_status scale(vv_mesh **mesh, double factor, const char *unit, vv_job *job)
{
    vv_mesh *scaled;
    if (strcmp(vv_mesh_get_info(*mesh)->unit, unit) != 0)
        return VV_OK;
    const vv_status st = vvi_mesh_scaled(&scaled, *mesh, factor, unit, job);
    vv_mesh_release(*mesh);
    *mesh = scaled;
    return st;
}

vv_status cli_mesh_check_frame(const cli_command *command, const cli_input_name *name)
{
    const cli_reading *reading = cli_command_options(command, &cli_reading_class);
    if (name->frame >= 0)
        return vv_fail_at(VV_E_ARGUMENT, name->path, NULL,
                          "is a mesh, which has no time steps: leave '@%" PRId64 "' out", name->frame);
    if (!vv_object_is_set(&reading->base, "frame"))
        return VV_OK;
    return cli_refused(command, "frame",
                       vv_fail_at(VV_E_ARGUMENT, name->path, NULL,
                                  "is a mesh, which has no time steps: leave '--frame %" PRId64 "' out",
                                  reading->frame));
}

static vv_status check_missing(const cli_command *command, const char *path)
{
    const cli_reading *reading = cli_command_options(command, &cli_reading_class);
    if (!reading->missing)
        return VV_OK;
    return cli_refused(
        command, "missing",
        vv_fail_at(VV_E_ARGUMENT, path, NULL, "is a mesh, and --missing is about samples of volumes: leave it out"));
}

static vv_status read_named(mesh_input *out, cli_command *command, const cli_input_name *name, const char *input_unit)
{
    const cli_reading *reading = cli_command_options(command, &cli_reading_class);
    vv_mesh_read_options options;
    const char *text;
    double factor;
    vv_status st = cli_mesh_check_frame(command, name);
    if (st != VV_OK || (st = check_missing(command, name->path)) != VV_OK)
        return st;
    vv_mesh_read_options_init(&options, sizeof options);
    options.format = reading->input_format;
    options.part = name->part ? name->part : reading->part;
    const double start = cli_now_s();
    st = split_unit(&factor, &input_unit);
    options.unit = input_unit;
    if (st == VV_OK && (st = check_unit(input_unit, "input-unit")) == VV_OK &&
        (st = vvi_notes_new(&out->notes, command->job)) == VV_OK)
        st = vvi_mesh_read_noted(&out->mesh, &out->format, out->notes, name->path, &options, command->job);
    if (st == VV_OK && factor != 1)
        st = scale(&out->mesh, factor, input_unit, command->job);
    out->read_s = cli_now_s() - start;
    for (size_t i = 0; st == VV_OK && (text = vvi_notes_warning(out->notes, i)); i++)
        cli_command_note(command, "warning: %s: %s", name->path, text);
    return st;
}

static vv_status read_mesh(mesh_input *out, cli_command *command, const char *word, const char *input_unit)
{
    cli_input_name name;
    vv_status st = cli_input_split(&name, word);
    if (st != VV_OK)
        return st;
    st = read_named(out, command, &name, input_unit);
    cli_input_name_free(&name);
    return st;
}

vv_status cli_mesh_read(vv_mesh **out, cli_command *command, const char *word, const char *input_unit)
{
    mesh_input in = {0};
    const vv_status st = read_mesh(&in, command, word, input_unit);
    *out = in.mesh;
    in.mesh = NULL;
    finish(&in);
    return st;
}

/* Telling --------------------------------------------------------------------------------------------------------- */

static void describe(char out[128], const vv_mesh_info *m)
{
    snprintf(out, 128, "%zu %s, %zu triangle%s%s%s%s", m->n_vertices, m->n_vertices == 1 ? "vertex" : "vertices",
             m->n_triangles, m->n_triangles == 1 ? "" : "s", m->normals ? ", normals" : "", m->values ? ", values" : "",
             m->colors ? ", colours" : "");
}

static void json_parts(vvi_result *json, const vv_mesh_info *m)
{
    vvi_result_open(json, "parts", '[');
    for (size_t i = 0; i < m->n_parts; i++) {
        const vv_mesh_part *part = &m->parts[i];
        vvi_result_open(json, NULL, '{');
        vvi_result_string(json, "name", part->name);
        vvi_result_unsigned(json, "triangles", part->n_triangles);
        if (part->color.a >= 0)
            vvi_result_numbers(json, "color", &part->color.r, 4);
        vvi_result_close(json, '}');
    }
    vvi_result_close(json, ']');
}

static void json_notes(vvi_result *json, const vv_notes *notes)
{
    const char *key, *value;
    vvi_result_open(json, "metadata", '[');
    for (size_t i = 0; vvi_notes_get(notes, i, &key, &value); i++) {
        vvi_result_open(json, NULL, '{');
        vvi_result_string(json, "key", key);
        vvi_result_string(json, "value", value);
        vvi_result_close(json, '}');
    }
    vvi_result_close(json, ']');
    vvi_result_open(json, "warnings", '[');
    for (size_t i = 0; (value = vvi_notes_warning(notes, i)); i++)
        vvi_result_string(json, NULL, value);
    vvi_result_close(json, ']');
}

static bool has_area(const vv_mesh_info *m, const vv_mesh_topology *t)
{
    return m->n_triangles > t->n_degenerate;
}

static void json_mesh(cli_command *command, const char *path, const mesh_input *in, const vv_mesh_topology *t,
                      const vv_mesh_measures *measures)
{
    const vv_mesh_info *m = vv_mesh_get_info(in->mesh);
    vvi_result *json = &command->json;
    vvi_result_string(json, "file", path);
    vvi_result_string(json, "format", in->format->name);
    vvi_result_unsigned(json, "vertices", m->n_vertices);
    vvi_result_unsigned(json, "triangles", m->n_triangles);
    vvi_result_bool(json, "normals", m->normals != NULL);
    vvi_result_bool(json, "values", m->values != NULL);
    vvi_result_bool(json, "colors", m->colors != NULL);
    vvi_result_string(json, "value_name", m->value_name);
    vvi_result_string(json, "value_unit", m->value_unit);
    json_parts(json, m);
    vvi_result_numbers(json, "lo", &measures->bounds.lo.x, 3);
    vvi_result_numbers(json, "hi", &measures->bounds.hi.x, 3);
    vvi_result_string(json, "unit", m->unit);
    vvi_result_string(json, "space", m->space == VV_SPACE_RAS ? "RAS" : "plain");
    vvi_result_bool(json, "closed", has_area(m, t) && t->n_open_edges + t->n_crowded_edges + t->n_turned_edges == 0);
    vvi_result_unsigned(json, "edges", t->n_edges);
    vvi_result_unsigned(json, "open_edges", t->n_open_edges);
    vvi_result_unsigned(json, "crowded_edges", t->n_crowded_edges);
    vvi_result_unsigned(json, "turned_edges", t->n_turned_edges);
    vvi_result_unsigned(json, "degenerate_triangles", t->n_degenerate);
    vvi_result_unsigned(json, "unused_vertices", t->n_unused);
    vvi_result_unsigned(json, "pieces", t->n_pieces);
    vvi_result_number(json, "area", measures->area.value);
    vvi_result_number(json, "volume", measures->volume.value);
    vvi_result_bool(json, "inside_out", measures->inside_out);
    json_notes(json, in->notes);
}

static void text_parts(cli_command *command, const vv_mesh_info *m)
{
    enum { SHOWN = 20 };
    for (size_t i = 0; i < m->n_parts && i < SHOWN; i++)
        cli_command_line(command, i ? "" : "parts", "%s: %zu %s", m->parts[i].name[0] ? m->parts[i].name : "(no name)",
                         m->parts[i].n_triangles, cli_plural(m->parts[i].n_triangles, "triangle", "triangles"));
    if (m->n_parts > SHOWN)
        cli_command_line(command, "", "and %zu more (--json lists them)", m->n_parts - SHOWN);
}

/* Vertices of a seam are two at one place: the edges there are open, and yet nothing gapes. */
static void text_closed(cli_command *command, const vv_mesh_topology *t, bool has_area, bool no_gap)
{
    const char *ending = t->n_pieces == 1 ? "" : "s";
    if (!has_area)
        cli_command_line(command, "closed", "no: there is no triangle that has an area");
    else if (t->n_edges > 0 && t->n_open_edges + t->n_crowded_edges + t->n_turned_edges == 0)
        cli_command_line(command, "closed", "yes: every edge joins two triangles; %zu piece%s", t->n_pieces, ending);
    else if (t->n_edges > 0 && t->n_open_edges + t->n_crowded_edges == 0)
        cli_command_line(command, "closed",
                         "no: there are no holes, but triangles that face the wrong way; %zu piece%s", t->n_pieces,
                         ending);
    else if (no_gap && t->n_open_edges == 0)
        cli_command_line(command, "closed", "yes, without a gap, but it touches itself; %zu piece%s", t->n_pieces,
                         ending);
    else if (no_gap)
        cli_command_line(command, "closed",
                         "yes, without a gap, but in %zu piece%s that share no vertices: %zu edges lie along seams",
                         t->n_pieces, ending, t->n_open_edges);
    else if (t->n_open_edges == 0)
        cli_command_line(command, "closed", "no: %zu edge%s of three or more triangles; %zu piece%s",
                         t->n_crowded_edges, t->n_crowded_edges == 1 ? "" : "s", t->n_pieces, ending);
    else
        cli_command_line(command, "closed", "no: %zu edge%s of one triangle only, at holes or rims; %zu piece%s",
                         t->n_open_edges, t->n_open_edges == 1 ? "" : "s", t->n_pieces, ending);
}

static void text_topology(cli_command *command, const vv_mesh_topology *t, bool has_area, bool no_gap)
{
    text_closed(command, t, has_area, no_gap);
    if (t->n_crowded_edges > 0)
        cli_command_line(command, "crowded",
                         "%zu %s where three or more triangles meet: the surface branches or "
                         "touches itself there",
                         t->n_crowded_edges, cli_plural(t->n_crowded_edges, "edge", "edges"));
    if (t->n_turned_edges > 0)
        cli_command_line(command, "turned", "%zu %s between neighbours of which one shows its outside, one its inside",
                         t->n_turned_edges, cli_plural(t->n_turned_edges, "edge", "edges"));
    if (t->n_degenerate > 0)
        cli_command_line(command, "degenerate", "%zu %s without area", t->n_degenerate,
                         cli_plural(t->n_degenerate, "triangle", "triangles"));
    if (t->n_unused > 0)
        cli_command_line(command, "unused", "%zu %s of no triangle", t->n_unused,
                         cli_plural(t->n_unused, "vertex", "vertices"));
}

static void text_mesh(cli_command *command, const char *path, const mesh_input *in, const vv_mesh_topology *t,
                      const vv_mesh_measures *measures)
{
    const vv_mesh_info *m = vv_mesh_get_info(in->mesh);
    const vv_vec3 lo = measures->bounds.lo, hi = measures->bounds.hi;
    char about[128];
    describe(about, m);
    cli_command_title(command, path);
    cli_command_line(command, "format", "%s", in->format->name);
    cli_command_line(command, "mesh", "%s", about);
    if (m->values && m->value_name[0])
        cli_command_line(command, "values", "%s %s", m->value_name, m->value_unit);
    text_parts(command, m);
    if (m->n_vertices > 0) {
        cli_command_line(command, "bounds", "%g .. %g, %g .. %g, %g .. %g %s", lo.x, hi.x, lo.y, hi.y, lo.z, hi.z,
                         m->unit);
        cli_command_line(command, "size", "%g x %g x %g %s", hi.x - lo.x, hi.y - lo.y, hi.z - lo.z, m->unit);
    }
    text_topology(command, t, has_area(m, t), measures->closed);
    cli_command_line(command, "area", "%g %s", measures->area.value, measures->area.unit);
    if (!isnan(measures->volume.value))
        cli_command_line(command, "volume", "%g %s%s", measures->volume.value, measures->volume.unit,
                         measures->inside_out ? " (its triangles face inwards)" : "");
}

vv_status cli_mesh_info(cli_command *command, const char *path, const char *input_unit)
{
    mesh_input in = {0};
    vv_mesh_topology topology;
    vv_mesh_measures measures;
    vv_mesh_measure_options options;
    vv_mesh_measure_options_init(&options, sizeof options);
    options.open = true;
    vv_status st = read_mesh(&in, command, path, input_unit);
    if (st == VV_OK && (st = vv_mesh_count_topology(&topology, in.mesh, command->job)) == VV_OK &&
        (st = vv_mesh_measure(&measures, in.mesh, &options, command->job)) == VV_OK) {
        json_mesh(command, path, &in, &topology, &measures);
        text_mesh(command, path, &in, &topology, &measures);
    }
    finish(&in);
    return st;
}

/* Converting ------------------------------------------------------------------------------------------------------ */

static void fill_options(vv_mesh_write_options *out, const cli_command *command, const char *unit)
{
    cli_output_mesh_options(out, command);
    out->unit = unit;
}

static vv_status check_mesh_output(const cli_command *command, const char *path, const char *output, const char *unit)
{
    const cli_writing *writing = cli_command_options(command, &cli_writing_class);
    const vv_format *volume;
    vv_mesh_write_options options;
    vv_status st = check_unit(unit, "unit");
    if (st != VV_OK)
        return st;
    if (!cli_mesh_is_output(command, output, writing->output_format) &&
        cli_output_format(&volume, command, output, writing->output_format) == VV_OK)
        return vv_fail_at(VV_E_UNSUPPORTED, path, NULL,
                          "is a mesh, and %s is a format of volumes: meshes cannot be made volumes of yet; name a mesh "
                          "file, such as .ply",
                          volume->name);
    fill_options(&options, command, unit);
    return cli_refused(command, "encoding,big-endian", vv_mesh_check(output, &options, command->job));
}

static void report(cli_command *command, const char *output, const mesh_input *in, double write_s)
{
    const vv_mesh_info *m = vv_mesh_get_info(in->mesh);
    char about[128];
    describe(about, m);
    vvi_result_string(&command->json, "output", output);
    vvi_result_unsigned(&command->json, "vertices", m->n_vertices);
    vvi_result_unsigned(&command->json, "triangles", m->n_triangles);
    vvi_result_number(&command->json, "load_s", in->read_s);
    vvi_result_number(&command->json, "write_s", write_s);
    vvi_text_add_clean(&command->text, output);
    vvi_text_printf(&command->text, ": %s; read %.2f s, written %.2f s\n", about, in->read_s, write_s);
}

vv_status cli_mesh_convert(cli_command *command, const char *path, const char *input_unit, const char *unit)
{
    const cli_writing *writing = cli_command_options(command, &cli_writing_class);
    const char *output = command->common->output;
    mesh_input in = {0};
    vv_mesh_write_options options;
    vv_status st = check_mesh_output(command, path, output, unit);
    if (st != VV_OK || (st = cli_output_check(command, output, CLI_OUTPUT_MESH, writing->output_format)) != VV_OK)
        return st;
    fill_options(&options, command, unit);
    st = read_mesh(&in, command, path, input_unit);
    const double start = cli_now_s();
    if (st == VV_OK && command->common->dry_run)
        report(command, output, &in, 0);
    else if (st == VV_OK && (st = vv_mesh_write(output, in.mesh, &options, command->job)) == VV_OK)
        report(command, output, &in, cli_now_s() - start);
    finish(&in);
    return st;
}
