/* Merge: volumes of one grid as the channels of one. */
#include "core/memory.h"
#include "grid/label_id.h"
#include "grid/making.h"
#include "grid/same_grid.h"
#include "registry.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 17)

enum { INPUTS_MOST = 8, CHANNELS_MOST = 64 };

typedef struct merge_params {
    vv_object object;
    char *names;
} merge_params;

static const vv_property properties[] = {
    {VV_PROP(merge_params, names), .kind = VV_KIND_STRING, .automatic = "none",
     .doc = "what the channels are called, in their order: ct,pet; NAME=FILE says it on the command line"},
    {0},
};

static const vv_class merge_class = {
    .name = "merge",
    .doc = "parameters of merge",
    .size = sizeof(merge_params),
    .properties = properties,
};

static size_t count_names(const char *names)
{
    size_t n = names && *names ? 1 : 0;
    for (; names && *names; names++)
        n += *names == ',';
    return n;
}

static bool is_plain(const vv_field_info *info)
{
    return info->value_scale == 1 && info->value_offset == 0;
}

static bool is_stored_alike(const vv_field_info *a, const vv_field_info *b)
{
    return a->type == b->type && a->value_scale == b->value_scale && a->value_offset == b->value_offset;
}

/* The smallest type of integers that holds what all hold; doubles hold what none does. */
static vv_type common_integer(const vv_field_info *inputs, size_t n)
{
    static const vv_type by_size[] = {VV_TYPE_U8,  VV_TYPE_I8,  VV_TYPE_U16, VV_TYPE_I16,
                                      VV_TYPE_U32, VV_TYPE_I32, VV_TYPE_U64, VV_TYPE_I64};
    for (size_t t = 0; t < sizeof by_size / sizeof *by_size; t++) {
        bool holds = true;
        for (size_t i = 0; i < n; i++)
            holds = holds && vvi_type_min(inputs[i].type) >= vvi_type_min(by_size[t]) &&
                    vvi_type_max(inputs[i].type) <= vvi_type_max(by_size[t]);
        if (holds)
            return by_size[t];
    }
    return VV_TYPE_F64;
}

static void choose_type(vv_field_info *out, const vv_field_info *inputs, size_t n)
{
    bool alike = true, integers = true, short_ones = true;
    for (size_t i = 0; i < n; i++) {
        const vv_type type = inputs[i].type;
        alike = alike && is_stored_alike(&inputs[0], &inputs[i]);
        integers = integers && !vv_type_is_float(type) && is_plain(&inputs[i]);
        short_ones = short_ones && (type == VV_TYPE_F32 || vv_type_bytes(type) <= 2);
    }
    if (alike)
        return;
    out->type = integers ? common_integer(inputs, n) : short_ones ? VV_TYPE_F32 : VV_TYPE_F64;
    out->value_scale = 1;
    out->value_offset = 0;
}

static vv_status check_names(const vv_object *params, size_t n_inputs, int components)
{
    const char *names = ((const merge_params *)params)->names;
    const size_t n = count_names(names);
    if (n == 0 || n == n_inputs || n == (size_t)components)
        return VV_OK;
    return vv_fail(VV_E_ARGUMENT, "merge: names: expected %d, one for each channel, found %zu: %s", components, n,
                   names);
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    *out = inputs[0];
    out->components = 0;
    for (size_t i = 0; i < n_inputs; i++) {
        char name[32];
        snprintf(name, sizeof name, "volume number %zu", i + 1);
        const vv_status st = vvi_grid_alike(&inputs[0].grid, &inputs[i].grid, name);
        if (st != VV_OK)
            return vv_fail_in(st, "merge");
        out->components += inputs[i].components;
        if (strcmp(inputs[i].value_unit, inputs[0].value_unit) != 0)
            out->value_unit[0] = 0;
        if (out->components > CHANNELS_MOST)
            return vv_fail(VV_E_ARGUMENT, "merge: the volumes have more than %d channels together", CHANNELS_MOST);
    }
    out->meaning = VV_MEANING_SCALAR;
    out->name[0] = 0;
    choose_type(out, inputs, n_inputs);
    return check_names(params, n_inputs, out->components);
}

typedef struct shared {
    vvi_making making;
    const vv_field_info *info; /* of the result */
    const vv_field *const *inputs;
    size_t n_inputs;
    vv_job *job;
} shared;

/* A row of one channel, as doubles or as whole numbers. */
static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const size_t bytes = (size_t)s->making.slabs.step[0] * 16;
    *scratch_out = vvi_alloc(s->job, bytes, VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(bytes);
}

static void finish(void *scratch, void *user)
{
    vvi_free(scratch);
}

#define COPY(bytes)                                                                                                    \
    for (int64_t i = 0; i < n; i++)                                                                                    \
        memcpy(out + (size_t)i * out_step, in + (size_t)i * in_step, bytes);                                           \
    break

static void copy_row(char *restrict out, size_t out_step, const char *restrict in, size_t in_step, size_t each,
                     int64_t n)
{
    switch (each) { /* as numbers: else each is a call */
    case 1:
        COPY(1);
    case 2:
        COPY(2);
    case 4:
        COPY(4);
    default:
        COPY(8);
    }
}

