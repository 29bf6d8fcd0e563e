#include "pipeline.h"
#include "carry.h"
#include "core/memory.h"
#include "core/units.h"
#include "filter/rescale.h"
#include "grid/true_values.h"
#include "io/file_stream.h"
#include "io/format.h"
#include "layers.h"
#include "output.h"
#include "registry.h"
#include "stream.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct pipeline {
    cli_command *command;
    cli_input *inputs;
    size_t n_inputs;
    const cli_step *steps;
    size_t n_steps;
    int64_t first_frame, n_frames;
    vv_field_info info;    /* of the result */
    vv_field_info written; /* of the result as it is in the file */
    uint64_t needed;       /* bytes that the samples read and the steps' results take */
    bool streamed;         /* they are more than should be held: slab by slab */
    cli_stream stream;
    bool labels_only;   /* what is written holds labels alone: whole numbers are some */
    cli_layers layers;  /* of the input, where all go into the output: the frames */
    vv_field **results; /* n_frames */
    double load_s, run_s, write_s;
} pipeline;

void cli_describe_info(char out[128], const vv_field_info *info, int64_t n_frames)
{
    char components[32] = "", frames[40] = "";
    if (info->components > 1)
        snprintf(components, sizeof components, ", %d channels", info->components);
    if (n_frames > 1)
        snprintf(frames, sizeof frames, ", %" PRId64 " time steps", n_frames);
    snprintf(out, 128, "%" PRId64 " x %" PRId64 " x %" PRId64 " %s%s%s", info->grid.dims[0], info->grid.dims[1],
             info->grid.dims[2], vv_type_name(info->type), components, frames);
}

/* Layers of a segmentation in the place of time steps, where the output holds them. */
static vv_status choose_layers(pipeline *p)
{
    p->labels_only = cli_layers_wanted(p->command);
    if (!p->labels_only || p->n_inputs > 1 || p->n_frames > 1)
        return VV_OK;
    const vv_status st = cli_layers_open(&p->layers, p->command, &p->inputs[0]);
    if (p->layers.n > 0)
        p->n_frames = (int64_t)p->layers.n;
    return st;
}

static vv_status choose_frames(pipeline *p)
{
    const int64_t n = vv_file_info(p->inputs[0].file)->n_frames;
    const bool chosen = p->inputs[0].frame >= 0;
    p->first_frame = chosen ? p->inputs[0].frame : 0;
    p->n_frames = chosen ? 1 : n;
    for (size_t i = 1; i < p->n_inputs && p->n_frames > 1; i++) {
        const int64_t there = vv_file_info(p->inputs[i].file)->n_frames;
        if (p->inputs[i].frame < 0 && there != 1 && there != n)
            return vv_fail_at(VV_E_ARGUMENT, p->inputs[i].path, NULL,
                              "has %" PRId64 " time steps but %s has %" PRId64 ": choose one with FILE@N", there,
                              p->inputs[0].path, n);
    }
    return VV_OK;
}

static void set_meaning(vv_field_info *info, const cli_step *step, vv_meaning from, vv_meaning to)
{
    if (step->labels_as_numbers && info->meaning == from)
        info->meaning = to;
}

static bool becomes_label(const pipeline *p, const vv_field_info *info)
{
    return p->labels_only && info->meaning == VV_MEANING_SCALAR && info->components == 1 &&
           !vv_type_is_float(info->type);
}

/* What the result will be, and what it takes on the way. */
static vv_status plan(pipeline *p)
{
    enum { MOST = 16 };
    vv_field_info infos[MOST] = {0};
    vv_status st;
    const size_t n = p->n_inputs < MOST ? p->n_inputs : MOST;
    for (size_t i = 0; i < n; i++)
        infos[i] = *vv_file_info(p->inputs[i].file);
    if (becomes_label(p, &infos[0]))
        infos[0].meaning = VV_MEANING_LABEL;
    for (size_t s = 0; s < p->n_steps; s++) {
        const cli_step *step = &p->steps[s];
        const bool labels = infos[0].meaning == VV_MEANING_LABEL;
        uint64_t bytes = 0;
        vv_field_info next;
        set_meaning(&infos[0], step, VV_MEANING_LABEL, VV_MEANING_SCALAR);
        if ((st = step->operation->plan(&next, infos, s ? 1 : n, step->params)) != VV_OK ||
            (st = vv_field_info_bytes(&bytes, &next)) != VV_OK)
            return st;
        infos[0] = next;
        if (labels)
            set_meaning(&infos[0], step, VV_MEANING_SCALAR, VV_MEANING_LABEL);
        p->needed += bytes * (uint64_t)(s + 1 == p->n_steps ? p->n_frames : 1);
    }
    if (becomes_label(p, &infos[0]))
        infos[0].meaning = VV_MEANING_LABEL;
    p->info = infos[0];
    return VV_OK;
}

