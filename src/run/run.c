/* Steps on files: planned from headers, run for every time step, streamed where memory does not hold them, written. */
#include "core/job.h"
#include "core/memory.h"
#include "core/os.h"
#include "grid/field.h"
#include "grid/lazy.h"
#include "grid/true_values.h"
#include "io/file_stream.h"
#include "io/format.h"
#include "run/run_impl.h"
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

static bool is_gap(const vv_run_input *in)
{
    return !in->file && !in->field && !in->mesh;
}

static const vv_field_info *info_of(const vv_run_input *in)
{
    return in->field ? vv_field_get_info(in->field) : vv_file_info(in->file);
}

int64_t vvi_run_frames(const vv_run_input *in)
{
    return in->field || !in->file ? 1 : vv_file_info(in->file)->n_frames;
}

/* Whether nothing but the header of an input is asked for. */
static bool is_grid_only(const vv_run *r, size_t input)
{
    const vv_operand *o = r->n_steps ? vv_operation_operand(r->steps[0].operation, input) : NULL;
    return o && o->grid_only;
}

/* Whether the time steps of the inputs follow each other. */
static bool joins(const vv_run *r)
{
    return r->n_steps > 0 && r->steps[0].operation->joins;
}

/* How many fields the first step has at a time. */
static size_t n_at_once(const vv_run *r)
{
    return joins(r) ? 1 : r->n_inputs;
}

static int64_t frames_taken(const vv_run_input *in)
{
    return in->frame >= 0 ? 1 : vvi_run_frames(in);
}

static vv_status join_frames(vv_run *r)
{
    r->about.n_frames = 0;
    for (size_t i = 0; i < r->n_inputs; i++) {
        const vv_run_input *in = &r->inputs[i];
        if (is_gap(in))
            return vv_fail(VV_E_ARGUMENT, "%s: input number %zu is missing", r->name, i + 1);
        r->about.n_frames += frames_taken(in);
        if (in->file && !in->field && frames_taken(in) > 1)
            vvi_file_follow(in->file, VVI_FOLLOW_FRAMES);
    }
    r->n_results = r->about.n_frames;
    return VV_OK;
}

/* The input that a time step of the result is of, and which of those that are taken of it. */
static size_t find_joined(const vv_run *r, int64_t *index)
{
    size_t i = 0;
    while (i + 1 < r->n_inputs && *index >= frames_taken(&r->inputs[i]))
        *index -= frames_taken(&r->inputs[i++]);
    return i;
}

static vv_status choose_frames(vv_run *r)
{
    if (joins(r))
        return join_frames(r);
    const int64_t n = vvi_run_frames(&r->inputs[0]);
    const bool chosen = r->inputs[0].frame >= 0;
    r->first_frame = chosen ? r->inputs[0].frame : 0;
    r->about.n_frames = r->n_results = chosen ? 1 : n;
    for (size_t i = 1; i < r->n_inputs && r->about.n_frames > 1; i++) {
        const int64_t there = is_grid_only(r, i) ? 1 : vvi_run_frames(&r->inputs[i]);
        if (r->inputs[i].frame < 0 && there != 1 && there != n)
            return vv_fail_at(VV_E_ARGUMENT, r->inputs[i].name, NULL,
                              "has %" PRId64 " time steps but %s has %" PRId64 ": choose one with FILE@N", there,
                              r->inputs[0].name, n);
    }
    for (size_t i = 0; i < r->n_inputs; i++) /* all of them, the last one too */
        if (r->inputs[i].file && !r->inputs[i].field && r->inputs[i].frame < 0 && r->about.n_frames > 1 &&
            vvi_run_frames(&r->inputs[i]) > 1)
            vvi_file_follow(r->inputs[i].file, VVI_FOLLOW_FRAMES);
    return VV_OK;
}

static vv_status choose_format(vv_run *r, const vv_run_output *output)
{
    const vv_registry *registry = vvi_job_registry(r->job);
    vv_write_options_init(&r->options, sizeof r->options);
    vvi_options_over(&r->options, sizeof r->options, output->options);
    if (!r->path)
        return VV_OK;
    return r->options.format ? vvi_format_named(&r->format, r->options.format, registry)
                             : vvi_format_of_output(&r->format, r->path, registry);
}

