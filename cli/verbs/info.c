#include "command.h"
#include "core/units.h"
#include "info_names.h"
#include "info_preview.h"
#include "info_statistics.h"
#include "input.h"
#include "mesh.h"
#include "output.h"
#include "pipeline.h"
#include "stream.h"
#include "verbs.h"
#include <inttypes.h>
#include <string.h>

typedef struct info_options {
    vv_object base;
    bool stats;
    int preview;
    char *size, *input_unit;
} info_options;

static const char *const previews[] = {"none", "auto", "sixel", "blocks", NULL};

static const vv_property rows[] = {
    {VV_PROP(info_options, stats), .kind = VV_KIND_BOOL,
     .doc = "look at every sample as well: range, mean, percentiles, histogram"},
    {VV_PROP(info_options, preview), .kind = VV_KIND_ENUM, .names = previews, .def = CLI_PREVIEW_NONE,
     .doc = "three slices through the middle, in the terminal or with -o as an image file"},
    {VV_PROP(info_options, size), .kind = VV_KIND_STRING, .unit = "WxH", .automatic = "as large as the slices need",
     .doc = "pixels of the preview's file"},
    {VV_PROP(info_options, input_unit), .kind = VV_KIND_STRING, .unit = "UNIT", .automatic = "none",
     .doc = "of lengths in a mesh file that does not say it, or counts voxels: mm, or 0.5mm for each"},
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

static void json_header(vvi_result *json, const cli_input *input, const vv_field_info *info, uint64_t bytes)
{
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
}

static void text_values(cli_command *command, const vv_field_info *info)
{
    if (info->value_scale != 1 || info->value_offset != 0)
        cli_command_line(command, "values", "stored * %g + %g %s", info->value_scale, info->value_offset,
                         info->value_unit);
    else if (info->value_unit[0])
        cli_command_line(command, "values", "in %s", info->value_unit);
    if (info->n_frames > 1 && info->frame_step > 0)
        cli_command_line(command, "time", "%" PRId64 " steps of %g %s", info->n_frames, info->frame_step,
                         info->frame_unit);
}

static void text_header(cli_command *command, const cli_input *input, const vv_field_info *info, uint64_t bytes)
{
    char size[32], about[128];
    const char *key, *value;
    cli_describe_info(about, info, info->n_frames);
    vvi_print_bytes(size, bytes);
    vvi_text_printf(&command->text, "%s\n", input->path);
    cli_command_line(command, "format", "%s", vv_file_format(input->file));
    cli_command_line(command, "samples", "%s, %s", about, meaning_names[info->meaning]);
    text_placement(command, &info->grid);
    text_values(command, info);
    cli_command_line(command, "memory", "%s%s", size,
                     vv_file_mappable(input->file) ? " (used where it lies, not read)" : "");
    for (size_t i = 0; vv_file_metadata(input->file, i, &key, &value); i++) {
        if (command->common->verbose)
            cli_command_line(command, i ? "" : "header", "%s: %s", key, value);
    }
}

/* What takes samples: all of them for statistics, which the preview then has at hand. */
static vv_status look_at_samples(cli_command *command, const cli_input *input, const info_options *options)
{
    vv_field *field = NULL;
    cli_stream stream = {0};
    const int64_t frame = input->frame < 0 ? 0 : input->frame;
    vv_status st = VV_OK;
    if (options->stats && (st = cli_stream_samples(&field, &stream, command, input, frame)) == VV_OK)
        st = cli_info_statistics(command, input, field);
    if (st == VV_OK && options->preview != CLI_PREVIEW_NONE)
        st = cli_info_preview(command, input, field, (cli_preview_kind)options->preview, options->size);
    vv_field_release(field);
    cli_stream_free(&stream);
    return st;
}

static vv_status info_of_data(cli_command *command, const char *word)
{
    const info_options *options = cli_command_options(command, &options_class);
    cli_input input = {0};
    uint64_t bytes = 0;
    vv_status st;
    if ((st = cli_input_open(&input, command, word)) != VV_OK)
        return st;
    const vv_field_info *info = vv_file_info(input.file);
    if ((st = vv_field_info_bytes(&bytes, info)) == VV_OK) {
        json_header(&command->json, &input, info, bytes);
        text_header(command, &input, info, bytes);
        cli_info_parts(command, &input);
        if (!options->stats) {
            cli_info_channels(command, &input);
            cli_info_labels(command, &input);
        }
        st = look_at_samples(command, &input, options);
    }
    cli_input_close(&input);
    return st;
}

static void list_ids(cli_command *command, const char *label, const vv_collection *collection)
{
    vvi_text text = {0};
    vvi_result_open(&command->json, label, '[');
    for (size_t i = 0; i < collection->n; i++) {
        vvi_result_string(&command->json, NULL, collection->entry[i].id);
        vvi_text_printf(&text, "%s%s", i ? ", " : "", collection->entry[i].id);
    }
    vvi_result_close(&command->json, ']');
    cli_command_line(command, label, "%s", text.n ? text.s : "none");
    vvi_text_free(&text);
}

/* With what each measures. */
static void list_measurements(cli_command *command, const vv_collection *stored)
{
    vvi_text text = {0};
    vvi_result_open(&command->json, "measurements", '[');
    for (size_t i = 0; i < stored->n; i++) {
        const vv_measurement *m = (const vv_measurement *)(const void *)stored->entry[i].object;
        const char *what = vv_class_find(m->base.cls, "what")->names[m->what];
        vvi_result_open(&command->json, NULL, '{');
        vvi_result_string(&command->json, "name", stored->entry[i].id);
        vvi_result_string(&command->json, "what", what);
        if (m->file)
            vvi_result_string(&command->json, "file", m->file);
        vvi_result_close(&command->json, '}');
        vvi_text_printf(&text, "%s%s (%s)", i ? ", " : "", stored->entry[i].id, what);
    }
    vvi_result_close(&command->json, ']');
    if (text.n)
        cli_command_line(command, "measurements", "%s", text.s);
    vvi_text_free(&text);
}

static vv_status info_of_world(cli_command *command, const char *word, const char *format)
{
    vv_world *world = NULL;
    vvi_recipe recipe;
    const vv_status st = cli_input_world(&world, &recipe, command, word);
    if (st != VV_OK)
        return st;
    vvi_text_printf(&command->text, "%s\n", word);
    vvi_result_string(&command->json, "file", word);
    vvi_result_string(&command->json, "format", format);
    cli_command_line(command, "format", "%s", format);
    if (world->title)
        cli_command_line(command, "title", "%s", world->title);
    vvi_result_string(&command->json, "title", world->title);
    vvi_result_string(&command->json, "unit", world->unit);
    list_ids(command, "datasets", world->datasets);
    list_ids(command, "volumes", world->volumes);
    list_ids(command, "lights", world->lights);
    list_ids(command, "views", world->views);
    list_measurements(command, world->measurements);
    vv_object_release(&world->base);
    return VV_OK;
}

/* With a preview -o is where the picture goes, and the text stays on standard output. */
static vv_status check_preview(cli_command *command)
{
    const info_options *options = cli_command_options(command, &options_class);
    const char *output = command->common->output;
    if (options->size && (!output || options->preview == CLI_PREVIEW_NONE))
        return vv_fail(VV_E_ARGUMENT, "--size is that of a preview's file: give --preview and -o FILE as well");
    if (!output || options->preview == CLI_PREVIEW_NONE)
        return VV_OK;
    command->verb.makes_file = true;
    return cli_output_check(command, output, CLI_OUTPUT_IMAGE, NULL);
}

static vv_status info_of_mesh(cli_command *command, const char *word)
{
    const info_options *options = cli_command_options(command, &options_class);
    if (options->stats || options->preview != CLI_PREVIEW_NONE)
        return vv_fail_at(VV_E_ARGUMENT, word, NULL, "is a mesh: --stats and --preview are about samples of volumes");
    return cli_mesh_info(command, word, options->input_unit);
}

static vv_status run(cli_command *command)
{
    const char *word = cli_command_word(command, 0);
    vv_status st;
    if ((st = check_preview(command)) != VV_OK || (st = cli_command_start(command)) != VV_OK)
        return st;
    if (cli_mesh_is_input(command, word))
        return info_of_mesh(command, word);
    switch (cli_input_contents(command, word)) {
    case CLI_INPUT_SCENE:
        return info_of_world(command, word, "scene");
    case CLI_INPUT_PICTURE:
        return info_of_world(command, word, "picture with a scene");
    case CLI_INPUT_DATA:
        break;
    }
    return info_of_data(command, word);
}

static const char *const examples[] = {"volvis info head.nii.gz",
                                       "volvis info head.nrrd --stats",
                                       "volvis info head.nrrd --stats --json",
                                       "volvis info cells.nrrd --preview",
                                       "volvis info head.nrrd --preview -o slices.png --size 600x200",
                                       "volvis info skin.ply",
                                       NULL};

const cli_verb cli_verb_info = {
    .name = "info",
    .doc = "what is in a file: dims, type, spacing, orientation, range, histogram; of a mesh its area and volume",
    .about =
        "A preview shows the axial, coronal and sagittal slice as a radiologist looks at them (from the feet, the "
        "front "
        "and the left) where the axes are anatomical, else xy, xz and yz: as pixels where the terminal can show them "
        "(sixel), else in letters. Only these slices are read where the format allows that.",
    .words = "INPUT",
    .choices = "files",
    .min_words = 1,
    .max_words = 1,
    .options = {&options_class, &cli_reading_class},
    .examples = examples,
    .run = run,
};
