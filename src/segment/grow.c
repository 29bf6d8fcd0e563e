/* Grow: the part around some points whose values are in a range, which is given or is that of the values around them.
 */
#include "core/findings.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "grid/field.h"
#include "registry.h"
#include "segment/connectivity.h"
#include "segment/label_result.h"
#include "segment/runs.h"

#include <math.h>
#include <string.h>

#define SEEDS_MOST 1000

typedef struct grow_params {
    vv_object object;
    vv_numbers *seed;
    int space;
    char *range;
    double deviations;
    int64_t radius, iterations;
    int connectivity;
} grow_params;

static const char *const spaces[] = {"index", "world", NULL};

static const vv_property properties[] = {
    {VV_PROP(grow_params, seed), .kind = VV_KIND_NUMBERS, .columns = 1, .automatic = "none: it must be given",
     .doc = "where it grows from: X,Y,Z, or more points one after the other"},
    {VV_PROP(grow_params, space), .kind = VV_KIND_ENUM, .names = spaces,
     .doc = "coordinates of seeds: sample indices, or lengths in the world"},
    {VV_PROP(grow_params, range), .kind = VV_KIND_STRING, .automatic = "from deviations",
     .doc = "values that it grows into, both ends included: 100..200, 100.. or ..200"},
    {VV_PROP(grow_params, deviations), .kind = VV_KIND_F64, .limited = true, .min = 0, .max = 1000, .def = 2.5,
     .doc = "instead of a range: so many standard deviations to both sides of the mean around the seeds"},
    {VV_PROP(grow_params, radius), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = 100, .def = 1,
     .unit = "voxels", .doc = "how far around the seeds values are taken for deviations"},
    {VV_PROP(grow_params, iterations), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = 100,
     .doc = "with deviations: how often it grows again with the mean and the deviation of what it has grown to"},
    VVI_CONNECTIVITY_PROPERTY(grow_params, connectivity, "the part"),
    {0},
};

static bool given(const grow_params *p)
{
    return p->range && *p->range;
}

static vv_status check(const vv_object *object, const char *path)
{
    const grow_params *p = (const grow_params *)object;
    vvi_value_range range;
    (void)path;
    if (p->seed && p->seed->n % 3)
        return vv_fail(VV_E_ARGUMENT, "grow: a seed has three coordinates, X,Y,Z; there are %zu numbers", p->seed->n);
    if (given(p) && (vv_object_is_set(object, "deviations") || vv_object_is_set(object, "radius") ||
                     vv_object_is_set(object, "iterations")))
        return vv_fail(
            VV_E_ARGUMENT,
            "grow: a range needs no `deviations`, `radius` or `iterations`: give the range, or some of them");
    return given(p) ? vvi_value_range_parse(&range, p->range, "grow: range") : VV_OK;
}

static const vv_class grow_class = {
    .name = "grow",
    .doc = "parameters of grow",
    .size = sizeof(grow_params),
    .properties = properties,
    .check = check,
};

/* Seeds ----------------------------------------------------------------------------------------------------------- */

static vv_status find_seed(int64_t index[3], const grow_params *p, size_t i, const vv_grid *grid)
{
    const double *v = p->seed->v + 3 * i;
    vv_vec3 at = {v[0], v[1], v[2]};
    if (p->space == 1) {
        vv_affine to_index;
        if (!vv_affine_invert(&to_index, grid->index_to_world))
            return vv_fail(VV_E_ARGUMENT, "grow: the volume lies in a plane, and has no places in the world");
        at = vv_affine_point(to_index, at);
    }
    const double place[3] = {at.x, at.y, at.z};
    for (int a = 0; a < 3; a++) {
        const double whole = floor(place[a] + 0.5);
        if (!(whole >= 0 && whole < (double)grid->dims[a]))
            return vv_fail(VV_E_ARGUMENT,
                           "grow: the seed %g,%g,%g is outside the volume, which has %lldx%lldx%lld "
                           "samples%s",
                           v[0], v[1], v[2], (long long)grid->dims[0], (long long)grid->dims[1],
                           (long long)grid->dims[2], p->space == 1 ? "" : "; --space world takes lengths");
        index[a] = (int64_t)whole;
    }
    return VV_OK;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    const grow_params *p = (const grow_params *)params;
    const size_t n = p->seed ? p->seed->n / 3 : 0;
    int64_t index[3];
    (void)n_inputs;
    *out = vvi_label_result(&inputs[0], VV_TYPE_U8);
    vv_status st = vvi_label_need_one_component(&inputs[0], "grow");
    if (st == VV_OK)
        st = check(params, NULL);
    if (st == VV_OK && n == 0)
        return vv_fail(VV_E_ARGUMENT, "grow: seed is needed: X,Y,Z of a voxel to grow from");
    if (st == VV_OK && n > SEEDS_MOST)
        return vv_fail(VV_E_LIMIT, "grow: %zu seeds are more than %d", n, SEEDS_MOST);
    if (st == VV_OK && inputs[0].meaning == VV_MEANING_LABEL && !given(p))
        return vv_fail(VV_E_UNSUPPORTED, "grow: labels are names, not amounts; give the numbers of those to grow into "
                                         "with --range");
    for (size_t i = 0; i < n && st == VV_OK; i++)
        st = find_seed(index, p, i, &inputs[0].grid);
    return st;
}