/* What reading holds: the samples of a time step, unless they are used where they lie. Without steps what was read is
 * the result, and every time step stays. */
static vv_status plan_reading(pipeline *p)
{
    for (size_t i = 0; i < p->n_inputs; i++) {
        uint64_t bytes = 0;
        const vv_status st = vv_field_info_bytes(&bytes, vv_file_info(p->inputs[i].file));
        if (st != VV_OK)
            return st;
        if (!vv_file_mappable(p->inputs[i].file))
            p->needed += bytes * (uint64_t)(p->n_steps ? 1 : p->n_frames);
    }
    return VV_OK;
}

static vv_status relabel(vv_field **field, vv_meaning meaning)
{
    vv_field_info info = *vv_field_get_info(*field);
    vv_field *same = NULL;
    info.meaning = meaning;
    const vv_status st = vvi_field_relabel(&same, *field, &info);
    if (st == VV_OK) {
        vv_field_release(*field);
        *field = same;
    }
    return st;
}

static vv_status run_step(vv_field **fields, size_t n, const pipeline *p, size_t index)
{
    const cli_step *step = &p->steps[index];
    vv_job *job = p->command->job;
    const bool labels = step->labels_as_numbers && vv_field_get_info(fields[0])->meaning == VV_MEANING_LABEL;
    vv_field *result = NULL;
    vv_status st = labels ? relabel(&fields[0], VV_MEANING_SCALAR) : VV_OK;
    if (st == VV_OK && p->streamed)
        st = cli_stream_step(&result, &p->stream, fields, n, step, index, job);
    else if (st == VV_OK)
        st = vv_operation_run(&result, step->operation, (const vv_field *const *)fields, n, step->params, job);
    if (st == VV_OK && labels)
        st = relabel(&result, VV_MEANING_LABEL);
    vv_field_release(fields[0]);
    fields[0] = result;
    return st;
}

static vv_status declare_labels(vv_field **field, const pipeline *p)
{
    return becomes_label(p, vv_field_get_info(*field)) ? relabel(field, VV_MEANING_LABEL) : VV_OK;
}

static int64_t frame_of(const pipeline *p, size_t input, int64_t index)
{
    if (p->layers.n > 0)
        return 0;
    const cli_input *in = &p->inputs[input];
    if (in->frame >= 0)
        return in->frame;
    return vv_file_info(in->file)->n_frames > 1 ? p->first_frame + index : 0;
}

/* A time step before step `n_steps`: *out, unless it fails. */
static vv_status make_frame(vv_field **out, pipeline *p, int64_t index, size_t n_steps)
{
    vv_job *job = p->command->job;
    vv_status st = VV_OK;
    const double start_s = cli_now_s();
    vv_field **fields = calloc(p->n_inputs, sizeof(vv_field *));
    if (!fields)
        return vv_fail_memory(p->n_inputs * sizeof(vv_field *));
    for (size_t i = 0; i < p->n_inputs && st == VV_OK; i++) {
        const cli_input *input = p->layers.n > 0 ? &p->layers.input[index] : &p->inputs[i];
        st = p->streamed ? cli_stream_read(&fields[i], &p->stream, input, i, frame_of(p, i, index), job)
                         : vv_file_read(&fields[i], input->file, frame_of(p, i, index), NULL, job);
    }
    if (st == VV_OK)
        st = declare_labels(&fields[0], p);
    const double read_s = cli_now_s();
    for (size_t s = 0; s < n_steps && st == VV_OK; s++)
        st = run_step(fields, s ? 1 : p->n_inputs, p, s);
    if (st == VV_OK)
        st = declare_labels(&fields[0], p);
    p->load_s += read_s - start_s;
    p->run_s += cli_now_s() - read_s;
    if (st == VV_OK) {
        *out = fields[0];
        fields[0] = NULL;
    }
    for (size_t i = 0; i < p->n_inputs; i++)
        vv_field_release(fields[i]);
    free(fields);
    return st;
}

typedef struct before_step {
    pipeline *p;
    size_t step;
} before_step;

