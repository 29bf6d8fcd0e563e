/* Operations that are switched off: their first input stands for what they would make. */
#include "core/property_impl.h"
#include "model/dataset.h"
#include "run/made.h"
#include <stdio.h>

static const char *word_of(bool mesh)
{
    return mesh ? "a mesh" : "a volume";
}

static vv_status fail_off(const vvi_made *made, const char *why)
{
    char where[VVI_ID_MOST + 16];
    snprintf(where, sizeof where, "datasets.%s.on", made->id);
    return vv_fail_at(VV_E_ARGUMENT, NULL, where, "%s cannot be switched off: %s", made->operation->name, why);
}

/* What it would make is of the kind of its first input, else nothing that works on it could go on. */
static vv_status check_kind(const vvi_made *made, vv_job *job)
{
    char why[128];
    if (made->n == 0 || !made->input[0])
        return fail_off(made, "it has no first input, which would stand for what it makes");
    const bool makes = vv_operation_makes(made->operation) == VV_IS_MESH,
               takes = vv_dataset_is_mesh(made->input[0], job);
    if (makes == takes)
        return VV_OK;
    snprintf(why, sizeof why, "it makes %s, and '%.63s' is %s", word_of(makes), made->input_id[0], word_of(takes));
    return fail_off(made, why);
}

static vv_status fail_ring(const vvi_made *made)
{
    char where[VVI_ID_MOST + 16];
    snprintf(where, sizeof where, "datasets.%s.inputs", made->id);
    return vv_fail_at(VV_E_ARGUMENT, NULL, where,
                      "it is made of itself, or of more than %d operations that are switched off", VVI_MADE_DEEPEST);
}

vv_status vvi_made_behind(const vv_dataset **dataset, const char **id, const vv_world *world, vv_job *job)
{
    vv_status st = VV_OK;
    for (int n = 0; vv_dataset_is_made(*dataset) && !(*dataset)->on && st == VV_OK; n++) {
        vvi_made made;
        st = vvi_made_open_as_is(&made, world, *dataset, job);
        if (st == VV_OK && n == VVI_MADE_DEEPEST)
            st = fail_ring(&made);
        if (st == VV_OK && (st = check_kind(&made, job)) == VV_OK) {
            *dataset = made.input[0];
            *id = made.input_id[0];
        }
        vvi_made_close(&made);
    }
    return st;
}
