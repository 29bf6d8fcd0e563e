/* Clamp: values outside a range become its ends, or what somebody says. */
#include "filter/amounts.h"
#include "filter/sample_keys.h"
#include "grid/making.h"
#include "registry.h"
#include "segment/value_range.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 18)
#define PART 1024 /* numbers that are compared at a time */

typedef struct clamp_params {
    vv_object object;
    char *range;
    double below, above;
} clamp_params;

enum { ROW_RANGE, ROW_BELOW, ROW_ABOVE };

static const vv_property properties[] = {
    [ROW_RANGE] = {VV_PROP(clamp_params, range), .kind = VV_KIND_STRING, .automatic = "none: it must be given",
                   .doc = "values that stay, both ends included: -1000..2000, 0.. or ..255"},
    [ROW_BELOW] = {VV_PROP(clamp_params, below), .kind = VV_KIND_F64, .unit = "value",
                   .automatic = "the lower end of the range", .doc = "what smaller values become"},
    [ROW_ABOVE] = {VV_PROP(clamp_params, above), .kind = VV_KIND_F64, .unit = "value",
                   .automatic = "the upper end of the range", .doc = "what larger values become"},
    {0},
};

static const vv_class clamp_class = {
    .name = "clamp",
    .doc = "parameters of clamp",
    .size = sizeof(clamp_params),
    .properties = properties,
};

/* Samples by their keys: those before and behind the range, and what they become. */
typedef struct limits {
    vvi_key_range range, numbers; /* what is among no numbers is NaN */
    int64_t before_key, behind_key;
} limits;

/* The key of what lies beyond an end, which has the key `end`. */
static vv_status find_end(int64_t *key, const vv_field_info *info, const clamp_params *p, int row, int64_t end)
{
    char sample[8];
    _Alignas(8) char as_key[8] = {0};
    *key = end;
    if (!(p->object.set >> row & 1))
        return VV_OK;
    const vv_status st = vvi_stored_bytes(sample, info, row == ROW_BELOW ? p->below : p->above,
                                          row == ROW_BELOW ? "clamp: below" : "clamp: above");
    if (st != VV_OK)
        return st;
    vvi_keys_of_samples(as_key, sample, (int64_t)vv_type_bytes(info->type), info->type, 1);
    *key = vvi_key_at(as_key, 0, info->type);
    return VV_OK;
}

/* The value of a 4-byte float that is nearest to what was typed: the shortest text of a sample is that sample. */
static double nearest_of(double typed, const vv_field_info *info)
{
    const double sample = (typed - info->value_offset) / info->value_scale;
    const bool some = info->type == VV_TYPE_F32 && fabs(sample) <= (double)FLT_MAX;
    return some ? (double)(float)sample * info->value_scale + info->value_offset : typed;
}

static vv_status find_limits(limits *out, const vv_field_info *info, const vv_object *params)
{
    const clamp_params *p = (const clamp_params *)params;
    const bool falls = info->value_scale < 0; /* larger values are smaller numbers */
    const vvi_value_range all = {-INFINITY, INFINITY};
    vvi_value_range range;
    vv_status st;
    if (info->meaning == VV_MEANING_LABEL)
        return vv_fail(VV_E_UNSUPPORTED, "clamp: labels are names, not amounts; 'volvis mask' keeps some of them");
    if (!p->range || !*p->range)
        return vv_fail(VV_E_ARGUMENT, "clamp: range is needed: the values that stay, such as -1000..2000");
    if ((st = vvi_value_range_parse(&range, p->range, "clamp: range")) != VV_OK)
        return st;
    range = vvi_value_range_as_typed(&range, info);
    range = (vvi_value_range){nearest_of(range.lo, info), nearest_of(range.hi, info)};
    out->range = vvi_key_range_of(&range, info);
    out->numbers = vvi_key_range_of(&all, info);
    if (out->range.lo > out->range.hi)
        return vv_fail(VV_E_ARGUMENT, "clamp: range: %s samples of this volume have no value from %s",
                       vv_type_name(info->type), p->range);
    if ((st = find_end(&out->before_key, info, p, falls ? ROW_ABOVE : ROW_BELOW, out->range.lo)) == VV_OK)
        st = find_end(&out->behind_key, info, p, falls ? ROW_BELOW : ROW_ABOVE, out->range.hi);
    return st;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    limits found;
    *out = inputs[0];
    return find_limits(&found, &inputs[0], params);
}

typedef struct shared {
    vvi_making making;
    limits limits;
} shared;

#define CLAMP(ctype)                                                                                                   \
    do {                                                                                                               \
        const ctype lo = (ctype)l->range.lo, hi = (ctype)l->range.hi;                                                  \
        const ctype least = (ctype)l->numbers.lo, most = (ctype)l->numbers.hi;                                         \
        const ctype before = (ctype)l->before_key, behind = (ctype)l->behind_key;                                      \
        ctype *k = (ctype *)(void *)keys;                                                                              \
        for (int64_t i = 0; i < n; i++)                                                                                \
            k[i] = k[i] < lo && k[i] >= least ? before : k[i] > hi && k[i] <= most ? behind : k[i];                    \
    } while (0)

static void clamp_keys(char *keys, size_t each, const limits *l, int64_t n)
{
    if (each == 1)
        CLAMP(uint8_t);
    else if (each == 2)
        CLAMP(int16_t);
    else if (each == 4)
        CLAMP(int32_t);
    else
        CLAMP(int64_t);
}

static void clamp_run(char *out, const char *in, vv_type type, const limits *l, int64_t n)
{
    _Alignas(64) char keys[PART * 8];
    const size_t each = vv_type_bytes(type);
    vvi_keys_of_samples(keys, in, (int64_t)each, type, n);
    clamp_keys(keys, each, l, n);
    vvi_samples_of_keys(out, (int64_t)each, keys, type, n);
}

static vv_status item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_field_info *info = vv_field_get_info(s->making.in);
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const vv_brick brick = vvi_brick_part(&s->making.brick, &box);
    const size_t each = vv_type_bytes(info->type);
    const int64_t n = box.n[0] * info->components;
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            const char *in = (const char *)brick.data + j * brick.stride[1] + k * brick.stride[2];
            char *out = s->making.out + (size_t)(vvi_slabs_row(&s->making.slabs, &box, j, k) * info->components) * each;
            for (int64_t at = 0; at < n; at += PART)
                clamp_run(out + (size_t)at * each, in + (size_t)at * each, info->type, &s->limits,
                          n - at < PART ? n - at : PART);
        }
    return VV_OK;
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "clamp", .item = item};
    const vv_field_info *info = vv_field_get_info(inputs[0]);
    shared s = {.making = {.in = inputs[0], .slabs = vvi_slabs_of(box, ITEM_SAMPLES)}};
    const vv_status st = find_limits(&s.limits, info, params);
    *out = NULL;
    return st == VV_OK ? vvi_making_run(out, &s.making, info, box, box, &work, &s, job) : st;
}

const vv_operation vvi_operation_clamp = {
    .api = VV_OPERATION_API,
    .name = "clamp",
    .component = "filter",
    .group = "values",
    .doc = "values outside a range become its ends, or other values; NaN stays",
    .example = "volvis clamp head.nrrd -o within.nrrd --range 20..200 --below 0",
    .params = &clamp_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
    .carry = vv_carry_values,
    .in_order = true,
};
