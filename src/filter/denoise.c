/* Non-local means (Buades, Coll & Morel 2005): the mean of samples whose surroundings look alike. For one offset after
 * the other all distances between patches at once, by sums along each axis (Darbon et al. 2008): the time does not grow
 * with the patch's volume. */
#include "core/cpu.h"
#include "core/job.h"
#include "core/memory.h"
#include "filter/noise.h"
#include "filter/real_samples.h"
#include "filter/smoothing_kernel.h"
#include "filter/window.h"
#include "grid/making.h"
#include "registry.h"

#include <math.h>

#define SEARCH_MOST 30      /* samples to each side */
#define TILE_MOST (1 << 16) /* numbers of a tile with its margin */

typedef struct denoise_params {
    vv_object object;
    double noise, strength;
    double search, patch;
    vv_vec3 search_voxels, patch_voxels;
} denoise_params;

enum { ROW_NOISE, ROW_STRENGTH, ROW_SEARCH, ROW_SEARCH_VOXELS, ROW_PATCH, ROW_PATCH_VOXELS };

static const vv_property properties[] = {
    [ROW_NOISE] = {VV_PROP(denoise_params, noise), .kind = VV_KIND_F64, .unit = "value", .limited = true, .min = 0,
                   .max = 1e300, .automatic = "estimated of each channel",
                   .doc = "standard deviation of the noise; 0 changes nothing"},
    [ROW_STRENGTH] = {VV_PROP(denoise_params, strength), .kind = VV_KIND_F64, .def = 0.8, .limited = true, .min = 0,
                      .max = 1000,
                      .doc = "how unlike patches may be, in standard deviations of the noise: more of it "
                             "smooths more; 0 changes nothing"},
    [ROW_SEARCH] = {VV_PROP(denoise_params, search), .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH, .limited = true,
                    .min = 0, .max = 1e12, .automatic = "three voxels along each axis",
                    .doc = "how far samples that look alike are searched for to each side, a length: 3mm, 4vox; "
                           "rounded to whole voxels of each axis"},
    [ROW_SEARCH_VOXELS] = {VV_PROP(denoise_params, search_voxels), .kind = VV_KIND_VEC3, .automatic = "from search",
                           .doc = "instead of search: whole voxels along x, y, z"},
    [ROW_PATCH] = {VV_PROP(denoise_params, patch), .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH, .limited = true,
                   .min = 0, .max = 1e12, .automatic = "one voxel along each axis",
                   .doc = "how far the surroundings that are compared reach to each side, a length"},
    [ROW_PATCH_VOXELS] = {VV_PROP(denoise_params, patch_voxels), .kind = VV_KIND_VEC3, .automatic = "from patch",
                          .doc = "instead of patch: whole voxels along x, y, z"},
    {0},
};

static bool is_set(const vv_object *object, int row)
{
    return object->set >> row & 1;
}

static bool is_count(double v)
{
    return v >= 0 && v <= 1e6 && v == floor(v);
}

static vv_status check_pair(const vv_object *params, int row, const char *name, vv_vec3 v, const char *path)
{
    if (is_set(params, row) && is_set(params, row + 1))
        return vv_fail(VV_E_ARGUMENT, "denoise: `%s` and `%s_voxels` set the same thing; give one of them", name, name);
    if (is_set(params, row + 1) && !(is_count(v.x) && is_count(v.y) && is_count(v.z)))
        return vv_fail_at(VV_E_ARGUMENT, NULL, path,
                          "%s_voxels is [%g, %g, %g]; three whole numbers of at least 0 are needed", name, v.x, v.y,
                          v.z);
    return VV_OK;
}

static vv_status check(const vv_object *params, const char *path)
{
    const denoise_params *p = (const denoise_params *)params;
    const vv_status st = check_pair(params, ROW_SEARCH, "search", p->search_voxels, path);
    return st == VV_OK ? check_pair(params, ROW_PATCH, "patch", p->patch_voxels, path) : st;
}

static const vv_class denoise_class = {
    .name = "denoise",
    .doc = "parameters of denoise",
    .size = sizeof(denoise_params),
    .properties = properties,
    .check = check,
};

