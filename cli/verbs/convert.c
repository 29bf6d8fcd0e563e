#include "channel_names.h"
#include "command.h"
#include "core/names.h"
#include "core/units.h"
#include "grid/field.h"
#include "grid/rounding.h"
#include "io/file_stream.h"
#include "mesh.h"
#include "output.h"
#include "pipeline.h"
#include "refusal.h"
#include "run/stream.h"
#include "value.h"
#include "verbs.h"
#include "watch.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

typedef struct convert_options {
    vv_object base;
    char *type, *range, *percentile, *channel, *x, *y, *z, *flip, *order, *spacing;
    char *unit, *input_unit;
} convert_options;

static const vv_property rows[] = {
    {VV_PROP(convert_options, type), .kind = VV_KIND_STRING, .unit = "TYPE", .table = "types", .automatic = "as it is",
     .doc = "type of the samples: u8, i16, f32, ...; without --range or --percentile the numbers stay what they are"},
    {VV_PROP(convert_options, range), .kind = VV_KIND_STRING, .unit = "LO..HI", .automatic = "values as they are",
     .doc = "window of values that is stretched over the whole range of an integer type, or to 0..1"},
    {VV_PROP(convert_options, percentile), .kind = VV_KIND_STRING, .unit = "LO..HI", .automatic = "values as they are",
     .doc = "the same window by share of the samples, of all time steps together: 1..99.8"},
    {VV_PROP(convert_options, channel), .kind = VV_KIND_STRING, .unit = "N|NAME,...", .automatic = "all",
     .doc = "channels that are kept, by number from 0 or by name"},
    {VV_PROP(convert_options, x), .kind = VV_KIND_STRING, .unit = "FIRST..LAST", .automatic = "all",
     .doc = "samples kept along x, as in 'volvis help crop'"},
    {VV_PROP(convert_options, y), .kind = VV_KIND_STRING, .unit = "FIRST..LAST", .automatic = "all",
     .doc = "samples kept along y"},
    {VV_PROP(convert_options, z), .kind = VV_KIND_STRING, .unit = "FIRST..LAST", .automatic = "all",
     .doc = "samples kept along z"},
    {VV_PROP(convert_options, flip), .kind = VV_KIND_STRING, .unit = "AXES", .automatic = "none",
     .doc = "axes along which samples are reversed, as in xy; places in the world stay"},
    {VV_PROP(convert_options, order), .kind = VV_KIND_STRING, .unit = "ORDER", .automatic = "as it is",
     .doc = "another axis order, RAS, LPI, zyx, ..., as in 'volvis help reorient'; places in the world stay"},
    {VV_PROP(convert_options, spacing), .kind = VV_KIND_STRING, .unit = "LENGTH[,LENGTH,LENGTH]",
     .automatic = "as it is", .doc = "distance between samples, 1mm or 1mm,1mm,2.5mm, as in 'volvis help resample'"},
    {VV_PROP(convert_options, unit), .kind = VV_KIND_STRING, .unit = "UNIT", .automatic = "as it is",
     .doc = "of lengths in a mesh that is written, as in mm"},
    {VV_PROP(convert_options, input_unit), .kind = VV_KIND_STRING, .unit = "UNIT", .automatic = "none",
     .doc = "unit of lengths in a mesh file that gives none, or counts voxels: mm, or 0.5mm for each"},
    {0},
};

static const vv_class options_class = {
    .name = "convert",
    .doc = "options of convert",
    .size = sizeof(convert_options),
    .properties = rows,
};

/* Give an operation's parameter, if there is something to give. */
static vv_status set(vv_step *step, const char *property, const char *value, const vv_property_context *context)
{
    return value ? vv_path_set(&step->params, property, value, context) : VV_OK;
}

static vv_status begin_step(vv_step *step, const cli_command *command, const char *name,
                            const vv_property_context *context)
{
    step->operation = vv_registry_operation(command->registry, name);
    if (!step->operation)
        return vv_error_last()->status;
    return vv_object_new(&step->params, step->operation->params, context);
}

/* Names become numbers, which the operation takes. */
static vv_status channel_step(vv_step *step, const cli_command *command, const convert_options *options,
                              const cli_input *input, const vv_property_context *context)
{
    vvi_text numbers = {0}, quoted = {0};
    vv_status st = begin_step(step, command, "channel", context);
    if (st == VV_OK && (st = cli_channel_numbers(&numbers, input, options->channel)) == VV_OK) {
        vvi_text_json(&quoted, numbers.s);
        st = quoted.bad ? vv_fail_memory(quoted.n) : set(step, "components", quoted.s, context);
    }
    vvi_text_free(&quoted);
    vvi_text_free(&numbers);
    return st;
}