/* Ranges ---------------------------------------------------------------------------------------------------------- */

typedef struct growing {
    const grow_params *p;
    const vv_field_info *info;
    vv_brick brick;
    int64_t (*seed)[3];
    size_t n_seeds;
    double least, most; /* values of the seeds */
    vvi_value_range range;
    vv_job *job;
} growing;

static double value_at(const growing *g, int64_t i, int64_t j, int64_t k)
{
    const int64_t *stride = g->brick.stride;
    double v;
    vvi_samples_to_f64(&v, (const char *)g->brick.data + i * stride[0] + j * stride[1] + k * stride[2], g->brick.type,
                       1);
    return v * g->info->value_scale + g->info->value_offset;
}

/* Mean and deviation, value by value (Welford 1962). What is near the seeds is a sample of the part: divided by n - 1.
 */
typedef struct sums {
    double n, mean, squares;
} sums;

static void add(sums *s, double v)
{
    if (!isfinite(v))
        return;
    const double off = v - s->mean;
    s->n++;
    s->mean += off / s->n;
    s->squares += off * (v - s->mean);
}

static void add_around(sums *s, const growing *g, const int64_t seed[3])
{
    int64_t lo[3], end[3];
    for (int a = 0; a < 3; a++) {
        const int64_t n = g->brick.box.n[a], r = g->p->radius;
        lo[a] = seed[a] > r ? seed[a] - r : 0;
        end[a] = seed[a] < n - r ? seed[a] + r + 1 : n;
    }
    for (int64_t k = lo[2]; k < end[2]; k++)
        for (int64_t j = lo[1]; j < end[1]; j++)
            for (int64_t i = lo[0]; i < end[0]; i++)
                add(s, value_at(g, i, j, k));
}

/* Seeds are always inside. */
static void set_range(growing *g, const sums *s)
{
    const double reach = g->p->deviations * sqrt(s->n > 1 ? s->squares / (s->n - 1) : 0);
    g->range.lo = fmin(s->mean - reach, g->least);
    g->range.hi = fmax(s->mean + reach, g->most);
}

static vv_status first_range(growing *g)
{
    sums s = {0};
    g->least = INFINITY;
    g->most = -INFINITY;
    for (size_t i = 0; i < g->n_seeds; i++) {
        const double v = value_at(g, g->seed[i][0], g->seed[i][1], g->seed[i][2]);
        g->least = fmin(g->least, v);
        g->most = fmax(g->most, v);
        add_around(&s, g, g->seed[i]);
    }
    if (given(g->p)) {
        const vv_status st = vvi_value_range_parse(&g->range, g->p->range, "grow: range");
        g->range = vvi_value_range_as_typed(&g->range, g->info);
        return st;
    }
    if (!(g->least <= g->most))
        return vv_fail(VV_E_ARGUMENT, "grow: no seed has a value: the samples there are NaN");
    set_range(g, &s);
    return VV_OK;
}

static sums sums_of(const growing *g, const vvi_runs *r, const uint32_t *label)
{
    sums s = {0};
    for (size_t row = 0; row < r->n_rows; row++)
        for (uint32_t i = r->first[row]; i < r->first[row + 1]; i++)
            for (int32_t x = r->lo[i]; x < r->end[i] && label[r->part[i]]; x++)
                add(&s, value_at(g, x, (int64_t)row % r->n[1], (int64_t)row / r->n[1]));
    return s;
}