/* Whole voxels to each side. */
static vv_status radius_of(int64_t radius[3], const vv_field_info *info, const vv_object *params, int row)
{
    const denoise_params *p = (const denoise_params *)params;
    const bool search = row == ROW_SEARCH;
    const vv_vec3 v = search ? p->search_voxels : p->patch_voxels;
    const double voxels[3] = {v.x, v.y, v.z}, length = search ? p->search : p->patch;
    const int most = search ? SEARCH_MOST : VVI_NONLOCAL_PATCH_MOST;
    for (int a = 0; a < 3; a++) {
        const double r = is_set(params, row + 1) ? voxels[a]
                         : is_set(params, row)   ? floor(length / vv_grid_spacing(&info->grid, a) + 0.5)
                         : search                ? 3
                                                 : 1;
        if (info->grid.dims[a] > 1 && !(r <= most))
            return vv_fail(VV_E_ARGUMENT, "denoise: `%s` is %g voxels to each side along %c; it may be %d",
                           search ? "search" : "patch", r, "xyz"[a], most);
        radius[a] = info->grid.dims[a] > 1 ? (int64_t)r : 0;
    }
    return VV_OK;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    (void)n_inputs;
    int64_t radius[3];
    *out = inputs[0];
    if (inputs[0].meaning == VV_MEANING_LABEL)
        return vv_fail(VV_E_UNSUPPORTED, "denoise: labels are names, not amounts, and have no mean");
    vv_status st = check(params, NULL);
    if (st == VV_OK && (st = radius_of(radius, &inputs[0], params, ROW_SEARCH)) == VV_OK)
        st = radius_of(radius, &inputs[0], params, ROW_PATCH);
    return st;
}

/* How values of a component are compared. */
typedef struct measure {
    double inverse;       /* of differences, 0: nothing changes */
    float expected, less; /* see vvi_nonlocal_tile */
} measure;

typedef struct shared {
    vvi_making making;
    const vv_field_info *info;
    const vvi_smoothing_kernels *kernels;
    int64_t search[3], patch[3], margin[3];
    int64_t row_n; /* of a tile's results at most */
    measure *measures;
    bool wide;
    vv_job *job;
} shared;

typedef struct scratch {
    char *tile, *row;
    float *sums, *weights, *room;
} scratch;

static void finish(void *scratch_in, void *user)
{
    (void)user;
    scratch *own = scratch_in;
    if (!own)
        return;
    vvi_free(own->tile);
    vvi_free(own->row);
    vvi_free(own->sums);
    vvi_free(own->weights);
    vvi_free(own->room);
    vvi_free(own);
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    (void)worker;
    const shared *s = user;
    const int64_t *step = s->making.slabs.step, *m = s->margin;
    const size_t each = vvi_reals_bytes(s->wide), results = (size_t)(s->row_n * step[1] * step[2]);
    const size_t tile =
        (size_t)((step[0] + 2 * m[0]) * (step[1] + 2 * m[1]) * (step[2] + 2 * m[2])) + VVI_SMOOTHING_GUARD;
    scratch *own = vvi_alloc_zeroed(s->job, sizeof *own, VVI_MEM_SCRATCH);
    if (!own)
        return vv_fail_memory(sizeof *own);
    own->tile = vvi_alloc_zeroed(s->job, tile * each, VVI_MEM_SCRATCH);
    own->row = vvi_alloc(s->job, (size_t)s->row_n * each, VVI_MEM_SCRATCH);
    own->sums = vvi_alloc(s->job, results * sizeof(float), VVI_MEM_SCRATCH);
    own->weights = vvi_alloc(s->job, results * sizeof(float), VVI_MEM_SCRATCH);
    own->room = vvi_alloc_zeroed(s->job, vvi_nonlocal_room(step, s->row_n, s->patch) * sizeof(float), VVI_MEM_SCRATCH);
    if (!own->tile || !own->row || !own->sums || !own->weights || !own->room) {
        finish(own, user);
        return vv_fail_memory(tile * each);
    }
    *scratch_out = own;
    return VV_OK;
}

static vv_status add_offsets(const shared *s, const vvi_nonlocal_tile *t)
{
    const int64_t *r = s->search;
    vv_status st = VV_OK;
    for (int64_t k = -r[2]; k <= r[2]; k++)
        for (int64_t j = -r[1]; j <= r[1] && st == VV_OK; j++)
            for (int64_t i = -r[0]; i <= r[0] && st == VV_OK; i++) {
                s->kernels->nonlocal[s->wide](t, k * t->stride[1] + j * t->stride[0] + i);
                st = vvi_job_poll(s->job);
            }
    return st;
}

/* What is not finite has no weights, and stays. */
static void finish_row(char *out, const char *row, const float *sum, const float *weights, double back, bool wide,
                       int64_t n)
{
    for (int64_t i = 0; i < n; i++) {
        const double mean = weights[i] > 0 ? back * (double)(sum[i] / weights[i]) : 0;
        if (wide)
            ((double *)(void *)out)[i] = ((const double *)(const void *)row)[i] + mean;
        else
            ((float *)(void *)out)[i] = (float)((double)((const float *)(const void *)row)[i] + mean);
    }
}

