#include "io/rectilinear.h"
#include "core/job.h"
#include "core/limits.h"
#include "core/memory.h"
#include "core/text.h"
#include "grid/field.h"
#include "io/notes.h"
#include <inttypes.h>
#include <math.h>
#include <string.h>

#define EVEN 1e-3 /* of a step */

static vv_status check_axis(const vvi_axes *axes, int a, const char *name)
{
    const double *at = axes->at[a];
    const int64_t n = axes->n[a];
    for (int64_t i = 0; i < n; i++)
        if (!isfinite(at[i]) || (i > 0 && !((at[i] > at[i - 1]) == (at[1] > at[0]) && at[i] != at[i - 1])))
            return vv_fail_at(VV_E_FORMAT, name, NULL,
                              "its coordinate %" PRId64
                              " along %c is %g after %g; they must be ascending or descending throughout",
                              i, 'x' + a, at[i], i > 0 ? at[i - 1] : at[i]);
    return isfinite(at[n - 1] - at[0])
               ? VV_OK
               : vv_fail_at(VV_E_FORMAT, name, NULL, "its coordinates along %c are too far apart", 'x' + a);
}

static void look_at_axis(vvi_axes *axes, int a)
{
    const double *at = axes->at[a];
    const int64_t n = axes->n[a];
    const double mean = n > 1 ? (at[n - 1] - at[0]) / (double)(n - 1) : 0;
    axes->even[a] = true;
    axes->gap[a] = fabs(mean);
    for (int64_t i = 1; i < n; i++) {
        axes->gap[a] = fmin(axes->gap[a], fabs(at[i] - at[i - 1]));
        axes->even[a] = axes->even[a] && fabs(at[i] - (at[0] + (double)i * mean)) <= EVEN * fabs(mean);
    }
}

/* Samples along an axis when each axis may have at most `growth` times as many as there are. */
static int64_t samples_of(const vvi_axes *axes, int a, double growth, const vv_limits *limits)
{
    const int64_t n = axes->n[a];
    if (axes->even[a])
        return n;
    const double wanted = ceil(fabs(axes->at[a][n - 1] - axes->at[a][0]) / axes->gap[a] - 1e-6) + 1;
    const double most = fmin(floor(growth * (double)n), (double)limits->dim);
    return wanted < most ? (int64_t)wanted : most > (double)n ? (int64_t)most : n;
}

/* The largest growth of axes, up to VVI_AXIS_GROWTH, with which the whole does not grow too much. */
static double allowed_growth(const vvi_axes *axes, const vv_limits *limits)
{
    double lo = 1, hi = VVI_AXIS_GROWTH;
    for (int step = 0; step < 40; step++) {
        const double growth = step == 0 ? hi : (lo + hi) / 2;
        double all = 1;
        for (int a = 0; a < 3; a++)
            all *= (double)samples_of(axes, a, growth, limits) / (double)axes->n[a];
        if (all <= VVI_SAMPLES_GROWTH) {
            lo = growth;
            if (step == 0)
                break;
        } else {
            hi = growth;
        }
    }
    return lo;
}

static void choose_dims(vvi_axes *axes, const vv_limits *limits)
{
    double shortest = INFINITY;
    const double growth = allowed_growth(axes, limits);
    for (int a = 0; a < 3; a++) {
        const int64_t n = axes->n[a];
        axes->dims[a] = samples_of(axes, a, growth, limits);
        axes->step[a] = n > 1 ? (axes->at[a][n - 1] - axes->at[a][0]) / (double)(axes->dims[a] - 1) : 0;
        if (n > 1)
            shortest = fmin(shortest, fabs(axes->step[a]));
    }
    for (int a = 0; a < 3; a++)
        if (axes->n[a] == 1) /* as thick as the shortest step */
            axes->step[a] = isfinite(shortest) ? shortest : 1;
}

vv_status vvi_axes_new(vvi_axes **out, const double *const at[3], const int64_t n[3], const char *name, vv_job *job)
{
    *out = NULL;
    vvi_axes *axes = vvi_alloc_zeroed(job, sizeof *axes, VVI_MEM_MODEL);
    if (!axes)
        return vv_fail_memory(sizeof *axes);
    vv_status st = VV_OK;
    for (int a = 0; a < 3 && st == VV_OK; a++) {
        const size_t bytes = (size_t)n[a] * sizeof *at[a];
        axes->n[a] = n[a];
        axes->at[a] = vvi_alloc(job, bytes, VVI_MEM_MODEL);
        if (!axes->at[a]) {
            st = vv_fail_memory(bytes);
            break;
        }
        memcpy(axes->at[a], at[a], bytes);
        st = check_axis(axes, a, name);
        if (st == VV_OK)
            look_at_axis(axes, a);
    }
    if (st != VV_OK) {
        vvi_axes_free(axes);
        return st;
    }
    choose_dims(axes, vvi_job_limits(job));
    *out = axes;
    return VV_OK;
}