static vv_status crop_step(vv_step *step, const cli_command *command, const convert_options *options,
                           const vv_property_context *context)
{
    vv_status st;
    if ((st = begin_step(step, command, "crop", context)) != VV_OK ||
        (st = set(step, "x", options->x, context)) != VV_OK || (st = set(step, "y", options->y, context)) != VV_OK)
        return st;
    return set(step, "z", options->z, context);
}

/* What samples hold, all components and time steps. */
typedef struct extent {
    double lo, hi; /* of finite samples; lo > hi: there are none */
    uint64_t odd;  /* NaN and infinite ones */
    int n_apart;   /* at least so many different values in one component */
} extent;

static vv_status add_frame(extent *e, cli_command *command, const cli_input *input, int64_t frame)
{
    vv_statistics *s = malloc(sizeof *s);
    vv_field *field = NULL;
    if (!s)
        return vv_fail_memory(sizeof *s);
    vvi_stream stream;
    vv_status st = vvi_stream_samples(&field, &stream, input->file, frame, command->job);
    for (int c = 0; st == VV_OK && c < vv_field_get_info(field)->components; c++) {
        if ((st = vv_field_statistics(s, field, c, command->job)) != VV_OK)
            break;
        e->odd += s->nan_count + s->infinite_count;
        if (s->count) {
            e->lo = s->min < e->lo ? s->min : e->lo;
            e->hi = s->max > e->hi ? s->max : e->hi;
            const int n = vvi_values_apart(s);
            e->n_apart = n > e->n_apart ? n : e->n_apart;
        }
    }
    vv_field_release(field);
    vvi_stream_free(&stream);
    free(s);
    return st;
}

/* Fractions that are packed in integers fit, and are lost all the same. */
static bool may_round(const vv_field_info *info, vv_type type)
{
    return !vv_type_is_float(type) && fabs(info->value_scale) < 0.1;
}

/* The numbers stay: whether they fit has to be looked up where the types alone do not say so. */
static vv_status check_fit(cli_command *command, const cli_input *input, vv_type type)
{
    const double lo = vvi_type_min(type), hi = vvi_type_max(type);
    const int64_t first = input->frame < 0 ? 0 : input->frame;
    const int64_t end = input->frame < 0 ? vv_file_info(input->file)->n_frames : first + 1;
    extent e = {.lo = INFINITY, .hi = -INFINITY};
    for (int64_t f = first; f < end; f++) {
        const vv_status st = add_frame(&e, command, input, f);
        if (st != VV_OK)
            return st;
    }
    if (e.lo < lo || e.hi > hi)
        return vv_fail_at(VV_E_ARGUMENT, input->path, NULL,
                          "values from %g to %g do not fit in %s (%g to %g): say which become its ends, --range %g..%g "
                          "or --percentile 1..99.8",
                          e.lo, e.hi, vv_type_name(type), lo, hi, e.lo, e.hi);
    if (e.odd)
        cli_command_note(command,
                         "warning: %s: %" PRIu64 " samples are NaN or infinite; in %s NaN becomes 0 and infinite ones "
                         "the end of the type",
                         input->path, e.odd, vv_type_name(type));
    vvi_tell_rounding(command->job, e.lo, e.hi, e.n_apart, e.lo > e.hi ? 0 : nearbyint(e.hi) - nearbyint(e.lo) + 1,
                      type);
    return VV_OK;
}

static bool always_fits(const vv_field_info *info, vv_type type)
{
    const double a = vvi_type_min(info->type) * info->value_scale + info->value_offset;
    const double b = vvi_type_max(info->type) * info->value_scale + info->value_offset;
    if (vv_type_is_float(type))
        return true;
    return !vv_type_is_float(info->type) && (a < b ? a : b) >= vvi_type_min(type) &&
           (a < b ? b : a) <= vvi_type_max(type);
}

static vv_status keep_numbers(vv_step *step, cli_command *command, const cli_input *input, vv_type type,
                              const vv_property_context *context)
{
    const vv_field_info *info = vv_file_info(input->file);
    vv_status st = VV_OK;
    if ((!always_fits(info, type) || may_round(info, type)) && !command->common->dry_run &&
        (st = vvi_file_make_repeatable(input->file, command->job)) == VV_OK) /* they are read again to be converted */
        st = check_fit(command, input, type);
    /* a window that is itself: every value goes to the same number */
    if (st != VV_OK || (st = set(step, "from", "0,1", context)) != VV_OK ||
        (st = set(step, "to", "0,1", context)) != VV_OK)
        return st;
    return set(step, "clamp", "false", context);
}