static vv_status open_frame(vv_field **out, void *user, size_t index, vv_job *job)
{
    (void)job;
    const before_step *b = user;
    const cli_step *step = &b->p->steps[b->step];
    vv_status st = make_frame(out, b->p, (int64_t)index, b->step);
    if (st == VV_OK && step->labels_as_numbers && vv_field_get_info(*out)->meaning == VV_MEANING_LABEL)
        st = relabel(out, VV_MEANING_SCALAR);
    return st;
}

/* Time steps share one window where their samples decide it: else each would be stretched by itself. */
static bool settles_window(const pipeline *p, const cli_step *step)
{
    return p->n_frames > 1 && step->operation == &vvi_operation_rescale && vvi_rescale_looks(step->params);
}

static vv_status settle_windows(pipeline *p)
{
    vv_status st = VV_OK;
    for (size_t s = 0; s < p->n_steps && st == VV_OK; s++) {
        const cli_step *step = &p->steps[s];
        if (!settles_window(p, step))
            continue;
        before_step before = {p, s};
        const vvi_field_series frames = {open_frame, &before, (size_t)p->n_frames};
        st = vvi_rescale_settle(step->params, &frames, p->command->job);
    }
    return st;
}

static vv_status all_frames(pipeline *p)
{
    vv_status st = settle_windows(p);
    if (st != VV_OK)
        return st;
    p->results = calloc((size_t)p->n_frames, sizeof(vv_field *));
    if (!p->results)
        return vv_fail_memory((size_t)p->n_frames * sizeof(vv_field *));
    for (int64_t f = 0; f < p->n_frames && st == VV_OK; f++)
        st = make_frame(&p->results[f], p, f, p->n_steps);
    return st;
}

static vv_status write_result(pipeline *p, const char *output)
{
    vv_write_options options;
    cli_carry carry;
    const double start_s = cli_now_s();
    cli_output_options(&options, p->command);
    options.written = &p->written;
    vv_status st = cli_carry_begin(&carry, &options, &p->inputs[0], p->steps, p->n_steps, &p->info);
    if (p->layers.n > 0) {
        options.layers = true;
        options.labels = p->layers.labels;
        options.n_labels = p->layers.n_labels;
    }
    if (st == VV_OK)
        st =
            vv_field_write(output, (const vv_field *const *)p->results, (size_t)p->n_frames, &options, p->command->job);
    cli_carry_finish(&carry);
    p->write_s = cli_now_s() - start_s;
    return st;
}

static void report_info(pipeline *p, const char *output, const vv_field_info *info)
{
    vvi_result *json = &p->command->json;
    const double dims[3] = {(double)info->grid.dims[0], (double)info->grid.dims[1], (double)info->grid.dims[2]};
    vvi_result_string(json, "output", output);
    vvi_result_numbers(json, "dims", dims, 3);
    vvi_result_string(json, "type", vv_type_name(info->type));
    vvi_result_integer(json, "components", info->components);
    vvi_result_integer(json, "frames", p->layers.n > 0 ? 1 : p->n_frames);
    if (p->layers.n > 0)
        vvi_result_integer(json, "layers", (int64_t)p->layers.n);
}

static void report(pipeline *p, const char *output)
{
    cli_command *command = p->command;
    char about[128], scaled[128] = "";
    vvi_check(p->results != NULL);
    const vv_field_info *info = vv_field_get_info(p->results[0]);
    cli_describe_info(about, &p->written, p->layers.n > 0 ? 1 : p->n_frames);
    if (vvi_has_scale(info) && !vvi_has_scale(&p->written))
        snprintf(scaled, sizeof scaled, ", the values of %s * %g %c %g", vv_type_name(info->type), info->value_scale,
                 info->value_offset < 0 ? '-' : '+', fabs(info->value_offset));
    report_info(p, output, &p->written);
    vvi_result_number(&command->json, "load_s", p->load_s);
    vvi_result_number(&command->json, "run_s", p->run_s);
    vvi_result_number(&command->json, "write_s", p->write_s);
    vvi_result_unsigned(&command->json, "peak_bytes", vv_runtime_memory_peak(command->runtime));
    vvi_result_integer(&command->json, "threads", vv_runtime_threads(command->runtime));
    vvi_result_bool(&command->json, "streamed", p->streamed);
    vvi_text_add_clean(&command->text, output);
    if (p->streamed)
        vvi_text_printf(&command->text, ": %s%s; streamed in %.2f s\n", about, scaled, p->run_s + p->write_s);
    else
        vvi_text_printf(&command->text, ": %s%s; read %.2f s, %s %.2f s, written %.2f s\n", about, scaled, p->load_s,
                        command->verb.name, p->run_s, p->write_s);
}

