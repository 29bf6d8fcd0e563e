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

vv_status vvi_made_fields_open(vvi_made_fields *out, const vvi_made *made, int64_t frame, vv_job *job)
{
    vv_status st = VV_OK;
    *out = (vvi_made_fields){.n = made->n};
    for (size_t i = 0; i < made->n && st == VV_OK; i++) {
        int64_t of_input;
        if (made->input[i] && (st = vvi_made_frame(&of_input, made, i, frame, job)) == VV_OK)
            st = vv_dataset_field(&out->field[i], made->world, made->input[i], NULL, of_input, job);
    }
    return vvi_made_fail(made, NULL, st);
}

void vvi_made_fields_close(vvi_made_fields *fields)
{
    for (size_t i = 0; i < fields->n; i++)
        vv_field_release(fields->field[i]);
    *fields = (vvi_made_fields){.n = 0};
}

vv_status vvi_made_box(vv_field **out, const vvi_made *made, const vvi_made_fields *fields, const vv_object *params,
                       const vv_box *box, vv_job *job)
{
    const vv_field *const *inputs = (const vv_field *const *)fields->field;
    const vv_operation *o = made->operation;
    *out = NULL;
    if (!vvi_made_is_local(made, params, 1))
        return vv_fail(VV_E_UNSUPPORTED, "datasets.%s: %s makes all of its samples at once", made->id, o->name);
    const vv_status st = o->run_box(out, inputs, fields->n, params, box, job);
    return vvi_made_fail(made, NULL, vvi_operation_check(out, inputs, fields->n, st));
}
