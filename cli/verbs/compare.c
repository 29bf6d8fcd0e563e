#include "command.h"
#include "core/units.h"
#include "input.h"
#include "measure.h"
#include "mesh.h"
#include "verbs.h"
#include <math.h>
#include <volvis/compare.h>

typedef struct compare_options {
    vv_object base;
    double psnr, ssim, flip;
    char *max_difference, *input_unit;
} compare_options;

static const vv_property rows[] = {
    {VV_PROP(compare_options, psnr), .kind = VV_KIND_F64, .automatic = "no limit",
     .doc = "differ if the peak signal-to-noise ratio is below this, in dB"},
    {VV_PROP(compare_options, ssim), .kind = VV_KIND_F64, .automatic = "no limit",
     .doc = "images: differ if the structural similarity is below this, at most 1"},
    {VV_PROP(compare_options, flip), .kind = VV_KIND_F64, .automatic = "no limit",
     .doc = "images: differ if the mean FLIP error is above this, 0 to 1"},
    {VV_PROP(compare_options, max_difference), .kind = VV_KIND_STRING, .unit = "VALUE", .automatic = "no limit",
     .doc = "differ if any sample differs by more: for images 0 to 1, for volumes in values; for meshes, if a point of "
            "one surface is farther from the other: a length, as in 20um, or a number in the unit of A"},
    {VV_PROP(compare_options, input_unit), .kind = VV_KIND_STRING, .unit = "UNIT", .automatic = "none",
     .doc = "meshes: unit of lengths in a file that gives none, or counts voxels: mm, or 0.5mm for each"},
    {0},
};

static const vv_class options_class = {
    .name = "compare",
    .doc = "options of compare",
    .size = sizeof(compare_options),
    .properties = rows,
};

/* unit: of A, a mesh; NULL: values are compared, which have no lengths. */
static vv_status read_limits(vv_compare_limits *out, const compare_options *o, const char *unit)
{
    const vv_property_context context = {.length_unit = unit};
    vv_compare_limits_init(out, sizeof *out);
    out->psnr = vv_object_is_set(&o->base, "psnr") ? o->psnr : NAN;
    out->ssim = vv_object_is_set(&o->base, "ssim") ? o->ssim : NAN;
    out->flip = vv_object_is_set(&o->base, "flip") ? o->flip : NAN;
    if (!o->max_difference ||
        (vvi_parse_number(&out->max_difference, o->max_difference) && isfinite(out->max_difference)))
        return VV_OK;
    if (!unit)
        return vv_fail(VV_E_ARGUMENT, "--max-difference: expected a number, found '%s'; only meshes differ by lengths",
                       o->max_difference);
    return vvi_parse_quantity(&out->max_difference, o->max_difference, VV_Q_LENGTH, &context, "--max-difference");
}

static vv_status report(cli_command *command, vv_answer *answer, bool exceeded, vv_status st)
{
    if (st == VV_OK)
        cli_answer_print(command, answer, false, false);
    if (st == VV_OK && exceeded)
        command->exit_code = CLI_EXIT_DIFFERS;
    vv_answer_release(answer);
    return st;
}

static vv_status compare_images(cli_command *command, const compare_options *o, const char *path_a, const char *path_b)
{
    vv_image *a = NULL, *b = NULL;
    vv_compare_limits limits;
    vv_answer *answer = NULL;
    bool exceeded = false;
    vv_status st;
    if ((st = read_limits(&limits, o, NULL)) == VV_OK &&
        (st = vv_image_read(&a, NULL, NULL, path_a, command->job)) == VV_OK &&
        (st = vv_image_read(&b, NULL, NULL, path_b, command->job)) == VV_OK)
        st = vv_compare_images(&answer, &exceeded, a, b, &limits, command->job);
    vv_image_release(a);
    vv_image_release(b);
    return report(command, answer, exceeded, st);
}

static vv_status compare_meshes(cli_command *command, const compare_options *o, const char *word_a, const char *word_b)
{
    vv_mesh *a = NULL, *b = NULL;
    vv_compare_limits limits;
    vv_answer *answer = NULL;
    bool exceeded = false;
    if (vv_object_is_set(&o->base, "psnr") || vv_object_is_set(&o->base, "ssim") || vv_object_is_set(&o->base, "flip"))
        return vv_fail(VV_E_ARGUMENT, "--psnr, --ssim and --flip are for samples: meshes take --max-difference");
    vv_status st = cli_mesh_read(&a, command, word_a, o->input_unit);
    if (st == VV_OK && (st = read_limits(&limits, o, vv_mesh_get_info(a)->unit)) == VV_OK &&
        (st = cli_mesh_read(&b, command, word_b, o->input_unit)) == VV_OK)
        st = vv_compare_meshes(&answer, &exceeded, a, b, &limits, command->job);
    vv_mesh_release(a);
    vv_mesh_release(b);
    return report(command, answer, exceeded, st);
}

