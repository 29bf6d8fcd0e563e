#include "command.h"
#include "core/job.h"
#include "core/units.h"
#include "info_folder.h"
#include "info_ids.h"
#include "info_names.h"
#include "info_preview.h"
#include "info_scene.h"
#include "info_statistics.h"
#include "input.h"
#include "io/channel_colors.h"
#include "io/file_stream.h"
#include "mesh.h"
#include "output.h"
#include "pipeline.h"
#include "refusal.h"
#include "report.h"
#include "run/stream.h"
#include "terminal.h"
#include "value.h"
#include "verbs.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct info_options {
    vv_object base;
    bool stats;
    int preview;
    char *size, *input_unit;
} info_options;

enum { RANGE_BYTES = 64 << 20 }; /* of samples, which are looked at without being asked */
#define TILT_LEAST 0.05          /* degrees; less is the rounding of numbers in headers */

static const char *const previews[] = {"none", "auto", "sixel", "blocks", NULL};

static const vv_property rows[] = {
    {VV_PROP(info_options, stats), .kind = VV_KIND_BOOL,
     .doc = "read all samples: range, mean, percentiles, histogram"},
    {VV_PROP(info_options, preview), .kind = VV_KIND_ENUM, .names = previews, .def = CLI_PREVIEW_NONE,
     .doc = "three slices through the middle, in the terminal or, with -o, as an image file"},
    {VV_PROP(info_options, size), .kind = VV_KIND_STRING, .unit = "WxH", .automatic = "as large as the slices need",
     .doc = "pixels of the preview's file"},
    {VV_PROP(info_options, input_unit), .kind = VV_KIND_STRING, .unit = "UNIT", .automatic = "none",
     .doc = "unit of lengths in a mesh file that gives none, or counts voxels: mm, or 0.5mm for each"},
    {0},
};

static const vv_class options_class = {
    .name = "info",
    .doc = "options of info",
    .size = sizeof(info_options),
    .properties = rows,
};

static const char *const meaning_names[] = {"scalar", "RGB", "RGBA", "vector", "label"};
static const char *const space_names[] = {"plain", "RAS"};

static void json_placement(vvi_result *json, const vv_grid *grid)
{
    const double dims[3] = {(double)grid->dims[0], (double)grid->dims[1], (double)grid->dims[2]};
    const double spacing[3] = {vv_grid_spacing(grid, 0), vv_grid_spacing(grid, 1), vv_grid_spacing(grid, 2)};
    const vv_affine *map = &grid->index_to_world;
    const double origin[3] = {map->origin.x, map->origin.y, map->origin.z};
    vvi_result_numbers(json, "dims", dims, 3);
    vvi_result_numbers(json, "spacing", spacing, 3);
    vvi_result_numbers(json, "origin", origin, 3);
    vvi_result_open(json, "directions", '[');
    for (int a = 0; a < 3; a++) {
        const double unit[3] = {map->axis[a].x / spacing[a], map->axis[a].y / spacing[a], map->axis[a].z / spacing[a]};
        vvi_result_numbers(json, NULL, unit, 3);
    }
    vvi_result_close(json, ']');
    vvi_result_string(json, "unit", grid->unit);
    vvi_result_string(json, "space", space_names[grid->space]);
}

static void json_header(vvi_result *json, const cli_input *input, const char *id, uint64_t bytes)
{
    const vv_field_info *info = vv_file_info(input->file);
    char letters[16];
    const char *key, *value;
    vv_grid_orientation(letters, &info->grid);
    vvi_result_string(json, "file", input->path);
    vvi_result_string(json, "format", vv_file_format(input->file));
    json_placement(json, &info->grid);
    vvi_result_string(json, "orientation", letters);
    vvi_result_string(json, "type", vv_type_name(info->type));
    vvi_result_integer(json, "components", info->components);
    vvi_result_string(json, "meaning", meaning_names[info->meaning]);
    vvi_result_integer(json, "frames", info->n_frames);
    vvi_result_number(json, "frame_step", info->frame_step);
    vvi_result_string(json, "frame_unit", info->frame_unit);
    vvi_result_string(json, "name", info->name);
    vvi_result_string(json, "volume", id);
    vvi_result_string(json, "value_unit", info->value_unit);
    vvi_result_number(json, "value_scale", info->value_scale);
    vvi_result_number(json, "value_offset", info->value_offset);
    vvi_result_unsigned(json, "memory_bytes", bytes);
    vvi_result_bool(json, "mappable", vv_file_mappable(input->file));
    vvi_result_open(json, "metadata", '{');
    for (size_t i = 0; vv_file_metadata(input->file, i, &key, &value); i++)
        vvi_result_string(json, key, value);
    vvi_result_close(json, '}');
    vvi_result_open(json, "warnings", '[');
    for (size_t i = 0; (value = vv_file_warning(input->file, i)); i++)
        vvi_result_string(json, NULL, value);
    vvi_result_close(json, ']');
}

