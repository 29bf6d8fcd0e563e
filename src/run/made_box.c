/* Made samples of one box alone, for whoever looks at a part before all of it is made. */
#include "filter/operation.h"
#include "run/made.h"
#include <volvis/sys/registry.h>

/* Rows that work slice by slice look at values alone, which is quick, and that is kept: those of one time step. */
bool vvi_made_is_local(const vvi_made *made, const vv_object *params, int64_t n_frames)
{
    const vv_operation *o = made->operation;
    const bool looks = o->looks && o->looks(params);
    return o->run_box && !o->joins && vv_operation_makes(o) == VV_IS_FIELD && (!looks || (o->in_order && n_frames < 2));
}

vv_status vvi_made_box(vv_field **out, const vvi_made *made, const vvi_made_run *run, const vv_box *box, vv_job *job)
{
    const vv_field *inputs[VVI_RUN_INPUTS] = {NULL};
    const vv_step *step = &run->step[0];
    const vvi_run_takes *takes = &run->takes[0];
    *out = NULL;
    if (!vvi_made_is_local(made, step->params, 1))
        return vv_fail(VV_E_UNSUPPORTED, "datasets.%s: %s makes all of its samples at once", made->id,
                       step->operation->name);
    for (size_t i = 0; i < takes->n; i++)
        inputs[i] = takes->from[i] == VVI_RUN_GAP ? NULL : run->input[takes->from[i]].field;
    const vv_status st = step->operation->run_box(out, inputs, takes->n, step->params, box, job);
    return vvi_made_fail(made, NULL, vvi_operation_check(out, inputs, takes->n, st));
}
