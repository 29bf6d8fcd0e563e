/* Add noise: what detectors add to values, from a generator without a state: the noise of a sample depends on the seed
 * and the number of the sample alone. */
#include "core/cpu.h"
#include "core/findings.h"
#include "core/job.h"
#include "core/memory.h"
#include "filter/amounts.h"
#include "filter/normals_kernel.h"
#include "grid/making.h"
#include "grid/percentile.h"
#include "registry.h"

#include <math.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 14)
#define ROW 512 /* normal numbers that are made at once */
#define TWO_PI 6.283185307179586
#define SHARE 0.05 /* of the range of values, that sigma is by itself */

typedef struct add_noise_params {
    vv_object object;
    int kind;
    double sigma, counts, fraction, pepper, salt;
    int64_t seed;
    bool settled; /* no property: see settle() */
    double found; /* sigma, of all samples */
} add_noise_params;

enum { ROW_KIND, ROW_SIGMA, ROW_COUNTS, ROW_FRACTION, ROW_PEPPER, ROW_SALT, ROW_SEED };
enum { GAUSSIAN, POISSON, SALT_AND_PEPPER, RICIAN };

static const char *const kind_names[] = {"gaussian", "poisson", "salt-and-pepper", "rician", NULL};

static const vv_property properties[] = {
    [ROW_KIND] =
        {VV_PROP(add_noise_params, kind), .kind = VV_KIND_ENUM, .names = kind_names,
         .doc = "gaussian; poisson: of counts, whose variance is their mean; salt-and-pepper: some samples "
                "become the smallest or the largest value; rician: of the magnitude of a complex number, as in MR"},
    [ROW_SIGMA] = {VV_PROP(add_noise_params, sigma), .kind = VV_KIND_F64, .unit = "value", .limited = true, .min = 0,
                   .max = 1e300, .when = "kind=gaussian|rician",
                   .automatic = "5 % of the range of values, from the 0.1 to the 99.9 percentile",
                   .doc = "standard deviation; of rician noise that of each part of the complex number"},
    [ROW_COUNTS] = {VV_PROP(add_noise_params, counts), .kind = VV_KIND_F64, .limited = true, .min = 1e-9, .max = 1e9,
                    .def = 1, .when = "kind=poisson",
                    .doc = "how many counts a value of 1 is: the larger, the less noise; values below 0 have none"},
    [ROW_FRACTION] = {VV_PROP(add_noise_params, fraction), .kind = VV_KIND_F64, .quantity = VV_Q_RATIO, .limited = true,
                      .min = 0, .max = 1, .def = 0.05, .when = "kind=salt-and-pepper",
                      .doc = "how many samples change: half of them to pepper, half to salt"},
    [ROW_PEPPER] = {VV_PROP(add_noise_params, pepper), .kind = VV_KIND_F64, .unit = "value",
                    .automatic = "the smallest value of an integer type, 0 of others", .when = "kind=salt-and-pepper",
                    .doc = "value of pepper"},
    [ROW_SALT] = {VV_PROP(add_noise_params, salt), .kind = VV_KIND_F64, .unit = "value",
                  .automatic = "the largest value of an integer type, 1 of others", .when = "kind=salt-and-pepper",
                  .doc = "value of salt"},
    [ROW_SEED] = {VV_PROP(add_noise_params, seed), .kind = VV_KIND_I64, .def = 1, .limited = true, .min = 0,
                  .max = 9007199254740991, .doc = "another number is other noise of the same kind"},
    {0},
};

static const vv_class add_noise_class = {
    .name = "add-noise",
    .doc = "parameters of add-noise",
    .size = sizeof(add_noise_params),
    .properties = properties,
};

/* Random numbers ---------------------------------------------------------------------------------------------------
 * The mixer of splitmix64 (Steele, Lea & Flood 2014) twice: over seed and sample, and over the draw. */

typedef struct draws {
    uint64_t key, n;
} draws;

