/* Diffusion by explicit steps, that stops at edges (Perona & Malik 1990): what flows between two neighbours is their
 * difference times a conductance that sinks as the difference grows. Steps are so short that no value leaves the range
 * of its neighbours (each keeps a share of itself that is not negative). Diffusion along structures is in coherence.c.
 */
#include "core/cpu.h"
#include "core/job.h"
#include "core/memory.h"
#include "filter/coherence.h"
#include "filter/diffuse_file.h"
#include "filter/diffuse_wave.h"
#include "filter/noise.h"
#include "filter/real_samples.h"
#include "filter/smoothed_samples.h"
#include "filter/smoothing_kernel.h"
#include "filter/window.h"
#include "registry.h"

#include <math.h>
#include <string.h>

enum { SLICES = 8, ITERATIONS_MOST = 10000 };
#define NOISES 3.0           /* the edge by itself, in standard deviations of the noise */
#define COHERENCE_NOISES 0.2 /* as much is left of it in smoothed differences, and more */

typedef struct diffuse_params {
    vv_object object;
    int method;
    int64_t iterations;
    double edge, step;
    int conductance;
    double sigma, rho, alpha;
} diffuse_params;

enum { ROW_METHOD, ROW_ITERATIONS, ROW_EDGE, ROW_STEP, ROW_CONDUCTANCE, ROW_SIGMA, ROW_RHO, ROW_ALPHA };
enum { PERONA_MALIK, COHERENCE };

static const char *const method_names[] = {"perona-malik", "coherence", NULL};

static const char *const conductance_names[] = {"exponential", "rational", NULL};

static const vv_property properties[] = {
    [ROW_METHOD] = {VV_PROP(diffuse_params, method), .kind = VV_KIND_ENUM, .names = method_names,
                    .doc = "stop at edges; or flow along structures such as fibres, vessels and stripes, which closes "
                           "gaps in them (Weickert)"},
    [ROW_ITERATIONS] = {VV_PROP(diffuse_params, iterations), .kind = VV_KIND_I64, .def = 10, .limited = true, .min = 0,
                        .max = ITERATIONS_MOST, .doc = "number of steps; more of them smooth farther"},
    [ROW_EDGE] = {VV_PROP(diffuse_params, edge), .kind = VV_KIND_F64, .unit = "value", .limited = true, .min = 0,
                  .max = 1e300, .automatic = "three times the noise, which is estimated; for coherence a fifth of it",
                  .doc =
                      "difference of values over a voxel (the smallest spacing) above which it is an edge, and stays; "
                      "0 changes nothing; for coherence, above which it is a structure that is followed"},
    [ROW_STEP] = {VV_PROP(diffuse_params, step), .kind = VV_KIND_F64, .limited = true, .min = 0, .max = 1,
                  .automatic = "half of the longest stable one, 1/12 for cubic voxels",
                  .doc = "time of a step, in squares of the smallest spacing; longer ones than 1 / (2 sum (smallest / "
                         "spacing)^2), 1/6 for cubic voxels, are not stable and refused"},
    [ROW_CONDUCTANCE] = {VV_PROP(diffuse_params, conductance), .kind = VV_KIND_ENUM, .names = conductance_names,
                         .when = "method=perona-malik",
                         .doc = "of a difference d where e is the edge: exp(-(d/e)^2), which keeps strong edges, or "
                                "1 / (1 + (d/e)^2), which keeps wide areas"},
    [ROW_SIGMA] = {VV_PROP(diffuse_params, sigma), .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH, .limited = true,
                   .min = 0, .max = 1e12, .automatic = "the smallest spacing", .when = "method=coherence",
                   .doc = "how far values are smoothed before their slopes are looked at, a standard deviation: 0.5mm, "
                          "1vox"},
    [ROW_RHO] = {VV_PROP(diffuse_params, rho), .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH, .limited = true, .min = 0,
                 .max = 1e12, .automatic = "three times sigma", .when = "method=coherence",
                 .doc = "how far slopes are compared, to know which way a structure goes, a standard deviation"},
    [ROW_ALPHA] = {VV_PROP(diffuse_params, alpha), .kind = VV_KIND_F64, .limited = true, .min = 0, .max = 1,
                   .def = 0.001, .when = "method=coherence",
                   .doc = "how much flows across structures, and where there are none; along them it is up to 1"},
    {0},
};