/* The largest angle between an axis of the grid and the axis of the world that it runs along, in degrees. */
static double tilt_of(const vv_grid *grid)
{
    double most = 0;
    for (int i = 0; i < 3; i++) {
        const vv_vec3 a = grid->index_to_world.axis[i];
        const double along = fmax(fabs(a.x), fmax(fabs(a.y), fabs(a.z)));
        const double beside = sqrt(fmax(0, a.x * a.x + a.y * a.y + a.z * a.z - along * along));
        most = fmax(most, atan2(beside, along) * 180 / 3.14159265358979323846);
    }
    return most;
}

static void text_tilt(cli_command *command, const vv_grid *grid)
{
    const double tilt = tilt_of(grid);
    const vv_affine *m = &grid->index_to_world;
    const double row[3][4] = {{m->axis[0].x, m->axis[1].x, m->axis[2].x, m->origin.x},
                              {m->axis[0].y, m->axis[1].y, m->axis[2].y, m->origin.y},
                              {m->axis[0].z, m->axis[1].z, m->axis[2].z, m->origin.z}};
    if (!(tilt >= TILT_LEAST))
        return;
    cli_command_line(command, "tilt", "%.2f degrees from the axes of the world", tilt);
    for (int r = 0; r < 3; r++) /* in columns, which cli_command_line() would close up */
        vvi_text_printf(&command->text, "%-13s%11.6g %11.6g %11.6g  %11.6g\n", r ? "" : "to world", row[r][0] + 0.0,
                        row[r][1] + 0.0, row[r][2] + 0.0, row[r][3] + 0.0);
}

static void text_placement(cli_command *command, const vv_grid *grid)
{
    char letters[16];
    const double spacing[3] = {vv_grid_spacing(grid, 0), vv_grid_spacing(grid, 1), vv_grid_spacing(grid, 2)};
    const bool measured = strcmp(grid->unit, "voxels") != 0;
    const char *unit = measured ? grid->unit : "(the file gives no spacing)";
    const vv_vec3 o = grid->index_to_world.origin;
    vv_grid_orientation(letters, grid);
    cli_command_line(command, "spacing", "%g x %g x %g %s", spacing[0], spacing[1], spacing[2], unit);
    cli_command_line(command, "size", "%g x %g x %g %s", spacing[0] * (double)grid->dims[0],
                     spacing[1] * (double)grid->dims[1], spacing[2] * (double)grid->dims[2], grid->unit);
    if (grid->space == VV_SPACE_RAS)
        cli_command_line(command, "orientation", "%s (letter = direction of increase along x, y, z)", letters);
    else
        cli_command_line(command, "orientation", "%s (the world axis that x, y, z run along)", letters);
    cli_command_line(command, "origin", "%g, %g, %g %s", o.x + 0.0, o.y + 0.0, o.z + 0.0, grid->unit);
    text_tilt(command, grid);
}

static void text_values(cli_command *command, const vv_field_info *info)
{
    char scaled[96];
    vvi_scaled_print(scaled, "stored", info->value_scale, info->value_offset);
    if (info->value_scale != 1 || info->value_offset != 0)
        cli_command_line(command, "values", "%s %s", scaled, info->value_unit);
    else if (info->value_unit[0])
        cli_command_line(command, "values", "in %s", info->value_unit);
    if (info->n_frames > 1 && info->frame_step > 0)
        cli_command_line(command, "time", "%" PRId64 " steps of %g %s", info->n_frames, info->frame_step,
                         info->frame_unit);
}

static void text_header(cli_command *command, const cli_input *input, const char *id, uint64_t bytes)
{
    const vv_field_info *info = vv_file_info(input->file);
    char size[32], about[128];
    const char *key, *value;
    vvi_samples_print(about, info, info->n_frames);
    vvi_print_bytes(size, bytes);
    cli_command_title(command, input->path);
    cli_command_line(command, "format", "%s", vv_file_format(input->file));
    cli_command_line(command, "samples", "%s, %s", about, meaning_names[info->meaning]);
    text_placement(command, &info->grid);
    text_values(command, info);
    cli_info_missing(command, input);
    cli_command_line(command, "memory", "%s%s", size,
                     vv_file_mappable(input->file) ? " (used where it lies, not read)" : "");
    cli_command_line(command, "in a scene", "volumes.%s%s", id, vvi_has_channels(info) ? " and so on" : "");
    for (size_t i = 0; vv_file_metadata(input->file, i, &key, &value); i++) {
        if (command->common->verbose)
            cli_command_line(command, i ? "" : "header", "%s: %s", key, value);
    }
}