/* Whether all samples are looked at for the type of what is written, before it is. */
static bool looks_for_type(const pipeline *p)
{
    const vv_format *format;
    vv_write_options options;
    cli_output_options(&options, p->command);
    const char *output = p->command->common->output;
    const vv_registry *registry = p->command->registry;
    const vv_status st = options.format ? vvi_format_named(&format, options.format, registry)
                                        : vvi_format_of_output(&format, output, registry);
    return st == VV_OK && vvi_format_writes_values(format, &p->info, options.stored);
}

static void report_plan(pipeline *p, const char *output)
{
    cli_command *command = p->command;
    char about[128], needed[32];
    uint64_t bytes = 0;
    cli_describe_info(about, &p->info, p->layers.n > 0 ? 1 : p->n_frames);
    vvi_print_bytes(needed, p->needed);
    for (size_t i = 0; i < p->n_inputs; i++) {
        char from[128];
        cli_describe_info(from, vv_file_info(p->inputs[i].file), vv_file_info(p->inputs[i].file)->n_frames);
        cli_command_line(command, "reads", "%s: %s", p->inputs[i].path, from);
    }
    cli_command_line(command, "makes", "%s: %s%s", output, about,
                     looks_for_type(p) ? ", as values: in the smallest type that holds them" : "");
    cli_command_line(command, "needs", "%s for samples and results%s", needed, p->streamed ? ", slab by slab" : "");
    report_info(p, output, &p->info);
    if (vv_field_info_bytes(&bytes, &p->info) == VV_OK)
        vvi_result_unsigned(&command->json, "output_bytes", bytes * (uint64_t)p->n_frames);
    vvi_result_unsigned(&command->json, "memory_bytes", p->needed);
    vvi_result_bool(&command->json, "streamed", p->streamed);
    vvi_result_bool(&command->json, "dry_run", true);
}

/* Inputs that come by a pipe, where a step goes through them more often or in another order. */
static vv_status allow_repeats(pipeline *p)
{
    bool again = p->streamed && (p->labels_only || looks_for_type(p));
    vv_status st = VV_OK;
    for (size_t s = 0; s < p->n_steps; s++)
        again = again || (p->streamed && !p->steps[s].once) || settles_window(p, &p->steps[s]);
    for (size_t i = 0; i < p->n_inputs && again && st == VV_OK; i++)
        st = vvi_file_make_repeatable(p->inputs[i].file, p->command->job);
    return st;
}

/* More than fits is streamed, unless a step cannot: then what it takes is said before the work. */
static vv_status plan_memory(pipeline *p)
{
    vv_status st = VV_OK;
    p->streamed = cli_stream_needed(p->command, p->needed);
    for (size_t s = 0; s < p->n_steps; s++)
        p->streamed = p->streamed && p->steps[s].operation->run_box;
    if (p->streamed && (st = cli_stream_init(&p->stream, p->command, p->n_inputs, p->n_steps)) == VV_OK)
        p->needed = p->stream.bytes;
    return st;
}

static vv_status run_pipeline(pipeline *p)
{
    const char *output = p->command->common->output;
    vv_status st;
    if ((st = choose_frames(p)) != VV_OK || (st = choose_layers(p)) != VV_OK || (st = plan(p)) != VV_OK ||
        (st = plan_reading(p)) != VV_OK || (st = plan_memory(p)) != VV_OK)
        return st;
    if (p->command->common->dry_run) {
        report_plan(p, output);
        return VV_OK;
    }
    if ((st = vvi_memory_plan(p->command->job, p->needed, p->command->verb.name)) == VV_OK &&
        (st = allow_repeats(p)) == VV_OK && (st = all_frames(p)) == VV_OK && (st = write_result(p, output)) == VV_OK)
        report(p, output);
    return st;
}

vv_status cli_pipeline_run(cli_command *command, cli_input *inputs, size_t n_inputs, const cli_step *steps,
                           size_t n_steps)
{
    pipeline p = {.command = command, .inputs = inputs, .n_inputs = n_inputs, .steps = steps, .n_steps = n_steps};
    const vv_status st = run_pipeline(&p);
    for (int64_t f = 0; p.results && f < p.n_frames; f++)
        vv_field_release(p.results[f]);
    free(p.results);
    cli_stream_free(&p.stream);
    cli_layers_close(&p.layers);
    return st;
}
