/* Mask: values where another volume says so, and one value elsewhere. */
#include "core/memory.h"
#include "filter/amounts.h"
#include "grid/label_id.h"
#include "grid/making.h"
#include "grid/same_grid.h"
#include "grid/true_values.h"
#include "registry.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 18)

typedef struct mask_params {
    vv_object object;
    vv_numbers *label;
    bool invert;
    double fill;
} mask_params;

enum { ROW_LABEL, ROW_INVERT, ROW_FILL };

static const vv_property properties[] = {
    [ROW_LABEL] = {VV_PROP(mask_params, label), .kind = VV_KIND_NUMBERS, .columns = 1, .lone = true,
                   .quantity = VV_Q_LABEL, .automatic = "all that is not 0",
                   .doc = "labels of the mask that are kept, one or several, by number or name: 3, 3,5 or liver"},
    [ROW_INVERT] = {VV_PROP(mask_params, invert), .kind = VV_KIND_BOOL,
                    .doc = "keep what the mask leaves out, and fill the rest"},
    [ROW_FILL] = {VV_PROP(mask_params, fill), .kind = VV_KIND_F64, .unit = "value", .doc = "value elsewhere"},
    {0},
};

static const vv_class mask_class = {
    .name = "mask",
    .doc = "parameters of mask",
    .size = sizeof(mask_params),
    .properties = properties,
};

/* What no sample of the mask can be is a slip of whoever named it. */
static vv_status check_labels(const vv_field_info *mask, const vv_numbers *label)
{
    const int bits = 8 * (int)vv_type_bytes(mask->type);
    const bool is_signed = mask->type == VV_TYPE_I8 || mask->type == VV_TYPE_I16 || mask->type == VV_TYPE_I32;
    if (vv_type_is_float(mask->type) || bits > 32 || vvi_has_scale(mask))
        return VV_OK;
    const vv_label_id most = ((vv_label_id)1 << (is_signed ? bits - 1 : bits)) - 1, least = is_signed ? -most - 1 : 0;
    for (size_t i = 0; label && i < label->n; i++) {
        const vv_label_id id = label->labels ? label->labels[i] : (vv_label_id)label->v[i];
        if (id < least || id > most)
            return vv_fail(VV_E_ARGUMENT,
                           "mask: label: no sample of the mask can be %" PRId64 ": they are %s, %" PRId64
                           " to %" PRId64,
                           (int64_t)id, vv_type_name(mask->type), (int64_t)least, (int64_t)most);
    }
    return VV_OK;
}

static vv_status check(char fill[8], const vv_field_info *volume, const vv_field_info *mask, const vv_object *params)
{
    const mask_params *p = (const mask_params *)params;
    vv_status st = vvi_grid_alike(&volume->grid, &mask->grid, "mask");
    if (st != VV_OK)
        return vv_fail_in(st, "mask");
    if (mask->components != 1 && mask->components != volume->components)
        return vv_fail(VV_E_ARGUMENT,
                       "mask: expected a mask of one channel or of as many as the volume has, %d, found %d; pick one "
                       "with 'volvis channel'",
                       volume->components, mask->components);
    st = check_labels(mask, p->label);
    return st == VV_OK ? vvi_stored_bytes(fill, volume, p->fill, "mask: fill") : st;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    char fill[8];
    *out = inputs[0];
    return check(fill, &inputs[0], &inputs[1], params);
}

typedef struct shared {
    vvi_making making;
    const vv_field_info *info, *mask;
    const vv_numbers *label; /* NULL: all that is not 0 */
    bool invert;
    char fill[8];
    vv_job *job;
} shared;

/* A row of labels or values, and behind them what is kept: a byte a sample. */
static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const size_t bytes = (size_t)s->making.slabs.step[0] * (sizeof(vv_label_id) + 1);
    *scratch_out = vvi_alloc(s->job, bytes, VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(bytes);
}

static void finish(void *scratch, void *user)
{
    vvi_free(scratch);
}

static bool has_label(const vv_numbers *labels, vv_label_id id)
{
    for (size_t i = 0; i < labels->n; i++)
        if (labels->labels ? labels->labels[i] == id : (vv_label_id)labels->v[i] == id)
            return true;
    return false;
}

static void keep_labels(uint8_t *kept, const vv_label_id *ids, const shared *s, int64_t n)
{
    vv_label_id last = 0;
    bool now = has_label(s->label, 0);
    for (int64_t i = 0; i < n; i++) {
        if (ids[i] != last) /* neighbours mostly have the same */
            now = has_label(s->label, last = ids[i]);
        kept[i] = now != s->invert;
    }
}