static const vv_class diffuse_class = {
    .name = "diffuse",
    .doc = "parameters of diffuse",
    .size = sizeof(diffuse_params),
    .properties = properties,
};

static bool is_set(const vv_object *object, int row)
{
    return object->set >> row & 1;
}

/* The axes' spacings over the smallest one, and the step. */
static vv_status step_of(double *step, double ratio[3], const vv_field_info *info, const vv_object *params)
{
    const double voxel = vv_grid_voxel(&info->grid);
    double sum = 0;
    for (int a = 0; a < 3; a++) {
        ratio[a] = vv_grid_spacing(&info->grid, a) / voxel;
        if (info->grid.dims[a] > 1)
            sum += 1 / (ratio[a] * ratio[a]);
    }
    if (((const diffuse_params *)params)->method == COHERENCE)
        sum = vvi_coherence_rate(&info->grid);
    const double longest = sum > 0 ? 0.5 / sum : 1;
    *step = is_set(params, ROW_STEP) ? ((const diffuse_params *)params)->step : 0.5 * longest;
    if (*step > longest * (1 + 1e-9))
        return vv_fail(VV_E_ARGUMENT,
                       "diffuse: a step of %g is not stable on this grid, the longest is %.6g: give a shorter one, and "
                       "more iterations",
                       *step, longest);
    return VV_OK;
}

/* Where it is asked for: all but the edge. */
static vv_status find_coherence(vvi_coherence *out, const vv_field_info *info, const vv_object *params)
{
    const diffuse_params *p = (const diffuse_params *)params;
    double ratio[3];
    *out = (vvi_coherence){.iterations = p->iterations, .alpha = p->alpha};
    if (p->method != COHERENCE)
        return VV_OK;
    out->sigma = is_set(params, ROW_SIGMA) ? p->sigma : vv_grid_voxel(&info->grid);
    out->rho = is_set(params, ROW_RHO) ? p->rho : 3 * out->sigma;
    vv_status st = step_of(&out->step, ratio, info, params);
    if (st == VV_OK)
        st = vvi_smoothed_check(&info->grid, out->sigma, "diffuse");
    return st == VV_OK ? vvi_smoothed_check(&info->grid, out->rho, "diffuse: rho") : st;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    (void)n_inputs;
    double step, ratio[3];
    *out = inputs[0];
    if (inputs[0].meaning == VV_MEANING_LABEL)
        return vv_fail(VV_E_UNSUPPORTED, "diffuse: labels are names, not amounts, and do not mix");
    vvi_coherence c;
    const vv_status st = step_of(&step, ratio, &inputs[0], params);
    return st == VV_OK ? find_coherence(&c, &inputs[0], params) : st;
}

/* A slab of one component on its way. */
typedef struct shared {
    const vv_field_info *info;
    const vvi_smoothing_kernels *kernels;
    vv_brick brick;    /* the slab's samples, with as many around as there are steps */
    vv_box box;        /* what is wanted of them */
    char *now, *next;  /* numbers of the brick */
    int64_t row_n;     /* of a row, with what fills it up to whole steps */
    double inverse[3]; /* of the difference along each axis that is an edge */
    double rate[3];
    bool rational, wide;
    int64_t component;
    char *out; /* the samples of the whole box */
    vv_box whole;
    uint64_t items_done, items_all;
    vv_job *job;
} shared;

static size_t row_bytes(const shared *s)
{
    return (size_t)s->row_n * vvi_reals_bytes(s->wide);
}

static char *row_at(char *numbers, const shared *s, int64_t j, int64_t k)
{
    return numbers + (size_t)(k * s->brick.box.n[1] + j) * row_bytes(s);
}

