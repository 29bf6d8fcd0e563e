/* What a file says of its samples, carried through operations into what is written. */
#include "core/memory.h"
#include "core/status.h"
#include "io/data_file.h"
#include <stdlib.h>
#include <string.h>
#include <volvis/sys/registry.h>

static vv_status take_channels(vv_carry *carry, const vv_file *origin)
{
    size_t n;
    const vv_channel *channels = vv_file_channels(origin, &n);
    if (n == 0 || n != (size_t)vv_file_info(origin)->components)
        return VV_OK;
    carry->channels = vvi_calloc(n, sizeof *channels);
    if (!carry->channels)
        return vv_fail_memory(n * sizeof *channels);
    memcpy(carry->channels, channels, n * sizeof *channels);
    carry->n_channels = n;
    return VV_OK;
}

static vv_status take_step(vv_carry *carry, const vv_step *step)
{
    if (step->operation->carry)
        return step->operation->carry(carry, step->params);
    carry->new_values = true;
    return VV_OK;
}

vv_status vv_carry_begin(vv_carry *out, vv_write_options *options, const vv_file *origin, const vv_step *steps,
                         size_t n_steps, const vv_field_info *result)
{
    *out = (vv_carry){0};
    if (!origin)
        return VV_OK;
    vv_status st = take_channels(out, origin);
    for (size_t s = 0; s < n_steps && st == VV_OK; s++)
        st = take_step(out, &steps[s]);
    if (st != VV_OK)
        return st;
    bool new_before = false;
    options->origin = vvi_file_origin(origin, &new_before);
    out->new_values |= new_before;
    for (size_t c = 0; c < out->n_channels && out->new_values; c++)
        out->channels[c].lo = out->channels[c].hi = 0; /* a window of other values */
    options->new_values = out->new_values;
    if (!options->channels && out->channels && out->n_channels == (size_t)result->components) {
        options->channels = out->channels;
        options->n_channels = out->n_channels;
    }
    if (!options->labels && result->meaning == VV_MEANING_LABEL && !out->new_values)
        options->labels = vv_file_labels(origin, &options->n_labels);
    return VV_OK;
}

void vv_carry_finish(vv_carry *carry)
{
    free(carry->channels);
    *carry = (vv_carry){0};
}
