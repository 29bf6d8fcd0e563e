/* Operations that are switched off: their first input stands for what they would make. */
#include "core/property_impl.h"
#include "model/dataset.h"
#include "run/made.h"
#include <stdio.h>
#include <string.h>

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

static vv_status fail_many(const vvi_made *made)
{
    char where[VVI_ID_MOST + 16];
    snprintf(where, sizeof where, "datasets.%s.inputs", made->id);
    return vv_fail_at(VV_E_LIMIT, NULL, where, "it is made of more than %d operations that are switched off",
                      VVI_MADE_DEEPEST);
}

/* before: n datasets that are switched off, each made of the next, the last one of this. */
static vv_status check_way(const vvi_made *made, const char *const *before, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (!strcmp(before[i], made->id))
            return vvi_made_fail_ring(made, before + i, n - i);
    return n == VVI_MADE_DEEPEST ? fail_many(made) : VV_OK;
}

vv_status vvi_made_behind(const vv_dataset **dataset, const char **id, const vv_world *world, vv_job *job)
{
    const char *way[VVI_MADE_DEEPEST];
    vv_status st = VV_OK;
    for (size_t n = 0; vv_dataset_is_made(*dataset) && !(*dataset)->on && st == VV_OK; n++) {
        vvi_made made;
        st = vvi_made_open_as_is(&made, world, *dataset, job);
        if (st == VV_OK && (st = check_way(&made, way, n)) == VV_OK && (st = check_kind(&made, job)) == VV_OK) {
            way[n] = made.id;
            *dataset = made.input[0];
            *id = made.input_id[0];
        }
        vvi_made_close(&made);
    }
    return st;
}