static uint64_t mixed(uint64_t v)
{
    v = (v ^ v >> 30) * 0xbf58476d1ce4e5b9;
    v = (v ^ v >> 27) * 0x94d049bb133111eb;
    return v ^ v >> 31;
}

static uint64_t mixed_seed(uint64_t seed)
{
    return mixed(seed * VVI_NORMALS_STEP + 1);
}

static draws draws_of(uint64_t seed, uint64_t sample)
{
    return (draws){mixed(mixed_seed(seed) + (sample + 1) * VVI_NORMALS_STEP), 0};
}

/* In (0, 1]. */
static double next_unit(draws *d)
{
    const uint64_t bits = mixed(d->key + ++d->n * VVI_NORMALS_STEP);
    return (double)((bits >> 11) + 1) * 0x1p-53;
}

/* Box & Muller (1958): two at once. */
static void next_normals(double out[2], draws *d)
{
    const double length = sqrt(-2 * log(next_unit(d))), angle = TWO_PI * next_unit(d);
    out[0] = length * cos(angle);
    out[1] = length * sin(angle);
}

/* The sum of probabilities that passes a random number. */
static double few_counts(double mean, draws *d)
{
    const double u = next_unit(d);
    double p = exp(-mean), sum = p, k = 0;
    while (u > sum && k < 1000) {
        p *= mean / ++k;
        sum += p;
    }
    return k;
}

static double log_factorial(double k)
{
    int sign;
    return lgamma_r(k + 1, &sign);
}

/* Hörmann (1993): transformed rejection with squeeze, PTRS. */
static double many_counts(double mean, draws *d)
{
    const double b = 0.931 + 2.53 * sqrt(mean), a = -0.059 + 0.02483 * b;
    const double inverse_alpha = 1.1239 + 1.1328 / (b - 3.4), v_r = 0.9277 - 3.6224 / (b - 2);
    for (;;) {
        const double u = next_unit(d) - 0.5, v = next_unit(d), us = 0.5 - fabs(u);
        const double k = floor((2 * a / us + b) * u + mean + 0.43);
        if (us >= 0.07 && v <= v_r)
            return k;
        if (!(k >= 0) || (us < 0.013 && v > us))
            continue;
        if (log(v * inverse_alpha / (a / (us * us) + b)) <= k * log(mean) - mean - log_factorial(k))
            return k;
    }
}

static double next_counts(double mean, draws *d)
{
    double normals[2];
    if (!(mean > 0) || isinf(mean))
        return isinf(mean) && mean > 0 ? mean : 0;
    if (mean < 10)
        return few_counts(mean, d);
    if (mean < 1e9)
        return many_counts(mean, d);
    next_normals(normals, d); /* the same to the last digits */
    return floor(mean + sqrt(mean) * normals[0] + 0.5);
}

/* Sigma ------------------------------------------------------------------------------------------------------------ */

static bool looks(const vv_object *params)
{
    const add_noise_params *p = (const add_noise_params *)params;
    return (p->kind == GAUSSIAN || p->kind == RICIAN) && !(params->set >> ROW_SIGMA & 1);
}

/* Of the channel where that is widest. What nearly all samples share is all of it, where so few differ. */
static vv_status widen_range(double *range, const vv_field *field, vv_job *job)
{
    static const double most[] = {0.1, 99.9}, all[] = {0, 100};
    double ends[2];
    vv_status st = VV_OK;
    for (int c = 0; c < vv_field_get_info(field)->components && st == VV_OK; c++) {
        if ((st = vvi_field_percentiles(ends, most, field, c, job)) == VV_OK && ends[0] == ends[1])
            st = vvi_field_percentiles(ends, all, field, c, job);
        if (st == VV_OK)
            *range = fmax(*range, fabs(ends[1] - ends[0])); /* NaN, of no finite sample, is left out */
    }
    return st;
}