static bool is_stopping(vv_status st)
{
    return st == VV_OK || st == VV_E_CANCELLED;
}

/* Without --stats, a look at what is quickly read: for people, and for the exit code, which is one with --json. What
 * cannot be read is told: the header was right. */
static vv_status look_at_range(cli_command *command, const cli_input *input, uint64_t bytes)
{
    vv_field *field = NULL;
    const int64_t frame = input->frame < 0 ? 0 : input->frame;
    if (bytes > RANGE_BYTES && !vvi_file_lacks(input->file)) {
        cli_command_line(command, "range", "samples were not looked at; --stats does");
        return VV_OK;
    }
    vv_status st = vv_file_read(&field, input->file, frame, NULL, command->job);
    if (st == VV_OK)
        st = cli_info_range(command, input, field);
    vv_field_release(field);
    if (is_stopping(st))
        return st;
    cli_command_line(command, "range", "samples cannot be read: %s", vv_error_last()->message);
    if (vvi_file_lacks(input->file) || cli_report_exit_code(st, NULL) == CLI_EXIT_INPUT)
        command->exit_code = command->exit_code > CLI_EXIT_INPUT ? command->exit_code : CLI_EXIT_INPUT;
    return VV_OK;
}

/* What takes samples: all of them for statistics, which the preview then has at hand. */
static vv_status look_at_samples(cli_command *command, const cli_input *input, const info_options *options,
                                 uint64_t bytes)
{
    vv_field *field = NULL;
    vvi_stream stream = {0};
    const int64_t frame = input->frame < 0 ? 0 : input->frame;
    const bool lacks = vvi_file_lacks(input->file);
    vv_status st = options->stats && !lacks ? VV_OK : look_at_range(command, input, bytes);
    if (lacks)
        return st;
    if (st == VV_OK && options->stats &&
        (st = vvi_stream_samples(&field, &stream, input->file, frame, command->job)) == VV_OK)
        st = cli_info_statistics(command, input, field);
    if (st == VV_OK && options->preview != CLI_PREVIEW_NONE)
        st = cli_info_preview(command, input, field, (cli_preview_kind)options->preview, options->size);
    vv_field_release(field);
    vvi_stream_free(&stream);
    return st;
}

static vv_status info_of_data(cli_command *command, const char *word, cli_info_ids *ids)
{
    const info_options *options = cli_command_options(command, &options_class);
    cli_input input = {0};
    uint64_t bytes = 0;
    char id[64];
    vv_status st;
    if ((st = cli_input_open(&input, command, word)) != VV_OK)
        return st == VV_E_FORMAT && cli_info_folder(command, word, true) ? VV_OK : st;
    const vv_field_info *info = vv_file_info(input.file);
    if (options->preview != CLI_PREVIEW_NONE) /* its samples are read again, after a look at their range */
        st = vvi_file_make_repeatable(input.file, command->job);
    if (st == VV_OK && (st = vv_field_info_bytes(&bytes, info)) == VV_OK &&
        (st = cli_info_ids_take(id, ids, input.path, info)) == VV_OK) {
        json_header(&command->json, &input, id, bytes);
        text_header(command, &input, id, bytes);
        cli_info_parts(command, &input);
        cli_info_folder(command, word, false);
        if (!options->stats) {
            cli_info_channels(command, &input);
            cli_info_labels(command, &input);
        }
        st = look_at_samples(command, &input, options, bytes);
    }
    cli_input_close(&input);
    return st;
}

/* With a preview -o is where the picture goes, and the text stays on standard output. */
static vv_status check_preview(cli_command *command)
{
    const info_options *options = cli_command_options(command, &options_class);
    const char *output = command->common->output;
    if (options->size && (!output || options->preview == CLI_PREVIEW_NONE))
        return cli_refused(
            command, "size",
            vv_fail(VV_E_ARGUMENT, "--size is the size of a preview file: give --preview and -o FILE as well"));
    if (!output)
        return VV_OK;
    if (options->preview == CLI_PREVIEW_NONE)
        return cli_output_check_text(command, output);
    if (command->args.n_words > 1)
        return cli_refused(command, "preview",
                           vv_fail(VV_E_ARGUMENT,
                                   "a preview file is made of one input; there are %zu: give one, or omit -o",
                                   command->args.n_words));
    command->verb.makes_file = true;
    return cli_output_check(command, output, CLI_OUTPUT_IMAGE, NULL);
}

static vv_status info_of_mesh(cli_command *command, const char *word)
{
    const info_options *options = cli_command_options(command, &options_class);
    if (options->stats || options->preview != CLI_PREVIEW_NONE)
        return cli_refused(
            command, "stats,preview",
            vv_fail_at(VV_E_ARGUMENT, word, NULL, "is a mesh: --stats and --preview need samples of volumes"));
    return cli_mesh_info(command, word, options->input_unit);
}

