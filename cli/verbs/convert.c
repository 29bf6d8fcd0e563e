#include "command.h"
#include "core/units.h"
#include "grid/field.h"
#include "output.h"
#include "pipeline.h"
#include "verbs.h"
#include <stdio.h>
#include <stdlib.h>

typedef struct convert_options {
    vv_object base;
    char *type, *range, *percentile, *x, *y, *z;
} convert_options;

static const vv_property rows[] = {
    {VV_PROP(convert_options, type), .kind = VV_KIND_STRING, .unit = "TYPE", .table = "types", .automatic = "as it is",
     .doc = "type of the samples: u8, i16, f32, ...; without --range or --percentile the numbers stay what they are"},
    {VV_PROP(convert_options, range), .kind = VV_KIND_STRING, .unit = "LO,HI", .automatic = "values as they are",
     .doc = "window of values that is stretched over the whole range of an integer type, or to 0..1"},
    {VV_PROP(convert_options, percentile), .kind = VV_KIND_STRING, .unit = "LO,HI", .automatic = "values as they are",
     .doc = "the same window by share of the samples: 1,99.8"},
    {VV_PROP(convert_options, x), .kind = VV_KIND_STRING, .unit = "FIRST:END", .automatic = "all",
     .doc = "samples kept along x, as in 'volvis help crop'"},
    {VV_PROP(convert_options, y), .kind = VV_KIND_STRING, .unit = "FIRST:END", .automatic = "all",
     .doc = "samples kept along y"},
    {VV_PROP(convert_options, z), .kind = VV_KIND_STRING, .unit = "FIRST:END", .automatic = "all",
     .doc = "samples kept along z"},
    {0},
};

static const vv_class options_class = {
    .name = "convert",
    .doc = "options of convert",
    .size = sizeof(convert_options),
    .properties = rows,
};

/* Give an operation's parameter, if there is something to give. */
static vv_status set(cli_step *step, const char *property, const char *value, const vv_property_context *context)
{
    return value ? vv_path_set(&step->params, property, value, context) : VV_OK;
}

static vv_status begin_step(cli_step *step, const cli_command *command, const char *name,
                            const vv_property_context *context)
{
    step->operation = vv_registry_operation(command->registry, name);
    if (!step->operation)
        return vv_error_last()->status;
    return vv_object_new(&step->params, step->operation->params, context);
}

static vv_status crop_step(cli_step *step, const cli_command *command, const convert_options *options,
                           const vv_property_context *context)
{
    vv_status st;
    if ((st = begin_step(step, command, "crop", context)) != VV_OK ||
        (st = set(step, "x", options->x, context)) != VV_OK || (st = set(step, "y", options->y, context)) != VV_OK)
        return st;
    return set(step, "z", options->z, context);
}

