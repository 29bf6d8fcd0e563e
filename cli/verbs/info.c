#include "command.h"
#include "core/job.h"
#include "info_ids.h"
#include "info_preview.h"
#include "input.h"
#include "io/file_stream.h"
#include "measure.h"
#include "mesh.h"
#include "output.h"
#include "picture_notes.h"
#include "refusal.h"
#include "report.h"
#include "run/stream.h"
#include "verbs.h"
#include <volvis/about.h>

typedef struct info_options {
    vv_object base;
    bool stats;
    int preview;
    char *size, *input_unit;
} info_options;

enum { RANGE_BYTES = 64 << 20 }; /* of samples, which are looked at without being asked */

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

static vv_about_options about_options(const cli_command *command)
{
    vv_about_options options;
    vv_about_options_init(&options, sizeof options);
    options.all = command->common->verbose;
    options.more = ", which --verbose and --json list";
    return options;
}

/* What the library tells of a file, and of the samples `field` where it is about these. */
static vv_status tell(cli_command *command, const cli_input *input, unsigned what, const vv_field *field,
                      const char *id)
{
    vv_about_options options = about_options(command);
    vv_answer *answer = NULL;
    options.what = what;
    options.field = field;
    options.id = id;
    const vv_status st = vv_about_file(&answer, input->file, &options, command->job);
    if (st == VV_OK)
        cli_answer_print(command, answer, false, true);
    vv_answer_release(answer);
    return st;
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
        st = tell(command, input, VV_ABOUT_RANGE, field, NULL);
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
        st = tell(command, input, VV_ABOUT_STATISTICS, field, NULL);
    if (st == VV_OK && options->preview != CLI_PREVIEW_NONE)
        st = cli_info_preview(command, input, field, (cli_preview_kind)options->preview, options->size);
    vv_field_release(field);
    vvi_stream_free(&stream);
    return st;
}

/* Meshes in a folder, and folders that are volumes; of a part of a folder, nothing. alone: it holds nothing else, and
 * has no block yet. Whether there are any. */
static bool tell_folder(cli_command *command, const char *word, bool alone)
{
    const vv_about_options options = about_options(command);
    vv_answer *answer = NULL;
    cli_input_name name;
    size_t n_meshes = 0, n_volumes = 0;
    if (cli_input_split(&name, word) != VV_OK)
        return false;
    if (!name.part)
        vv_about_folder(&answer, &n_meshes, &n_volumes, name.path, &options, command->job);
    const bool any = n_meshes > 0 || n_volumes > 0;
    if (any && alone) {
        cli_command_title(command, name.path);
        vvi_result_string(&command->json, "file", name.path);
        vvi_result_string(&command->json, "format", "folder");
        cli_command_line(command, "format", "folder of %s%s%s", n_meshes ? "meshes" : "",
                         n_meshes && n_volumes ? " and " : "", n_volumes ? "volumes that are folders" : "");
    }
    if (any)
        cli_answer_print(command, answer, false, false);
    vv_answer_release(answer);
    cli_input_name_free(&name);
    return any;
}

static vv_status info_of_data(cli_command *command, const char *word, cli_info_ids *ids)
{
    const info_options *options = cli_command_options(command, &options_class);
    cli_input input = {0};
    uint64_t bytes = 0;
    char id[64];
    vv_status st;
    if ((st = cli_input_open(&input, command, word)) != VV_OK)
        return st == VV_E_FORMAT && tell_folder(command, word, true) ? VV_OK : st;
    const vv_field_info *info = vv_file_info(input.file);
    if (options->preview != CLI_PREVIEW_NONE) /* its samples are read again, after a look at their range */
        st = vvi_file_make_repeatable(input.file, command->job);
    if (st == VV_OK && (st = vv_field_info_bytes(&bytes, info)) == VV_OK &&
        (st = cli_info_ids_take(id, ids, input.path, info)) == VV_OK) {
        cli_command_title(command, input.path);
        vvi_result_string(&command->json, "file", input.path);
        st = tell(command, &input, VV_ABOUT_HEADER | VV_ABOUT_PARTS, NULL, id);
        tell_folder(command, word, false);
        if (st == VV_OK && !options->stats)
            st = tell(command, &input, VV_ABOUT_NAMES, NULL, NULL);
        if (st == VV_OK)
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

static vv_status info_of_scene(cli_command *command, const char *word, const char *format)
{
    vv_world *world = NULL;
    vv_answer *answer = NULL;
    vvi_recipe recipe;
    vv_status st = cli_input_world(&world, &recipe, command, word);
    if (st != VV_OK)
        return st;
    cli_command_title(command, word);
    vvi_result_string(&command->json, "file", word);
    vvi_result_string(&command->json, "format", format);
    cli_command_line(command, "format", "%s", format);
    if ((st = vv_about_world(&answer, world)) == VV_OK)
        cli_answer_print(command, answer, false, false);
    cli_note_moved(command, world, word);
    vv_answer_release(answer);
    vv_object_release(&world->base);
    return st;
}

static vv_status info_of(cli_command *command, const char *word, cli_info_ids *ids)
{
    if (cli_mesh_is_input(command, word))
        return info_of_mesh(command, word);
    switch (cli_input_contents(command, word)) {
    case CLI_INPUT_SCENE:
        return info_of_scene(command, word, "scene");
    case CLI_INPUT_PICTURE:
        return info_of_scene(command, word, "picture with a scene");
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