static vv_status take_share(double *out, double range, vv_job *job)
{
    *out = SHARE * range;
    if (!(*out > 0))
        return vv_fail(VV_E_ARGUMENT, "add-noise: all values are the same, and say nothing of how much noise is much: "
                                      "give a --sigma");
    vvi_find_number(job, "sigma", *out);
    vvi_find_phrase(job, "sigma %.4g", *out);
    return VV_OK;
}

/* One for all time steps. */
static vv_status settle(vv_object *params, const vv_field_series *fields, vv_job *job)
{
    add_noise_params *p = (add_noise_params *)params;
    double range = 0;
    vv_status st = VV_OK;
    for (size_t f = 0; f < fields->n && st == VV_OK; f++) {
        vv_field *field = NULL;
        if ((st = fields->open(&field, fields->user, f, job)) == VV_OK)
            st = widen_range(&range, field, job);
        vv_field_release(field);
    }
    if (st == VV_OK)
        st = take_share(&p->found, range, job);
    p->settled = st == VV_OK;
    return st;
}

static vv_status find_sigma(double *out, const add_noise_params *p, const vv_field *in, vv_job *job)
{
    double range = 0;
    *out = p->settled ? p->found : p->sigma;
    if (p->settled || !looks(&p->object))
        return VV_OK;
    const vv_status st = widen_range(&range, in, job);
    return st == VV_OK ? take_share(out, range, job) : st;
}

/* Samples ---------------------------------------------------------------------------------------------------------- */

typedef struct shared {
    vvi_making making;
    const add_noise_params *params;
    double sigma;
    const vv_field_info *info;
    char pepper[8], salt[8];
    const vvi_normals_kernels *kernels;
    vv_job *job;
} shared;

