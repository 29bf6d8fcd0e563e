/* dilate, erode, open, close, top-hat. */
#include "core/status.h"
#include "filter/few_labels.h"
#include "filter/morphology.h"
#include "grid/label_id.h"
#include "grid/making.h"
#include "registry.h"

#include <string.h>

typedef struct morphology_params {
    vvi_element_params element;
    vv_label_id label;
} morphology_params;

typedef struct top_hat_params {
    vvi_element_params element;
    bool dark;
} top_hat_params;

enum { ROW_LABEL = 3 }; /* behind those of the element */

static const vv_property properties[] = {
    VVI_ELEMENT_PROPERTIES,
    {VV_PROP(morphology_params, label), .kind = VV_KIND_I64, .quantity = VV_Q_LABEL, .automatic = "all",
     .when = "data=labels", .doc = "the one label that changes; others stay, and are not grown over"},
    {0},
};

static const vv_property top_hat_properties[] = {
    VVI_ELEMENT_PROPERTIES,
    {VV_PROP(top_hat_params, dark), .kind = VV_KIND_BOOL,
     .doc = "what is darker than its surroundings and smaller than the element, not what is brighter"},
    {0},
};

static bool is_for_labels(const vv_field_info *info)
{
    return info->meaning == VV_MEANING_LABEL;
}

static const vv_label_id *only_of(const vv_object *params)
{
    return params->set >> ROW_LABEL & 1 ? &((const morphology_params *)params)->label : NULL;
}

static vv_status check_all(const vv_field_info *info, const vv_object *params, const char *name)
{
    const vv_label_id *only = only_of(params);
    if (only && !is_for_labels(info))
        return vv_fail(
            VV_E_ARGUMENT,
            "%s: `label` is for labels, and these samples are taken as amounts: leave it out, or make a file "
            "that says that they are labels, as 'volvis convert FILE -o labels.seg.nrrd' does",
            name);
    if (only && *only == 0)
        return vv_fail(VV_E_ARGUMENT, "%s: label 0 is what has no label; give another one", name);
    return vvi_element_check(info, params, name);
}

static vv_status run_steps(vv_field **out, const vv_field *in, const vv_object *params, const vv_box *box,
                           const char *name, int n_steps, bool erodes_first, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(in);
    vvi_morphology m = {.name = name, .n_steps = n_steps, .erodes = {erodes_first, !erodes_first}};
    *out = NULL;
    vv_status st = vvi_element_init(&m.element, info, params, name, job);
    if (st != VV_OK)
        return st;
    if (is_for_labels(info))
        st = vvi_morphology_of_labels(out, in, box, &m, only_of(params), job);
    else
        st = vvi_morphology_of_values(out, in, box, &m, job);
    vvi_element_finish(&m.element);
    return st;
}

/* Whoever has labels is told that these are none, where all samples are there. */
static vv_status advise(const vv_field *in, const vv_box *box, vv_job *job)
{
    const vv_box all = vv_field_box(in);
    return memcmp(box, &all, sizeof all) == 0 ? vvi_advise_labels(in, job) : VV_OK;
}

/* An operation of its own name for each order of steps. */
#define MORPHOLOGY(symbol, steps, erodes_first, doc_text, example_text)                                                \
    static const vv_class symbol##_class = {                                                                           \
        .name = #symbol,                                                                                               \
        .doc = "parameters of " #symbol,                                                                               \
        .size = sizeof(morphology_params),                                                                             \
        .properties = properties,                                                                                      \
        .check = vvi_window_check,                                                                                     \
    };                                                                                                                 \
    static vv_status symbol##_plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs,                   \
                                   const vv_object *params)                                                            \
    {                                                                                                                  \
        *out = inputs[0];                                                                                              \
        return check_all(&inputs[0], params, #symbol);                                                                 \
    }                                                                                                                  \
    static vv_status symbol##_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs,                      \
                                  const vv_object *params, const vv_box *box, vv_job *job)                             \
    {                                                                                                                  \
        *out = NULL;                                                                                                   \
        vv_status st = check_all(vv_field_get_info(inputs[0]), params, #symbol);                                       \
        if (st == VV_OK)                                                                                               \
            st = advise(inputs[0], box, job);                                                                          \
        return st == VV_OK ? run_steps(out, inputs[0], params, box, #symbol, steps, erodes_first, job) : st;           \
    }                                                                                                                  \
    const vv_operation vvi_operation_##symbol = {                                                                      \
        .api = VV_OPERATION_API,                                                                                       \
        .name = #symbol,                                                                                               \
        .component = "filter",                                                                                         \
        .group = "morphology",                                                                                         \
        .doc = doc_text,                                                                                               \
        .example = example_text,                                                                                       \
        .params = &symbol##_class,                                                                                     \
        .inputs = VV_ONE_VOLUME,                                                                                       \
        .run_box = symbol##_box,                                                                                       \
        .plan = symbol##_plan,                                                                                         \
        .carry = vv_carry_values,                                                                                      \
    }

MORPHOLOGY(dilate, 1, false,
           "the greatest value under a structuring element around each sample: what is bright grows; labels grow over "
           "what has none, where several come the nearest has it; beyond the border nothing counts",
           "volvis dilate cells.nrrd -o larger.nrrd --radius 2vox");
MORPHOLOGY(erode, 1, true,
           "the least value under a structuring element around each sample: what is bright shrinks; labels stay where "
           "they fill the element; beyond the border nothing counts",
           "volvis erode cells.nrrd -o smaller.nrrd --radius 2vox");
MORPHOLOGY(
    open, 2, true,
    "erode, then dilate: what is bright, or has a label, and is narrower than the structuring element goes, and the "
    "rest stays",
    "volvis open cells.nrrd -o clean.nrrd --radius 1.5vox");
MORPHOLOGY(
    close, 2, false,
    "dilate, then erode: gaps and holes that are narrower than the structuring element are closed, of each label by "
    "itself, and the rest stays",
    "volvis close cells.nrrd -o whole.nrrd --radius 1.5vox");

static const vv_class top_hat_class = {
    .name = "top-hat",
    .doc = "parameters of top-hat",
    .size = sizeof(top_hat_params),
    .properties = top_hat_properties,
    .check = vvi_window_check,
};

/* Differences of signed samples are as large as unsigned ones can be. */
static vv_type difference_type(vv_type type)
{
    switch (type) {
    case VV_TYPE_I8:
        return VV_TYPE_U8;
    case VV_TYPE_I16:
        return VV_TYPE_U16;
    case VV_TYPE_I32:
        return VV_TYPE_U32;
    case VV_TYPE_I64:
        return VV_TYPE_U64;
    default:
        return type;
    }
}

static vv_status top_hat_plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    *out = inputs[0];
    if (is_for_labels(&inputs[0]))
        return vv_fail(VV_E_UNSUPPORTED, "top-hat: labels are names, not amounts, and have no difference; see `open`");
    out->type = difference_type(inputs[0].type);
    out->value_offset = 0;
    out->value_scale = inputs[0].value_scale < 0 ? -inputs[0].value_scale : inputs[0].value_scale;
    return vvi_element_check(&inputs[0], params, "top-hat");
}

