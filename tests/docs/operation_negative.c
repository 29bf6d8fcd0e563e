/* "negative": every value becomes `white` minus the value. Values, not stored numbers: scale and offset stay. */
#include "operation_negative.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"

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

/* What the loop's items share. An item is one slice; each worker has a row of doubles as scratch. */
typedef struct negative_work {
    const vv_field_info *info;
    vv_brick in;
    uint8_t *out;
    double white;
    vv_job *job;
} negative_work;

static vv_status start(void **scratch_out, void *shared, int worker)
{
    const negative_work *w = shared;
    const size_t bytes = (size_t)w->info->grid.dims[0] * (size_t)w->info->components * sizeof(double);
    *scratch_out = vvi_alloc(w->job, bytes, VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(bytes);
}

static vv_status negate_slice(void *scratch, void *shared, size_t k)
{
    const negative_work *w = shared;
    const vv_field_info *info = w->info;
    const size_t n = (size_t)info->grid.dims[0] * (size_t)info->components;
    const size_t row_bytes = n * vv_type_bytes(info->type), rows = (size_t)info->grid.dims[1];
    double *row = scratch;
    for (size_t j = 0; j < rows; j++) {
        const uint8_t *in = (const uint8_t *)w->in.data + (int64_t)j * w->in.stride[1] + (int64_t)k * w->in.stride[2];
        vvi_samples_to_f64(row, in, info->type, n);
        for (size_t i = 0; i < n;
             i++) /* value = stored * scale + offset, so stored' = (white - 2 offset) / scale - stored */
            row[i] = (w->white - 2 * info->value_offset) / info->value_scale - row[i];
        vvi_samples_from_f64(w->out + (k * rows + j) * row_bytes, row, info->type, n);
    }
    return VV_OK;
}

static void finish(void *scratch, void *shared)
{
    vvi_free(scratch);
}

static vv_status run(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                     vv_job *job)
{
    static const vvi_work loop = {.stage = "negative", .start = start, .item = negate_slice, .finish = finish};
    const vv_field_info *info = vv_field_get_info(inputs[0]);
    const vv_box box = vv_field_box(inputs[0]);
    negative_work work = {.info = info, .white = ((const negative_params *)params)->white, .job = job};
    void *data;
    vv_status st = vv_field_new_empty(out, &data, info, job);
    if (st != VV_OK)
        return st;
    work.out = data;
    if ((st = vv_field_brick(&work.in, inputs[0], &box, job)) == VV_OK) {
        st = vvi_parallel_for(job, &loop, &work, (size_t)info->grid.dims[2]);
        vv_brick_release(&work.in);
    }
    if (st != VV_OK) {
        vv_field_release(*out);
        *out = NULL;
    }
    return st;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    *out = inputs[0];
    return VV_OK;
}

const vv_operation vvi_operation_negative = {
    .api = VV_OPERATION_API,
    .name = "negative",
    .component = "filter",
    .doc = "turn light into dark, an example",
    .example = "volvis negative in.nrrd -o out.nrrd --white 255",
    .params = &negative_class,
    .min_inputs = 1,
    .max_inputs = 1,
    .run = run,
    .plan = plan,
};
