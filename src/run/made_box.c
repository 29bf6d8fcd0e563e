/* Made samples of one box alone, for whoever looks at a part before all of it is made. */
#include "filter/operation.h"
#include "run/made.h"
#include <volvis/sys/registry.h>

bool vvi_made_is_local(const vvi_made *made, const vv_object *params)
{
    const vv_operation *o = made->operation;
    return o->run_box && !o->joins && vv_operation_makes(o) == VV_IS_FIELD && !(o->looks && o->looks(params));
}

vv_status vvi_made_box(vv_field **out, const vvi_made *made, const vvi_made_run *run, const vv_box *box, vv_job *job)
{
    const vv_field *inputs[VVI_RUN_INPUTS] = {NULL};
    const vv_step *step = &run->step[0];
    const vvi_run_takes *takes = &run->takes[0];
    *out = NULL;
    if (!vvi_made_is_local(made, step->params))
        return vv_fail(VV_E_UNSUPPORTED, "datasets.%s: %s makes all of its samples at once", made->id,
                       step->operation->name);
    for (size_t i = 0; i < takes->n; i++)
        inputs[i] = takes->from[i] == VVI_RUN_GAP ? NULL : run->input[takes->from[i]].field;
    const vv_status st = step->operation->run_box(out, inputs, takes->n, step->params, box, job);
    return vvi_made_fail(made, NULL, vvi_operation_check(out, inputs, takes->n, st));
}
