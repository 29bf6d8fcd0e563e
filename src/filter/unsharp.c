/* Unsharp masking: what a Gaussian takes away is added once more. */
#include "core/memory.h"
#include "filter/smoothed_samples.h"
#include "grid/making.h"
#include "registry.h"

#include <math.h>
#include <string.h>

typedef struct unsharp_params {
    vv_object object;
    double sigma, amount, threshold;
} unsharp_params;

static const vv_property properties[] = {
    {VV_PROP(unsharp_params, sigma), .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH, .limited = true, .min = 0,
     .max = 1e12, .automatic = "the smallest spacing",
     .doc = "standard deviation of the Gaussian, a length: 1.5mm, 2vox; 0 changes nothing"},
    {VV_PROP(unsharp_params, amount), .kind = VV_KIND_F64, .limited = true, .min = -1, .max = 1000, .def = 1,
     .doc = "how much of the difference from the smoothed value is added; -1 smooths"},
    {VV_PROP(unsharp_params, threshold), .kind = VV_KIND_F64, .unit = "value", .limited = true, .min = 0, .max = 1e300,
     .doc = "smaller differences are left as they are"},
    {0},
};

static const vv_class unsharp_class = {
    .name = "unsharp",
    .doc = "parameters of unsharp",
    .size = sizeof(unsharp_params),
    .properties = properties,
};

static double sigma_of(const vv_grid *grid, const vv_object *params)
{
    return params->set & 1 ? ((const unsharp_params *)params)->sigma : vv_grid_voxel(grid);
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    *out = inputs[0];
    if (inputs[0].meaning == VV_MEANING_LABEL)
        return vv_fail(VV_E_UNSUPPORTED, "unsharp: labels are names, not amounts, and have no mean");
    return vvi_smoothed_check(&inputs[0].grid, sigma_of(&inputs[0].grid, params), "unsharp");
}

typedef struct shared {
    vvi_making making;
    vv_brick smooth; /* of the same box */
    vv_type type, smooth_type;
    double amount, threshold; /* of stored numbers */
    vv_job *job;
} shared;

static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const size_t n = 2 * (size_t)(s->making.slabs.step[0] * s->making.brick.components);
    *scratch_out = vvi_alloc(s->job, n * sizeof(double), VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(n * sizeof(double));
}

static void finish(void *scratch, void *user)
{
    vvi_free(scratch);
}

/* What is not finite stays: bits and all. */
static void sharpen_row(char *out, const char *in, double *v, const double *smooth, const shared *s, size_t n)
{
    const size_t each = vv_type_bytes(s->type);
    for (size_t i = 0; i < n; i++) {
        const double difference = v[i] - smooth[i];
        v[i] += fabs(difference) >= s->threshold ? s->amount * difference : 0;
    }
    vvi_samples_from_f64(out, v, s->type, n);
    if (!vv_type_is_float(s->type))
        return;
    for (size_t i = 0; i < n; i++)
        if (smooth[i] - smooth[i] != 0)
            memcpy(out + i * each, in + i * each, each);
}

static vv_status item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const vv_brick in = vvi_brick_part(&s->making.brick, &box);
    const int64_t *lo = s->making.slabs.box.lo, each = (int64_t)vv_type_bytes(s->type) * in.components;
    const size_t n = (size_t)(box.n[0] * in.components);
    double *v = scratch, *smooth = v + n;
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            const char *from = (const char *)in.data + j * in.stride[1] + k * in.stride[2];
            const char *beside = (const char *)s->smooth.data + (box.lo[0] - lo[0]) * s->smooth.stride[0] +
                                 (box.lo[1] - lo[1] + j) * s->smooth.stride[1] +
                                 (box.lo[2] - lo[2] + k) * s->smooth.stride[2];
            vvi_samples_to_f64(v, from, s->type, n);
            vvi_samples_to_f64(smooth, beside, s->smooth_type, n);
            sharpen_row(s->making.out + vvi_slabs_row(&s->making.slabs, &box, j, k) * each, from, v, smooth, s, n);
        }
    return VV_OK;
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "unsharp", .start = start, .item = item, .finish = finish};
    const unsharp_params *p = (const unsharp_params *)params;
    vv_field_info info;
    vv_field *smooth = NULL;
    *out = NULL;
    vv_status st = plan(&info, vv_field_get_info(inputs[0]), n_inputs, params);
    if (st == VV_OK)
        st = vvi_smoothed(&smooth, inputs[0], box, sigma_of(&info.grid, params), job);
    if (st != VV_OK)
        return st;
    shared s = {.making = {.in = inputs[0], .slabs = vvi_slabs_of(box, 1 << 16)}, .type = info.type, .job = job};
    const vv_box all = vv_field_box(smooth);
    s.smooth_type = vv_field_get_info(smooth)->type;
    s.amount = p->amount;
    s.threshold = p->threshold / fabs(info.value_scale);
    if ((st = vv_field_brick(&s.smooth, smooth, &all, job)) == VV_OK)
        st = vvi_making_run(out, &s.making, &info, box, box, &work, &s, job);
    vv_brick_release(&s.smooth);
    vv_field_release(smooth);
    return st;
}

const vv_operation vvi_operation_unsharp = {
    .api = VV_OPERATION_API,
    .name = "unsharp",
    .component = "filter",
    .group = "edges",
    .doc = "sharpen (unsharp masking): add what a Gaussian takes away once more; rounded, and held within the range of "
           "the type; each "
           "channel separately",
    .example = "volvis unsharp head.nrrd -o sharp.nrrd --sigma 1mm --amount 0.5",
    .params = &unsharp_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
    .carry = vv_carry_values,
};
