/* Bilateral filter (Tomasi & Manduchi 1998): the mean of what is near in place and in value. */
#include "core/cpu.h"
#include "core/job.h"
#include "core/memory.h"
#include "filter/noise.h"
#include "filter/real_samples.h"
#include "filter/sigma.h"
#include "filter/smoothing_kernel.h"
#include "filter/window.h"
#include "grid/making.h"
#include "registry.h"

#include <math.h>

#define CUT 3.0             /* sigmas that the ball reaches: what weighs a hundredth of the middle, and more */
#define SIGMA_MOST 100.0    /* voxels */
#define WINDOW_MOST 65536   /* samples: else one row is no longer done within the time to cancel */
#define TILE_MOST (1 << 17) /* numbers of a tile with its margin: what second-level caches hold */
#define NOISES 2.0          /* widths of values by themselves, in standard deviations of the noise */

typedef struct bilateral_params {
    vvi_sigma_params place;
    double value_sigma;
} bilateral_params;

enum { ROW_VALUE_SIGMA = 2 };

static const vv_property properties[] = {
    VVI_SIGMA_PROPERTIES,
    [ROW_VALUE_SIGMA] = {VV_PROP(bilateral_params, value_sigma), .kind = VV_KIND_F64, .unit = "value", .limited = true,
                         .min = 0, .max = 1e300, .automatic = "twice the noise, which is estimated",
                         .doc = "standard deviation of values: steps of several of these stay; 0 changes nothing"},
    {0},
};

static const vv_class bilateral_class = {
    .name = "bilateral",
    .doc = "parameters of bilateral",
    .size = sizeof(bilateral_params),
    .properties = properties,
    .check = vvi_sigma_check,
};

static vv_status radius_of(int64_t radius[3], double sigma[3], const vv_field_info *info, const vv_object *params)
{
    double samples = 1;
    vv_status st = vvi_sigma_voxels(sigma, info, params, "bilateral", SIGMA_MOST);
    if (st != VV_OK)
        return st;
    for (int a = 0; a < 3; a++) {
        radius[a] = (int64_t)floor(CUT * sigma[a]);
        samples *= (double)(2 * radius[a] + 1);
    }
    if (samples > WINDOW_MOST)
        return vv_fail(
            VV_E_ARGUMENT,
            "bilateral: with a sigma of %g, %g, %g voxels each sample has %g neighbours; it may have %d: give "
            "a smaller sigma",
            sigma[0], sigma[1], sigma[2], samples, WINDOW_MOST);
    return VV_OK;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    int64_t radius[3];
    double sigma[3];
    *out = inputs[0];
    if (inputs[0].meaning == VV_MEANING_LABEL)
        return vv_fail(VV_E_UNSUPPORTED, "bilateral: labels are names, not amounts, and have no mean");
    return radius_of(radius, sigma, &inputs[0], params);
}

typedef struct shared {
    vvi_making making;
    const vv_field_info *info;
    const vvi_smoothing_kernels *kernels;
    int64_t radius[3];
    double sigma[3];
    double *width; /* of the values of each component: where a weight has halved; 0: they stay */
    bool wide;
    vv_job *job;
} shared;

typedef struct scratch {
    char *tile, *row;
    vvi_bilateral_taps taps;
} scratch;

static void finish(void *scratch_in, void *user)
{
    (void)user;
    scratch *own = scratch_in;
    if (!own)
        return;
    vvi_free(own->tile);
    vvi_free(own->row);
    vvi_free(own->taps.offset);
    vvi_free(own->taps.weight);
    vvi_free(own);
}

static size_t window_of(const shared *s)
{
    return (size_t)((2 * s->radius[0] + 1) * (2 * s->radius[1] + 1) * (2 * s->radius[2] + 1));
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    (void)worker;
    const shared *s = user;
    const size_t each = vvi_reals_bytes(s->wide), n = window_of(s);
    size_t tile = VVI_SMOOTHING_GUARD;
    for (size_t a = 0, numbers = 1; a < 3; a++) {
        numbers *= (size_t)(s->making.slabs.step[a] + 2 * s->radius[a]);
        tile += a == 2 ? numbers : 0;
    }
    scratch *own = vvi_alloc_zeroed(s->job, sizeof *own, VVI_MEM_SCRATCH);
    if (!own)
        return vv_fail_memory(sizeof *own);
    own->tile = vvi_alloc_zeroed(s->job, tile * each, VVI_MEM_SCRATCH);
    own->row = vvi_alloc(s->job, ((size_t)s->making.slabs.step[0] + VVI_SMOOTHING_GUARD) * each, VVI_MEM_SCRATCH);
    own->taps.offset = vvi_alloc(s->job, n * sizeof *own->taps.offset, VVI_MEM_SCRATCH);
    own->taps.weight = vvi_alloc(s->job, n * sizeof *own->taps.weight, VVI_MEM_SCRATCH);
    if (!own->tile || !own->row || !own->taps.offset || !own->taps.weight) {
        finish(own, user);
        return vv_fail_memory(tile * each);
    }
    *scratch_out = own;
    return VV_OK;
}