/* Layers of a segmentation in the place of time steps, where the output holds them. */
static vv_status choose_layers(vv_run *r)
{
    if (!r->format || !r->format->labels_only || r->n_inputs > 1 || r->about.n_frames > 1)
        return VV_OK;
    const vv_status st = vvi_layers_open(&r->layers, &r->inputs[0], r->job);
    r->about.n_layers = r->layers.n;
    if (r->layers.n > 0)
        r->n_results = (int64_t)r->layers.n;
    return st;
}

static bool settles(const vv_run *r, const vv_step *step)
{
    return r->n_results > 1 && step->operation->looks && step->operation->looks(step->params);
}

static bool in_order(const vv_step *step)
{
    const vv_operation *o = step->operation;
    return o->in_order && !(o->looks && o->looks(step->params));
}

/* Whole numbers that a format of labels is given are labels, before steps ask what they are; with a scale they are
 * amounts. */
static bool becomes_label(const vv_run *r, const vv_field_info *info)
{
    return r->format && r->format->labels_only && info->meaning == VV_MEANING_SCALAR && info->components == 1 &&
           !vv_type_is_float(info->type) && !vvi_has_scale(info);
}

static void declare_label(vv_field_info *info, const vv_run *r)
{
    if (becomes_label(r, info))
        info->meaning = VV_MEANING_LABEL;
}

static vv_status declare_labels(vv_field **field, const vv_run *r)
{
    vv_field_info info = *vv_field_get_info(*field);
    vv_field *same = NULL;
    if (!becomes_label(r, &info))
        return VV_OK;
    info.meaning = VV_MEANING_LABEL;
    const vv_status st = vvi_field_relabel(&same, *field, &info);
    if (st == VV_OK) {
        vv_field_release(*field);
        *field = same;
    }
    return st;
}

/* Planning -------------------------------------------------------------------------------------------------------- */

/* What the result will be, and what it takes on the way. */
static vv_status plan_steps(vv_run *r)
{
    vv_field_info infos[VVI_RUN_INPUTS] = {0};
    vv_status st;
    for (size_t i = 0; i < r->n_inputs; i++)
        if (!is_gap(&r->inputs[i]))
            infos[i] = *info_of(&r->inputs[i]);
    declare_label(&infos[0], r);
    for (size_t s = 0; s < r->n_steps; s++) {
        const vv_step *step = &r->steps[s];
        uint64_t bytes = 0;
        vv_field_info next;
        if (!step->operation->plan)
            return vv_fail(VV_E_ARGUMENT, "%s: makes no samples of samples", step->operation->name);
        if ((st = step->operation->plan(&next, infos, s ? 1 : r->n_inputs, step->params)) != VV_OK ||
            (st = vv_field_info_bytes(&bytes, &next)) != VV_OK)
            return st;
        const uint64_t working =
            step->operation->memory ? step->operation->memory(infos, s ? 1 : n_at_once(r), step->params) : 0;
        r->about.working = working > r->about.working ? working : r->about.working;
        r->whole |= !(step->operation->run_box && working == 0) && !step->operation->passes;
        if (step->operation->passes && step->operation->passes->scratch)
            r->about.scratch += step->operation->passes->scratch(infos, s ? 1 : n_at_once(r), step->params);
        infos[0] = next;
        r->about.bytes += bytes * (uint64_t)(s + 1 == r->n_steps ? r->n_results : 1);
    }
    declare_label(&infos[0], r);
    r->about.finds_type = r->format && vvi_format_writes_values(r->format, &infos[0], r->options.stored);
    r->about.info = r->about.result = r->about.written = infos[0];
    return VV_OK;
}

/* What reading holds: the samples of a time step, unless they are used where they lie. Without steps what was read is
 * the result, and every time step stays. */