static vv_status load_item(void *scratch, void *user, size_t index)
{
    (void)scratch;
    const shared *s = user;
    const vv_brick *b = &s->brick;
    const int64_t k = (int64_t)index;
    for (int64_t j = 0; j < b->box.n[1]; j++)
        vvi_reals_of_samples(row_at(s->now, s, j, k), s->wide,
                             (const char *)b->data + j * b->stride[1] + k * b->stride[2] +
                                 s->component * (int64_t)vv_type_bytes(b->type),
                             b->stride[0], b->type, b->box.n[0]);
    return vvi_job_poll(s->job);
}

/* Fluxes: along x of a row, behind a number 0; along y of the last row and this one; along z of the last slice, and of
 * a row of this one. */
typedef struct scratch {
    char *x, *y[2], *z, *z_row;
} scratch;

static vv_status start(void **scratch_out, void *user, int worker)
{
    (void)worker;
    const shared *s = user;
    const size_t row = row_bytes(s), margin = VVI_SMOOTHING_GUARD * sizeof(double);
    const size_t bytes = sizeof(scratch) + 2 * margin + row * (4 + (size_t)s->brick.box.n[1]);
    scratch *own = vvi_alloc_zeroed(s->job, bytes, VVI_MEM_SCRATCH);
    if (!own)
        return vv_fail_memory(bytes);
    own->x = (char *)(own + 1) + margin;
    own->y[0] = own->x + row;
    own->y[1] = own->y[0] + row;
    own->z_row = own->y[1] + row;
    own->z = own->z_row + row;
    *scratch_out = own;
    return VV_OK;
}

static void finish(void *scratch_in, void *user)
{
    (void)user;
    vvi_free(scratch_in);
}

/* What flows to the next row along an axis; nothing through the border. */
static void flux(char *out, const shared *s, int axis, int64_t j, int64_t k)
{
    const int64_t *n = s->brick.box.n;
    const bool inside = axis == 1 ? j >= 0 && j + 1 < n[1] : k >= 0 && k + 1 < n[2];
    if (inside)
        s->kernels->flux[s->wide](out, row_at(s->now, s, j, k), row_at(s->now, s, j + (axis == 1), k + (axis == 2)),
                                  s->inverse[axis], s->rational, s->row_n);
    else
        memset(out, 0, row_bytes(s));
}

static void step_row(const shared *s, scratch *own, int64_t j, int64_t k)
{
    const size_t each = vvi_reals_bytes(s->wide);
    const char *row = row_at(s->now, s, j, k);
    char *z = own->z + (size_t)j * row_bytes(s), *y = own->y[j & 1], *y_before = own->y[!(j & 1)];
    s->kernels->flux[s->wide](own->x, row, row + each, s->inverse[0], s->rational, s->row_n);
    memset(own->x + (size_t)(s->brick.box.n[0] - 1) * each, 0, each);
    flux(y, s, 1, j, k);
    flux(own->z_row, s, 2, j, k);
    const void *const all[6] = {own->x - each, own->x, y_before, y, z, own->z_row};
    s->kernels->spread[s->wide](row_at(s->next, s, j, k), row, all, s->rate, s->row_n);
    memcpy(z, own->z_row, row_bytes(s));
}

static vv_status step_item(void *scratch_in, void *user, size_t index)
{
    const shared *s = user;
    const int64_t *n = s->brick.box.n, first = (int64_t)index * SLICES;
    const int64_t end = first + SLICES < n[2] ? first + SLICES : n[2];
    scratch *own = scratch_in;
    vv_status st = VV_OK;
    for (int64_t j = 0; j < n[1]; j++)
        flux(own->z + (size_t)j * row_bytes(s), s, 2, j, first - 1);
    for (int64_t k = first; k < end && st == VV_OK; k++) {
        memset(own->y[1], 0, row_bytes(s));
        for (int64_t j = 0; j < n[1]; j++)
            step_row(s, own, j, k);
        st = vvi_job_poll(s->job);
    }
    return st;
}

