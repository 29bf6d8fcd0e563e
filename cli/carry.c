#include "carry.h"
#include "filter/channel.h"
#include "registry.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* Operations that move samples, or write the same values in another type. */
static bool keeps_values(const cli_step *step)
{
    static const vv_operation *const keeping[] = {&vvi_operation_channel,
                                                  &vvi_operation_crop,
                                                  &vvi_operation_flip,
                                                  &vvi_operation_gaussian,
                                                  &vvi_operation_reorient,
                                                  &vvi_operation_resample,
                                                  NULL};
    for (const vv_operation *const *row = keeping; *row; row++)
        if (step->operation == *row)
            return true;
    return step->labels_as_numbers;
}

static vv_status pick(cli_carry *carry, const vv_object *params)
{
    int picks[VVI_CHANNELS_MOST], n;
    vv_status st = vvi_channel_picks(picks, &n, params, (int)carry->n_channels);
    if (st != VV_OK)
        return st;
    vv_channel *picked = malloc((size_t)n * sizeof *picked);
    if (!picked)
        return vv_fail_memory((size_t)n * sizeof *picked);
    for (int c = 0; c < n; c++)
        picked[c] = carry->channels[picks[c]];
    free(carry->channels);
    carry->channels = picked;
    carry->n_channels = (size_t)n;
    return VV_OK;
}

static vv_status carry_channels(cli_carry *carry, const vv_channel *channels, size_t n, const cli_step *steps,
                                size_t n_steps)
{
    vv_status st = VV_OK;
    carry->channels = malloc(n * sizeof *channels);
    if (!carry->channels)
        return vv_fail_memory(n * sizeof *channels);
    memcpy(carry->channels, channels, n * sizeof *channels);
    carry->n_channels = n;
    for (size_t s = 0; s < n_steps && st == VV_OK; s++) {
        if (steps[s].operation == &vvi_operation_channel)
            st = pick(carry, steps[s].params);
        for (size_t c = 0; c < carry->n_channels && !keeps_values(&steps[s]); c++)
            carry->channels[c].lo = carry->channels[c].hi = 0; /* a window of other values */
    }
    return st;
}

vv_status cli_carry_begin(cli_carry *carry, vv_write_options *options, const cli_input *input, const cli_step *steps,
                          size_t n_steps, const vv_field_info *result)
{
    size_t n;
    vv_status st = VV_OK;
    *carry = (cli_carry){0};
    options->origin = input->file;
    for (size_t s = 0; s < n_steps; s++)
        options->new_values |= !keeps_values(&steps[s]);
    const vv_channel *channels = vv_file_channels(input->file, &n);
    if (n > 0 && n == (size_t)vv_file_info(input->file)->components)
        st = carry_channels(carry, channels, n, steps, n_steps);
    if (st == VV_OK && carry->n_channels == (size_t)result->components) {
        options->channels = carry->channels;
        options->n_channels = carry->n_channels;
    }
    if (result->meaning == VV_MEANING_LABEL)
        options->labels = vv_file_labels(input->file, &options->n_labels);
    return st;
}

void cli_carry_finish(cli_carry *carry)
{
    free(carry->channels);
    *carry = (cli_carry){0};
}

static vv_status fail_name(const cli_input *input, const char *word, size_t length, const vv_channel *channels,
                           size_t n)
{
    enum { MOST = 64 };
    char typed[64];
    const char *names[MOST];
    size_t n_names = 0;
    for (size_t c = 0; c < n && n_names < MOST; c++)
        if (channels[c].name[0])
            names[n_names++] = channels[c].name;
    snprintf(typed, sizeof typed, "%.*s", (int)(length < 60 ? length : 60), word);
    const char *near = vv_nearest_name(typed, names, n_names);
    return vv_fail_at(VV_E_ARGUMENT, input->path, NULL,
                      "there is no channel '%s'; they are numbered 0 to %d%s%s%s ('volvis info' lists them)", typed,
                      vv_file_info(input->file)->components - 1, near ? "; did you mean '" : "", near ? near : "",
                      near ? "'?" : "");
}

vv_status cli_carry_find(int *out, const cli_input *input, const char *word, size_t length)
{
    size_t n;
    const vv_channel *channels = vv_file_channels(input->file, &n);
    const int components = vv_file_info(input->file)->components;
    for (size_t c = 0; c < n && c < (size_t)components; c++) {
        *out = (int)c;
        if (strlen(channels[c].name) == length && strncasecmp(channels[c].name, word, length) == 0)
            return VV_OK;
    }
    const bool number = length > 0 && length < 10 && strspn(word, "0123456789") >= length;
    *out = number ? (int)strtol(word, NULL, 10) : components;
    return *out < components ? VV_OK : fail_name(input, word, length, channels, n);
}
