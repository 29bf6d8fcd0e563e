/* Bias: a smooth field that values are multiplied with is found, and taken off (N4: Tustison et al. 2010).
 *
 * The field is the one that blurs the histogram of the logarithms: over and over, each value is compared with what it
 * is expected to have been in a sharper histogram, and a smooth field is fitted to what is left. It is found in some of
 * the samples, evenly spaced, and known everywhere. */
#include "core/findings.h"
#include "core/memory.h"
#include "filter/sharpen.h"
#include "filter/spline_field.h"
#include "grid/making.h"
#include "grid/same_grid.h"
#include "registry.h"
#include "segment/cuts.h"
#include "segment/value_range.h"

#include <math.h>
#include <string.h>

enum { LEVELS_MOST = 6, SPANS_MOST = 256, CUT_BINS = 1024, ITEM_SAMPLES = 1 << 15, SAMPLES_MOST = 1 << 18, LEAST = 64 };

typedef struct bias_params {
    vv_object object;
    double distance;
    int64_t levels, iterations;
    double tolerance, blur, noise;
    int64_t every;
    char *range;
    int output;
} bias_params;

enum { ROW_DISTANCE, ROW_LEVELS, ROW_ITERATIONS, ROW_TOLERANCE, ROW_BLUR, ROW_NOISE, ROW_EVERY, ROW_RANGE, ROW_OUTPUT };
enum { VOLUME, MASK, INPUTS };
enum { CORRECTED, FIELD };

static const char *const output_names[] = {"corrected", "field", NULL};

static const vv_property properties[] = {
    [ROW_DISTANCE] = {VV_PROP(bias_params, distance), .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH, .limited = true,
                      .min = 0, .max = 1e12, .automatic = "the volume's extent along each axis",
                      .doc = "from one knot of the field to the next at the first level, a length; half of it at each "
                             "level that follows"},
    [ROW_LEVELS] = {VV_PROP(bias_params, levels), .kind = VV_KIND_I64, .limited = true, .min = 1, .max = LEVELS_MOST,
                    .def = 4, .doc = "number of levels; more of them follow steeper fields"},
    [ROW_ITERATIONS] = {VV_PROP(bias_params, iterations), .kind = VV_KIND_I64, .limited = true, .min = 1, .max = 1000,
                        .def = 50, .doc = "number of iterations of each level, at most"},
    [ROW_TOLERANCE] = {VV_PROP(bias_params, tolerance), .kind = VV_KIND_F64, .limited = true, .min = 0, .max = 1,
                       .def = 0.001,
                       .doc = "a level ends when an iteration changes the field by less, as a share of it"},
    [ROW_BLUR] = {VV_PROP(bias_params, blur), .kind = VV_KIND_F64, .limited = true, .min = 1e-6, .max = 10, .def = 0.15,
                  .doc = "full width at half maximum of the Gaussian by which the field is taken to have blurred the "
                         "histogram of natural logarithms: the wider, the more an iteration sharpens it"},
    [ROW_NOISE] = {VV_PROP(bias_params, noise), .kind = VV_KIND_F64, .limited = true, .min = 1e-12, .max = 1e3,
                   .def = 0.01,
                   .doc = "noise term of the Wiener filter that sharpens the histogram: more of it sharpens less"},
    [ROW_EVERY] = {VV_PROP(bias_params, every), .kind = VV_KIND_I64, .limited = true, .min = 1, .max = 64,
                   .automatic = "as many as give at most 262 144 samples",
                   .doc = "the field is found in every n-th sample along each axis"},
    [ROW_RANGE] = {VV_PROP(bias_params, range), .kind = VV_KIND_STRING,
                   .automatic = "without a mask those above Otsu's limit, else all",
                   .doc = "values above 0 that the field is found in, both ends included: 100..200, 100.. or ..200"},
    [ROW_OUTPUT] = {VV_PROP(bias_params, output), .kind = VV_KIND_ENUM, .names = output_names,
                    .doc =
                        "corrected: values divided by the field; field: the field, whose logarithms have a mean of 0 "
                        "where it was found"},
    {0},
};