static vv_status info_of(cli_command *command, const char *word, cli_info_ids *ids)
{
    if (cli_mesh_is_input(command, word))
        return info_of_mesh(command, word);
    switch (cli_input_contents(command, word)) {
    case CLI_INPUT_SCENE:
        return cli_info_scene(command, word, "scene");
    case CLI_INPUT_PICTURE:
        return cli_info_scene(command, word, "picture with a scene");
    case CLI_INPUT_DATA:
        break;
    }
    return info_of_data(command, word, ids);
}

/* In the place of what would be said of an input. */
static void put_failure(cli_command *command, const char *word)
{
    const vv_error *error = vv_error_last();
    vvi_result_open(&command->json, NULL, '{');
    vvi_result_string(&command->json, "file", word);
    vvi_result_open(&command->json, "error", '{');
    vvi_result_string(&command->json, "code", vv_status_name(error->status));
    vvi_result_string(&command->json, "message", error->message);
    vvi_result_close(&command->json, '}');
    cli_command_note(command, "%s", error->message);
}

/* A block for each input; one that cannot be read is told, and the others follow. */
static vv_status info_of_several(cli_command *command, cli_info_ids *ids)
{
    vvi_text_free(&command->json.text);
    command->json = (vvi_result){0};
    command->several = true;
    vvi_result_open(&command->json, NULL, '[');
    for (size_t i = 0; i < command->args.n_words; i++) {
        const char *word = cli_command_word(command, i);
        const size_t n_text = command->text.n;
        const vvi_result before = command->json;
        if (command->text.n)
            vvi_text_add(&command->text, "\n");
        vvi_result_open(&command->json, NULL, '{');
        const vv_status st = info_of(command, word, ids);
        if (st == VV_E_CANCELLED || st == VV_E_MEMORY)
            return st;
        if (st != VV_OK) {
            const int code = cli_report_exit_code(st, NULL);
            vvi_text_cut(&command->text, n_text);
            vvi_text_cut(&command->json.text, before.text.n);
            command->json.depth = before.depth;
            command->json.filled = before.filled;
            put_failure(command, word);
            command->exit_code = code > command->exit_code ? code : command->exit_code;
        }
        vvi_result_close(&command->json, '}');
    }
    return VV_OK;
}

/* Of several inputs one may be a mesh. */
static vv_status check_unit(cli_command *command)
{
    const info_options *options = cli_command_options(command, &options_class);
    for (size_t i = 0; options->input_unit && i < command->args.n_words; i++)
        if (cli_mesh_is_input(command, command->args.words[i]))
            return VV_OK;
    if (!options->input_unit)
        return VV_OK;
    return cli_refused(command, "input-unit",
                       vv_fail(VV_E_ARGUMENT, "--input-unit is about meshes, and %s is none", command->args.words[0]));
}

static vv_status run(cli_command *command)
{
    vv_status st;
    if ((st = check_preview(command)) != VV_OK || (st = check_unit(command)) != VV_OK ||
        (st = cli_command_start(command)) != VV_OK)
        return st;
    command->any_part = true;
    cli_info_ids ids = {0};
    st = command->args.n_words > 1 ? info_of_several(command, &ids)
                                   : info_of(command, cli_command_word(command, 0), &ids);
    cli_info_ids_finish(&ids);
    return st;
}

static const char *const examples[] = {"volvis info head.nii.gz",
                                       "volvis info head.nrrd skin.ply cells.nrrd",
                                       "volvis info head.nrrd --stats",
                                       "volvis info head.nrrd --stats --json",
                                       "volvis info cells.nrrd --preview",
                                       "volvis info head.nrrd --preview -o slices.png --size 600x200",
                                       "volvis info skin.ply",
                                       NULL};

const cli_verb cli_verb_info = {
    .name = "info",
    .doc = "what is in a file: dims, type, spacing, orientation, range, histogram; for a mesh, its area and volume",
    .about = "A preview shows the axial, coronal and sagittal slices as radiologists view them (from the feet, the "
             "front and the left) if the axes are anatomical, else xy, xz and yz: as pixels if the terminal can show "
             "them (sixel), else as characters. Only these slices are read if the format allows it.\n\nRange and mean "
             "are shown for up to 64 MiB of samples, and for more with --stats. For a file that holds several "
             "data sets, all are listed. For several inputs there is one block each, or one object each in a "
             "JSON array; an error is shown for each that cannot be read, and the exit code is the largest.",
    .words = "INPUT ...",
    .choices = "files",
    .min_words = 1,
    .max_words = 4096,
    .each_input = true,
    .options = {&options_class, &cli_reading_class},
    .examples = examples,
    .draws = "give --preview for a picture of slices",
    .run = run,
};
