/* Steps on files: planned (run_plan.c), run for every time step (run_make.c), written. */
#include "core/job.h"
#include "core/memory.h"
#include "core/os.h"
#include "io/file_stream.h"
#include "run/run_impl.h"
#include <stdlib.h>
#include <string.h>

/* All inputs go into the first step, and what each makes into the next. */
static void chain_steps(vv_run *r)
{
    for (size_t i = 0; i < r->n_inputs && r->n_steps > 0; i++) {
        const vv_run_input *in = &r->inputs[i];
        r->takes[0].from[i] = in->file || in->field || in->mesh ? (int)i : VVI_RUN_GAP;
    }
    for (size_t s = 0; s < r->n_steps; s++) {
        r->takes[s].n = s ? 1 : r->n_inputs;
        if (s)
            r->takes[s].from[0] = VVI_RUN_INPUTS + (int)s - 1;
    }
}

static vv_status copy_plan(vv_run *r, const vvi_run_plan *plan)
{
    const size_t n = plan->n_steps;
    r->steps = vvi_calloc(n + 1, sizeof *r->steps);
    r->takes = vvi_calloc(n + 1, sizeof *r->takes);
    r->nodes = vvi_calloc(VVI_RUN_INPUTS + n, sizeof *r->nodes);
    r->ways = vvi_calloc(n + 1, sizeof *r->ways);
    if (!r->steps || !r->takes || !r->nodes || !r->ways)
        return vv_fail_memory((VVI_RUN_INPUTS + n) * sizeof *r->nodes);
    if (plan->n_inputs > 0)
        memcpy(r->inputs, plan->inputs, plan->n_inputs * sizeof *plan->inputs);
    if (n > 0)
        memcpy(r->steps, plan->steps, n * sizeof *plan->steps);
    if (plan->takes && n > 0)
        memcpy(r->takes, plan->takes, n * sizeof *plan->takes);
    else
        chain_steps(r);
    for (size_t s = 0; s < n; s++)
        if (r->takes[s].n == 0)
            r->takes[s].from[0] = VVI_RUN_GAP;
    return VV_OK;
}

/* Of an operation that takes nothing there is a run without inputs. */
static vv_status check_count(const vvi_run_plan *plan)
{
    const bool none = plan->n_steps > 0 && vv_operation_most(plan->steps[0].operation) == 0;
    if (plan->n_inputs > VVI_RUN_INPUTS || (plan->n_inputs < 1 && !none))
        return vv_fail(VV_E_ARGUMENT, "%s: takes 1 to %d inputs, there are %zu", plan->name, VVI_RUN_INPUTS,
                       plan->n_inputs);
    if (none && !plan->takes && plan->n_inputs > 0)
        return vv_fail(VV_E_ARGUMENT, "%s: takes no inputs, and there are %zu", plan->steps[0].operation->name,
                       plan->n_inputs);
    return VV_OK;
}

vv_status vvi_run_new(vv_run **out, const vvi_run_plan *plan, const vv_run_output *output, vv_job *job)
{
    *out = NULL;
    vv_status st = check_count(plan);
    if (st != VV_OK)
        return st;
    vv_run *r = vvi_calloc(1, sizeof *r);
    if (!r)
        return vv_fail_memory(sizeof *r);
    *r = (vv_run){.n_inputs = plan->n_inputs,
                  .n_steps = plan->n_steps,
                  .name = plan->name,
                  .job = job,
                  .path = output->path,
                  .settled = plan->settled,
                  .mesh_options = output->mesh_options,
                  .check = output->check,
                  .check_user = output->check_user};
    st = copy_plan(r, plan);
    if (st == VV_OK && (st = vvi_run_plan_all(r, output)) == VV_OK) {
        *out = r;
        return VV_OK;
    }
    vv_run_release(r);
    return st;
}

vv_status vv_run_new(vv_run **out, const vv_run_input *inputs, size_t n_inputs, const vv_step *steps, size_t n_steps,
                     const vv_run_output *output, const char *name, vv_job *job)
{
    const vvi_run_plan plan = {
        .inputs = inputs, .n_inputs = n_inputs, .steps = steps, .n_steps = n_steps, .name = name};
    return vvi_run_new(out, &plan, output, job);
}

