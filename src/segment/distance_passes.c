/* Distances that memory does not hold: along x and y of a few slices after the other; what these leave lies in a
 * temporary file, where columns of all slices are measured along z, some rows of them at a time. Between the two a
 * number has both sides: the square to the object outside of it, and inside, where that is 0, less the square to what
 * is outside. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "io/scratch_file.h"
#include "segment/distance_lines.h"
#include "segment/distance_object.h"

#include <math.h>
#include <string.h>

#define SHARE 8        /* of the memory, for a slab or for columns */
#define SLICES 16      /* of a slab, at most */
#define MOST (4 << 20) /* bytes that columns take at most: more makes nothing faster */

typedef struct passes {
    vvi_scratch_file *file;
    vvi_distance_object object;
    const vv_field *in;
    int side;
    int64_t n[3];
    double spacing[3];
    float *out, *inside; /* of a slab, or of columns; inside: where both sides are measured */
    vv_job *job;
} passes;

static vv_status make_room(passes *p, size_t samples)
{
    const size_t bytes = samples * sizeof(float);
    p->out = vvi_alloc(p->job, bytes, VVI_MEM_SCRATCH);
    p->inside = p->side == VVI_DISTANCE_BOTH ? vvi_alloc(p->job, bytes, VVI_MEM_SCRATCH) : p->out;
    return p->out && p->inside ? VV_OK : vv_fail_memory(bytes);
}

static void free_room(passes *p)
{
    vvi_free(p->out);
    if (p->inside != p->out)
        vvi_free(p->inside);
    p->out = p->inside = NULL;
}

/* How many things of so many samples are worked on at once. */
static int64_t at_once(const passes *p, int64_t samples, double bytes_each, double most)
{
    const double share = p->job ? (double)vv_runtime_memory_limit(vv_job_runtime(p->job)) / SHARE : most;
    const double bytes = bytes_each * (double)samples * (p->side == VVI_DISTANCE_BOTH ? 2 : 1);
    const double n = floor(fmin(share, most) / bytes);
    return n < 1 ? 1 : (int64_t)n;
}

/* One sign for each side: both cannot be more than 0 at once. */
static void join(float *out, const float *inside, size_t n)
{
    for (size_t i = 0; i < n; i++)
        out[i] = inside[i] > 0 ? -inside[i] : out[i];
}

static void part(float *out, float *inside, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        inside[i] = out[i] < 0 ? -out[i] : 0;
        out[i] = out[i] > 0 ? out[i] : 0;
    }
}

static vv_status measure(passes *p, const int64_t n[3], const int axes[2])
{
    const int last = vvi_distances_last(p->n);
    vv_status st = VV_OK;
    p->object.complement = false;
    if (p->side != VVI_DISTANCE_INSIDE)
        st = vvi_distances_along(p->out, n, p->spacing, axes, last, vvi_distance_set_row, &p->object, p->job);
    if (st != VV_OK || p->side == VVI_DISTANCE_OUTSIDE)
        return st;
    const uint64_t counted = atomic_load(&p->object.n_inside);
    p->object.complement = true;
    st = vvi_distances_along(p->inside, n, p->spacing, axes, last, vvi_distance_set_row, &p->object, p->job);
    if (p->side == VVI_DISTANCE_BOTH)
        atomic_store(&p->object.n_inside, counted);
    return st;
}

/* Along x and y ---------------------------------------------------------------------------------------------------- */

static vv_status measure_slab(passes *p, const vv_box *box)
{
    const size_t n = (size_t)(box->n[0] * box->n[1] * box->n[2]);
    vv_status st = vv_field_brick(&p->object.brick, p->in, box, p->job);
    if (st == VV_OK)
        st = measure(p, box->n, (const int[2]){0, 2});
    vv_brick_release(&p->object.brick);
    if (p->side == VVI_DISTANCE_BOTH && st == VV_OK)
        join(p->out, p->inside, n);
    const uint64_t at = (uint64_t)(box->lo[2] * box->n[0] * box->n[1]) * sizeof(float);
    return st == VV_OK ? vvi_scratch_file_write(p->file, at, p->out, n * sizeof(float), p->job) : st;
}

static vv_status measure_slabs(passes *p)
{
    const int64_t slice = p->n[0] * p->n[1], slices = at_once(p, slice, sizeof(float), 1e18);
    const int64_t step = slices < SLICES ? slices : SLICES;
    vv_status st = make_room(p, (size_t)(slice * (step < p->n[2] ? step : p->n[2])));
    for (int64_t k = 0; k < p->n[2] && st == VV_OK; k += step) {
        const vv_box box = {{0, 0, k}, {p->n[0], p->n[1], p->n[2] - k < step ? p->n[2] - k : step}};
        vvi_job_hush(p->job, 1);
        st = measure_slab(p, &box);
        vvi_job_hush(p->job, -1);
        if (st == VV_OK)
            st = vvi_job_progress(p->job, "distance", (uint64_t)(k + box.n[2]), 2 * (uint64_t)p->n[2]);
    }
    free_room(p);
    return st;
}

/* Along z ---------------------------------------------------------------------------------------------------------- */

typedef vv_status transfer_fn(vvi_scratch_file *file, uint64_t at, float *numbers, size_t n_bytes, vv_job *job);

static vv_status get(vvi_scratch_file *file, uint64_t at, float *numbers, size_t n_bytes, vv_job *job)
{
    return vvi_scratch_file_read(file, at, numbers, n_bytes, job);
}

static vv_status put(vvi_scratch_file *file, uint64_t at, float *numbers, size_t n_bytes, vv_job *job)
{
    return vvi_scratch_file_write(file, at, numbers, n_bytes, job);
}

