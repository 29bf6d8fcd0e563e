#include "command.h"
#include "core/units.h"
#include "input.h"
#include "mesh.h"
#include "mesh_difference.h"
#include "pipeline.h"
#include "verbs.h"
#include "volume_difference.h"
#include "volume_turn.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <volvis/image.h>

typedef struct compare_options {
    vv_object base;
    double psnr, ssim, flip;
    char *max_difference, *input_unit;
    double most; /* max_difference as a number */
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
static vv_status read_most(cli_command *command, const char *unit)
{
    compare_options *o = (compare_options *)(uintptr_t)cli_command_options(command, &options_class);
    const vv_property_context context = {.length_unit = unit};
    if (!o->max_difference || (vvi_parse_number(&o->most, o->max_difference) && isfinite(o->most)))
        return VV_OK;
    if (!unit)
        return vv_fail(VV_E_ARGUMENT, "--max-difference: expected a number, found '%s'; only meshes differ by lengths",
                       o->max_difference);
    return vvi_parse_quantity(&o->most, o->max_difference, VV_Q_LENGTH, &context, "--max-difference");
}

/* The first limit that is not kept makes the exit code 6; each is said. */
static void judge(cli_command *command, const char *option, const char *what, double found, bool least)
{
    const compare_options *o = cli_command_options(command, &options_class);
    const double limit = strcmp(option, "psnr") == 0   ? o->psnr
                         : strcmp(option, "ssim") == 0 ? o->ssim
                         : strcmp(option, "flip") == 0 ? o->flip
                                                       : o->most;
    if (!vv_object_is_set(&o->base, option) || (least ? found >= limit : found <= limit))
        return;
    command->exit_code = CLI_EXIT_DIFFERS;
    if (isnan(found))
        cli_command_line(command, "differs", "%s is not defined, the limit is %s %g", what,
                         least ? "at least" : "at most", limit);
    else
        cli_command_line(command, "differs", "%s is %g, the limit is %s %g", what, found,
                         least ? "at least" : "at most", limit);
}

static void differ(cli_command *command, const char *text)
{
    command->exit_code = CLI_EXIT_DIFFERS;
    cli_command_line(command, "differs", "%s", text);
}

static void report_decibels(cli_command *command, double psnr, double max_difference)
{
    vvi_result_number(&command->json, "psnr", psnr);
    if (isfinite(psnr))
        cli_command_line(command, "PSNR", "%.2f dB", psnr);
    else if (isnan(psnr))
        cli_command_line(command, "PSNR", "not defined: %s",
                         isfinite(max_difference) ? "all values of A are the same, or differences have no finite square"
                                                  : "somewhere only one of A and B is a finite number");
    else
        cli_command_line(command, "PSNR", "infinite: nothing differs");
}

/* By the limits, where there are some; else whatever differs. */
static void report_verdict(cli_command *command, bool identical)
{
    static const char *const limits[] = {"psnr", "ssim", "flip", "max_difference"};
    const vv_object *o = cli_command_options(command, &options_class);
    bool limited = false;
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++)
        limited |= vv_object_is_set(o, limits[i]);
    vvi_result_bool(&command->json, "identical", identical);
    vvi_result_bool(&command->json, "differs", limited ? command->exit_code == CLI_EXIT_DIFFERS : !identical);
}

/* Images ---------------------------------------------------------------------------------------------------------- */

static void report_images(cli_command *command, const vv_image_difference *d)
{
    vvi_result *json = &command->json;
    report_decibels(command, d->psnr, d->max_difference);
    vvi_result_number(json, "ssim", d->ssim);
    vvi_result_number(json, "flip_mean", d->flip_mean);
    vvi_result_number(json, "max_difference", d->max_difference);
    vvi_result_unsigned(json, "different_pixels", d->n_different);
    cli_command_line(command, "SSIM", "%.6f", d->ssim);
    cli_command_line(command, "FLIP", "%.6f mean", d->flip_mean);
    cli_command_line(command, "largest", "%.4g of 1", d->max_difference);
    cli_command_line(command, "pixels", "%" PRIu64 " differ", d->n_different);
    judge(command, "psnr", "PSNR", d->psnr, true);
    judge(command, "ssim", "SSIM", d->ssim, true);
    judge(command, "flip", "FLIP", d->flip_mean, false);
    judge(command, "max_difference", "the largest difference", d->max_difference, false);
    report_verdict(command, d->n_different == 0);
}

static vv_status compare_images(cli_command *command, const char *path_a, const char *path_b)
{
    vv_image *a = NULL, *b = NULL;
    vv_image_difference d;
    vv_status st;
    char text[128];
    if ((st = read_most(command, NULL)) == VV_OK &&
        (st = vv_image_read(&a, NULL, NULL, path_a, command->job)) == VV_OK &&
        (st = vv_image_read(&b, NULL, NULL, path_b, command->job)) == VV_OK) {
        vvi_result_string(&command->json, "kind", "images");
        if (a->width != b->width || a->height != b->height) {
            snprintf(text, sizeof text, "sizes are %d x %d and %d x %d", a->width, a->height, b->width, b->height);
            differ(command, text);
            report_verdict(command, false);
        } else if ((st = vv_image_compare(&d, a, b, command->job)) == VV_OK) {
            report_images(command, &d);
        }
    }
    vv_image_release(a);
    vv_image_release(b);
    return st;
}