static vv_status store_item(void *scratch_in, void *user, size_t index)
{
    (void)scratch_in;
    const shared *s = user;
    const vv_box *box = &s->box, *from = &s->brick.box, *whole = &s->whole;
    const int64_t each = (int64_t)vv_type_bytes(s->info->type) * s->info->components, k = box->lo[2] + (int64_t)index;
    for (int64_t j = box->lo[1]; j < box->lo[1] + box->n[1]; j++) {
        const int64_t at = ((k - whole->lo[2]) * whole->n[1] + j - whole->lo[1]) * whole->n[0];
        const char *row = row_at(s->now, s, j - from->lo[1], k - from->lo[2]);
        vvi_samples_of_reals(s->out + at * each + s->component * (int64_t)vv_type_bytes(s->info->type), each,
                             s->info->type, row + (size_t)(box->lo[0] - from->lo[0]) * vvi_reals_bytes(s->wide),
                             s->wide, box->n[0]);
    }
    return vvi_job_poll(s->job);
}

static vv_status loop(shared *s, vvi_work work, size_t n)
{
    work.stage = "diffuse";
    work.n_before = s->items_done;
    s->items_done += n;
    work.n_after = s->items_all > s->items_done ? s->items_all - s->items_done : 0;
    return vvi_parallel_for(s->job, &work, s, n);
}

static vv_status diffuse_slab(shared *s, int64_t iterations)
{
    const vvi_work load = {.item = load_item}, store = {.item = store_item};
    const vvi_work step = {.start = start, .item = step_item, .finish = finish};
    vv_status st = loop(s, load, (size_t)s->brick.box.n[2]);
    for (int64_t i = 0; i < iterations && st == VV_OK; i++) {
        st = loop(s, step, (size_t)((s->brick.box.n[2] + SLICES - 1) / SLICES));
        char *const was = s->now;
        s->now = s->next;
        s->next = was;
    }
    return st == VV_OK ? loop(s, store, (size_t)s->box.n[2]) : st;
}

/* In stored numbers. */
static vv_status edge_of(double *edge, const vv_field *in, int component, const vv_object *params, vv_job *job)
{
    const diffuse_params *p = (const diffuse_params *)params;
    *edge = p->edge / fabs(vv_field_get_info(in)->value_scale);
    if (is_set(params, ROW_EDGE))
        return VV_OK;
    const vv_status st = vvi_noise(edge, in, component, job);
    *edge *= p->method == COHERENCE ? COHERENCE_NOISES : NOISES;
    return st;
}

/* An edge of nothing lets nothing through. */
static vv_status find_edge(shared *s, const vv_field *in, const vv_object *params, const double ratio[3], double step)
{
    double edge = 0;
    const vv_status st = edge_of(&edge, in, (int)s->component, params, s->job);
    for (int a = 0; a < 3; a++) {
        const double inverse = (s->rational ? 1 : sqrt(1 / M_LN2)) / (edge * ratio[a]);
        const bool none = !(inverse < (s->wide ? 1e300 : 1e37));
        s->inverse[a] = none ? 0 : inverse;
        s->rate[a] = none ? 0 : step / (ratio[a] * ratio[a]);
    }
    return st;
}

/* Of all slices at once: their numbers before and after a step. */
static vv_status diffuse_all(shared *s, const vv_field *in, int64_t iterations)
{
    const size_t bytes =
        row_bytes(s) * (size_t)(s->brick.box.n[1] * s->brick.box.n[2]) + VVI_SMOOTHING_GUARD * sizeof(double);
    const vv_box reach = s->brick.box;
    char *const room[2] = {vvi_alloc_zeroed(s->job, bytes, VVI_MEM_SCRATCH),
                           vvi_alloc_zeroed(s->job, bytes, VVI_MEM_SCRATCH)};
    vv_status st = room[0] && room[1] ? VV_OK : vv_fail_memory(bytes);
    s->now = room[0];
    s->next = room[1];
    if (st == VV_OK && (st = vv_field_brick(&s->brick, in, &reach, s->job)) == VV_OK)
        st = diffuse_slab(s, iterations);
    vv_brick_release(&s->brick);
    s->brick.box = reach;
    vvi_free(room[0]);
    vvi_free(room[1]);
    return st;
}