/* Rows of a box of whole rows lie behind each other in a slice. */
static vv_status transfer(passes *p, const vv_box *box, transfer_fn *fn)
{
    const bool whole = box->n[0] == p->n[0];
    const int64_t rows = whole ? 1 : box->n[1], run = whole ? box->n[0] * box->n[1] : box->n[0];
    float *numbers = p->out;
    vv_status st = VV_OK;
    for (int64_t k = 0; k < p->n[2]; k++)
        for (int64_t j = 0; j < rows && st == VV_OK; j++, numbers += run) {
            const int64_t at = (k * p->n[1] + box->lo[1] + j) * p->n[0] + box->lo[0];
            st = fn(p->file, (uint64_t)at * sizeof(float), numbers, (size_t)run * sizeof(float), p->job);
        }
    return st;
}

static vv_status measure_columns(passes *p, const vv_box *box)
{
    const size_t n = (size_t)(box->n[0] * box->n[1] * box->n[2]);
    vv_status st = transfer(p, box, get);
    if (p->side == VVI_DISTANCE_BOTH && st == VV_OK)
        part(p->out, p->inside, n);
    if (st == VV_OK)
        st = measure(p, box->n, (const int[2]){2, 3});
    if (p->side == VVI_DISTANCE_BOTH && st == VV_OK)
        join(p->out, p->inside, n);
    return st == VV_OK ? transfer(p, box, put) : st;
}

static vv_status measure_all_columns(passes *p)
{
    const int64_t columns = at_once(p, p->n[2], sizeof(float), MOST);
    const int64_t width = columns < p->n[0] ? columns : p->n[0];
    const int64_t fit = columns / width, rows = fit < p->n[1] ? fit : p->n[1];
    vv_status st = make_room(p, (size_t)(width * rows * p->n[2]));
    for (int64_t j = 0; j < p->n[1] && st == VV_OK; j += rows) {
        vvi_job_hush(p->job, 1);
        for (int64_t i = 0; i < p->n[0] && st == VV_OK; i += width) {
            const vv_box box = {
                {i, j, 0},
                {p->n[0] - i < width ? p->n[0] - i : width, p->n[1] - j < rows ? p->n[1] - j : rows, p->n[2]}};
            st = measure_columns(p, &box);
        }
        vvi_job_hush(p->job, -1);
        if (st == VV_OK)
            st = vvi_job_progress(p->job, "distance", (uint64_t)(p->n[2] + j * p->n[2] / p->n[1]),
                                  2 * (uint64_t)p->n[2]);
    }
    free_room(p);
    return st;
}

/* The row's functions ---------------------------------------------------------------------------------------------- */

static uint64_t scratch(const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    const int64_t *n = inputs[0].grid.dims;
    return (uint64_t)(n[0] * n[1] * n[2]) * sizeof(float);
}

static void drop(void *state)
{
    passes *p = state;
    if (!p)
        return;
    vvi_scratch_file_free(p->file);
    vvi_free(p->object.range);
    vvi_free(p);
}

static vv_status find_all(passes *p, const vvi_distance_params *params)
{
    const vv_field_info *info = vv_field_get_info(p->in);
    const uint64_t n_voxels = (uint64_t)(p->n[0] * p->n[1] * p->n[2]);
    vv_status st = vvi_distance_choose(&p->object, params, info, p->job);
    if (st == VV_OK)
        st = vvi_scratch_file_new(&p->file, scratch(info, 1, &params->object), "distance", p->job);
    if (st == VV_OK && (st = measure_slabs(p)) == VV_OK && p->n[2] > 1)
        st = measure_all_columns(p);
    if (st != VV_OK)
        return st;
    if (p->side == VVI_DISTANCE_INSIDE)
        atomic_store(&p->object.n_inside, n_voxels - atomic_load(&p->object.n_inside));
    vvi_distance_tell(&p->object, p->side, n_voxels, p->job);
    return vv_field_health(p->in);
}

static vv_status find(void **state_out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                      vv_job *job)
{
    const vv_grid *grid = &vv_field_get_info(inputs[0])->grid;
    passes *p = vvi_alloc_zeroed(job, sizeof *p, VVI_MEM_SCRATCH);
    *state_out = NULL;
    if (!p)
        return vv_fail_memory(sizeof *p);
    p->in = inputs[0];
    p->side = ((const vvi_distance_params *)params)->side;
    p->job = job;
    memcpy(p->n, grid->dims, sizeof p->n);
    for (int a = 0; a < 3; a++)
        p->spacing[a] = vv_grid_spacing(grid, a);
    const vv_status st = find_all(p, (const vvi_distance_params *)params);
    if (st == VV_OK)
        *state_out = p;
    else
        drop(p);
    return st;
}

static vv_status make(vv_field **out, void *state, const vv_field *const *inputs, size_t n_inputs,
                      const vv_object *params, const vv_box *box, vv_job *job)
{
    const passes *p = state;
    const uint64_t slice = (uint64_t)(p->n[0] * p->n[1]) * sizeof(float);
    vv_field_info info;
    void *data;
    *out = NULL;
    vv_status st = vvi_distance_plan(&info, vv_field_get_info(inputs[0]), n_inputs, params);
    info.grid = vv_grid_crop(&info.grid, box);
    if (st == VV_OK)
        st = vv_field_new_empty(out, &data, &info, job);
    if (st == VV_OK)
        st = vvi_scratch_file_read(p->file, (uint64_t)box->lo[2] * slice, data, (size_t)box->n[2] * (size_t)slice, job);
    return st;
}

const vv_passes vvi_distance_passes = {.find = find, .make = make, .drop = drop, .scratch = scratch};