/* Whole numbers of a type that holds them. */
static void store_whole(char *out, size_t step, const vv_label_id *row, vv_type type, int64_t n)
{
    const size_t each = vv_type_bytes(type);
    for (int64_t i = 0; i < n; i++) {
        const uint64_t v = (uint64_t)row[i];
        const uint8_t v8 = (uint8_t)v;
        const uint16_t v16 = (uint16_t)v;
        const uint32_t v32 = (uint32_t)v;
        memcpy(out + (size_t)i * step,
               each == 1   ? (const void *)&v8
               : each == 2 ? (const void *)&v16
               : each == 4 ? (const void *)&v32
                           : &v,
               each);
    }
}

static void store_values(char *out, size_t step, double *row, const char *in, int64_t in_step,
                         const vv_field_info *from, vv_type type, int64_t n)
{
    const size_t each = vv_type_bytes(type);
    char *packed = (char *)(row + n);
    for (int64_t i = 0; i < n; i++) {
        vvi_samples_to_f64(&row[i], in + i * in_step, from->type, 1);
        row[i] = row[i] * from->value_scale + from->value_offset;
    }
    vvi_samples_from_f64(packed, row, type, (size_t)n);
    copy_row(out, step, packed, each, each, n);
}

/* Row (j, k) of channel `component` of an input. */
static void write_row(char *out, void *scratch, const shared *s, size_t input, const vv_brick *brick, int component,
                      int64_t j, int64_t k)
{
    const vv_field_info *from = vv_field_get_info(s->inputs[input]);
    const vv_type type = s->info->type;
    const size_t step = vv_type_bytes(type) * (size_t)s->info->components, each = vv_type_bytes(from->type);
    const char *in = (const char *)brick->data + j * brick->stride[1] + k * brick->stride[2] + (size_t)component * each;
    if (is_stored_alike(from, s->info)) {
        copy_row(out, step, in, (size_t)brick->stride[0], each, brick->box.n[0]);
    } else if (vv_type_is_float(type)) {
        store_values(out, step, scratch, in, brick->stride[0], from, type, brick->box.n[0]);
    } else {
        vvi_label_read(scratch, brick, component, NULL, j, k);
        store_whole(out, step, scratch, type, brick->box.n[0]);
    }
}

static vv_status item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const size_t each = vv_type_bytes(s->info->type);
    size_t first = 0; /* channel of the result */
    for (size_t n = 0; n < s->n_inputs; n++) {
        const vv_brick brick = vvi_brick_part(n ? &s->making.more_bricks[n - 1] : &s->making.brick, &box);
        for (int c = 0; c < brick.components; c++, first++)
            for (int64_t k = 0; k < box.n[2]; k++)
                for (int64_t j = 0; j < box.n[1]; j++) {
                    const int64_t row = vvi_slabs_row(&s->making.slabs, &box, j, k) * s->info->components;
                    write_row(s->making.out + ((size_t)row + first) * each, scratch, s, n, &brick, c, j, k);
                }
    }
    return VV_OK;
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "merge", .start = start, .item = item, .finish = finish};
    vv_field_info info, infos[INPUTS_MOST] = {0};
    shared s = {.making = {.in = inputs[0], .slabs = vvi_slabs_of(box, ITEM_SAMPLES)},
                .info = &info,
                .inputs = inputs,
                .n_inputs = n_inputs,
                .job = job};
    *out = NULL;
    for (size_t i = 0; i < n_inputs; i++) {
        infos[i] = *vv_field_get_info(inputs[i]);
        if (i > 0)
            s.making.more[i - 1] = inputs[i];
    }
    const vv_status st = plan(&info, infos, n_inputs, params);
    return st == VV_OK ? vvi_making_run(out, &s.making, &info, box, box, &work, &s, job) : st;
}

/* What the first file says of its channels is not said of the others'. */
static vv_status carry(vv_carry *carried, const vv_object *params)
{
    const char *at = ((const merge_params *)params)->names;
    const size_t n = count_names(at);
    free(carried->channels);
    carried->channels = NULL;
    carried->n_channels = 0;
    carried->new_values = true;
    if (n == 0)
        return VV_OK;
    carried->channels = vvi_calloc(n, sizeof *carried->channels);
    if (!carried->channels)
        return vv_fail_memory(n * sizeof *carried->channels);
    for (; carried->n_channels < n; carried->n_channels++) {
        vv_channel *channel = &carried->channels[carried->n_channels];
        const size_t length = strcspn(at, ",");
        snprintf(channel->name, sizeof channel->name, "%.*s", (int)length, at);
        at += length + (at[length] == ',');
    }
    return VV_OK;
}

static const vv_operand inputs_taken[] = {
    {"volume", VV_IS_FIELD, 2, INPUTS_MOST, "volumes whose channels the result has", .names = "names"},
    {0},
};

const vv_operation vvi_operation_merge = {
    .api = VV_OPERATION_API,
    .name = "merge",
    .component = "filter",
    .group = "channels",
    .doc = "two to eight volumes on one grid as channels of one, in their order",
    .example = "volvis merge before=pre.nrrd after=post.nrrd -o both.nrrd",
    .params = &merge_class,
    .inputs = inputs_taken,
    .run_box = run_box,
    .plan = plan,
    .carry = carry,
    .in_order = true,
};