/* LO..HI, so that refusals speak of what was typed, not of the operation's parameters. */
static vv_status check_window(const char *option, const char *typed, bool percentile)
{
    double ends[2];
    if (!typed)
        return VV_OK;
    if (cli_value_numbers(ends, 2, typed, false) != VV_OK)
        return vv_fail(VV_E_ARGUMENT, "--%s: expected two numbers LO..HI, as in %s, found '%s'", option,
                       percentile ? "1..99.8" : "0..1500", typed);
    if (percentile && !(ends[0] >= 0 && ends[0] < ends[1] && ends[1] <= 100))
        return vv_fail(VV_E_ARGUMENT, "--%s: expected ascending LO..HI between 0 and 100, as in 1..99.8, found '%s'",
                       option, typed);
    if (ends[0] == ends[1])
        return vv_fail(VV_E_ARGUMENT, "--%s: LO and HI of '%s' are the same; give two different values", option, typed);
    return VV_OK;
}

static vv_status rescale_step(vv_step *step, cli_command *command, const convert_options *options,
                              const cli_input *input, const vv_property_context *context)
{
    vv_type type = vv_file_info(input->file)->type;
    vv_status st;
    if (options->range && options->percentile)
        return cli_refused(
            command, "range,percentile",
            vv_fail(VV_E_ARGUMENT, "--range and --percentile both say which values to keep: give one of them"));
    if ((st = check_window("range", options->range, false)) != VV_OK ||
        (st = check_window("percentile", options->percentile, true)) != VV_OK)
        return st;
    if (options->type && !vv_type_parse(&type, options->type)) {
        const char *names[VV_TYPE_COUNT];
        for (int t = 0; t < VV_TYPE_COUNT; t++)
            names[t] = vv_type_name((vv_type)t);
        return vvi_fail_name(VV_E_ARGUMENT, NULL, NULL, options->type, &(vvi_known){names, VV_TYPE_COUNT, NULL, NULL},
                             "--type: no type '%s'", options->type);
    }
    if ((st = begin_step(step, command, "rescale", context)) != VV_OK ||
        (st = set(step, "type", vv_type_name(type), context)) != VV_OK)
        return st;
    if (!options->range && !options->percentile)
        return keep_numbers(step, command, input, type, context);
    if ((st = set(step, "from", options->range, context)) != VV_OK)
        return vv_fail_in(st, "--range");
    if ((st = set(step, "percentile", options->percentile, context)) != VV_OK)
        return vv_fail_in(st, "--percentile");
    return VV_OK;
}

/* An operation with one parameter. */
static vv_status simple_step(vv_step *step, const cli_command *command, const char *operation, const char *parameter,
                             const char *value, const vv_property_context *context)
{
    const vv_status st = begin_step(step, command, operation, context);
    return st == VV_OK ? set(step, parameter, value, context) : st;
}

static vv_status convert(cli_command *command, cli_input *input)
{
    const convert_options *options = cli_command_options(command, &options_class);
    const vv_field_info *info = vv_file_info(input->file);
    const vv_property_context context = cli_input_context(info, command->registry);
    const bool retyped = options->type || options->range || options->percentile;
    vv_step steps[6] = {0};
    size_t n = 0;
    vv_status st = VV_OK;
    if (options->x || options->y || options->z)
        st = crop_step(&steps[n++], command, options, &context);
    if (st == VV_OK && options->channel)
        st = cli_refused(command, "channel", channel_step(&steps[n++], command, options, input, &context));
    if (st == VV_OK && options->spacing)
        st = simple_step(&steps[n++], command, "resample", "spacing", options->spacing, &context);
    if (st == VV_OK && retyped)
        st = rescale_step(&steps[n++], command, options, input, &context);
    /* last: what asks for samples out of their order has the least to do */
    if (st == VV_OK && options->flip)
        st = simple_step(&steps[n++], command, "flip", "axes", options->flip, &context);
    if (st == VV_OK && options->order)
        st = simple_step(&steps[n++], command, "reorient", "order", options->order, &context);
    if (st == VV_OK && (st = cli_pipeline_run(command, input, 1, steps, n)) == VV_E_ARGUMENT)
        cli_refused(command, "type", st); /* of labels, and of formats that have no such samples */
    for (size_t i = 0; i < n; i++)
        vv_object_release(steps[i].params);
    return st;
}