/* Growing --------------------------------------------------------------------------------------------------------- */

static vv_status mark(uint32_t **label_out, const growing *g, const vvi_runs *runs)
{
    const size_t bytes = ((size_t)runs->n_parts + 1) * sizeof **label_out;
    uint32_t *label = *label_out = vvi_alloc_zeroed(g->job, bytes, VVI_MEM_SCRATCH);
    bool any = false;
    if (!label)
        return vv_fail_memory(bytes);
    for (size_t i = 0; i < g->n_seeds; i++) {
        const size_t run = vvi_runs_at(runs, g->seed[i]);
        if (run < runs->n_runs)
            label[runs->part[run]] = 1;
        any |= run < runs->n_runs;
    }
    if (any)
        return VV_OK;
    return vv_fail(VV_E_ARGUMENT, "grow: no seed has a value from %g to %g; the first has %g", g->range.lo, g->range.hi,
                   value_at(g, g->seed[0][0], g->seed[0][1], g->seed[0][2]));
}

static void tell(const growing *g, const vvi_runs *r, const uint32_t *label)
{
    uint64_t voxels = 0;
    for (size_t i = 0; i < r->n_runs; i++)
        voxels += label[r->part[i]] ? (uint64_t)(r->end[i] - r->lo[i]) : 0;
    vvi_find_count(g->job, "voxels", voxels);
    vvi_find_numbers(g->job, "range", (double[]){g->range.lo, g->range.hi}, 2);
    vvi_find_phrase(g->job, "%llu voxels from %.6g to %.6g", (unsigned long long)voxels, g->range.lo, g->range.hi);
}

static vv_status grow(void *data, growing *g)
{
    const vvi_touch touch = {.axes = g->p->connectivity + 1};
    vv_status st = VV_OK;
    for (int64_t again = given(g->p) ? 0 : g->p->iterations; again >= 0 && st == VV_OK; again--) {
        const vvi_run_source source = {.brick = &g->brick, .range = vvi_key_range_of(&g->range, g->info)};
        vvi_runs runs = {0};
        uint32_t *label = NULL;
        if ((st = vvi_runs_find(&runs, &source, &touch, "grow", g->job)) == VV_OK)
            st = mark(&label, g, &runs);
        if (st == VV_OK && again > 0) {
            const sums s = sums_of(g, &runs, label);
            set_range(g, &s);
        } else if (st == VV_OK && (st = vvi_runs_paint(data, VV_TYPE_U8, &runs, label, g->job)) == VV_OK)
            tell(g, &runs, label);
        vvi_free(label);
        vvi_runs_finish(&runs);
    }
    return st;
}

static vv_status run(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                     vv_job *job)
{
    int64_t seed[SEEDS_MOST][3];
    const vv_field_info *info = vv_field_get_info(inputs[0]);
    const vv_box all = vv_field_box(inputs[0]);
    growing g = {.p = (const grow_params *)params, .info = info, .seed = seed, .job = job};
    vv_field_info result;
    void *data;
    *out = NULL;
    vv_status st = plan(&result, info, n_inputs, params);
    if (st != VV_OK)
        return st;
    for (; g.n_seeds < g.p->seed->n / 3 && st == VV_OK; g.n_seeds++)
        st = find_seed(seed[g.n_seeds], g.p, g.n_seeds, &info->grid);
    if (st != VV_OK || (st = vv_field_brick(&g.brick, inputs[0], &all, job)) != VV_OK)
        return st;
    if ((st = first_range(&g)) == VV_OK && (st = vv_field_new_empty(out, &data, &result, job)) == VV_OK)
        st = grow(data, &g);
    vv_brick_release(&g.brick);
    if (st != VV_OK) {
        vv_field_release(*out);
        *out = NULL;
    }
    return st;
}

static uint64_t memory(const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    return vvi_runs_memory(&inputs[0], false);
}

const vv_operation vvi_operation_grow = {
    .api = VV_OPERATION_API,
    .name = "grow",
    .component = "segment",
    .group = "segmentation",
    .doc = "region growing: the connected part around seeds whose values are in a range, as label 1",
    .example = "volvis grow head.nrrd -o part.nrrd --seed 32,32,32 --range 150..",
    .params = &grow_class,
    .inputs = VV_ONE_VOLUME,
    .run = run,
    .plan = plan,
    .memory = memory,
};
