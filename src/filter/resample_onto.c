#include "filter/resample_onto.h"
#include "core/memory.h"
#include "filter/amounts.h"
#include "grid/making.h"
#include "grid/same_grid.h"

#include <math.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 13)
#define SLACK 1e-6 /* of a sample, at the end of an axis */

/* A number that is whole but for what the inversion of maps loses. */
static double snapped(double v, double times)
{
    const double whole = nearbyint(v);
    return fabs(v - whole) * times < SLACK ? whole : v;
}

/* Samples in the same places are the same samples, to the last bit. */
static void snap(vv_affine *map, const int64_t dims[3])
{
    for (int b = 0; b < 3; b++) {
        (&map->origin.x)[b] = snapped((&map->origin.x)[b], 1);
        for (int a = 0; a < 3; a++)
            (&map->axis[a].x)[b] = snapped((&map->axis[a].x)[b], (double)dims[a]);
    }
}

vv_status vvi_onto_map(vv_affine *map, const vv_grid *grid, const vv_grid *onto)
{
    const vv_grid to = vvi_grid_in_unit_of(grid, onto);
    const bool none = strcmp(grid->unit, "voxels") == 0, onto_none = strcmp(onto->unit, "voxels") == 0;
    vv_affine inverse;
    if (none != onto_none)
        return vv_fail(VV_E_ARGUMENT,
                       "resample: %s has no spacing, so nobody knows where it lies; give it one, as in 'volvis convert "
                       "IN --spacing 1,1,1 -o OUT'",
                       none ? "the volume" : "onto");
    if (grid->space != onto->space)
        return vv_fail(VV_E_ARGUMENT,
                       "resample: %s is anatomical and %s is not, so nobody knows how the two lie; write both with "
                       "directions (RAS) or both without",
                       grid->space == VV_SPACE_RAS ? "the volume" : "onto",
                       grid->space == VV_SPACE_RAS ? "onto" : "the volume");
    if (!vv_affine_invert(&inverse, grid->index_to_world))
        return vv_fail(VV_E_ARGUMENT, "resample: the axes of the volume lie in one plane");
    *map = vv_affine_compose(inverse, to.index_to_world);
    snap(map, onto->dims);
    return VV_OK;
}

static double part(vv_vec3 v, int axis)
{
    return (&v.x)[axis];
}

bool vvi_onto_is_straight(const vv_affine *map, const int64_t dims[3])
{
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
            if (a != b && fabs(part(map->axis[a], b)) * (double)(dims[a] - 1) > SLACK)
                return false;
    return true;
}

typedef struct shared {
    vvi_making making;
    const vv_field_info *info; /* of the result */
    vv_affine map;
    vvi_resample_kernel kernel;
    double width[3]; /* of the kernel, in old samples */
    int most[3];     /* weights */
    char fill[8];
    vv_job *job;
} shared;

/* The old samples that one new one is made of. */
typedef struct taps {
    int64_t first[3];
    int count[3];
    double *w[3];
} taps;

static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const size_t n = (size_t)s->most[0] + (size_t)s->most[1] + (size_t)s->most[2];
    const size_t bytes = (n + (size_t)s->info->components) * sizeof(double);
    *scratch_out = vvi_alloc(s->job, bytes, VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(bytes);
}

static void finish(void *scratch, void *user)
{
    vvi_free(scratch);
}

static bool find_taps(taps *t, const shared *s, vv_vec3 at)
{
    const int64_t *d = vv_field_get_info(s->making.in)->grid.dims;
    for (int a = 0; a < 3; a++)
        if (!vvi_resample_inside(part(at, a), d[a]))
            return false;
    for (int a = 0; a < 3; a++)
        t->count[a] = vvi_resample_weigh(t->w[a], &t->first[a], s->most[a], s->kernel, d[a], part(at, a), s->width[a]);
    return true;
}

static const char *old_row(const shared *s, const taps *t, int b, int c)
{
    const vv_brick *from = &s->making.brick;
    return (const char *)from->data + (t->first[0] - from->box.lo[0]) * from->stride[0] +
           (t->first[1] + b - from->box.lo[1]) * from->stride[1] +
           (t->first[2] + c - from->box.lo[2]) * from->stride[2];
}

#define SUM_ROW(vtype, ctype)                                                                                          \
    case vtype:                                                                                                        \
        for (int a = 0; a < n; a++)                                                                                    \
            for (int i = 0; i < components; i++) {                                                                     \
                ctype v;                                                                                               \
                memcpy(&v, in + a * step + i * (int)sizeof v, sizeof v);                                               \
                sum[i] += weight * w[a] * (double)v;                                                                   \
            }                                                                                                          \
        break

