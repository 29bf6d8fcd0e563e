/* Gradient and Laplacian: differences between neighbours, per world length. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/vec.h"
#include "filter/slopes_kernel.h"
#include "filter/smoothed_samples.h"
#include "filter/window.h"
#include "grid/making.h"
#include "registry.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define TILE_MOST 40000 /* numbers with their margin: they stay in the second-level cache */

typedef struct slope_params {
    vv_object object;
    double sigma;
    bool vector;
} slope_params;

#define SIGMA_PROPERTY                                                                                                 \
    {                                                                                                                  \
        VV_PROP(slope_params, sigma),                                                                                  \
            .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH, .limited = true, .min = 0, .max = 1e12,                      \
            .doc = "smooth first with a Gaussian of this standard deviation, a length: 1.5mm, 2vox; 0: not at all"     \
    }

static const vv_property gradient_properties[] = {
    SIGMA_PROPERTY,
    {VV_PROP(slope_params, vector), .kind = VV_KIND_BOOL,
     .doc = "the three components along the world axes, not their length; of one channel"},
    {0},
};

static const vv_property laplacian_properties[] = {SIGMA_PROPERTY, {0}};

static const vv_class gradient_class = {
    .name = "gradient",
    .doc = "parameters of gradient",
    .size = sizeof(slope_params),
    .properties = gradient_properties,
};

static const vv_class laplacian_class = {
    .name = "laplacian",
    .doc = "parameters of laplacian",
    .size = sizeof(slope_params),
    .properties = laplacian_properties,
};

/* "HU/mm", "HU/mm^2"; nothing where the unit of values is not known, or it is too long. */
static void set_unit(vv_field_info *out, const char *behind)
{
    char unit[40] = "";
    const size_t length = strlen(out->grid.unit);
    const bool plural = strcmp(out->grid.unit, "voxels") == 0 || strcmp(out->grid.unit, "units") == 0;
    if (out->value_unit[0])
        snprintf(unit, sizeof unit, "%s/%.*s%s", out->value_unit, (int)(length - plural), out->grid.unit, behind);
    if (strlen(unit) >= sizeof out->value_unit)
        unit[0] = 0;
    memcpy(out->value_unit, unit, sizeof out->value_unit);
}

static vv_status plan_any(vv_field_info *out, const vv_field_info *in, const slope_params *p, const char *name,
                          const char *behind)
{
    *out = *in;
    if (in->meaning == VV_MEANING_LABEL)
        return vv_fail(VV_E_UNSUPPORTED, "%s: labels are names, not amounts, and have no slope", name);
    out->type = VV_TYPE_F32;
    out->meaning = VV_MEANING_SCALAR;
    out->value_scale = 1;
    out->value_offset = 0;
    set_unit(out, behind);
    return vvi_smoothed_check(&in->grid, p->sigma, name);
}

static vv_status gradient_plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs,
                               const vv_object *params)
{
    const slope_params *p = (const slope_params *)params;
    const vv_status st = plan_any(out, &inputs[0], p, "gradient", "");
    if (st != VV_OK || !p->vector)
        return st;
    if (inputs[0].components != 1)
        return vv_fail(VV_E_UNSUPPORTED,
                       "gradient: `vector` is of one channel, and there are %d; take one of them with "
                       "the operation `channel`",
                       inputs[0].components);
    out->components = 3;
    out->meaning = VV_MEANING_VECTOR;
    return VV_OK;
}

static vv_status laplacian_plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs,
                                const vv_object *params)
{
    return plan_any(out, &inputs[0], (const slope_params *)params, "laplacian", "^2");
}

/* Numbers of a tile and one more to each side; NaN where there are none. */
typedef struct tile {
    vv_box box;
    int64_t n[3];
    int64_t component;
} tile;

typedef struct shared {
    vvi_making making;
    vv_field_info info; /* of the result */
    vv_type from;
    vvi_slopes slopes; /* but for the steps, which are a tile's */
    vvi_slopes_row *row;
    int outs; /* numbers of one of the row's results */
    vv_job *job;
} shared;

typedef struct scratch {
    double *numbers, *row, *samples;
} scratch;