static bool is_set(const vv_object *object, int row)
{
    return object->set >> row & 1;
}

static bool given(const bias_params *p)
{
    return p->range && *p->range;
}

static vv_status check(const vv_object *object, const char *path)
{
    const bias_params *p = (const bias_params *)object;
    vvi_value_range range;
    (void)path;
    return given(p) ? vvi_value_range_parse(&range, p->range, "bias: range") : VV_OK;
}

static const vv_class bias_class = {
    .name = "bias",
    .doc = "parameters of bias",
    .size = sizeof(bias_params),
    .properties = properties,
    .check = check,
};

/* Spans of the first level along each axis. */
static vv_status find_spans(int64_t spans[3], const vv_grid *grid, const vv_object *params)
{
    const bias_params *p = (const bias_params *)params;
    for (int a = 0; a < 3; a++) {
        const double extent = vv_grid_spacing(grid, a) * (double)(grid->dims[a] - 1);
        const double n = is_set(params, ROW_DISTANCE) && extent > 0 ? ceil(extent / p->distance - 1e-9) : 1;
        if (!(n * (double)(1 << (p->levels - 1)) <= SPANS_MOST))
            return vv_fail(VV_E_ARGUMENT,
                           "bias: a distance of %g and %lld levels make more than %d knots along %c: give a greater "
                           "distance, or fewer levels",
                           p->distance, (long long)p->levels, SPANS_MOST, "xyz"[a]);
        spans[a] = n < 1 ? 1 : (int64_t)n;
    }
    return VV_OK;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    const bias_params *p = (const bias_params *)params;
    int64_t spans[3];
    *out = inputs[0];
    out->type = VV_TYPE_F32;
    out->value_scale = 1;
    out->value_offset = 0;
    if (p->output == FIELD)
        memset(out->value_unit, 0, sizeof out->value_unit);
    if (inputs[0].meaning == VV_MEANING_LABEL)
        return vv_fail(VV_E_UNSUPPORTED, "bias: labels are names, not amounts, and no field brightens them");
    vv_status st = check(params, NULL);
    if (st == VV_OK && n_inputs > MASK && inputs[MASK].components > 1)
        return vv_fail(VV_E_UNSUPPORTED, "bias: mask: expected one channel, found %d; pick one with `volvis channel`",
                       inputs[MASK].components);
    if (st == VV_OK && n_inputs > MASK && inputs[MASK].components &&
        (st = vvi_grid_alike(&inputs[0].grid, &inputs[MASK].grid, "mask")) != VV_OK)
        return vv_fail_in(st, "bias");
    return st == VV_OK ? find_spans(spans, &inputs[0].grid, params) : st;
}

/* The samples that the field is found in -------------------------------------------------------------------------- */

typedef struct finding {
    const bias_params *p;
    const vv_field_info *info;
    const vv_brick *brick, *mask; /* mask: NULL where there is none */
    const vv_field_info *mask_info;
    int component;
    int64_t every, n[3], first[3];
    size_t n_all;
    double *log, *field, *rest; /* NaN where a sample does not count */
    vvi_lattice lattice[LEVELS_MOST];
    double mean; /* of the field's logarithm */
    float *out;
    vv_job *job;
} finding;

static int64_t sample_of(const finding *f, int axis, int64_t index)
{
    return f->first[axis] + index * f->every;
}

static double value_of(const vv_brick *b, const vv_field_info *info, const int64_t at[3], int component)
{
    double v;
    vvi_samples_to_f64(&v,
                       (const char *)b->data + at[0] * b->stride[0] + at[1] * b->stride[1] + at[2] * b->stride[2] +
                           component * (int64_t)vv_type_bytes(b->type),
                       b->type, 1);
    return v * info->value_scale + info->value_offset;
}