void vv_run_release(vv_run *run)
{
    if (!run)
        return;
    for (int64_t f = 0; run->results && f < run->n_results; f++)
        vv_data_release(&run->results[f]);
    free(run->results);
    vvi_stream_free(&run->stream);
    vvi_layers_close(&run->layers);
    free(run->steps);
    free(run->takes);
    free(run->nodes);
    free(run->ways);
    free(run);
}

const vv_run_about *vv_run_get_about(const vv_run *run)
{
    return &run->about;
}

vv_status vv_run_make(vv_run *run)
{
    if (run->results)
        return vv_fail(VV_E_ARGUMENT, "%s: has run already", run->name);
    vv_job_forget_findings(run->job);
    return vvi_run_make(run);
}

const vv_mesh *vv_run_mesh(const vv_run *run)
{
    return run->results ? run->results[0].mesh : NULL;
}

const vv_field *vv_run_field(const vv_run *run, int64_t index)
{
    return run->results && index >= 0 && index < run->n_results ? run->results[index].field : NULL;
}

/* Writing --------------------------------------------------------------------------------------------------------- */

static void take_layers(vv_write_options *options, const vvi_layers *layers)
{
    options->layers = layers->n > 0;
    if (layers->n > 0 && !options->labels) {
        options->labels = layers->labels;
        options->n_labels = layers->n_labels;
    }
}

/* The input that the result leads back to, each step on its first operand. NULL: one that takes nothing began it. */
static vv_file *main_file(const vv_run *run)
{
    int node = vvi_run_last(run);
    while (node >= VVI_RUN_INPUTS)
        node = run->takes[node - VVI_RUN_INPUTS].from[0];
    return node == VVI_RUN_GAP ? NULL : run->inputs[0].file;
}

/* The steps that lead from the first input to the result, each on its first operand: what a file says goes with them.
 */
static size_t main_steps(vv_step *out, const vv_run *run)
{
    size_t n = 0, at = 0;
    for (int node = vvi_run_last(run); node >= VVI_RUN_INPUTS; node = run->takes[node - VVI_RUN_INPUTS].from[0])
        n++;
    at = n;
    for (int node = vvi_run_last(run); node >= VVI_RUN_INPUTS; node = run->takes[node - VVI_RUN_INPUTS].from[0])
        out[--at] = run->steps[node - VVI_RUN_INPUTS];
    return n;
}

static vv_status write_frames(vv_run *run, vv_write_options *options, vv_step *steps, const vv_field **fields)
{
    vv_carry carry;
    for (int64_t f = 0; f < run->n_results; f++)
        fields[f] = run->results[f].field;
    take_layers(options, &run->layers);
    vv_status st = vv_carry_begin(&carry, options, main_file(run), steps, main_steps(steps, run), &run->about.result);
    if (st == VV_OK)
        st = vv_field_write(run->path, fields, (size_t)run->n_results, options, run->job);
    vv_carry_finish(&carry);
    return st;
}

static vv_status write_fields(vv_run *run)
{
    vv_write_options options = run->options;
    vv_run_about *about = &run->about;
    const vv_field **fields = vvi_calloc((size_t)run->n_results, sizeof(vv_field *));
    vv_step *steps = vvi_calloc(run->n_steps + 1, sizeof *steps);
    options.written = &about->written;
    vv_status st = fields && steps ? write_frames(run, &options, steps, fields)
                                   : vv_fail_memory((size_t)run->n_results * sizeof(vv_field *));
    free(fields);
    free(steps);
    for (size_t i = 0; i < run->n_inputs && st == VV_OK; i++) /* a part of a streamed one, as a crop reads it */
        if (about->streamed && run->inputs[i].file && !run->inputs[i].field)
            vvi_file_tell_unproven(run->inputs[i].file, run->job);
    if (run->options.written)
        *run->options.written = about->written;
    return st;
}

vv_status vv_run_write(vv_run *run)
{
    if (!run->path)
        return vv_fail(VV_E_ARGUMENT, "%s: there is no file to write the result to", run->name);
    if (run->written)
        return vv_fail(VV_E_ARGUMENT, "%s: is written already", run->name);
    vv_status st = run->results ? VV_OK : vv_run_make(run);
    if (st != VV_OK)
        return st;
    run->written = true;
    const double start_s = vvi_os_seconds();
    st = run->about.makes == VV_IS_MESH ? vv_mesh_write(run->path, run->results[0].mesh, run->mesh_options, run->job)
                                        : write_fields(run);
    run->about.write_s = vvi_os_seconds() - start_s;
    return st;
}