static vv_status write_tile(scratch *own, const shared *s, const vv_box *box, int64_t component)
{
    const size_t each = vvi_reals_bytes(s->wide), bytes = vv_type_bytes(s->info->type);
    const measure *m = &s->measures[component];
    vvi_nonlocal_tile t = {.numbers = own->tile,
                           .n = {box->n[0], box->n[1], box->n[2]},
                           .patch = {s->patch[0], s->patch[1], s->patch[2]},
                           .inverse = m->inverse,
                           .expected = m->expected,
                           .less = m->less,
                           .sums = own->sums,
                           .weights = own->weights,
                           .room = own->room};
    vv_status st = VV_OK;
    t.row_n = (box->n[0] + VVI_SMOOTHING_STEP - 1) / VVI_SMOOTHING_STEP * VVI_SMOOTHING_STEP;
    t.stride[0] = box->n[0] + 2 * s->margin[0];
    t.stride[1] = t.stride[0] * (box->n[1] + 2 * s->margin[1]);
    t.first = s->margin[2] * t.stride[1] + s->margin[1] * t.stride[0] + s->margin[0];
    vvi_reals_of_box(own->tile, s->wide, &s->making.brick, box, s->margin, component);
    for (int64_t i = 0; i < t.row_n * box->n[1] * box->n[2]; i++)
        own->sums[i] = own->weights[i] = 0;
    if (m->inverse > 0)
        st = add_offsets(s, &t);
    for (int64_t k = 0; k < box->n[2] && st == VV_OK; k++)
        for (int64_t j = 0; j < box->n[1]; j++) {
            const int64_t at = vvi_slabs_row(&s->making.slabs, box, j, k) * s->info->components + component;
            const int64_t from = (k * box->n[1] + j) * t.row_n;
            const char *row = own->tile + (size_t)(t.first + k * t.stride[1] + j * t.stride[0]) * each;
            finish_row(own->row, row, own->sums + from, own->weights + from, 1 / m->inverse, s->wide, box->n[0]);
            vvi_samples_of_reals(s->making.out + (size_t)at * bytes, (int64_t)bytes * s->info->components,
                                 s->info->type, own->row, s->wide, box->n[0]);
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

/* The weight of a mean square d^2 of a patch's differences is exp(-max(d^2 - 2 noise^2, 0) / (strength noise)^2). */
static vv_status find_measures(shared *s, const vv_object *params)
{
    const denoise_params *p = (const denoise_params *)params;
    double samples = 1;
    vv_status st = VV_OK;
    for (int a = 0; a < 3; a++)
        samples *= (double)(2 * s->patch[a] + 1);
    for (int c = 0; c < s->info->components && st == VV_OK; c++) {
        double noise = p->noise / fabs(s->info->value_scale);
        if (!is_set(params, ROW_NOISE) && (st = vvi_noise(&noise, s->making.in, c, s->job)) != VV_OK)
            break;
        const double inverse = 1 / (noise * p->strength * sqrt(samples * M_LN2));
        const double expected = 2 / (p->strength * p->strength * M_LN2);
        s->measures[c] = (measure){inverse, (float)(expected / samples), (float)expected};
        if (!(inverse < (s->wide ? 1e300 : 1e37)) || !(expected < 1e30))
            s->measures[c].inverse = 0;
    }
    return st;
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "denoise", .start = start, .item = item, .finish = finish};
    vv_field_info info;
    shared s = {.making = {.in = inputs[0]}, .info = &info, .job = job};
    *out = NULL;
    vv_status st = plan(&info, vv_field_get_info(inputs[0]), n_inputs, params);
    if (st != VV_OK || (st = radius_of(s.search, &info, params, ROW_SEARCH)) != VV_OK ||
        (st = radius_of(s.patch, &info, params, ROW_PATCH)) != VV_OK)
        return st;
    for (int a = 0; a < 3; a++)
        s.margin[a] = s.search[a] + s.patch[a];
    s.kernels = vvi_smoothing_kernels_for(vvi_job_cpu(job));
    s.wide = vvi_reals_wide(info.type);
    s.making.slabs = vvi_window_tiles(box, s.margin, TILE_MOST);
    s.row_n = s.making.slabs.step[0] + VVI_SMOOTHING_STEP;
    const vv_box needed = vvi_window_reach(box, s.margin, info.grid.dims);
    s.measures = vvi_alloc(job, (size_t)info.components * sizeof *s.measures, VVI_MEM_SCRATCH);
    if (!s.measures)
        return vv_fail_memory((size_t)info.components * sizeof *s.measures);
    if ((st = find_measures(&s, params)) == VV_OK)
        st = vvi_making_run(out, &s.making, &info, box, &needed, &work, &s, job);
    vvi_free(s.measures);
    return st;
}

const vv_operation vvi_operation_denoise = {
    .api = VV_OPERATION_API,
    .name = "denoise",
    .component = "filter",
    .group = "smoothing",
    .doc =
        "take noise away by non-local means: the mean of the samples nearby whose surroundings look alike; beyond the "
        "border are the values of the border; each channel separately",
    .example = "volvis denoise head.nrrd -o clean.nrrd --noise 12",
    .params = &denoise_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
    .carry = vv_carry_values,
};