void vvi_axes_free(vvi_axes *axes)
{
    for (int a = 0; axes && a < 3; a++)
        vvi_free(axes->at[a]);
    vvi_free(axes);
}

bool vvi_axes_even(const vvi_axes *axes)
{
    return axes->even[0] && axes->even[1] && axes->even[2];
}

int64_t vvi_axes_centres(double *at, int64_t n)
{
    for (int64_t i = 0; i + 1 < n; i++)
        at[i] = at[i] + (at[i + 1] - at[i]) / 2;
    return n > 1 ? n - 1 : n;
}

void vvi_axes_place(vv_field_info *info, const vvi_axes *axes)
{
    vv_affine *map = &info->grid.index_to_world;
    memcpy(info->grid.dims, axes->dims, sizeof axes->dims);
    *map = (vv_affine){{{axes->step[0], 0, 0}, {0, axes->step[1], 0}, {0, 0, axes->step[2]}},
                       {axes->at[0][0], axes->at[1][0], axes->at[2][0]}};
    const bool colour = info->meaning == VV_MEANING_RGB || info->meaning == VV_MEANING_RGBA;
    if (!vvi_axes_even(axes) && !vv_type_is_float(info->type) && !colour)
        info->type = vv_type_bytes(info->type) <= 2 ? VV_TYPE_F32 : VV_TYPE_F64;
}

vv_status vvi_axes_warn(vv_notes *notes, const vvi_axes *axes)
{
    vvi_text t = {0};
    const int64_t *n = axes->n, *m = axes->dims;
    if (vvi_axes_even(axes))
        return VV_OK;
    for (int a = 0; a < 3; a++)
        if (!axes->even[a])
            vvi_text_printf(&t, "%s along %c every %.4g (smallest gap %.4g)", t.n ? "," : "", 'x' + a,
                            fabs(axes->step[a]), axes->gap[a]);
    vv_status st = t.bad ? vv_fail_memory(t.n)
                         : vvi_notes_warn(notes,
                                          "its coordinates are uneven: resampled linearly from %" PRId64 " x %" PRId64
                                          " x %" PRId64 " to %" PRId64 " x %" PRId64 " x %" PRId64 " samples,%s",
                                          n[0], n[1], n[2], m[0], m[1], m[2], t.s);
    vvi_text_free(&t);
    return st;
}

/* Resampling --------------------------------------------------------------------------------------------------------
 */

/* The stored sample at or before the i-th of the regular grid, and how far it is to the next. */
static int64_t find(const vvi_axes *axes, int a, int64_t i, double *share)
{
    const double *at = axes->at[a];
    const int64_t last = axes->n[a] - 1;
    *share = 0;
    if (axes->even[a])
        return i;
    if (i >= axes->dims[a] - 1)
        return last;
    const double sign = axes->step[a] < 0 ? -1 : 1, x = at[0] + (double)i * axes->step[a];
    int64_t lo = 0, hi = last;
    while (hi - lo > 1) {
        const int64_t middle = lo + (hi - lo) / 2;
        if (sign * at[middle] <= sign * x)
            lo = middle;
        else
            hi = middle;
    }
    *share = fmin(fmax((x - at[lo]) / (at[lo + 1] - at[lo]), 0), 1);
    return lo;
}

static vv_box box_of(const vvi_axes *axes, const vv_box *region)
{
    return region ? *region : (vv_box){{0, 0, 0}, {axes->dims[0], axes->dims[1], axes->dims[2]}};
}

vv_box vvi_axes_needs(const vvi_axes *axes, const vv_box *region)
{
    const vv_box box = box_of(axes, region);
    vv_box needs;
    for (int a = 0; a < 3; a++) {
        double share;
        needs.lo[a] = find(axes, a, box.lo[a], &share);
        const int64_t hi = find(axes, a, box.lo[a] + box.n[a] - 1, &share);
        needs.n[a] = hi - needs.lo[a] + 1 + (share > 0);
    }
    return needs;
}