static vvi_diffuse_wave wave_of(const shared *s, const vv_field *in, int64_t iterations)
{
    const int64_t type = (int64_t)vv_type_bytes(s->info->type);
    vvi_diffuse_wave w = {.in = in,
                          .kernels = s->kernels,
                          .rational = s->rational,
                          .wide = s->wide,
                          .component = s->component,
                          .iterations = iterations,
                          .box = s->whole,
                          .out = s->out ? s->out + s->component * type : NULL,
                          .type = s->info->type,
                          .step = type * s->info->components,
                          .job = s->job};
    memcpy(w.inverse, s->inverse, sizeof w.inverse);
    memcpy(w.rate, s->rate, sizeof w.rate);
    return w;
}

/* The same, slice after slice, in less memory. */
static vv_status diffuse_wave(const shared *s, const vv_field *in, int64_t iterations)
{
    const vvi_diffuse_wave w = wave_of(s, in, iterations);
    const vv_status st = vvi_memory_plan(s->job, (uint64_t)fmin(vvi_diffuse_wave_bytes(&w), 1e18), "diffuse");
    return st == VV_OK ? vvi_diffuse_wave_run(&w) : st;
}

/* The numbers of all slices may take a quarter of the memory. */
static bool fits(const shared *s)
{
    const double room = s->job ? (double)vv_runtime_memory_limit(vv_job_runtime(s->job)) / 4 : INFINITY;
    return 2 * (double)row_bytes(s) * (double)s->brick.box.n[1] * (double)s->brick.box.n[2] <= room;
}

static vv_status diffuse(shared *s, const vv_field *in, const vv_object *params)
{
    const int64_t iterations = ((const diffuse_params *)params)->iterations, *dims = s->info->grid.dims;
    const int64_t halo[3] = {dims[0] > 1 ? iterations : 0, dims[1] > 1 ? iterations : 0, dims[2] > 1 ? iterations : 0};
    double ratio[3], step;
    vv_status st = step_of(&step, ratio, s->info, params);
    s->brick.box = vvi_window_reach(&s->whole, halo, dims);
    s->box = s->whole;
    s->row_n = (s->brick.box.n[0] + VVI_SMOOTHING_STEP - 1) / VVI_SMOOTHING_STEP * VVI_SMOOTHING_STEP;
    for (s->component = 0; s->component < s->info->components && st == VV_OK; s->component++)
        if ((st = find_edge(s, in, params, ratio, step)) == VV_OK)
            st = iterations == 0 || fits(s) ? diffuse_all(s, in, iterations) : diffuse_wave(s, in, iterations);
    return st;
}

/* For the progress: nearly, where slabs differ. */
static uint64_t items_of(const shared *s, int64_t iterations)
{
    const uint64_t n = (uint64_t)s->whole.n[2];
    return (uint64_t)s->info->components * (2 * n + (uint64_t)iterations * ((n + SLICES - 1) / SLICES));
}