typedef struct shared {
    vvi_making making;
    vv_brick steps; /* what the steps made of the same samples */
    vv_type type;
} shared;

/* How far two rows are apart. */
#define ONE_TYPE(ctype, utype)                                                                                         \
    for (int64_t i = 0; i < n; i++) {                                                                                  \
        ctype x, y;                                                                                                    \
        memcpy(&x, a + i * (int64_t)sizeof x, sizeof x);                                                               \
        memcpy(&y, b + i * (int64_t)sizeof y, sizeof y);                                                               \
        const utype d = (utype)(x > y ? (utype)x - (utype)y : x == y ? 0 : (utype)y - (utype)x);                       \
        memcpy(out + i * (int64_t)sizeof d, &d, sizeof d);                                                             \
    }                                                                                                                  \
    break

static void subtract_row(char *out, const char *a, const char *b, vv_type type, int64_t n)
{
    switch (type) {
    case VV_TYPE_U8:
        ONE_TYPE(uint8_t, uint8_t);
    case VV_TYPE_I8:
        ONE_TYPE(int8_t, uint8_t);
    case VV_TYPE_U16:
        ONE_TYPE(uint16_t, uint16_t);
    case VV_TYPE_I16:
        ONE_TYPE(int16_t, uint16_t);
    case VV_TYPE_U32:
        ONE_TYPE(uint32_t, uint32_t);
    case VV_TYPE_I32:
        ONE_TYPE(int32_t, uint32_t);
    case VV_TYPE_U64:
        ONE_TYPE(uint64_t, uint64_t);
    case VV_TYPE_I64:
        ONE_TYPE(int64_t, uint64_t);
    case VV_TYPE_F32:
        ONE_TYPE(float, float);
    case VV_TYPE_F64:
        ONE_TYPE(double, double);
    }
}

static vv_status subtract(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_box item = vvi_slabs_item(&s->making.slabs, index);
    const vv_brick a = vvi_brick_part(&s->making.brick, &item);
    const int64_t each = (int64_t)vv_type_bytes(s->type) * a.components, *lo = s->making.slabs.box.lo;
    for (int64_t k = 0; k < item.n[2]; k++)
        for (int64_t j = 0; j < item.n[1]; j++) {
            const char *from = (const char *)a.data + j * a.stride[1] + k * a.stride[2];
            const char *step = (const char *)s->steps.data + (item.lo[0] - lo[0]) * s->steps.stride[0] +
                               (item.lo[1] - lo[1] + j) * s->steps.stride[1] +
                               (item.lo[2] - lo[2] + k) * s->steps.stride[2];
            subtract_row(s->making.out + vvi_slabs_row(&s->making.slabs, &item, j, k) * each, from, step, s->type,
                         item.n[0] * a.components);
        }
    return VV_OK;
}

static vv_status top_hat_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                             const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "top-hat", .item = subtract};
    const vv_field_info *from = vv_field_get_info(inputs[0]);
    shared s = {.making = {.in = inputs[0], .slabs = vvi_slabs_of(box, 1 << 17)}, .type = from->type};
    vv_field *steps = NULL;
    vv_field_info info;
    *out = NULL;
    vv_status st = top_hat_plan(&info, from, n_inputs, params);
    if (st == VV_OK)
        st = run_steps(&steps, inputs[0], params, box, "top-hat", 2, !((const top_hat_params *)params)->dark, job);
    if (st != VV_OK)
        return st;
    const vv_box all = vv_field_box(steps);
    if ((st = vv_field_brick(&s.steps, steps, &all, job)) == VV_OK)
        st = vvi_making_run(out, &s.making, &info, box, box, &work, &s, job);
    vv_brick_release(&s.steps);
    vv_field_release(steps);
    return st;
}

const vv_operation vvi_operation_top_hat = {
    .api = VV_OPERATION_API,
    .name = "top-hat",
    .component = "filter",
    .group = "morphology",
    .doc = "how far each sample is above what `open` makes of it: what is bright and smaller than the structuring "
           "element, without its surroundings; with --dark how far it is below what `close` makes of it",
    .example = "volvis top-hat head.nrrd -o thin.nrrd --radius 3mm",
    .params = &top_hat_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = top_hat_box,
    .plan = top_hat_plan,
};
