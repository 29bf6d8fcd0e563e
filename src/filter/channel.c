/* Channel: some components of every sample, in any order. */
#include "core/memory.h"
#include "core/status.h"
#include "grid/field.h"
#include "grid/making.h"
#include "registry.h"

#include <stdlib.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 18)
#define PICKS_MOST 64 /* at once */

typedef struct channel_params {
    vv_object object;
    char *components;
} channel_params;

static const vv_property properties[] = {
    {VV_PROP(channel_params, components), .kind = VV_KIND_STRING, .option = "channel", .def_text = "\"0\"",
     .doc =
         "numbers of the channels to keep, counted from 0, in the order of the result: 1 or 2,0; on the command line "
         "names too: nuclei, or green of a colour"},
    {0},
};

static const vv_class channel_class = {
    .name = "channel",
    .doc = "parameters of channel",
    .size = sizeof(channel_params),
    .properties = properties,
};

static vv_status fail_number(const char *at, size_t n, int components)
{
    if (components == 1)
        return vv_fail(VV_E_ARGUMENT, "channel: '%.*s' is not the channel that there is, which is 0", (int)n, at);
    return vv_fail(VV_E_ARGUMENT, "channel: '%.*s' is not one of the channels, which are 0 to %d; write 1 or 2,0",
                   (int)n, at, components - 1);
}

/* Numbers of the components that the parameters pick from so many, in their order. */
static vv_status find_picks(int picks[PICKS_MOST], int *n_out, const vv_object *params, int components)
{
    const char *at = ((const channel_params *)(const void *)params)->components;
    int n = 0;
    *n_out = 0;
    for (at = at ? at : "";; at++) {
        const size_t length = strcspn(at, ","), digits = strspn(at, "0123456789");
        const long number = digits > 0 && digits < 10 ? strtol(at, NULL, 10) : components;
        if (digits != length || number >= components)
            return fail_number(at, length < 40 ? length : 40, components);
        if (n == PICKS_MOST)
            return vv_fail(VV_E_ARGUMENT, "channel: at most %d channels can be picked at once", PICKS_MOST);
        picks[n++] = (int)number;
        at += length;
        if (!*at)
            break;
    }
    *n_out = n;
    return VV_OK;
}

/* Red, green and blue of a colour with alpha are a colour; what else is taken out of one is numbers. */
static vv_meaning meaning_of(const vv_field_info *in, const int *picks, int n)
{
    bool in_order = true;
    for (int c = 0; c < n; c++)
        in_order &= picks[c] == c;
    if (in->meaning == VV_MEANING_LABEL || (in_order && n == in->components))
        return in->meaning;
    return in->meaning == VV_MEANING_RGBA && in_order && n == 3 ? VV_MEANING_RGB : VV_MEANING_SCALAR;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    (void)n_inputs;
    int picks[PICKS_MOST], n;
    const vv_status st = find_picks(picks, &n, params, inputs[0].components);
    if (st != VV_OK)
        return st;
    *out = inputs[0];
    out->components = n;
    out->meaning = meaning_of(&inputs[0], picks, n);
    return VV_OK;
}

typedef struct shared {
    vvi_making making;
    int picks[PICKS_MOST], n;
} shared;

static void pick_row(char *out, const char *in, int64_t n, int64_t stride, size_t bytes, int64_t out_stride)
{
    switch (bytes) { /* known sizes become single loads and stores */
#define PICK(size)                                                                                                     \
    case size:                                                                                                         \
        for (int64_t i = 0; i < n; i++)                                                                                \
            memcpy(out + i * out_stride, in + i * stride, size);                                                       \
        break
        PICK(1);
        PICK(2);
        PICK(4);
        PICK(8);
#undef PICK
    }
}

static vv_status item(void *scratch, void *user, size_t index)
{
    (void)scratch;
    const shared *s = user;
    const vv_field_info *info = vv_field_get_info(s->making.in);
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const size_t bytes = vv_type_bytes(info->type), sample = bytes * (size_t)s->n;
    const vv_brick brick = vvi_brick_part(&s->making.brick, &box);
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            const int64_t first = vvi_slabs_row(&s->making.slabs, &box, j, k);
            const char *row = (const char *)brick.data + j * brick.stride[1] + k * brick.stride[2];
            for (int c = 0; c < s->n; c++)
                pick_row(s->making.out + (size_t)first * sample + (size_t)c * bytes, row + (size_t)s->picks[c] * bytes,
                         box.n[0], brick.stride[0], bytes, (int64_t)sample);
        }
    return VV_OK;
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "channel", .item = item};
    const vv_field_info *from = vv_field_get_info(inputs[0]);
    vv_field_info info;
    shared s = {.making = {.in = inputs[0], .slabs = vvi_slabs_of(box, ITEM_SAMPLES)}};
    vv_status st;
    *out = NULL;
    if ((st = plan(&info, from, n_inputs, params)) != VV_OK ||
        (st = find_picks(s.picks, &s.n, params, from->components)) != VV_OK)
        return st;
    return vvi_making_run(out, &s.making, &info, box, box, &work, &s, job);
}

static vv_status carry(vv_carry *carried, const vv_object *params)
{
    int picks[PICKS_MOST], n;
    if (!carried->channels)
        return VV_OK;
    const vv_status st = find_picks(picks, &n, params, (int)carried->n_channels);
    if (st != VV_OK)
        return st;
    vv_channel *picked = vvi_calloc((size_t)n, sizeof *picked);
    if (!picked)
        return vv_fail_memory((size_t)n * sizeof *picked);
    for (int c = 0; c < n; c++)
        picked[c] = carried->channels[picks[c]];
    free(carried->channels);
    carried->channels = picked;
    carried->n_channels = (size_t)n;
    return VV_OK;
}

const vv_operation vvi_operation_channel = {
    .api = VV_OPERATION_API,
    .name = "channel",
    .component = "filter",
    .group = "channels",
    .doc = "pick channels: one of a multi-channel image, red of a colour, x of a vector",
    .example = "volvis channel cells.nrrd -o nuclei.nrrd --channel 1",
    .params = &channel_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
    .carry = carry,
    .in_order = true,
};
