/* One file for each time step of a series. */
#include "command.h"
#include "core/text.h"
#include "input.h"
#include "io/file_stream.h"
#include "output.h"
#include "pipeline.h"
#include "verbs.h"
#include <ctype.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <volvis/run.h>

enum { WIDTH_MOST = 20 };

/* "%d" or "%03d" in the name of a file: where it stands, and how wide it is. */
typedef struct field {
    size_t at, n;
    int width;
} field;

static bool take_field(field *out, const char *pattern)
{
    for (const char *at = strchr(pattern, '%'); at; at = strchr(at + 1, '%')) {
        const size_t n = vvi_text_place(at, &out->width);
        if (n == 0 || out->width > WIDTH_MOST)
            continue;
        out->at = (size_t)(at - pattern);
        out->n = n;
        return true;
    }
    return false;
}

static vv_status find_field(field *out, const char *pattern)
{
    field other;
    if (!take_field(out, pattern))
        return vv_fail(VV_E_ARGUMENT,
                       "split: -o %s: expected a place for the number of the time step, as in 'step-%%03d.nii.gz'",
                       pattern);
    if (take_field(&other, pattern + out->at + out->n) || strchr(pattern + out->at, '/'))
        return vv_fail(VV_E_ARGUMENT, "split: -o %s: the number of the time step stands once, in the name of the file",
                       pattern);
    return VV_OK;
}

static vv_status make_name(char **out, const char *pattern, const field *f, int64_t step)
{
    vvi_text text = {0};
    vvi_text_printf(&text, "%.*s%0*" PRId64 "%s", (int)f->at, pattern, f->width, step, pattern + f->at + f->n);
    const vv_status st = text.bad ? vv_fail_memory(text.n) : VV_OK;
    *out = vvi_text_take(&text);
    vvi_text_free(&text);
    return st;
}

/* None is begun unless all may be written. */
static vv_status check_names(const cli_command *command, char *const *names, int64_t n)
{
    const cli_writing *writing = cli_command_options(command, &cli_writing_class);
    vv_status st = VV_OK;
    for (int64_t i = 0; i < n && st == VV_OK; i++)
        st = cli_output_check(command, names[i], CLI_OUTPUT_VOLUME, writing->output_format);
    return st;
}

static vv_status write_step(vv_run_about *out, cli_command *command, const cli_input *input, const char *name,
                            int64_t step)
{
    vv_write_options options;
    vv_run *run = NULL;
    const vv_run_output output = {.path = name, .options = &options};
    const vv_run_input file = {
        .file = input->file, .frame = step, .name = input->path, .path = input->path, .part = input->part};
    cli_output_options(&options, command);
    vv_status st = vv_run_new(&run, &file, 1, NULL, 0, &output, command->verb.name, command->job);
    if (st == VV_OK && !command->common->dry_run)
        st = vv_run_write(run);
    if (st == VV_OK)
        *out = *vv_run_get_about(run);
    vv_run_release(run);
    return st;
}

static void report(cli_command *command, char *const *names, int64_t n, const vv_run_about *run)
{
    char about[128];
    const bool dry = command->common->dry_run;
    const vv_field_info *info = dry ? &run->info : &run->written;
    const double dims[3] = {(double)info->grid.dims[0], (double)info->grid.dims[1], (double)info->grid.dims[2]};
    vvi_result *json = &command->json;
    vvi_samples_print(about, info, 1);
    vvi_result_open(json, "outputs", '[');
    for (int64_t i = 0; i < n; i++)
        vvi_result_string(json, NULL, names[i]);
    vvi_result_close(json, ']');
    vvi_result_numbers(json, "dims", dims, 3);
    vvi_result_string(json, "type", vv_type_name(info->type));
    vvi_result_integer(json, "frames", n);
    vvi_result_unsigned(json, "memory_bytes", run->bytes);
    if (dry)
        vvi_result_bool(json, "dry_run", true);
    vvi_text_add_clean(&command->text, names[0]);
    if (n > 1) {
        vvi_text_add(&command->text, " to ");
        vvi_text_add_clean(&command->text, names[n - 1]);
    }
    vvi_text_printf(&command->text, ": %s%" PRId64 " file%s, %s%s\n", dry ? "would be " : "", n, n == 1 ? "" : "s",
                    n == 1 ? "" : "each ", about);
}

static vv_status split_steps(cli_command *command, const cli_input *input, const char *pattern, const field *f)
{
    const int64_t n = vv_file_info(input->file)->n_frames;
    vv_run_about about = {0};
    char **names = calloc((size_t)n, sizeof *names);
    vv_status st = names ? VV_OK : vv_fail_memory((size_t)n * sizeof *names);
    for (int64_t i = 0; i < n && st == VV_OK; i++)
        st = make_name(&names[i], pattern, f, i);
    if (st == VV_OK)
        st = check_names(command, names, n);
    if (st == VV_OK && !command->common->dry_run)
        vvi_file_follow(input->file, VVI_FOLLOW_FRAMES);
    for (int64_t i = 0; i < n && st == VV_OK; i++)
        st = write_step(&about, command, input, names[i], i);
    if (st == VV_OK)
        report(command, names, n, &about);
    for (int64_t i = 0; names && i < n; i++)
        free(names[i]);
    free(names);
    return st;
}

static vv_status run(cli_command *command)
{
    const char *output;
    cli_input input = {0};
    field f;
    vv_status st = cli_output_need(&output, command, "the time steps");
    if (st != VV_OK || (st = find_field(&f, output)) != VV_OK || (st = cli_command_start(command)) != VV_OK ||
        (st = cli_input_open(&input, command, command->args.words[0])) != VV_OK)
        return st;
    if (input.frame >= 0)
        st = vv_fail_at(VV_E_ARGUMENT, input.path, NULL,
                        "time step %" PRId64 " alone was chosen, and split writes all: 'volvis convert' writes one",
                        input.frame);
    else
        st = split_steps(command, &input, output, &f);
    cli_input_close(&input);
    return st;
}

static const char *const examples[] = {
    "volvis split series.nrrd -o 'step-%03d.nii.gz'",
    NULL,
};

const cli_verb cli_verb_split = {
    .name = "split",
    .doc = "one file for each time step of a series",
    .about = "The name of the files has the place of the number, from 0: %d, or %03d with leading zeros. Each file has "
             "what the series says of orientation, units, channels and labels; one time step is in memory at a time. "
             "'volvis join' goes the other way.",
    .words = "INPUT",
    .choices = "files",
    .min_words = 1,
    .max_words = 1,
    .options = {&cli_reading_class, &cli_writing_class},
    .examples = examples,
    .makes_file = true,
    .run = run,
};