static vv_status plan_reading(vv_run *r)
{
    for (size_t i = 0; i < n_at_once(r); i++) {
        const vv_run_input *in = &r->inputs[i];
        uint64_t bytes = 0;
        const vv_status st = is_gap(in) ? VV_OK : vv_field_info_bytes(&bytes, info_of(in));
        if (st != VV_OK)
            return st;
        if (!is_grid_only(r, i) && in->file && !in->field && !vv_file_mappable(in->file))
            r->about.bytes += bytes * (uint64_t)(r->n_steps ? 1 : r->n_results);
    }
    return VV_OK;
}

/* More than fits is streamed, unless a step cannot: then what it takes is said before the work. */
static vv_status plan_memory(vv_run *r)
{
    vv_status st = VV_OK;
    const bool streamed = vvi_stream_needed(r->about.bytes, r->job) && !r->whole;
    if (streamed && (st = vvi_stream_init(&r->stream, n_at_once(r), r->n_steps, r->job)) == VV_OK) {
        r->about.bytes = r->stream.bytes;
        r->about.working = 0;
    } else
        r->about.scratch = 0;
    r->about.streamed = streamed;
    return st;
}

static vv_status plan_fields(vv_run *r, const vv_run_output *output)
{
    vv_status st = VV_OK;
    r->about.makes = VV_IS_FIELD;
    for (size_t i = 0; i < r->n_inputs; i++)
        if (r->inputs[i].mesh)
            return vv_fail(VV_E_ARGUMENT, "%s: takes a volume, and '%s' is a mesh", r->name, r->inputs[i].name);
    if ((st = choose_format(r, output)) == VV_OK && (st = choose_frames(r)) == VV_OK &&
        (st = choose_layers(r)) == VV_OK && (st = plan_steps(r)) == VV_OK && (st = plan_reading(r)) == VV_OK)
        st = plan_memory(r);
    return st;
}

static bool makes_mesh(const vv_run *r)
{
    return r->n_steps > 0 && vv_operation_makes(r->steps[r->n_steps - 1].operation) == VV_IS_MESH;
}

vv_status vv_run_new(vv_run **out, const vv_run_input *inputs, size_t n_inputs, const vv_step *steps, size_t n_steps,
                     const vv_run_output *output, const char *name, vv_job *job)
{
    *out = NULL;
    if (n_inputs < 1 || n_inputs > VVI_RUN_INPUTS)
        return vv_fail(VV_E_ARGUMENT, "%s: takes 1 to %d inputs, there are %zu", name, VVI_RUN_INPUTS, n_inputs);
    vv_run *r = vvi_calloc(1, sizeof *r);
    if (!r)
        return vv_fail_memory(sizeof *r);
    *r = (vv_run){.n_inputs = n_inputs,
                  .n_steps = n_steps,
                  .name = name,
                  .job = job,
                  .path = output->path,
                  .mesh_options = output->mesh_options,
                  .check = output->check,
                  .check_user = output->check_user};
    memcpy(r->inputs, inputs, n_inputs * sizeof *inputs);
    r->steps = vvi_calloc(n_steps + 1, sizeof *steps);
    vv_status st = r->steps ? VV_OK : vv_fail_memory((n_steps + 1) * sizeof *steps);
    if (st == VV_OK && n_steps > 0)
        memcpy(r->steps, steps, n_steps * sizeof *steps);
    if (st == VV_OK)
        st = makes_mesh(r) ? vvi_run_plan_mesh(r) : plan_fields(r, output);
    if (st == VV_OK) {
        *out = r;
        return VV_OK;
    }
    vv_run_release(r);
    return st;
}

void vv_run_release(vv_run *run)
{
    if (!run)
        return;
    for (int64_t f = 0; run->results && f < run->n_results; f++)
        vv_field_release(run->results[f]);
    free(run->results);
    vv_mesh_release(run->mesh);
    vvi_stream_free(&run->stream);
    vvi_layers_close(&run->layers);
    free(run->steps);
    free(run);
}

const vv_run_about *vv_run_get_about(const vv_run *run)
{
    return &run->about;
}

/* Running --------------------------------------------------------------------------------------------------------- */