/* Tensors are smoothed over and over: each sample depends on those far away, and all are needed at once. */
static vv_status follow(shared *s, const vv_field *in, const vv_object *params)
{
    const vv_box all = vv_field_box(in);
    vvi_coherence c;
    vv_status st = find_coherence(&c, s->info, params);
    if (st == VV_OK && memcmp(&all, &s->whole, sizeof all) != 0)
        return vv_fail(VV_E_LIMIT, "diffuse: coherence needs all samples in memory at once: raise the limit with "
                                   "--memory, or crop the volume");
    if (st == VV_OK)
        st = vvi_coherence_plan(s->info, s->job);
    for (int component = 0; component < s->info->components && st == VV_OK; component++)
        if ((st = edge_of(&c.edge, in, component, params, s->job)) == VV_OK)
            st = vvi_coherence_run(s->out, in, component, &c, s->job);
    return st;
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    const diffuse_params *p = (const diffuse_params *)params;
    vv_field_info info, part;
    vv_field *field;
    void *data;
    shared s = {.info = &info, .whole = *box, .rational = p->conductance == 1, .job = job};
    *out = NULL;
    vv_status st = plan(&info, vv_field_get_info(inputs[0]), n_inputs, params);
    if (st != VV_OK)
        return st;
    part = info;
    part.grid = vv_grid_crop(&info.grid, box);
    if ((st = vv_field_new_empty(&field, &data, &part, job)) != VV_OK)
        return st;
    s.kernels = vvi_smoothing_kernels_for(vvi_job_cpu(job));
    s.wide = vvi_reals_wide(info.type);
    s.out = data;
    s.items_all = items_of(&s, p->iterations);
    st = p->method == COHERENCE ? follow(&s, inputs[0], params) : diffuse(&s, inputs[0], params);
    if (st == VV_OK)
        *out = field;
    else
        vv_field_release(field);
    return st;
}

static uint64_t memory(const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    return ((const diffuse_params *)params)->method == COHERENCE ? vvi_coherence_memory(&inputs[0]) : 0;
}

/* Streamed: some steps at a time, through a temporary file. */
static uint64_t scratch_bytes(const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    (void)n_inputs;
    return ((const diffuse_params *)params)->iterations > 0 ? vvi_diffuse_file_bytes(&inputs[0]) : 0;
}

static vv_status find(void **state_out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                      vv_job *job)
{
    (void)n_inputs;
    const diffuse_params *p = (const diffuse_params *)params;
    const vv_field_info *info = vv_field_get_info(inputs[0]);
    shared s = {.info = info, .whole = vv_field_box(inputs[0]), .rational = p->conductance == 1, .job = job};
    double ratio[3], step;
    vvi_diffuse_file *file = NULL;
    *state_out = NULL;
    if (p->iterations == 0)
        return VV_OK;
    s.kernels = vvi_smoothing_kernels_for(vvi_job_cpu(job));
    s.wide = vvi_reals_wide(info->type);
    vv_status st = step_of(&step, ratio, info, params);
    if (st == VV_OK)
        st = vvi_diffuse_file_new(&file, inputs[0], job);
    for (s.component = 0; s.component < info->components && st == VV_OK; s.component++)
        if ((st = find_edge(&s, inputs[0], params, ratio, step)) == VV_OK) {
            const vvi_diffuse_wave w = wave_of(&s, inputs[0], p->iterations);
            st = vvi_diffuse_file_run(file, &w);
        }
    if (st == VV_OK)
        st = vv_field_health(inputs[0]);
    if (st == VV_OK)
        *state_out = file;
    else
        vvi_diffuse_file_free(file);
    return st;
}

static vv_status make(vv_field **out, void *state, const vv_field *const *inputs, size_t n_inputs,
                      const vv_object *params, const vv_box *box, vv_job *job)
{
    (void)inputs;
    (void)n_inputs;
    (void)params;
    return vvi_diffuse_file_slices(out, state, box, job);
}

static void drop(void *state)
{
    vvi_diffuse_file_free(state);
}

static const vv_passes passes = {.find = find, .make = make, .drop = drop, .scratch = scratch_bytes};

const vv_operation vvi_operation_diffuse = {
    .api = VV_OPERATION_API,
    .name = "diffuse",
    .component = "filter",
    .group = "smoothing",
    .doc = "smooth and keep edges by diffusion that stops at them (Perona & Malik), or that flows along structures "
           "(Weickert); nothing flows through the border; each channel separately",
    .example = "volvis diffuse head.nrrd -o clean.nrrd --iterations 20 --edge 15",
    .params = &diffuse_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
    .memory = memory,
    .passes = &passes,
    .carry = vv_carry_values,
};