static vv_status cut_off(finding *f)
{
    double value[CUT_BINS], count[CUT_BINS] = {0}, lo = INFINITY, hi = -INFINITY;
    size_t last;
    for (size_t i = 0; i < f->n_all; i++) {
        lo = f->log[i] < lo ? f->log[i] : lo;
        hi = f->log[i] > hi ? f->log[i] : hi;
    }
    if (!(lo < hi))
        return VV_OK;
    vvi_histogram h = {.value = value, .count = count, .width = (hi - lo) / CUT_BINS};
    double all[CUT_BINS] = {0};
    for (size_t i = 0; i < f->n_all; i++)
        if (!isnan(f->log[i]))
            all[(size_t)fmin((f->log[i] - lo) / h.width, CUT_BINS - 1)]++;
    for (size_t b = 0; b < CUT_BINS; b++)
        if (all[b] > 0) {
            value[h.n] = lo + h.width * ((double)b + 0.5);
            count[h.n++] = all[b];
        }
    const vv_status st = vvi_otsu(&last, &h, 2, f->job);
    const double limit = value[last] + 0.5 * h.width;
    for (size_t i = 0; i < f->n_all && st == VV_OK; i++)
        if (!(f->log[i] > limit))
            f->log[i] = NAN;
    return st;
}

/* Where they are looked for, and what gives more of them. */
static vv_status fail_few(size_t n, const finding *f)
{
    const char *where = f->mask       ? "in the mask"
                        : given(f->p) ? "in the range"
                                      : "above the limit that Otsu's method finds";
    const char *more = f->mask ? "a larger mask" : given(f->p) ? "a wider --range" : "a --range or a mask";
    return vv_fail(VV_E_ARGUMENT,
                   "bias: the field needs %d samples with values above 0, and there are %zu %s: give %s%s", LEAST, n,
                   where, more, f->every > 1 ? ", or --every 1 to look at all samples" : "");
}

/* Values first, then their logarithms; only those above 0 have one. */
static vv_status take_samples(finding *f)
{
    vvi_value_range range = {-INFINITY, INFINITY};
    vv_status st = VV_OK;
    size_t at = 0, n = 0;
    if (given(f->p) && (st = vvi_value_range_parse(&range, f->p->range, "bias: range")) == VV_OK)
        range = vvi_value_range_as_typed(&range, f->info);
    for (int64_t k = 0; k < f->n[2]; k++)
        for (int64_t j = 0; j < f->n[1]; j++)
            for (int64_t i = 0; i < f->n[0]; i++, at++) {
                const int64_t p[3] = {sample_of(f, 0, i), sample_of(f, 1, j), sample_of(f, 2, k)};
                const double v = value_of(f->brick, f->info, p, f->component);
                const double m = f->mask ? value_of(f->mask, f->mask_info, p, 0) : 1;
                const bool counts = isfinite(v) && v >= range.lo && v <= range.hi && m != 0 && !isnan(m);
                f->log[at] = counts ? v : NAN;
            }
    if (st == VV_OK && !f->mask && !given(f->p))
        st = cut_off(f);
    for (size_t i = 0; i < f->n_all; i++) {
        f->log[i] = f->log[i] > 0 ? log(f->log[i]) : NAN;
        f->field[i] = 0;
        n += !isnan(f->log[i]);
    }
    return st == VV_OK && n < LEAST ? fail_few(n, f) : st;
}

/* Levels ---------------------------------------------------------------------------------------------------------- */

/* Adds what the lattice gives to the field, and tells how much it changed: the deviation of their quotient over its
 * mean. */
static vv_status add_to_field(double *change, finding *f, const vvi_lattice *more, const vvi_spline_samples *s)
{
    const size_t bytes = (size_t)(more->spans[0] + 3) * sizeof(double);
    double *row = vvi_alloc(f->job, bytes, VVI_MEM_SCRATCH);
    double n = 0, mean = 0, squares = 0;
    size_t at = 0;
    if (!row)
        return vv_fail_memory(bytes);
    for (int64_t k = 0; k < f->n[2]; k++)
        for (int64_t j = 0; j < f->n[1]; j++) {
            vvi_lattice_row(row, more, &s->knot[1][j], &s->knot[2][k]);
            for (int64_t i = 0; i < f->n[0]; i++, at++) {
                const double v = vvi_lattice_value(row, &s->knot[0][i]);
                f->field[at] += v;
                if (isnan(f->log[at]))
                    continue;
                const double quotient = exp(v), off = quotient - mean;
                mean += off / ++n;
                squares += off * (quotient - mean);
            }
        }
    vvi_free(row);
    *change = sqrt(squares / n) / mean;
    return VV_OK;
}

