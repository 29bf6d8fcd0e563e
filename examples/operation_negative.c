/* "negative": every value becomes `white` minus the value. Values, not stored numbers: scale and offset stay. */
#include "operation_negative.h"
#include <volvis/sys/making.h>

typedef struct negative_params {
    vv_object base;
    double white;
} negative_params;

static const vv_property negative_rows[] = {
    {VV_PROP(negative_params, white), .kind = VV_KIND_F64, .unit = "value", .def = 255, .doc = "value that becomes 0"},
    {0},
};

static const vv_class negative_class = {
    .name = "negative",
    .doc = "parameters of negative",
    .size = sizeof(negative_params),
    .properties = negative_rows,
};

/* What the loop's items share. Each worker has a row of doubles as scratch. */
typedef struct negative_work {
    vv_making making;
    double white;
    vv_job *job;
} negative_work;

static vv_status start(void **scratch_out, void *shared, int worker)
{
    const negative_work *w = shared;
    const size_t n = (size_t)w->making.slabs.step[0] * (size_t)vv_field_get_info(w->making.in)->components;
    *scratch_out = vv_alloc(w->job, n * sizeof(double));
    return *scratch_out ? VV_OK : vv_fail_memory(n * sizeof(double));
}

static vv_status negate(void *scratch, void *shared, size_t index)
{
    const negative_work *w = shared;
    const vv_field_info *info = vv_field_get_info(w->making.in);
    const vv_box item = vv_slabs_item(&w->making.slabs, index);
    const vv_brick in = vv_brick_part(&w->making.brick, &item);
    const size_t sample = vv_type_bytes(info->type) * (size_t)info->components;
    const size_t n = (size_t)(item.n[0] * info->components);
    const double white = (w->white - 2 * info->value_offset) / info->value_scale; /* value = stored * scale + offset */
    double *row = scratch;
    for (int64_t k = 0; k < item.n[2]; k++)
        for (int64_t j = 0; j < item.n[1]; j++) {
            vv_samples_to_f64(row, (const char *)in.data + j * in.stride[1] + k * in.stride[2], info->type, n);
            for (size_t i = 0; i < n; i++)
                row[i] = white - row[i];
            char *out = w->making.out + (size_t)vv_slabs_row(&w->making.slabs, &item, j, k) * sample;
            vv_samples_from_f64(out, row, info->type, n);
        }
    return VV_OK;
}

static void finish(void *scratch, void *shared)
{
    vv_free(scratch);
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    static const vv_work loop = {.stage = "negative", .start = start, .item = negate, .finish = finish};
    negative_work work = {
        .making = {.in = inputs[0], .slabs = vv_slabs_of(box, 1 << 18)}, /* samples of an item, at most */
        .white = ((const negative_params *)params)->white,
        .job = job,
    };
    return vv_making_run(out, &work.making, vv_field_get_info(inputs[0]), box, box, &loop, &work, job);
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    *out = inputs[0];
    return VV_OK;
}

const vv_operation operation_negative = {
    .api = VV_OPERATION_API,
    .name = "negative",
    .component = "filter",
    .doc = "turn light into dark, an example",
    .example = "volvis negative in.nrrd -o out.nrrd --white 255",
    .params = &negative_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
};