/* What is about samples says nothing to a mesh. */
static vv_status check_mesh_options(const cli_command *command, const convert_options *options, const char *word)
{
    for (const vv_property *row = rows; row->name; row++)
        if (!strstr(row->name, "unit") && vv_object_is_set(&options->base, row->name))
            return cli_refused(
                command, row->name,
                vv_fail_at(VV_E_ARGUMENT, word, NULL, "is a mesh: --%s is about samples of volumes", row->name));
    return VV_OK;
}

/* An output that is to be a mesh, of what is none: a volume, or a file that nobody knows. */
static vv_status fail_mesh_output(cli_command *command, const char *output)
{
    const cli_writing *writing = cli_command_options(command, &cli_writing_class);
    cli_input input = {0};
    vv_status st = cli_command_start(command);
    if (st == VV_OK)
        st = cli_input_open(&input, command, command->args.words[0]);
    cli_input_close(&input);
    return st == VV_OK ? cli_output_check(command, output, CLI_OUTPUT_VOLUME, writing->output_format) : st;
}

static vv_status run(cli_command *command)
{
    const convert_options *options = cli_command_options(command, &options_class);
    const cli_writing *writing = cli_command_options(command, &cli_writing_class);
    cli_input input = {0};
    const char *output;
    vv_status st;
    if ((st = cli_output_need(&output, command, "the result")) != VV_OK)
        return st;
    if (cli_mesh_is_input(command, command->args.words[0])) {
        if ((st = check_mesh_options(command, options, command->args.words[0])) != VV_OK ||
            (st = cli_command_start(command)) != VV_OK)
            return st;
        return cli_mesh_convert(command, command->args.words[0], options->input_unit, options->unit);
    }
    if (writing->stored && (options->type || options->range || options->percentile))
        return cli_refused(command, "stored,type,range,percentile",
                           vv_fail(VV_E_ARGUMENT,
                                   "--stored keeps stored numbers, and --%s makes others of values: give one of them",
                                   options->type    ? "type"
                                   : options->range ? "range"
                                                    : "percentile"));
    if (options->unit || options->input_unit)
        return cli_refused(command, options->unit ? "unit" : "input-unit",
                           vv_fail(VV_E_ARGUMENT, "--%s is about meshes, and %s is none",
                                   options->unit ? "unit" : "input-unit", command->args.words[0]));
    if (cli_mesh_is_output(command, output, writing->output_format))
        return fail_mesh_output(command, output);
    if ((st = cli_output_check(command, output, CLI_OUTPUT_VOLUME, writing->output_format)) != VV_OK ||
        (st = cli_command_start(command)) != VV_OK ||
        (st = cli_input_open(&input, command, command->args.words[0])) != VV_OK)
        return st;
    do
        st = convert(command, &input);
    while (st != VV_OK && cli_refusal_gives_way(command));
    cli_input_close(&input);
    return st;
}

static const char *const examples[] = {
    "volvis convert head.nii.gz -o head.nrrd",
    "volvis convert head.nrrd new.nii.gz",
    "volvis convert head.nrrd lobster.nrrd -o '{stem}.mha'",
    "volvis convert head.nrrd -o head8.nrrd --type u8 --range 0..1500 --encoding gzip",
    "volvis convert head.nrrd -o 'slices/head_%03d.tif'",
    "volvis convert head.nrrd -o part.npy --x 8..39 --type f32",
    "volvis convert cells.nrrd -o nuclei.nrrd --channel 1",
    "volvis convert head.nii.gz -o even.nrrd --order RAS --spacing 2mm",
    "volvis convert - --input-format nrrd -o out.nii.gz < head.nrrd",
    "volvis convert skin.ply -o skin.stl --unit mm",
    NULL,
};

const cli_verb cli_verb_convert = {
    .name = "convert",
    .doc = "data from one format, type and window to another; meshes from one format to another",
    .about =
        "Orientation, spacing and units stay what they are unless --order or --spacing says otherwise; the steps are "
        "taken in the order crop, channel, spacing, type, flip, order. A file with time steps keeps all of them unless "
        "one is "
        "chosen with FILE@N or --frame. Whole numbers that are written to .seg.nrrd, the segmentations of 3D Slicer, "
        "become labels. IN OUT will do for IN -o OUT where there is no OUT yet. What does not fit in "
        "memory goes from file to file slab by slab.",
    .words = "INPUT",
    .choices = "files",
    .min_words = 1,
    .max_words = 1,
    .options = {&options_class, &cli_reading_class, &cli_writing_class, &cli_watching_class},
    .examples = examples,
    .makes_file = true,
    .each_input = true,
    .in_out = true,
    .run = run,
};
