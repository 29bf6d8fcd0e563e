#include "mesh.h"
#include "core/units.h"
#include "grid/info_text.h"
#include "grid/mesh.h"
#include "input.h"
#include "io/format.h"
#include "io/mesh_file.h"
#include "measure.h"
#include "output.h"
#include "refusal.h"
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <volvis/about.h>

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

vv_status cli_mesh_info(cli_command *command, const char *path, const char *input_unit)
{
    mesh_input in = {0};
    vv_answer *answer = NULL;
    vv_status st = read_mesh(&in, command, path, input_unit);
    if (st == VV_OK && (st = vv_about_mesh(&answer, in.mesh, command->job)) == VV_OK) {
        cli_command_title(command, path);
        vvi_result_string(&command->json, "file", path);
        vvi_result_string(&command->json, "format", in.format->name);
        cli_command_line(command, "format", "%s", in.format->name);
        cli_answer_print(command, answer, false, false);
        json_notes(&command->json, in.notes);
    }
    vv_answer_release(answer);
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
    char about[VVI_MESH_TEXT];
    vvi_mesh_print(about, m);
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