static void keep_values(uint8_t *kept, double *v, const shared *s, const vv_brick *mask, int component, int64_t j,
                        int64_t k)
{
    const size_t each = vv_type_bytes(mask->type);
    const int64_t n = mask->box.n[0];
    const char *row = (const char *)mask->data + j * mask->stride[1] + k * mask->stride[2] + (size_t)component * each;
    const bool packed = mask->stride[0] == (int64_t)each;
    for (int64_t i = 0; i < n; i += packed ? n : 1)
        vvi_samples_to_f64(v + i, row + i * mask->stride[0], mask->type, packed ? (size_t)n : 1);
    for (int64_t i = 0; i < n; i++) {
        const double value = v[i] * s->mask->value_scale + s->mask->value_offset;
        kept[i] = (value < 0 || value > 0) != s->invert; /* NaN is not in it */
    }
}

/* One number after the other, as gcc makes vectors of it. */
#define SELECT(type)                                                                                                   \
    {                                                                                                                  \
        type v, other;                                                                                                 \
        memcpy(&other, fill, sizeof other);                                                                            \
        for (int64_t i = 0; i < n; i++) {                                                                              \
            memcpy(&v, in + (size_t)i * sizeof v, sizeof v);                                                           \
            v = kept[i] ? v : other;                                                                                   \
            memcpy(out + (size_t)i * sizeof v, &v, sizeof v);                                                          \
        }                                                                                                              \
        break;                                                                                                         \
    }

static void select_numbers(char *restrict out, const char *restrict in, const char *fill, const uint8_t *restrict kept,
                           size_t each, int64_t n)
{
    switch (each) {
    case 1:
        SELECT(uint8_t)
    case 2:
        SELECT(uint16_t)
    case 4:
        SELECT(uint32_t)
    default:
        SELECT(uint64_t)
    }
}

static void write_row(char *out, const char *in, const shared *s, const uint8_t *kept, int component, int64_t n)
{
    const bool each_alone = s->mask->components > 1;
    const size_t each = vv_type_bytes(s->info->type), sample = each * (size_t)s->info->components;
    const size_t bytes = each_alone ? each : sample, first = (size_t)component * each;
    if (sample == each) {
        select_numbers(out, in, s->fill, kept, each, n);
        return;
    }
    for (int64_t i = 0; i < n; i++) {
        char *at = out + (size_t)i * sample + first;
        if (kept[i])
            memcpy(at, in + (size_t)i * sample + first, bytes);
        else
            vvi_fill_numbers(at, s->fill, each, (int64_t)(bytes / each));
    }
}

static vv_status item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const vv_brick brick = vvi_brick_part(&s->making.brick, &box),
                   mask = vvi_brick_part(&s->making.more_bricks[0], &box);
    const size_t sample = vv_type_bytes(s->info->type) * (size_t)s->info->components;
    uint8_t *kept = (uint8_t *)scratch + (size_t)s->making.slabs.step[0] * sizeof(vv_label_id);
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            const char *in = (const char *)brick.data + j * brick.stride[1] + k * brick.stride[2];
            char *out = s->making.out + (size_t)vvi_slabs_row(&s->making.slabs, &box, j, k) * sample;
            for (int c = 0; c < s->mask->components; c++) {
                if (s->label) {
                    vvi_label_read(scratch, &mask, c, s->mask, j, k);
                    keep_labels(kept, scratch, s, box.n[0]);
                } else {
                    keep_values(kept, scratch, s, &mask, c, j, k);
                }
                write_row(out, in, s, kept, c, box.n[0]);
            }
        }
    return VV_OK;
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "mask", .start = start, .item = item, .finish = finish};
    const mask_params *p = (const mask_params *)params;
    shared s = {.making = {.in = inputs[0], .more = {inputs[1]}, .slabs = vvi_slabs_of(box, ITEM_SAMPLES)},
                .info = vv_field_get_info(inputs[0]),
                .mask = vv_field_get_info(inputs[1]),
                .label = p->label && p->label->n ? p->label : NULL,
                .invert = p->invert,
                .job = job};
    const vv_status st = check(s.fill, s.info, s.mask, params);
    *out = NULL;
    return st == VV_OK ? vvi_making_run(out, &s.making, s.info, box, box, &work, &s, job) : st;
}

static const vv_operand inputs_taken[] = {
    {"volume", VV_IS_FIELD, 1, 1, "the volume that it works on"},
    {"mask", VV_IS_FIELD, 1, 1, "a volume on the same grid that says what is kept", .names_labels = true},
    {0},
};

const vv_operation vvi_operation_mask = {
    .api = VV_OPERATION_API,
    .name = "mask",
    .component = "filter",
    .group = "values",
    .doc = "keep values where another volume is not 0, or has given labels; elsewhere is one value",
    .example = "volvis mask head.nrrd mask=labels.nrrd -o part.nrrd --label 1,2",
    .params = &mask_class,
    .inputs = inputs_taken,
    .run_box = run_box,
    .plan = plan,
    .carry = vv_carry_values,
    .in_order = true,
};
