/* Runs carried out: each time step of the result asks for what it is made of, and that for what it is made of. */
#include "core/findings.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/os.h"
#include "grid/field.h"
#include "grid/store.h"
#include "io/file_stream.h"
#include "run/run_impl.h"
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* A time step under way: what there is of each node, which goes when no step needs it any more. */
typedef struct frame {
    vv_run *run;
    int64_t index;
    vv_data *node; /* VVI_RUN_INPUTS + n_steps */
    double read_s;
} frame;

static vv_status make_node(frame *f, int number);

static vv_status begin_frame(frame *out, vv_run *r, int64_t index)
{
    const size_t n = VVI_RUN_INPUTS + r->n_steps;
    *out = (frame){r, index, vvi_calloc(n, sizeof *out->node), 0};
    return out->node ? VV_OK : vv_fail_memory(n * sizeof *out->node);
}

static void end_frame(frame *f)
{
    for (size_t i = 0; f->node && i < VVI_RUN_INPUTS + f->run->n_steps; i++)
        vv_data_release(&f->node[i]);
    free(f->node);
}

/* A node alone, for what it is asked for beside the result. */
static vv_status make_alone(vv_data *out, vv_run *r, int number, int64_t index)
{
    frame f;
    vv_status st = begin_frame(&f, r, index);
    if (st == VV_OK && (st = make_node(&f, number)) == VV_OK) {
        *out = f.node[number];
        f.node[number] = (vv_data){0};
    }
    r->about.load_s += f.read_s;
    end_frame(&f);
    return st;
}

/* Reading --------------------------------------------------------------------------------------------------------- */

static vv_status refuse_samples(vv_field **out, void *user, const vv_box *box, vv_job *job)
{
    *out = NULL;
    return vv_fail(VV_E_UNSUPPORTED, "the samples of an input were asked for, of which only the grid is known");
}

vv_status vvi_run_grid(vv_field **out, const vv_field_info *info, vv_job *job)
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

static vv_status declare_labels(vv_field **field, const vv_run *r)
{
    vv_field_info info = *vv_field_get_info(*field);
    vv_field *same = NULL;
    const vv_meaning before = info.meaning;
    vvi_run_declare_label(&info, r);
    if (info.meaning == before)
        return VV_OK;
    const vv_status st = vvi_field_relabel(&same, *field, &info);
    if (st == VV_OK) {
        vv_field_release(*field);
        *field = same;
    }
    return st;
}

/* The time step of a file that goes with time step `index` of the result. */
static int64_t frame_of(const vv_run *r, const vv_run_input *in, int64_t index)
{
    if (in->frame >= 0)
        return in->frame;
    return vv_file_info(in->file)->n_frames == 1 ? 0 : r->chosen >= 0 ? r->chosen : index;
}

static vv_status read_file(vv_field **out, const vv_run *r, size_t input, int64_t index)
{
    const vv_run_input *in = &r->inputs[input];
    const bool layered = r->layers.n > 0;
    vv_file *file = layered ? r->layers.file[index] : in->file;
    const int64_t number = layered ? 0 : frame_of(r, in, index);
    return r->about.streamed ? vvi_stream_read(out, &r->stream, file, r->nodes[input].pool, number, r->job)
                             : vv_file_read(out, file, number, NULL, r->job);
}

static vv_status read_input(vv_data *out, const vv_run *r, size_t input, int64_t index)
{
    const vv_run_input *in = &r->inputs[input];
    vv_status st = VV_OK;
    if (in->mesh)
        out->mesh = vv_mesh_retain((vv_mesh *)(uintptr_t)in->mesh);
    else if (in->field)
        out->field = vv_field_retain((vv_field *)(uintptr_t)in->field);
    else
        st = read_file(&out->field, r, input, index);
    return st == VV_OK && input == 0 && out->field ? declare_labels(&out->field, r) : st;
}

/* Steps ----------------------------------------------------------------------------------------------------------- */

static vv_status take_operand(vv_data *out, frame *f, size_t s, size_t i)
{
    const int from = f->run->takes[s].from[i];
    if (from == VVI_RUN_GAP)
        return VV_OK;
    const vv_run_input *in = from < VVI_RUN_INPUTS ? &f->run->inputs[from] : NULL;
    if (vv_operation_operand(f->run->steps[s].operation, i)->grid_only && f->run->about.makes == VV_IS_FIELD &&
        !(in && in->field))
        return vvi_run_grid(&out->field, &f->run->nodes[from].info, f->run->job);
    const vv_status st = make_node(f, from);
    if (st != VV_OK)
        return st;
    out->field = f->node[from].field ? vv_field_retain(f->node[from].field) : NULL;
    out->mesh = f->node[from].mesh ? vv_mesh_retain(f->node[from].mesh) : NULL;
    return VV_OK;
}