/* Meshes ---------------------------------------------------------------------------------------------------------- */

/* The largest distance is found from below: what it leaves open is looked at once more. */
static vv_status judge_meshes(cli_command *command, const cli_mesh_difference *d, const vv_mesh *a, const vv_mesh *b)
{
    const compare_options *o = cli_command_options(command, &options_class);
    const vv_figure far = d->distance.hausdorff;
    bool within = true;
    if (!vv_object_is_set(&o->base, "max_difference") || d->apart)
        return VV_OK;
    const vv_status st = cli_mesh_within(&within, d, a, b, o->most, command->job);
    if (st == VV_OK && !within)
        command->exit_code = CLI_EXIT_DIFFERS;
    if (st == VV_OK && !within)
        cli_command_line(command, "differs", "the largest distance is %g %s%s, the limit is at most %g",
                         far.value > o->most ? far.value : far.value + far.error, vv_mesh_get_info(a)->unit,
                         far.value > o->most ? "" : " at most", o->most);
    return st;
}

static vv_status report_meshes(cli_command *command, const vv_mesh *a, vv_mesh **b)
{
    cli_mesh_difference d;
    vv_status st = cli_mesh_compare(&d, a, b, command->job);
    if (st != VV_OK)
        return st;
    vvi_result_string(&command->json, "kind", "meshes");
    cli_mesh_difference_report(command, &d, a, *b);
    if (d.apart)
        differ(command, "one has no triangles");
    if ((st = judge_meshes(command, &d, a, *b)) == VV_OK)
        report_verdict(command, d.same_world && d.same_topology && d.same_places && d.same_data);
    return st;
}