typedef struct sampling {
    const vvi_axes *axes;
    const vv_field_info *info;
    vv_box box, needs;
    const vv_brick *brick;
    uint8_t *out;
    size_t row; /* numbers in a stored row */
    vv_job *job;
} sampling;

static vv_status start(void **scratch_out, void *shared, int worker)
{
    const sampling *s = shared;
    const size_t n = (2 * s->row + (size_t)s->box.n[0] * (size_t)s->info->components) * sizeof(double);
    *scratch_out = vvi_alloc(s->job, n, VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(n);
}

static void finish(void *scratch, void *shared)
{
    vvi_free(scratch);
}

/* The row of stored samples between up to four; weights of 0 are left out, so that NaN spreads no further than it must.
 */
static void mix_rows(double *mixed, double *one, const sampling *s, const int64_t at[2], const double share[2])
{
    memset(mixed, 0, s->row * sizeof *mixed);
    for (int corner = 0; corner < 4; corner++) {
        const int dy = corner & 1, dz = corner >> 1;
        const double weight = (dy ? share[0] : 1 - share[0]) * (dz ? share[1] : 1 - share[1]);
        if (weight == 0)
            continue;
        const uint8_t *from =
            (const uint8_t *)s->brick->data + (at[0] + dy) * s->brick->stride[1] + (at[1] + dz) * s->brick->stride[2];
        vvi_samples_to_f64(one, from, s->brick->type, s->row);
        for (size_t i = 0; i < s->row; i++)
            mixed[i] += weight * one[i];
    }
}

static void sample_row(double *out, const double *row, const sampling *s)
{
    const int c = s->info->components;
    for (int64_t i = 0; i < s->box.n[0]; i++) {
        double share;
        const double *at = row + (find(s->axes, 0, s->box.lo[0] + i, &share) - s->needs.lo[0]) * c;
        for (int k = 0; k < c; k++)
            *out++ = share == 0 ? at[k] : share == 1 ? at[c + k] : (1 - share) * at[k] + share * at[c + k];
    }
}

static vv_status sample_slice(void *scratch, void *shared, size_t index)
{
    const sampling *s = shared;
    double *mixed = scratch, *one = mixed + s->row, *out = one + s->row, share[2];
    int64_t at[2];
    const size_t n = (size_t)s->box.n[0] * (size_t)s->info->components, bytes = vv_type_bytes(s->info->type);
    at[1] = find(s->axes, 2, s->box.lo[2] + (int64_t)index, &share[1]) - s->needs.lo[2];
    for (int64_t j = 0; j < s->box.n[1]; j++) {
        at[0] = find(s->axes, 1, s->box.lo[1] + j, &share[0]) - s->needs.lo[1];
        mix_rows(mixed, one, s, at, share);
        sample_row(out, mixed, s);
        vvi_samples_from_f64(s->out + (index * (size_t)s->box.n[1] + (size_t)j) * n * bytes, out, s->info->type, n);
    }
    return vvi_job_poll(s->job);
}

vv_status vvi_axes_sample(vv_field **out, const vv_field_info *info, const vvi_axes *axes, const vv_box *region,
                          const vv_field *stored, const vv_box *needs, vv_job *job)
{
    static const vvi_work work = {.stage = "resample", .start = start, .item = sample_slice, .finish = finish};
    sampling s = {.axes = axes, .info = info, .box = box_of(axes, region), .needs = *needs, .job = job};
    vv_field_info part = *info;
    vv_brick brick;
    void *data;
    uint64_t bytes;
    *out = NULL;
    part.grid = vv_grid_crop(&info->grid, &s.box);
    const vv_box all = vv_field_box(stored);
    vv_status st = vv_field_info_bytes(&bytes, &part);
    if (st != VV_OK || (st = vvi_memory_plan(job, bytes, "volume")) != VV_OK ||
        (st = vv_field_brick(&brick, stored, &all, job)) != VV_OK)
        return st;
    s.brick = &brick;
    s.row = (size_t)(all.n[0] * info->components);
    vv_field *field;
    if ((st = vv_field_new_empty(&field, &data, &part, job)) == VV_OK) {
        s.out = data;
        if ((st = vvi_parallel_for(job, &work, &s, (size_t)s.box.n[2])) == VV_OK)
            st = vv_field_health(stored);
        if (st == VV_OK)
            *out = field;
        else
            vv_field_release(field);
    }
    vv_brick_release(&brick);
    return st;
}