/* What follows each other in the result: the one that has the time step. */
static vv_status take_joined(vv_data *out, const frame *f, size_t s)
{
    int64_t index = f->index;
    const size_t i = vvi_run_joined(f->run, s, &index);
    return make_alone(out, f->run, f->run->takes[s].from[i], index);
}

static vv_status open_only(vv_field **out, void *user, size_t index, vv_job *job)
{
    *out = vv_field_retain(user);
    return VV_OK;
}

/* Names and colours of labels come from whoever asks, else from the file. */
static void lend_looks(vv_run *r, const vv_step *step)
{
    const vv_run_input *in = &r->inputs[0];
    if (!step->operation->take_looks)
        return;
    if (in->file && !in->look)
        r->labels.label = vv_file_labels(in->file, &r->labels.n);
    step->operation->take_looks(step->params, in->look ? in->look : vvi_label_look_of_file,
                                in->look ? in->look_user : &r->labels);
}

static bool looks(const vv_step *step)
{
    return step->operation->settle && step->operation->looks && step->operation->looks(step->params);
}

/* What the samples decide is decided once, before the work: so it can be told. */
static vv_status settle_alone(vv_run *r, const vv_step *step, const vv_data *first)
{
    lend_looks(r, step);
    if (r->settled || r->stream.rehearses || r->n_results > 1 || !first->field || !looks(step))
        return VV_OK;
    const vv_field_series one = {open_only, first->field, 1};
    const vv_status st = vvi_field_prepare(first->field, r->job);
    return st == VV_OK ? step->operation->settle(step->params, &one, r->job) : st;
}

static vv_status run_streamed(vv_data *out, const frame *f, const vv_data *data, size_t n, size_t s)
{
    const vv_run *r = f->run;
    vv_field *fields[VVI_RUN_INPUTS];
    for (size_t i = 0; i < n; i++)
        fields[i] = data[i].field;
    return vvi_stream_step(&out->field, &r->stream, fields, n, &r->steps[s], s, f->index, r->job);
}

static vv_status run_on(vv_data *out, const frame *f, const vv_data *data, size_t n, size_t s)
{
    vv_run *r = f->run;
    const vv_step *step = &r->steps[s];
    vv_status st = settle_alone(r, step, &data[0]);
    if (st == VV_OK && r->check && s == 0)
        st = r->check(r->check_user, step, &data[0]);
    if (st != VV_OK)
        return st;
    return r->about.streamed ? run_streamed(out, f, data, n, s)
                             : vv_operation_make(out, step->operation, data, n, step->params, r->job);
}

static void drop_used(frame *f, size_t s)
{
    const vvi_run_takes *takes = &f->run->takes[s];
    for (size_t i = 0; i < takes->n; i++)
        if (takes->from[i] != VVI_RUN_GAP && f->run->nodes[takes->from[i]].last_use == s)
            vv_data_release(&f->node[takes->from[i]]);
}

static vv_status run_step(frame *f, size_t s)
{
    vv_data data[VVI_RUN_INPUTS] = {{0}};
    vv_run *r = f->run;
    const bool joins = r->steps[s].operation->joins;
    const size_t n = joins ? 1 : r->takes[s].n;
    vv_status st = joins ? take_joined(&data[0], f, s) : VV_OK;
    for (size_t i = 0; i < n && !joins && st == VV_OK; i++)
        st = take_operand(&data[i], f, s, i);
    drop_used(f, s);
    if (st == VV_OK)
        st = run_on(&f->node[VVI_RUN_INPUTS + s], f, data, n, s);
    for (size_t i = 0; i < n; i++)
        vv_data_release(&data[i]);
    return st;
}

static vv_status make_node(frame *f, int number)
{
    if (f->node[number].field || f->node[number].mesh)
        return VV_OK;
    if (number >= VVI_RUN_INPUTS)
        return run_step(f, (size_t)(number - VVI_RUN_INPUTS));
    const double start_s = vvi_os_seconds();
    const vv_status st = read_input(&f->node[number], f->run, (size_t)number, f->index);
    f->read_s += vvi_os_seconds() - start_s;
    return st;
}

/* Time steps ------------------------------------------------------------------------------------------------------ */

typedef struct before_step {
    vv_run *run;
    size_t step;
} before_step;