static vv_status compare_meshes(cli_command *command, const char *word_a, const char *word_b)
{
    const compare_options *o = cli_command_options(command, &options_class);
    vv_mesh *a = NULL, *b = NULL;
    if (vv_object_is_set(&o->base, "psnr") || vv_object_is_set(&o->base, "ssim") || vv_object_is_set(&o->base, "flip"))
        return vv_fail(VV_E_ARGUMENT, "--psnr, --ssim and --flip are for samples: meshes take --max-difference");
    vv_status st = cli_mesh_read(&a, command, word_a, o->input_unit);
    if (st == VV_OK && (st = read_most(command, vv_mesh_get_info(a)->unit)) == VV_OK &&
        (st = cli_mesh_read(&b, command, word_b, o->input_unit)) == VV_OK)
        st = report_meshes(command, a, &b);
    vv_mesh_release(a);
    vv_mesh_release(b);
    return st;
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

/* Volumes --------------------------------------------------------------------------------------------------------- */

/* The volumes, the second with its axes as those of the first where they run along the same lines. */
typedef struct pair {
    cli_input *inputs;
    vv_field *fields[2];
    cli_axes axes;
    char to[8];
} pair;

static bool same_shape(const vv_field_info *a, const vv_field_info *b, const char *to)
{
    bool same = a->components == b->components;
    for (int i = 0; i < 3; i++)
        same &= a->grid.dims[i] == b->grid.dims[to[2 * i + 1] - 'x'];
    return same;
}

static void report_placement(cli_command *command, const vv_field_info *a, const vv_field_info *b)
{
    const double moved = cli_placement_difference(&a->grid, &b->grid);
    const bool same_world = strcmp(a->grid.unit, b->grid.unit) == 0 && a->grid.space == b->grid.space;
    char text[96];
    vvi_result_number(&command->json, "placement_difference", moved);
    vvi_result_bool(&command->json, "same_world", same_world);
    vvi_result_bool(&command->json, "same_type", a->type == b->type);
    if (!same_world)
        cli_command_line(command, "world", "%s, %s", a->grid.unit, b->grid.unit);
    snprintf(text, sizeof text, moved > 0 ? "corners are up to %g %s apart" : "the same", moved, a->grid.unit);
    cli_command_line(command, "placement", "%s", text);
    cli_command_line(command, "types", "%s, %s", vv_type_name(a->type), vv_type_name(b->type));
}

static void report_volumes(cli_command *command, const cli_volume_difference *d)
{
    vvi_result *json = &command->json;
    report_decibels(command, d->psnr, d->max_difference);
    vvi_result_number(json, "max_difference", d->max_difference);
    vvi_result_number(json, "rms", d->rms);
    vvi_result_unsigned(json, "different_samples", d->n_different);
    cli_command_line(command, "largest", "%g", d->max_difference);
    cli_command_line(command, "RMS", "%g", d->rms);
    cli_command_line(command, "samples", "%" PRIu64 " of %" PRIu64 " differ", d->n_different, d->n_samples);
    judge(command, "psnr", "PSNR", d->psnr, true);
    judge(command, "max_difference", "the largest difference", d->max_difference, false);
    report_verdict(command, d->n_different == 0);
}

static vv_status read_pair(pair *p, cli_command *command)
{
    vv_status st = VV_OK;
    for (int i = 0; i < 2 && st == VV_OK; i++) {
        const cli_input *in = &p->inputs[i];
        st = vv_file_read(&p->fields[i], in->file, in->frame < 0 ? 0 : in->frame, NULL, command->job);
    }
    if (st == VV_OK && p->axes == CLI_AXES_TURNED)
        st = cli_volume_turn(&p->fields[1], p->to, command->registry, command->job);
    return st;
}

static void report_axes(cli_command *command, const pair *p, const vv_grid *a, const vv_grid *b)
{
    char letters_a[16], letters_b[16];
    vv_grid_orientation(letters_a, a);
    vv_grid_orientation(letters_b, b);
    vvi_result_bool(&command->json, "same_axes", p->axes == CLI_AXES_SAME);
    vvi_result_string(&command->json, "reoriented", p->axes == CLI_AXES_TURNED ? p->to : "");
    if (p->axes == CLI_AXES_TURNED)
        cli_command_line(command, "axes",
                         "%s and %s; compared at the same places, the second as by 'reorient --order %s'", letters_a,
                         letters_b, p->to);
    else if (p->axes == CLI_AXES_OTHER)
        cli_command_line(command, "axes",
                         "%s and %s, which run differently; compared sample by sample as they are stored: "
                         "resample one first: 'volvis resample B onto=A -o C'",
                         letters_a, letters_b);
}

static vv_status compare_pair(cli_command *command, const pair *p)
{
    cli_volume_difference d;
    const vv_field_info *a = vv_field_get_info(p->fields[0]), *b = vv_field_get_info(p->fields[1]);
    report_placement(command, a, b);
    const vv_status st = cli_volume_compare(&d, p->fields[0], p->fields[1], command->job);
    if (st == VV_OK)
        report_volumes(command, &d);
    return st;
}

static vv_status compare_volumes(cli_command *command, cli_input inputs[2])
{
    const vv_field_info *a = vv_file_info(inputs[0].file), *b = vv_file_info(inputs[1].file);
    char about_a[128], about_b[128];
    pair p = {.inputs = inputs};
    p.axes = cli_axes_compare(p.to, &a->grid, &b->grid);
    cli_describe_info(about_a, a, 1);
    cli_describe_info(about_b, b, 1);
    vvi_result_string(&command->json, "kind", "volumes");
    vvi_result_bool(&command->json, "same_dims", same_shape(a, b, p.to));
    if (!same_shape(a, b, p.to)) {
        cli_command_line(command, "differs", "%s and %s", about_a, about_b);
        command->exit_code = CLI_EXIT_DIFFERS;
        report_verdict(command, false);
        return VV_OK;
    }
    cli_command_line(command, "samples", "%s", about_a);
    report_axes(command, &p, &a->grid, &b->grid);
    vv_status st = read_pair(&p, command);
    if (st == VV_OK)
        st = compare_pair(command, &p);
    vv_field_release(p.fields[0]);
    vv_field_release(p.fields[1]);
    return st;
}

static vv_status open_and_compare(cli_command *command)
{
    const compare_options *o = cli_command_options(command, &options_class);
    cli_input inputs[2] = {0};
    vv_status st;
    if (vv_object_is_set(&o->base, "ssim") || vv_object_is_set(&o->base, "flip"))
        return vv_fail(VV_E_ARGUMENT, "--ssim and --flip are for images: volumes take --psnr and --max-difference");
    if ((st = read_most(command, NULL)) == VV_OK &&
        (st = cli_input_open(&inputs[0], command, command->args.words[0])) == VV_OK &&
        (st = cli_input_open(&inputs[1], command, command->args.words[1])) == VV_OK)
        st = compare_volumes(command, inputs);
    cli_input_close(&inputs[0]);
    cli_input_close(&inputs[1]);
    return st;
}

static vv_status run(cli_command *command)
{
    const char *a = command->args.words[0], *b = command->args.words[1];
    const bool image_a = cli_input_guess(command, a) == CLI_INPUT_PICTURE,
               image_b = cli_input_guess(command, b) == CLI_INPUT_PICTURE;
    vv_status st;
    if ((st = cli_command_start(command)) != VV_OK)
        return st;
    if (image_a && image_b)
        return compare_images(command, a, b);
    if ((image_a && cli_input_contents(command, a) == CLI_INPUT_PICTURE) ||
        (image_b && cli_input_contents(command, b) == CLI_INPUT_PICTURE))
        return vv_fail_at(VV_E_ARGUMENT, image_a ? a : b, NULL,
                          "is a picture, and '%s' is not: compare two pictures, or the data with data",
                          image_a ? b : a);
    const bool mesh_a = cli_mesh_is_input(command, a), mesh_b = cli_mesh_is_input(command, b);
    if (mesh_a && mesh_b)
        return compare_meshes(command, a, b);
    if (mesh_a || mesh_b)
        return fail_mesh_and_volume(command, mesh_a ? a : b, mesh_a ? b : a);
    return open_and_compare(command);
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
