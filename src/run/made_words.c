/* What a file says of its data, carried through the operations that others were made of them by. */
#include "core/status.h"
#include "model/dataset.h"
#include "run/made.h"
#include "scene/load.h"

/* Steps from the file that it all began with, the last one first; *from is that file's dataset. */
static vv_status collect(vvi_words *out, vv_step steps[VVI_MADE_DEEPEST], const vv_dataset **from,
                         const vv_world *world, vv_job *job)
{
    const char *id = "";
    vv_status st = vvi_made_behind(from, &id, world, job);
    while (*from && vv_dataset_is_made(*from) && st == VV_OK) {
        vvi_made made;
        if (out->n == VVI_MADE_DEEPEST)
            return vv_fail(VV_E_LIMIT, "made by more than %d operations one after the other", VVI_MADE_DEEPEST);
        if ((st = vvi_made_open(&made, world, *from, job)) == VV_OK)
            st = vvi_made_params(&out->params[out->n], &made, job);
        if (st == VV_OK)
            steps[out->n] = (vv_step){made.operation, out->params[out->n]};
        out->n += st == VV_OK;
        *from = made.n > 0 ? made.input[0] : NULL;
        vvi_made_close(&made);
    }
    return st;
}

vv_status vvi_words_open(vvi_words *out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    vv_step last_first[VVI_MADE_DEEPEST], steps[VVI_MADE_DEEPEST];
    vv_field_info info;
    const vv_dataset *from = dataset;
    *out = (vvi_words){.n = 0};
    vv_write_options_init(&out->options, sizeof out->options);
    vv_status st = vv_dataset_info(&info, world, dataset, job);
    if (st == VV_OK)
        st = collect(out, last_first, &from, world, job);
    if (st != VV_OK || !from || !from->path || from->fields || vv_dataset_is_mesh(from, job))
        return st;
    for (size_t i = 0; i < out->n; i++)
        steps[i] = last_first[out->n - 1 - i];
    if ((st = vvi_dataset_open(&out->file, NULL, from, job)) == VV_OK)
        st = vv_carry_begin(&out->carry, &out->options, out->file, steps, out->n, &info);
    return st;
}

void vvi_words_close(vvi_words *words)
{
    vv_carry_finish(&words->carry);
    vv_file_close(words->file);
    for (size_t i = 0; i < words->n; i++)
        vv_object_release(words->params[i]);
    *words = (vvi_words){.n = 0};
}