int64_t vvi_run_frame(const vv_run *r, const vv_run_input *in, int64_t index)
{
    if (in->frame >= 0)
        return in->frame;
    return vvi_run_frames(in) > 1 ? r->first_frame + index : 0;
}

static vv_status refuse_samples(vv_field **out, void *user, const vv_box *box, vv_job *job)
{
    *out = NULL;
    return vv_fail(VV_E_UNSUPPORTED, "the samples of an input were asked for, of which only the grid is known");
}

/* A field that has no samples. */
static vv_status grid_of(vv_field **out, const vv_field_info *info, vv_job *job)
{
    const vvi_lazy_source none = {.make = refuse_samples};
    vvi_lazy_pool *pool;
    *out = NULL;
    vv_status st = vvi_lazy_pool_new(&pool, 1, 0, job);
    if (st == VV_OK)
        st = vvi_field_lazy(out, info, &none, pool, job);
    vvi_lazy_pool_release(pool);
    return st;
}

static vv_status read_input(vv_field **out, const vv_run *r, size_t input, int64_t index)
{
    const vv_run_input *in = &r->inputs[input];
    const bool layered = r->layers.n > 0;
    vv_file *file = layered ? r->layers.file[index] : in->file;
    const int64_t frame = layered ? 0 : vvi_run_frame(r, in, index);
    if (in->field || is_gap(in)) {
        *out = in->field ? vv_field_retain(in->field) : NULL;
        return VV_OK;
    }
    if (is_grid_only(r, input))
        return grid_of(out, vv_file_info(file), r->job);
    return r->about.streamed ? vvi_stream_read(out, &r->stream, file, joins(r) ? 0 : input, frame, r->job)
                             : vv_file_read(out, file, frame, NULL, r->job);
}

static vv_status run_step(vv_field **fields, size_t n, const vv_run *r, size_t index)
{
    const vv_step *step = &r->steps[index];
    vv_field *result = NULL;
    const vv_status st = r->about.streamed ? vvi_stream_step(&result, &r->stream, fields, n, step, index, r->job)
                                           : vv_operation_run(&result, step->operation, (const vv_field *const *)fields,
                                                              n, step->params, r->job);
    vv_field_release(fields[0]);
    fields[0] = result;
    return st;
}

/* A time step before step `n_steps`: *out, unless it fails. */
static vv_status make_frame(vv_field **out, vv_run *r, int64_t index, size_t n_steps)
{
    vv_field *fields[VVI_RUN_INPUTS] = {NULL};
    vv_status st = VV_OK;
    const double start_s = vvi_os_seconds();
    const size_t n = n_at_once(r), first = joins(r) ? find_joined(r, &index) : 0;
    for (size_t i = 0; i < n && st == VV_OK; i++)
        st = read_input(&fields[i], r, first + i, index);
    if (st == VV_OK)
        st = declare_labels(&fields[0], r);
    const double read_s = vvi_os_seconds();
    for (size_t s = 0; s < n_steps && st == VV_OK; s++)
        st = run_step(fields, s ? 1 : n, r, s);
    if (st == VV_OK)
        st = declare_labels(&fields[0], r);
    r->about.load_s += read_s - start_s;
    r->about.run_s += vvi_os_seconds() - read_s;
    if (st == VV_OK) {
        *out = fields[0];
        fields[0] = NULL;
    }
    for (size_t i = 0; i < n; i++)
        vv_field_release(fields[i]);
    return st;
}

typedef struct before_step {
    vv_run *run;
    size_t step;
} before_step;

static vv_status open_frame(vv_field **out, void *user, size_t index, vv_job *job)
{
    const before_step *b = user;
    return make_frame(out, b->run, (int64_t)index, b->step);
}

/* Time steps share what their samples decide: else each would be stretched by itself. */
static vv_status settle(vv_run *r)
{
    vv_status st = VV_OK;
    for (size_t s = 0; s < r->n_steps && st == VV_OK; s++) {
        const vv_step *step = &r->steps[s];
        before_step before = {r, s};
        const vv_field_series frames = {open_frame, &before, (size_t)r->n_results};
        if (settles(r, step))
            st = step->operation->settle(step->params, &frames, r->job);
    }
    return st;
}