static void finish(void *scratch_in, void *user)
{
    scratch *own = scratch_in;
    if (!own)
        return;
    vvi_free(own->numbers);
    vvi_free(own->row);
    vvi_free(own->samples);
    vvi_free(own);
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const int64_t *step = s->making.slabs.step;
    const size_t row = (size_t)(step[0] + 2) * sizeof(double);
    const size_t numbers = row * (size_t)((step[1] + 2) * (step[2] + 2)) + VVI_SLOPES_GUARD * sizeof(double);
    const size_t samples = row * (size_t)s->making.brick.components;
    scratch *own = vvi_alloc_zeroed(s->job, sizeof *own, VVI_MEM_SCRATCH);
    if (!own)
        return vv_fail_memory(sizeof *own);
    own->numbers = vvi_alloc_zeroed(s->job, numbers, VVI_MEM_SCRATCH);
    own->row = vvi_alloc(s->job, row * (size_t)s->outs, VVI_MEM_SCRATCH);
    own->samples = vvi_alloc(s->job, samples, VVI_MEM_SCRATCH);
    if (!own->numbers || !own->row || !own->samples) {
        finish(own, user);
        return vv_fail_memory(numbers + row + samples);
    }
    *scratch_out = own;
    return VV_OK;
}

static void load_row(double *out, const scratch *own, const shared *s, const tile *t, int64_t j, int64_t k)
{
    const vv_brick *b = &s->making.brick;
    const int64_t *lo = b->box.lo, x = t->box.lo[0] - 1, y = t->box.lo[1] - 1 + j, z = t->box.lo[2] - 1 + k;
    const int64_t first = x < lo[0] ? lo[0] : x;
    const int64_t last = x + t->n[0] < lo[0] + b->box.n[0] ? x + t->n[0] : lo[0] + b->box.n[0];
    for (int64_t i = 0; i < t->n[0]; i++)
        out[i] = NAN;
    if (y < lo[1] || y >= lo[1] + b->box.n[1] || z < lo[2] || z >= lo[2] + b->box.n[2])
        return;
    const char *in = (const char *)b->data + (first - lo[0]) * b->stride[0] + (y - lo[1]) * b->stride[1] +
                     (z - lo[2]) * b->stride[2];
    if (b->components == 1) {
        vvi_samples_to_f64(out + (first - x), in, s->from, (size_t)(last - first));
        return;
    }
    vvi_samples_to_f64(own->samples, in, s->from, (size_t)((last - first) * b->components));
    for (int64_t i = first; i < last; i++)
        out[i - x] = own->samples[(i - first) * b->components + t->component];
}

static vv_status write_tile(const scratch *own, const shared *s, tile *t)
{
    const int64_t step[3] = {1, t->n[0], t->n[0] * t->n[1]};
    vvi_slopes slopes = s->slopes;
    const int64_t components = s->info.components, n = t->box.n[0];
    memcpy(slopes.step, step, sizeof step);
    for (int64_t k = 0; k < t->n[2]; k++)
        for (int64_t j = 0; j < t->n[1]; j++)
            load_row(own->numbers + k * step[2] + j * step[1], own, s, t, j, k);
    for (int64_t k = 0; k < t->box.n[2]; k++)
        for (int64_t j = 0; j < t->box.n[1]; j++) {
            const double *row = own->numbers + (k + 1) * step[2] + (j + 1) * step[1] + 1;
            float *out = (float *)(void *)s->making.out + vvi_slabs_row(&s->making.slabs, &t->box, j, k) * components;
            s->row(own->row, row, &slopes, n);
            if (components == s->outs)
                vvi_samples_from_f64(out, own->row, VV_TYPE_F32, (size_t)(n * s->outs));
            else
                for (int64_t i = 0; i < n; i++)
                    vvi_samples_from_f64(out + i * components + t->component, own->row + i, VV_TYPE_F32, 1);
        }
    return vvi_job_poll(s->job);
}

static vv_status item(void *scratch_in, void *user, size_t index)
{
    const shared *s = user;
    tile t = {.box = vvi_slabs_item(&s->making.slabs, index)};
    vv_status st = VV_OK;
    for (int a = 0; a < 3; a++)
        t.n[a] = t.box.n[a] + 2;
    for (; t.component < s->making.brick.components && st == VV_OK; t.component++)
        st = write_tile(scratch_in, s, &t);
    return st;
}