static void sum_row(double *sum, const char *in, int64_t step, vv_type type, int components, const double *w, int n,
                    double weight)
{
    switch (type) {
        SUM_ROW(VV_TYPE_U8, uint8_t);
        SUM_ROW(VV_TYPE_I8, int8_t);
        SUM_ROW(VV_TYPE_U16, uint16_t);
        SUM_ROW(VV_TYPE_I16, int16_t);
        SUM_ROW(VV_TYPE_U32, uint32_t);
        SUM_ROW(VV_TYPE_I32, int32_t);
        SUM_ROW(VV_TYPE_U64, uint64_t);
        SUM_ROW(VV_TYPE_I64, int64_t);
        SUM_ROW(VV_TYPE_F32, float);
        SUM_ROW(VV_TYPE_F64, double);
    }
}

static void write_sample(char *out, const shared *s, taps *t, double *sum, vv_vec3 at)
{
    const int components = s->info->components;
    const size_t each = vv_type_bytes(s->info->type);
    if (!find_taps(t, s, at)) {
        vvi_fill_numbers(out, s->fill, each, components);
        return;
    }
    if (s->kernel == VVI_RESAMPLE_NEAREST) {
        memcpy(out, old_row(s, t, 0, 0), each * (size_t)components);
        return;
    }
    memset(sum, 0, (size_t)components * sizeof *sum);
    for (int c = 0; c < t->count[2]; c++)
        for (int b = 0; b < t->count[1]; b++)
            sum_row(sum, old_row(s, t, b, c), s->making.brick.stride[0], s->info->type, components, t->w[0],
                    t->count[0], t->w[1][b] * t->w[2][c]);
    vvi_samples_from_f64(out, sum, s->info->type, (size_t)components);
}

static vv_status item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const size_t bytes = vv_type_bytes(s->info->type) * (size_t)s->info->components;
    taps t = {.w = {scratch}};
    t.w[1] = t.w[0] + s->most[0];
    t.w[2] = t.w[1] + s->most[1];
    double *sum = t.w[2] + s->most[2];
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            char *out = s->making.out + (size_t)vvi_slabs_row(&s->making.slabs, &box, j, k) * bytes;
            for (int64_t i = 0; i < box.n[0]; i++) {
                const vv_vec3 at = {(double)(box.lo[0] + i), (double)(box.lo[1] + j), (double)(box.lo[2] + k)};
                write_sample(out + (size_t)i * bytes, s, &t, sum, vv_affine_point(s->map, at));
            }
        }
    return VV_OK;
}

/* The old samples that a box of new ones is made of; the nearest to it where there are none. */
static vv_box box_needed(const shared *s, const vv_box *box)
{
    const int64_t *d = vv_field_get_info(s->making.in)->grid.dims;
    vv_box needed;
    for (int b = 0; b < 3; b++) {
        double lo = part(s->map.origin, b), hi = lo;
        for (int a = 0; a < 3; a++) {
            const double step = part(s->map.axis[a], b), first = step * (double)box->lo[a],
                         last = step * (double)(box->lo[a] + box->n[a] - 1);
            lo += fmin(first, last);
            hi += fmax(first, last);
        }
        const double reach = 3 * s->width[b] + 2, most = (double)(d[b] - 1);
        needed.lo[b] = (int64_t)fmin(fmax(floor(lo - reach), 0), most);
        needed.n[b] = (int64_t)fmax(fmin(ceil(hi + reach), most), (double)needed.lo[b]) - needed.lo[b] + 1;
    }
    return needed;
}

vv_status vvi_onto_run_box(vv_field **out, const vv_field *in, const vv_field_info *info, const vv_affine *map,
                           vvi_resample_kernel kernel, const char fill[8], const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "resample", .start = start, .item = item, .finish = finish};
    shared s = {.making = {.in = in, .slabs = vvi_slabs_of(box, ITEM_SAMPLES)},
                .info = info,
                .map = *map,
                .kernel = kernel,
                .job = job};
    const int64_t *d = vv_field_get_info(in)->grid.dims;
    memcpy(s.fill, fill, sizeof s.fill);
    for (int a = 0; a < 3; a++) { /* what a step to each side moves along old axis a, as of a ball */
        s.width[a] = fmax(1, hypot(hypot(part(map->axis[0], a), part(map->axis[1], a)), part(map->axis[2], a)));
        s.most[a] = vvi_resample_most(kernel, s.width[a], d[a]);
    }
    const vv_box needed = box_needed(&s, box);
    return vvi_making_run(out, &s.making, info, box, &needed, &work, &s, job);
}