static vv_status iterate(double *change, finding *f, vvi_lattice *level, vvi_lattice *more,
                         const vvi_spline_samples *samples)
{
    vvi_sharpened sharp;
    *change = 0;
    for (size_t i = 0; i < f->n_all; i++)
        f->rest[i] = f->log[i] - f->field[i];
    if (!vvi_sharpen(&sharp, f->rest, f->n_all, f->p->blur, f->p->noise))
        return VV_OK;
    for (size_t i = 0; i < f->n_all; i++)
        f->rest[i] -= isnan(f->rest[i]) ? 0 : vvi_sharpened_value(&sharp, f->rest[i]);
    memset(more->c, 0, vvi_lattice_size(more) * sizeof *more->c);
    vv_status st = vvi_lattice_fit(more, samples, f->job);
    if (st == VV_OK)
        st = add_to_field(change, f, more, samples);
    for (size_t c = 0; c < vvi_lattice_size(more) && st == VV_OK; c++)
        level->c[c] += more->c[c];
    return st;
}

static double place_of(int64_t sample, int64_t n)
{
    return n > 1 ? (double)sample / (double)(n - 1) : 0.5;
}

static vv_status find_level(finding *f, int number, int64_t *done)
{
    vvi_lattice *level = &f->lattice[number], more = *level;
    const size_t bytes = vvi_lattice_size(level) * sizeof(double), sides = (size_t)(f->n[0] + f->n[1] + f->n[2]);
    double change = INFINITY;
    vv_status st = VV_OK;
    level->c = vvi_alloc_zeroed(f->job, bytes, VVI_MEM_SCRATCH);
    more.c = vvi_alloc(f->job, bytes, VVI_MEM_SCRATCH);
    vvi_knot *knots = vvi_alloc(f->job, sides * sizeof *knots, VVI_MEM_SCRATCH);
    if (!level->c || !more.c || !knots)
        st = vv_fail_memory(bytes);
    vvi_spline_samples samples = {.v = f->rest};
    size_t at = 0;
    for (int a = 0; a < 3 && st == VV_OK; a++) {
        samples.n[a] = f->n[a];
        samples.knot[a] = knots + at;
        for (int64_t i = 0; i < f->n[a]; i++)
            knots[at++] = vvi_knot_at(place_of(sample_of(f, a, i), f->info->grid.dims[a]), level->spans[a]);
    }
    const int64_t most = f->p->iterations, all = most * f->p->levels;
    int64_t n = 0;
    for (; n < most && change > f->p->tolerance && st == VV_OK; n++)
        if ((st = vvi_job_progress(f->job, "find the field", (uint64_t)(number * most + n), (uint64_t)all)) == VV_OK)
            st = iterate(&change, f, level, &more, &samples);
    *done += n;
    vvi_free(more.c);
    vvi_free(knots);
    return st;
}

static vv_status find_field(finding *f, int64_t *iterations)
{
    int64_t spans[3];
    double sum = 0, n = 0;
    vv_status st = find_spans(spans, &f->info->grid, &f->p->object);
    if (st == VV_OK)
        st = take_samples(f);
    for (int level = 0; level < f->p->levels && st == VV_OK; level++) {
        for (int a = 0; a < 3; a++)
            f->lattice[level].spans[a] = f->info->grid.dims[a] > 1 ? spans[a] << level : 1;
        st = find_level(f, level, iterations);
    }
    for (size_t i = 0; i < f->n_all && st == VV_OK; i++)
        if (!isnan(f->log[i])) {
            sum += f->field[i];
            n++;
        }
    f->mean = n > 0 ? sum / n : 0;
    return st;
}