/* The numbers stay: whether they fit has to be looked up where the types alone do not say so. */
static vv_status check_fit(cli_command *command, const cli_input *input, vv_type type, int64_t frame)
{
    const double lo = vvi_type_min(type), hi = vvi_type_max(type);
    vv_statistics *s = malloc(sizeof *s);
    vv_field *field = NULL;
    if (!s)
        return vv_fail_memory(sizeof *s);
    vv_status st = vv_file_read(&field, input->file, frame, NULL, command->job);
    for (int c = 0; st == VV_OK && c < vv_field_get_info(field)->components; c++) {
        st = vv_field_statistics(s, field, c, command->job);
        if (st == VV_OK && s->count && (s->min < lo || s->max > hi))
            st =
                vv_fail_at(VV_E_ARGUMENT, input->path, NULL,
                           "values from %g to %g do not fit in %s (%g to %g): say which become its ends, --range %g,%g "
                           "or --percentile 1,99.8",
                           s->min, s->max, vv_type_name(type), lo, hi, s->min, s->max);
    }
    vv_field_release(field);
    free(s);
    return st;
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

static vv_status keep_numbers(cli_step *step, cli_command *command, const cli_input *input, vv_type type,
                              const vv_property_context *context)
{
    const vv_field_info *info = vv_file_info(input->file);
    vv_status st = VV_OK;
    if (!always_fits(info, type) && !command->common->dry_run) {
        const int64_t first = input->frame < 0 ? 0 : input->frame;
        const int64_t end = input->frame < 0 ? info->n_frames : first + 1;
        for (int64_t f = first; f < end && st == VV_OK; f++)
            st = check_fit(command, input, type, f);
    }
    step->labels_as_numbers = true;
    /* a window that is itself: every value goes to the same number */
    if (st != VV_OK || (st = set(step, "from", "0,1", context)) != VV_OK ||
        (st = set(step, "to", "0,1", context)) != VV_OK)
        return st;
    return set(step, "clamp", "false", context);
}

static vv_status rescale_step(cli_step *step, cli_command *command, const convert_options *options,
                              const cli_input *input, const vv_property_context *context)
{
    vv_type type = vv_file_info(input->file)->type;
    vv_status st;
    if (options->range && options->percentile)
        return vv_fail(VV_E_ARGUMENT, "--range and --percentile both say which values to keep: give one of them");
    if (options->type && !vv_type_parse(&type, options->type)) {
        const char *names[VV_TYPE_COUNT];
        for (int t = 0; t < VV_TYPE_COUNT; t++)
            names[t] = vv_type_name((vv_type)t);
        const char *near = vv_nearest_name(options->type, names, VV_TYPE_COUNT);
        return vv_fail(VV_E_ARGUMENT, "--type: no type '%s'; %s%s", options->type,
                       near ? "did you mean " : "there are u8, i8, u16, i16, u32, i32, u64, i64, f32, f64",
                       near ? near : "");
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

static vv_status convert(cli_command *command, cli_input *input)
{
    const convert_options *options = cli_command_options(command, &options_class);
    const vv_field_info *info = vv_file_info(input->file);
    const vv_property_context context = cli_input_context(info, command->registry);
    const bool retyped = options->type || options->range || options->percentile;
    cli_step steps[2] = {0};
    size_t n = 0;
    vv_status st = VV_OK;
    if (options->x || options->y || options->z)
        st = crop_step(&steps[n++], command, options, &context);
    if (st == VV_OK && retyped)
        st = rescale_step(&steps[n++], command, options, input, &context);
    if (st == VV_OK)
        st = cli_pipeline_run(command, input, 1, steps, n);
    for (size_t i = 0; i < n; i++)
        vv_object_release(steps[i].params);
    return st;
}

static vv_status run(cli_command *command)
{
    const cli_writing *writing = cli_command_options(command, &cli_writing_class);
    cli_input input = {0};
    const char *output;
    vv_status st;
    if ((st = cli_output_need(&output, command, "the result")) != VV_OK ||
        (st = cli_output_check(command, output, CLI_OUTPUT_VOLUME, writing->output_format)) != VV_OK ||
        (st = cli_command_start(command)) != VV_OK ||
        (st = cli_input_open(&input, command, command->args.words[0])) != VV_OK)
        return st;
    st = convert(command, &input);
    cli_input_close(&input);
    return st;
}

static const char *const examples[] = {
    "volvis convert head.nii.gz -o head.nrrd",
    "volvis convert head.nrrd -o head8.nrrd --type u8 --range 0,1500 --encoding gzip",
    "volvis convert head.nrrd -o part.npy --x 8:40 --type f32",
    "volvis convert - --input-format nrrd -o out.nii.gz < head.nrrd",
    NULL,
};

const cli_verb cli_verb_convert = {
    .name = "convert",
    .doc = "data from one format, type and window to another",
    .about =
        "Orientation, spacing and units stay what they are. A file with time steps keeps all of them unless one is "
        "chosen with FILE@N or --frame.",
    .words = "INPUT",
    .choices = "files",
    .min_words = 1,
    .max_words = 1,
    .options = {&options_class, &cli_reading_class, &cli_writing_class},
    .examples = examples,
    .makes_file = true,
    .run = run,
};