/* All samples of the ball, in a tile whose rows have row_n numbers and whose slices have slice_n. */
static void make_taps(vvi_bilateral_taps *taps, const shared *s, int64_t row_n, int64_t slice_n)
{
    const int64_t *r = s->radius;
    taps->n = 0;
    for (int64_t k = -r[2]; k <= r[2]; k++)
        for (int64_t j = -r[1]; j <= r[1]; j++)
            for (int64_t i = -r[0]; i <= r[0]; i++) {
                const double at[3] = {(double)i, (double)j, (double)k};
                double far = 0;
                for (int a = 0; a < 3; a++)
                    far += r[a] ? at[a] / s->sigma[a] * (at[a] / s->sigma[a]) : 0;
                if (far > CUT * CUT)
                    continue;
                taps->offset[taps->n] = k * slice_n + j * row_n + i;
                taps->weight[taps->n++] = (float)(-0.5 * far / M_LN2);
            }
}

static vv_status write_tile(scratch *own, const shared *s, const vv_box *box, int64_t component)
{
    const size_t each = vvi_reals_bytes(s->wide), bytes = vv_type_bytes(s->info->type);
    const int64_t row_n = box->n[0] + 2 * s->radius[0], slice_n = row_n * (box->n[1] + 2 * s->radius[1]);
    vv_status st = VV_OK;
    vvi_reals_of_box(own->tile, s->wide, &s->making.brick, box, s->radius, component);
    make_taps(&own->taps, s, row_n, slice_n);
    for (int64_t k = 0; k < box->n[2] && st == VV_OK; k++)
        for (int64_t j = 0; j < box->n[1] && st == VV_OK; j++) {
            const int64_t at = vvi_slabs_row(&s->making.slabs, box, j, k) * s->info->components + component;
            const int64_t first = (k + s->radius[2]) * slice_n + (j + s->radius[1]) * row_n + s->radius[0];
            const char *row = own->tile + (size_t)first * each, *result = row;
            if (s->width[component] > 0) {
                s->kernels->bilateral[s->wide](own->row, row, &own->taps, s->width[component], box->n[0]);
                result = own->row;
            }
            vvi_samples_of_reals(s->making.out + (size_t)at * bytes, (int64_t)bytes * s->info->components,
                                 s->info->type, result, s->wide, box->n[0]);
            st = vvi_job_poll(s->job);
        }
    return st;
}

static vv_status item(void *scratch_in, void *user, size_t index)
{
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    vv_status st = VV_OK;
    for (int64_t c = 0; c < s->info->components && st == VV_OK; c++)
        st = write_tile(scratch_in, s, &box, c);
    return st;
}

/* In stored numbers. */
static vv_status find_widths(shared *s, const vv_object *params)
{
    const bool given = params->set >> ROW_VALUE_SIGMA & 1;
    const double least = s->wide ? 1e-300 : 1e-37; /* its inverse is finite */
    vv_status st = VV_OK;
    for (int c = 0; c < s->info->components && st == VV_OK; c++) {
        double sigma = ((const bilateral_params *)params)->value_sigma / fabs(s->info->value_scale);
        if (!given && (st = vvi_noise(&sigma, s->making.in, c, s->job)) == VV_OK)
            sigma *= NOISES;
        s->width[c] = sigma * sqrt(2 * M_LN2);
        s->width[c] = s->width[c] > least && isfinite(s->width[c]) ? s->width[c] : 0;
    }
    return st;
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "bilateral", .start = start, .item = item, .finish = finish};
    vv_field_info info;
    shared s = {.making = {.in = inputs[0]}, .info = &info, .job = job};
    *out = NULL;
    vv_status st = plan(&info, vv_field_get_info(inputs[0]), n_inputs, params);
    if (st == VV_OK)
        st = radius_of(s.radius, s.sigma, &info, params);
    if (st != VV_OK)
        return st;
    s.kernels = vvi_smoothing_kernels_for(vvi_job_cpu(job));
    s.wide = vvi_reals_wide(info.type);
    s.making.slabs = vvi_window_tiles(box, s.radius, TILE_MOST);
    const vv_box needed = vvi_window_reach(box, s.radius, info.grid.dims);
    s.width = vvi_alloc(job, (size_t)info.components * sizeof *s.width, VVI_MEM_SCRATCH);
    if (!s.width)
        return vv_fail_memory((size_t)info.components * sizeof *s.width);
    if ((st = find_widths(&s, params)) == VV_OK)
        st = vvi_making_run(out, &s.making, &info, box, &needed, &work, &s, job);
    vvi_free(s.width);
    return st;
}

const vv_operation vvi_operation_bilateral = {
    .api = VV_OPERATION_API,
    .name = "bilateral",
    .component = "filter",
    .group = "smoothing",
    .doc = "smooth and keep edges: the mean of the samples around each, weighed by how near they are in place and in "
           "value; beyond the border are the values of the border; each channel separately",
    .example = "volvis bilateral head.nrrd -o clean.nrrd --sigma 1.5mm --value-sigma 20",
    .params = &bilateral_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
    .carry = vv_carry_values,
};