/* The result ------------------------------------------------------------------------------------------------------ */

typedef struct applying {
    const finding *f;
    vvi_slabs slabs;
    vvi_knot *x; /* by level and sample */
    vv_job *job;
} applying;

static size_t row_room(const finding *f)
{
    return (size_t)f->lattice[f->p->levels - 1].spans[0] + 3;
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    const applying *a = user;
    const size_t bytes = row_room(a->f) * (size_t)a->f->p->levels * sizeof(double);
    (void)worker;
    *scratch_out = vvi_alloc(a->job, bytes, VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(bytes);
}

static void finish(void *scratch, void *user)
{
    (void)user;
    vvi_free(scratch);
}

static void apply_row(const applying *a, double *room, const vv_box *box, int64_t j, int64_t k)
{
    const finding *f = a->f;
    const int64_t *d = f->info->grid.dims;
    for (int l = 0; l < f->p->levels; l++) {
        const vvi_knot y = vvi_knot_at(place_of(j, d[1]), f->lattice[l].spans[1]),
                       z = vvi_knot_at(place_of(k, d[2]), f->lattice[l].spans[2]);
        vvi_lattice_row(room + (size_t)l * row_room(f), &f->lattice[l], &y, &z);
    }
    for (int64_t i = box->lo[0]; i < box->lo[0] + box->n[0]; i++) {
        const int64_t at[3] = {i, j, k};
        double sum = -f->mean;
        for (int l = 0; l < f->p->levels; l++)
            sum += vvi_lattice_value(room + (size_t)l * row_room(f), &a->x[l * d[0] + i]);
        const double v = f->p->output == FIELD ? exp(sum) : value_of(f->brick, f->info, at, f->component) / exp(sum);
        const float narrow = (float)v;
        f->out[((k * d[1] + j) * d[0] + i) * f->info->components + f->component] = narrow;
    }
}

static vv_status apply_item(void *scratch, void *user, size_t index)
{
    const applying *a = user;
    const vv_box box = vvi_slabs_item(&a->slabs, index);
    for (int64_t k = box.lo[2]; k < box.lo[2] + box.n[2]; k++)
        for (int64_t j = box.lo[1]; j < box.lo[1] + box.n[1]; j++)
            apply_row(a, scratch, &box, j, k);
    return vvi_job_poll(a->job);
}

static vv_status apply(const finding *f, const vv_box *all)
{
    static const vvi_work work = {.stage = "take it off", .start = start, .item = apply_item, .finish = finish};
    const int64_t n = f->info->grid.dims[0];
    const size_t bytes = (size_t)(n * f->p->levels) * sizeof(vvi_knot);
    applying a = {.f = f,
                  .slabs = vvi_slabs_of(all, ITEM_SAMPLES),

                  .x = vvi_alloc(f->job, bytes, VVI_MEM_SCRATCH),
                  .job = f->job};
    if (!a.x)
        return vv_fail_memory(bytes);
    for (int l = 0; l < f->p->levels; l++)
        for (int64_t i = 0; i < n; i++)
            a.x[l * n + i] = vvi_knot_at(place_of(i, n), f->lattice[l].spans[0]);
    const vv_status st = vvi_parallel_for(f->job, &work, &a, a.slabs.n);
    vvi_free(a.x);
    return st;
}

/* As few as are enough, but one of a side at least. */
static void choose_samples(finding *f, const vv_object *params)
{
    f->every = is_set(params, ROW_EVERY) ? f->p->every : 1;
    for (;; f->every++) {
        double n = 1;
        for (int a = 0; a < 3; a++) {
            const int64_t d = f->info->grid.dims[a];
            f->n[a] = d < f->every ? 1 : d / f->every;
            f->first[a] = (d - 1 - (f->n[a] - 1) * f->every) / 2;
            n *= (double)f->n[a];
        }
        f->n_all = (size_t)n;
        if (is_set(params, ROW_EVERY) || n <= SAMPLES_MOST)
            return;
    }
}

static vv_status correct(finding *f, const vv_box *all)
{
    const size_t bytes = f->n_all * sizeof(double);
    int64_t iterations = 0;
    vv_status st = vvi_memory_plan(f->job, 3 * (uint64_t)bytes, "bias");
    if (st != VV_OK)
        return st;
    f->log = vvi_alloc(f->job, bytes, VVI_MEM_SCRATCH);
    f->field = vvi_alloc(f->job, bytes, VVI_MEM_SCRATCH);
    f->rest = vvi_alloc(f->job, bytes, VVI_MEM_SCRATCH);
    st = f->log && f->field && f->rest ? find_field(f, &iterations) : vv_fail_memory(bytes);
    if (st == VV_OK && (st = apply(f, all)) == VV_OK) {
        vvi_find_count(f->job, "iterations", (uint64_t)iterations);
        vvi_find_phrase(f->job, "%lld iterations", (long long)iterations);
    }
    for (int l = 0; l < LEVELS_MOST; l++) {
        vvi_free(f->lattice[l].c);
        f->lattice[l].c = NULL;
    }
    vvi_free(f->log);
    vvi_free(f->field);
    vvi_free(f->rest);
    return st;
}

static vv_status run(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                     vv_job *job)
{
    const vv_field *mask = n_inputs > MASK ? inputs[MASK] : NULL;
    vv_field_info infos[INPUTS] = {*vv_field_get_info(inputs[VOLUME])}, result;
    const vv_box all = vv_field_box(inputs[VOLUME]);
    vv_brick bricks[INPUTS] = {{0}};
    vv_field *field = NULL;
    void *data;
    *out = NULL;
    if (mask)
        infos[MASK] = *vv_field_get_info(mask);
    finding f = {.p = (const bias_params *)params,
                 .info = &infos[VOLUME],
                 .brick = &bricks[VOLUME],
                 .mask = mask ? &bricks[MASK] : NULL,
                 .mask_info = &infos[MASK],
                 .job = job};
    vv_status st = plan(&result, infos, n_inputs, params);
    if (st != VV_OK || (st = vv_field_new_empty(&field, &data, &result, job)) != VV_OK)
        return st;
    f.out = data;
    choose_samples(&f, params);
    if ((st = vv_field_brick(&bricks[VOLUME], inputs[VOLUME], &all, job)) == VV_OK && mask)
        st = vv_field_brick(&bricks[MASK], mask, &all, job);
    for (f.component = 0; f.component < f.info->components && st == VV_OK; f.component++)
        st = correct(&f, &all);
    vv_brick_release(&bricks[VOLUME]);
    vv_brick_release(&bricks[MASK]);
    if (st == VV_OK)
        *out = vv_field_retain(field);
    vv_field_release(field);
    return st;
}

/* What is brightened means what it meant; a field is new. */
static vv_status carry(vv_carry *carried, const vv_object *params)
{
    carried->new_values |= ((const bias_params *)params)->output == FIELD;
    return VV_OK;
}

static const vv_operand inputs_taken[] = {
    {"volume", VV_IS_FIELD, 1, 1, "the volume that it works on"},
    {"mask", VV_IS_FIELD, 0, 1,
     "the field is found where this volume on the same grid is not 0; best the tissue that matters"},
    {0},
};

static uint64_t memory(const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    finding f = {.info = &inputs[0], .p = (const bias_params *)params};
    choose_samples(&f, params);
    return 3 * (uint64_t)f.n_all * sizeof(double);
}

const vv_operation vvi_operation_bias = {
    .api = VV_OPERATION_API,
    .name = "bias",
    .component = "filter",
    .group = "values",
    .doc =
        "take off a smooth field that has made parts of an MR or microscope image brighter than others (N4, Tustison "
        "et al. 2010); each "
        "channel separately",
    .example = "volvis bias head.nrrd -o even.nrrd --range 50.. --levels 3",
    .params = &bias_class,
    .inputs = inputs_taken,
    .run = run,
    .plan = plan,
    .memory = memory,
    .carry = carry,
};