static vv_status find_ends(char pepper[8], char salt[8], const vv_field_info *info, const add_noise_params *p)
{
    const bool real = vv_type_is_float(info->type), falls = info->value_scale < 0;
    const double least = vvi_type_min(info->type), most = vvi_type_max(info->type);
    const double lo = falls ? most : least, hi = falls ? least : most, zero = -info->value_offset / info->value_scale;
    const double one = zero + 1 / info->value_scale;
    vv_status st = VV_OK;
    memset(pepper, 0, 8);
    memset(salt, 0, 8);
    vvi_samples_from_f64(pepper, real ? &zero : &lo, info->type, 1);
    vvi_samples_from_f64(salt, real ? &one : &hi, info->type, 1);
    if (p->object.set >> ROW_PEPPER & 1)
        st = vvi_stored_bytes(pepper, info, p->pepper, "add-noise: pepper");
    if (st == VV_OK && p->object.set >> ROW_SALT & 1)
        st = vvi_stored_bytes(salt, info, p->salt, "add-noise: salt");
    return st;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    char pepper[8], salt[8];
    *out = inputs[0];
    if (inputs[0].meaning == VV_MEANING_LABEL)
        return vv_fail(VV_E_UNSUPPORTED, "add-noise: labels are names, not amounts, and have no noise");
    return find_ends(pepper, salt, &inputs[0], (const add_noise_params *)params);
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const size_t bytes = (size_t)(s->making.slabs.step[0] * s->info->components) * sizeof(double);
    *scratch_out = vvi_alloc(s->job, bytes, VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(bytes);
}

static void finish(void *scratch, void *user)
{
    vvi_free(scratch);
}

static void add_normals(double *values, const shared *s, uint64_t first, int64_t n)
{
    const double sigma = s->sigma;
    double a[ROW + VVI_NORMALS_GUARD], b[ROW + VVI_NORMALS_GUARD];
    s->kernels->make(a, b, mixed_seed((uint64_t)s->params->seed), first, n);
    if (s->params->kind == GAUSSIAN)
        for (int64_t i = 0; i < n; i++)
            values[i] += sigma * a[i];
    else
        for (int64_t i = 0; i < n; i++)
            values[i] = hypot(values[i] + sigma * a[i], sigma * b[i]);
}

static void count_events(double *values, const shared *s, uint64_t first, int64_t n)
{
    for (int64_t i = 0; i < n; i++) {
        draws d = draws_of((uint64_t)s->params->seed, first + (uint64_t)i);
        values[i] = next_counts(values[i] * s->params->counts, &d) / s->params->counts;
    }
}

/* `first`: the number of its first sample among all of the volume and its time steps. */
static void add_to_row(char *out, double *row, const char *in, const shared *s, uint64_t first, size_t n)
{
    const double scale = s->info->value_scale, offset = s->info->value_offset;
    double values[ROW];
    vvi_samples_to_f64(row, in, s->info->type, n);
    for (size_t at = 0; at < n; at += ROW) {
        const int64_t now = (int64_t)(n - at < ROW ? n - at : ROW);
        for (int64_t i = 0; i < now; i++)
            values[i] = row[at + (size_t)i] * scale + offset;
        (s->params->kind == POISSON ? count_events : add_normals)(values, s, first + at, now);
        for (int64_t i = 0; i < now; i++) {
            const double was = row[at + (size_t)i], v = (values[i] - offset) / scale;
            row[at + (size_t)i] = isnan(was) ? was : v;
        }
    }
    vvi_samples_from_f64(out, row, s->info->type, n);
}

static void strew_row(char *out, const char *in, const shared *s, uint64_t first, size_t n)
{
    const size_t each = vv_type_bytes(s->info->type);
    memcpy(out, in, n * each);
    for (size_t i = 0; i < n; i++) {
        draws d = draws_of((uint64_t)s->params->seed, first + i);
        double v;
        vvi_samples_to_f64(&v, in + i * each, s->info->type, 1);
        if (!isnan(v) && next_unit(&d) <= s->params->fraction)
            memcpy(out + i * each, next_unit(&d) <= 0.5 ? s->pepper : s->salt, each);
    }
}

static vv_status item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const vv_brick brick = vvi_brick_part(&s->making.brick, &box);
    const int64_t *d = s->info->grid.dims, components = s->info->components;
    const size_t n = (size_t)(box.n[0] * components), each = vv_type_bytes(s->info->type);
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            const char *in = (const char *)brick.data + j * brick.stride[1] + k * brick.stride[2];
            const int64_t row = ((s->info->frame * d[2] + box.lo[2] + k) * d[1] + box.lo[1] + j) * d[0] + box.lo[0];
            char *out = s->making.out + (size_t)(vvi_slabs_row(&s->making.slabs, &box, j, k) * components) * each;
            if (s->params->kind == SALT_AND_PEPPER)
                strew_row(out, in, s, (uint64_t)(row * components), n);
            else
                add_to_row(out, scratch, in, s, (uint64_t)(row * components), n);
        }
    return vvi_job_poll(s->job);
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "add-noise", .start = start, .item = item, .finish = finish};
    const vv_field_info *info = vv_field_get_info(inputs[0]);
    shared s = {.making = {.in = inputs[0], .slabs = vvi_slabs_of(box, ITEM_SAMPLES)},
                .params = (const add_noise_params *)params,
                .info = info,
                .kernels = vvi_normals_kernels_for(vvi_job_cpu(job)),
                .job = job};
    vv_field_info same;
    vv_status st = plan(&same, info, 1, params);
    *out = NULL;
    if (st == VV_OK)
        st = find_ends(s.pepper, s.salt, info, s.params);
    if (st == VV_OK)
        st = find_sigma(&s.sigma, s.params, inputs[0], job);
    return st == VV_OK ? vvi_making_run(out, &s.making, info, box, box, &work, &s, job) : st;
}

const vv_operation vvi_operation_add_noise = {
    .api = VV_OPERATION_API,
    .name = "add-noise",
    .component = "filter",
    .group = "values",
    .doc = "add noise of a known kind and size, to try methods on: the same for the same seed; NaN stays",
    .example = "volvis add-noise head.nrrd -o noisy.nrrd --kind rician --sigma 15 --seed 7",
    .params = &add_noise_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
    .carry = vv_carry_values,
    .looks = looks,
    .settle = settle,
    .in_order = true,
};
