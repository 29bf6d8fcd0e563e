/* How long a run will take: its steps on a part of the samples, and from there by their number. */
#include "core/job.h"
#include "grid/field_copy.h"
#include "run/run_impl.h"
#include <math.h>
#include <string.h>

/* Along each axis, in the middle: large enough for caches and threads to matter, done in some tenths of a second. Where
 * that was quick the larger part is tried: work hangs on what is in the middle, and does not always grow with samples.
 */
enum { PROBE_SIDE = 64, PROBE_SIDE_MOST = 128 };
#define PROBE_QUICK 0.2 /* seconds */

static const vv_field_info *info_of(const vv_run_input *in)
{
    return in->field ? vv_field_get_info(in->field) : in->file ? vv_file_info(in->file) : NULL;
}

static double samples_of(const int64_t n[3])
{
    return (double)n[0] * (double)n[1] * (double)n[2];
}

static vv_box middle_of(const int64_t dims[3], int64_t side)
{
    vv_box box;
    for (int a = 0; a < 3; a++) {
        box.n[a] = dims[a] < side ? dims[a] : side;
        box.lo[a] = (dims[a] - box.n[a]) / 2;
    }
    return box;
}

/* Inputs on the first one's grid are cut as it is; others stay as they are. *in has a field of its own then. */
static vv_status cut(vv_run_input *in, const int64_t dims[3], int64_t side, vv_job *job)
{
    const vv_box box = middle_of(dims, side);
    const vv_field_info *info = info_of(in);
    vv_field *part = NULL;
    vv_status st = VV_OK;
    if (!info || memcmp(info->grid.dims, dims, sizeof info->grid.dims) != 0)
        return VV_OK;
    st = in->field ? vvi_field_copy_box(&part, in->field, &box, job)
                   : vv_file_read(&part, in->file, in->frame > 0 ? in->frame : 0, &box, job);
    *in = (vv_run_input){.field = part, .name = in->name};
    return st;
}

static vv_status run_part(double *seconds, const vvi_run_plan *plan, vv_job *job)
{
    vv_run *run = NULL;
    vv_status st = vvi_run_new(&run, plan, &(vv_run_output){.path = NULL}, job);
    if (st == VV_OK && (st = vv_run_make(run)) == VV_OK)
        *seconds = vv_run_get_about(run)->run_s;
    vv_run_release(run);
    vv_job_forget_findings(job);
    return st;
}

/* Seconds that the middle takes. */
static vv_status run_middle(double *seconds, const vvi_run_plan *plan, const int64_t dims[3], int64_t side, vv_job *job)
{
    vv_run_input parts[VVI_RUN_INPUTS];
    vvi_run_plan part = *plan;
    vv_status st = VV_OK;
    size_t n = 0;
    memcpy(parts, plan->inputs, plan->n_inputs * sizeof *parts);
    part.inputs = parts;
    for (; n < plan->n_inputs && st == VV_OK; n++)
        st = cut(&parts[n], dims, side, job);
    if (st == VV_OK)
        st = run_part(seconds, &part, job);
    for (size_t i = 0; i < n; i++)
        if (parts[i].field != plan->inputs[i].field)
            vv_field_release((vv_field *)(uintptr_t)parts[i].field);
    return st;
}

double vvi_run_seconds(const vvi_run_plan *plan, vv_job *job)
{
    const vv_field_info *first = plan->n_steps && plan->n_inputs ? info_of(&plan->inputs[0]) : NULL;
    double all = NAN;
    if (!first)
        return NAN;
    int64_t dims[3];
    memcpy(dims, first->grid.dims, sizeof dims);
    vvi_job_hush(job, 1);
    for (int64_t side = PROBE_SIDE; side <= PROBE_SIDE_MOST; side *= 2) {
        const vv_box box = middle_of(dims, side);
        double seconds = 0;
        if (run_middle(&seconds, plan, dims, side, job) != VV_OK)
            continue; /* a part may be refused, or memory lack */
        all = seconds * samples_of(dims) / samples_of(box.n);
        if (seconds > PROBE_QUICK || memcmp(box.n, dims, sizeof dims) == 0)
            break;
    }
    vvi_job_hush(job, -1);
    return all;
}