/* Unless the other one cannot be read at all. */
static vv_status fail_mesh_and_volume(cli_command *command, const char *mesh, const char *other)
{
    cli_input input = {0};
    const vv_status st = cli_input_open(&input, command, other);
    cli_input_close(&input);
    return st != VV_OK ? st
                       : vv_fail_at(VV_E_ARGUMENT, mesh, NULL,
                                    "is a mesh, and '%s' a volume: compare two meshes, or two volumes; 'volvis "
                                    "isosurface' makes a mesh of a volume",
                                    other);
}

static vv_status compare_volumes(cli_command *command, const compare_options *o)
{
    cli_input a = {0}, b = {0};
    vv_compare_limits limits;
    vv_answer *answer = NULL;
    bool exceeded = false;
    vv_status st;
    if (vv_object_is_set(&o->base, "ssim") || vv_object_is_set(&o->base, "flip"))
        return vv_fail(VV_E_ARGUMENT, "--ssim and --flip are for images: volumes take --psnr and --max-difference");
    if ((st = read_limits(&limits, o, NULL)) == VV_OK &&
        (st = cli_input_open(&a, command, command->args.words[0])) == VV_OK &&
        (st = cli_input_open(&b, command, command->args.words[1])) == VV_OK)
        st = vv_compare_files(&answer, &exceeded, a.file, a.frame < 0 ? 0 : a.frame, b.file, b.frame < 0 ? 0 : b.frame,
                              &limits, command->job);
    cli_input_close(&a);
    cli_input_close(&b);
    return report(command, answer, exceeded, st);
}

static vv_status run(cli_command *command)
{
    const compare_options *o = cli_command_options(command, &options_class);
    const char *a = command->args.words[0], *b = command->args.words[1];
    const bool image_a = cli_input_guess(command, a) == CLI_INPUT_PICTURE,
               image_b = cli_input_guess(command, b) == CLI_INPUT_PICTURE;
    vv_status st;
    if ((st = cli_command_start(command)) != VV_OK)
        return st;
    if (image_a && image_b)
        return compare_images(command, o, a, b);
    if ((image_a && cli_input_contents(command, a) == CLI_INPUT_PICTURE) ||
        (image_b && cli_input_contents(command, b) == CLI_INPUT_PICTURE))
        return vv_fail_at(VV_E_ARGUMENT, image_a ? a : b, NULL,
                          "is a picture, and '%s' is not: compare two pictures, or the data with data",
                          image_a ? b : a);
    const bool mesh_a = cli_mesh_is_input(command, a), mesh_b = cli_mesh_is_input(command, b);
    if (mesh_a && mesh_b)
        return compare_meshes(command, o, a, b);
    if (mesh_a || mesh_b)
        return fail_mesh_and_volume(command, mesh_a ? a : b, mesh_a ? b : a);
    return compare_volumes(command, o);
}

static const char *const examples[] = {
    "volvis compare a.png b.png",
    "volvis compare a.png again.png --psnr 40 --flip 0.05",
    "volvis compare head.nrrd head.nii.gz --max-difference 0 --json",
    "volvis compare skin.ply copy.stl --max-difference 0.5",
    NULL,
};

const cli_verb cli_verb_compare = {
    .name = "compare",
    .doc = "two images, volumes or meshes: PSNR, SSIM, FLIP, largest difference, distances, placement",
    .about = "Without limits the differences are only reported; if a limit is exceeded, or the inputs differ in size, "
             "the exit code is 6; differs in JSON is then true, and without limits where anything differs. Volumes "
             "whose axes run along the same lines of the world in another order or direction are compared at the "
             "same places. PSNR counts the range of A over the root mean square of the differences; it is null in "
             "JSON when nothing differs (identical is then true), and where it is not defined: all values of A are the "
             "same, or somewhere only one of A and B is a finite number. For two meshes the areas, volumes and "
             "numbers of triangles are reported, and the smallest, mean, root mean square and largest (Hausdorff) "
             "distance of their surfaces, as found by 'volvis measure distance'; parts are FILE:PART.",
    .words = "A B",
    .choices = "files",
    .min_words = 2,
    .max_words = 2,
    .options = {&options_class, &cli_reading_class},
    .examples = examples,
    .run = run,
};