static vv_status open_before(vv_field **out, void *user, size_t index, vv_job *job)
{
    const before_step *b = user;
    vv_data data = {0};
    const vv_status st = make_alone(&data, b->run, b->run->takes[b->step].from[0], (int64_t)index);
    *out = data.field;
    return st == VV_OK ? vvi_field_prepare(data.field, job) : st;
}

/* Time steps share what their samples decide: else each would be stretched by itself. */
static vv_status settle_together(vv_run *r)
{
    vv_status st = VV_OK;
    for (size_t s = 0; s < r->n_steps && st == VV_OK; s++) {
        const vv_step *step = &r->steps[s];
        before_step before = {r, s};
        const vv_field_series frames = {open_before, &before, (size_t)r->n_results};
        if (r->n_results > 1 && r->takes[s].n > 0 && looks(step) && !r->stream.rehearses)
            st = step->operation->settle(step->params, &frames, r->job);
    }
    return st;
}

/* Whether steps go through samples more often than once, or in another order than they come by a pipe. */
static bool repeats(const vv_run *r, size_t input)
{
    const vvi_run_node *node = &r->nodes[input];
    bool again = r->about.streamed && (!r->format || r->format->labels_only || r->about.finds_type);
    for (size_t s = 0; s < r->n_steps; s++) {
        const vv_step *step = &r->steps[s];
        again = again || (r->about.streamed && (!step->operation->in_order || looks(step))) ||
                (r->n_results > 1 && looks(step));
    }
    return again || (r->about.streamed && node->n_uses > 1) || (r->n_results > 1 && node->n_frames == 1);
}

static vv_status allow_repeats(vv_run *r)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < r->n_inputs && st == VV_OK; i++)
        if (r->inputs[i].file && repeats(r, i))
            st = vvi_file_make_repeatable(r->inputs[i].file, r->job);
    return st;
}

/* The time of a series that only another input is. */
static vv_status declare_time(vv_field **field, const vv_run *r)
{
    vv_field_info info = *vv_field_get_info(*field);
    vv_field *same = NULL;
    if (info.n_frames >= r->about.info.n_frames)
        return VV_OK;
    info.n_frames = r->about.info.n_frames;
    info.frame_step = r->about.info.frame_step;
    memcpy(info.frame_unit, r->about.info.frame_unit, sizeof info.frame_unit);
    const vv_status st = vvi_field_relabel(&same, *field, &info);
    if (st == VV_OK) {
        vv_field_release(*field);
        *field = same;
    }
    return st;
}

static vv_status make_result(vv_data *out, vv_run *r, int64_t index)
{
    const double start_s = vvi_os_seconds(), loaded_s = r->about.load_s;
    vv_status st = make_alone(out, r, vvi_run_last(r), index);
    if (st == VV_OK && out->field && (st = declare_labels(&out->field, r)) == VV_OK)
        st = declare_time(&out->field, r);
    r->about.run_s += vvi_os_seconds() - start_s - (r->about.load_s - loaded_s);
    return st;
}

void vvi_run_note_first(int64_t n_frames, vv_job *job)
{
    if (n_frames > 1)
        vvi_find_note(job, "the mesh is of the first of %" PRId64 " time steps", n_frames);
}

vv_status vvi_run_make_all(vv_run *r)
{
    const vv_run_input *first = &r->inputs[0];
    vv_status st = VV_OK;
    if (r->about.makes == VV_IS_MESH && first->frame < 0 && first->file)
        vvi_run_note_first(vv_file_info(first->file)->n_frames, r->job);
    if (r->about.makes == VV_IS_FIELD &&
        ((st = vvi_memory_plan(r->job, r->about.bytes + r->about.working, r->name)) != VV_OK ||
         (r->about.streamed && (st = vvi_stream_reserve(&r->stream, r->ways, r->name, r->job)) != VV_OK) ||
         (st = allow_repeats(r)) != VV_OK || (st = settle_together(r)) != VV_OK))
        return st;
    r->results = vvi_calloc((size_t)r->n_results, sizeof *r->results);
    if (!r->results)
        return vv_fail_memory((size_t)r->n_results * sizeof *r->results);
    for (int64_t f = 0; f < r->n_results && st == VV_OK; f++)
        st = make_result(&r->results[f], r, f);
    for (int64_t f = 0; f < r->n_results && st != VV_OK; f++)
        vv_data_release(&r->results[f]);
    if (st != VV_OK) {
        free(r->results);
        r->results = NULL;
    } else if (r->about.makes == VV_IS_FIELD)
        r->about.result = *vv_field_get_info(r->results[0].field);
    return st;
}