/* Slopes along index axes are covariant: they turn with the inverse of the grid's map. A scale of values goes in. */
static void set_world(shared *s, const vv_field_info *info)
{
    vv_affine inverse = vv_affine_identity();
    vv_affine_invert(&inverse, info->grid.index_to_world);
    const vv_vec3 *c = inverse.axis;
    const vv_vec3 rows[3] = {{c[0].x, c[1].x, c[2].x}, {c[0].y, c[1].y, c[2].y}, {c[0].z, c[1].z, c[2].z}};
    for (int a = 0; a < 3; a++) {
        const double turn[3] = {rows[a].x * info->value_scale, rows[a].y * info->value_scale,
                                rows[a].z * info->value_scale};
        memcpy(s->slopes.world[a], turn, sizeof turn);
        s->slopes.lone[a] = info->grid.dims[a] > 1 ? NAN : 0;
        for (int b = 0; b < 3; b++) {
            const double d = vvi_dot(rows[a], rows[b]);
            const bool none = fabs(d) <= 1e-12 * vvi_length(rows[a]) * vvi_length(rows[b]);
            s->slopes.second[a][b] = none ? 0 : d * info->value_scale;
        }
    }
}

/* What is smoothed first is a field of its own, as large as the box and its neighbours. */
static vv_status run_any(vv_field **out, shared *s, const vv_field *in, double sigma, const vv_box *box, vv_job *job)
{
    const vvi_work work = {.stage = "differences", .start = start, .item = item, .finish = finish};
    static const int64_t one[3] = {1, 1, 1};
    const vv_field_info *info = vv_field_get_info(in);
    const vv_box around = vvi_window_reach(box, one, info->grid.dims);
    vv_box here = *box, needed = around;
    vv_field *smooth = NULL;
    vv_status st = VV_OK;
    set_world(s, info);
    s->job = job;
    if (sigma > 0) {
        st = vvi_smoothed(&smooth, in, &around, sigma, job);
        for (int a = 0; a < 3; a++) {
            here.lo[a] -= around.lo[a];
            needed.lo[a] = 0;
        }
    }
    if (st == VV_OK) {
        s->making.in = smooth ? smooth : in;
        s->from = vv_field_get_info(s->making.in)->type;
        if (smooth)
            s->info.grid = vv_field_get_info(smooth)->grid;
        s->making.slabs = vvi_window_tiles(&here, one, TILE_MOST);
        st = vvi_making_run(out, &s->making, &s->info, &here, &needed, &work, s, job);
    }
    vv_field_release(smooth);
    return st;
}

static vv_status gradient_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                              const vv_box *box, vv_job *job)
{
    const slope_params *p = (const slope_params *)params;
    const vvi_slopes_kernels *kernels = vvi_slopes_kernels_for(vvi_job_cpu(job));
    shared s = {.row = p->vector ? kernels->vector : kernels->length, .outs = p->vector ? 3 : 1};
    *out = NULL;
    const vv_status st = gradient_plan(&s.info, vv_field_get_info(inputs[0]), n_inputs, params);
    return st == VV_OK ? run_any(out, &s, inputs[0], p->sigma, box, job) : st;
}

static vv_status laplacian_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                               const vv_box *box, vv_job *job)
{
    shared s = {.row = vvi_slopes_kernels_for(vvi_job_cpu(job))->laplacian, .outs = 1};
    *out = NULL;
    const vv_status st = laplacian_plan(&s.info, vv_field_get_info(inputs[0]), n_inputs, params);
    return st == VV_OK ? run_any(out, &s, inputs[0], ((const slope_params *)params)->sigma, box, job) : st;
}

const vv_operation vvi_operation_gradient = {
    .api = VV_OPERATION_API,
    .name = "gradient",
    .component = "filter",
    .group = "edges",
    .doc =
        "the length of the gradient: how steep values are, per world length, by central differences; with --vector the "
        "gradient itself; each "
        "channel separately",
    .example = "volvis gradient head.nrrd -o edges.nrrd --sigma 1mm",
    .params = &gradient_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = gradient_box,
    .plan = gradient_plan,
};

const vv_operation vvi_operation_laplacian = {
    .api = VV_OPERATION_API,
    .name = "laplacian",
    .component = "filter",
    .group = "edges",
    .doc = "the sum of second derivatives in the world: above 0 where a value lies below those around it; each channel "
           "separately",
    .example = "volvis laplacian head.nrrd -o edges.nrrd --sigma 1mm",
    .params = &laplacian_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = laplacian_box,
    .plan = laplacian_plan,
};