static vv_status make_frames(vv_run *r)
{
    vv_status st = settle(r);
    if (st != VV_OK)
        return st;
    r->results = vvi_calloc((size_t)r->n_results, sizeof(vv_field *));
    if (!r->results)
        return vv_fail_memory((size_t)r->n_results * sizeof(vv_field *));
    for (int64_t f = 0; f < r->n_results && st == VV_OK; f++)
        st = make_frame(&r->results[f], r, f, r->n_steps);
    return st;
}

/* Writing --------------------------------------------------------------------------------------------------------- */

/* Inputs that come by a pipe, where a step goes through them more often or in another order. */
static vv_status allow_repeats(vv_run *r)
{
    bool again = r->about.streamed && (!r->format || r->format->labels_only || r->about.finds_type);
    vv_status st = VV_OK;
    for (size_t s = 0; s < r->n_steps; s++)
        again = again || (r->about.streamed && !in_order(&r->steps[s])) || settles(r, &r->steps[s]);
    for (size_t i = 0; i < r->n_inputs && again && st == VV_OK; i++)
        if (r->inputs[i].file)
            st = vvi_file_make_repeatable(r->inputs[i].file, r->job);
    return st;
}

static void take_layers(vv_write_options *options, const vvi_layers *layers)
{
    options->layers = layers->n > 0;
    if (layers->n > 0 && !options->labels) {
        options->labels = layers->labels;
        options->n_labels = layers->n_labels;
    }
}

static vv_status make_fields(vv_run *run)
{
    vv_status st;
    if ((st = vvi_memory_plan(run->job, run->about.bytes + run->about.working, run->name)) != VV_OK ||
        (st = allow_repeats(run)) != VV_OK || (st = make_frames(run)) != VV_OK)
        return st;
    run->about.result = *vv_field_get_info(run->results[0]);
    return VV_OK;
}

vv_status vv_run_make(vv_run *run)
{
    if (run->results || run->mesh)
        return vv_fail(VV_E_ARGUMENT, "%s: has run already", run->name);
    vv_job_forget_findings(run->job);
    return run->about.makes == VV_IS_MESH ? vvi_run_make_mesh(run) : make_fields(run);
}

const vv_mesh *vv_run_mesh(const vv_run *run)
{
    return run->mesh;
}

const vv_field *vv_run_field(const vv_run *run, int64_t index)
{
    return run->results && index >= 0 && index < run->n_results ? run->results[index] : NULL;
}

static vv_status write_fields(vv_run *run)
{
    vv_write_options options = run->options;
    vv_run_about *about = &run->about;
    vv_carry carry;
    const double start_s = vvi_os_seconds();
    options.written = &about->written;
    take_layers(&options, &run->layers);
    vv_status st = vv_carry_begin(&carry, &options, run->inputs[0].file, run->steps, run->n_steps, &about->result);
    if (st == VV_OK)
        st = vv_field_write(run->path, (const vv_field *const *)run->results, (size_t)run->n_results, &options,
                            run->job);
    vv_carry_finish(&carry);
    for (size_t i = 0; i < run->n_inputs && st == VV_OK; i++) /* a part of a streamed one, as a crop reads it */
        if (about->streamed && run->inputs[i].file && !run->inputs[i].field)
            vvi_file_tell_unproven(run->inputs[i].file, run->job);
    if (run->options.written)
        *run->options.written = about->written;
    about->write_s = vvi_os_seconds() - start_s;
    return st;
}

vv_status vv_run_write(vv_run *run)
{
    if (!run->path)
        return vv_fail(VV_E_ARGUMENT, "%s: there is no file to write the result to", run->name);
    if (run->written)
        return vv_fail(VV_E_ARGUMENT, "%s: is written already", run->name);
    const vv_status st = run->results || run->mesh ? VV_OK : vv_run_make(run);
    if (st != VV_OK)
        return st;
    run->written = true;
    return run->about.makes == VV_IS_MESH ? vvi_run_write_mesh(run) : write_fields(run);
}
