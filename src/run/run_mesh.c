/* Runs whose last step makes a mesh: of one time step, whole in memory. */
#include "core/findings.h"
#include "core/job.h"
#include "core/os.h"
#include "run/run_impl.h"
#include <inttypes.h>
#include <stdlib.h>

vv_status vvi_run_plan_mesh(vv_run *r)
{
    vv_status st = VV_OK;
    r->about.makes = VV_IS_MESH;
    r->about.n_frames = 1;
    for (size_t i = 0; i < r->n_inputs && st == VV_OK; i++) {
        uint64_t bytes = 0;
        const vv_run_input *in = &r->inputs[i];
        if (in->field || !in->file || vv_file_mappable(in->file))
            continue;
        st = vv_field_info_bytes(&bytes, vv_file_info(in->file));
        r->about.bytes += bytes;
    }
    return st;
}

static vv_status read_inputs(vv_data *out, const vv_run *r)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < r->n_inputs && st == VV_OK; i++) {
        const vv_run_input *in = &r->inputs[i];
        if (in->mesh)
            out[i].mesh = vv_mesh_retain((vv_mesh *)(uintptr_t)in->mesh);
        else if (in->field)
            out[i].field = vv_field_retain((vv_field *)(uintptr_t)in->field);
        else if (in->file)
            st = vv_file_read(&out[i].field, in->file, in->frame < 0 ? 0 : in->frame, NULL, r->job);
    }
    if (st == VV_OK && r->inputs[0].frame < 0 && r->inputs[0].file)
        vvi_run_note_first(vv_file_info(r->inputs[0].file)->n_frames, r->job);
    return st;
}

void vvi_run_note_first(int64_t n_frames, vv_job *job)
{
    if (n_frames > 1)
        vvi_find_note(job, "the mesh is of the first of %" PRId64 " time steps", n_frames);
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

/* What the samples decide is decided before the work: so it can be told. */
static vv_status settle(vv_run *r, const vv_step *step, const vv_data *first)
{
    const vv_operation *o = step->operation;
    lend_looks(r, step);
    if (!first->field || !o->settle || !o->looks(step->params))
        return VV_OK;
    const vv_field_series one = {open_only, first->field, 1};
    return o->settle(step->params, &one, r->job);
}

static vv_status run_step(vv_data *data, size_t n, vv_run *r, size_t index)
{
    const vv_step *step = &r->steps[index];
    vv_data made = {0};
    vv_status st = settle(r, step, &data[0]);
    if (st == VV_OK && r->check && index == 0)
        st = r->check(r->check_user, step, &data[0]);
    if (st == VV_OK)
        st = vv_operation_make(&made, step->operation, data, n, step->params, r->job);
    if (st != VV_OK)
        return st;
    vv_data_release(&data[0]);
    data[0] = made;
    return VV_OK;
}

vv_status vvi_run_make_mesh(vv_run *r)
{
    vv_data data[VVI_RUN_INPUTS] = {{0}};
    const double start_s = vvi_os_seconds();
    vv_status st = read_inputs(data, r);
    const double read_s = vvi_os_seconds();
    for (size_t s = 0; s < r->n_steps && st == VV_OK; s++)
        st = run_step(data, s ? 1 : r->n_inputs, r, s);
    r->about.load_s = read_s - start_s;
    r->about.run_s = vvi_os_seconds() - read_s;
    if (st == VV_OK) {
        r->mesh = data[0].mesh;
        data[0].mesh = NULL;
    }
    for (size_t i = 0; i < r->n_inputs; i++)
        vv_data_release(&data[i]);
    return st;
}

vv_status vvi_run_write_mesh(vv_run *r)
{
    const double start_s = vvi_os_seconds();
    const vv_status st = vv_mesh_write(r->path, r->mesh, r->mesh_options, r->job);
    r->about.write_s = vvi_os_seconds() - start_s;
    return st;
}
