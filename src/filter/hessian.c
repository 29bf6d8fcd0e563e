#include "filter/hessian.h"
#include "core/memory.h"
#include "core/vec.h"
#include "filter/real_samples.h"
#include "filter/smoothed_samples.h"
#include "filter/window.h"
#include "grid/slabs.h"

#include <math.h>

#define ITEM_SAMPLES 4096
enum { ROWS = 9 }; /* of neighbours, and the one in the middle */

typedef struct shared {
    vv_brick smooth;
    vvi_slabs slabs;                           /* of the box, in the smoothed field's numbers */
    double turn[VVI_SYMMETRIC][VVI_SYMMETRIC]; /* by entry in the world: what each entry of index axes counts */
    vvi_hessian_take *take;
    void *user;
    vv_job *job;
} shared;

static size_t row_room(const shared *s)
{
    return (size_t)s->slabs.step[0] + 2;
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const size_t bytes = row_room(s) * (ROWS + VVI_SYMMETRIC) * sizeof(double);
    *scratch_out = vvi_alloc(s->job, bytes, VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(bytes);
}

static void finish(void *scratch, void *user)
{
    vvi_free(scratch);
}

static int64_t clamped(int64_t v, int64_t lo, int64_t n)
{
    return v < lo ? lo : v >= lo + n ? lo + n - 1 : v;
}

/* n + 2 numbers of a row, from the one before `x` on; repeated beyond the border. */
static void load_row(double *out, const shared *s, int component, int64_t x, int64_t n, int64_t y, int64_t z)
{
    const vv_brick *b = &s->smooth;
    const int64_t *lo = b->box.lo, *size = b->box.n;
    const int64_t first = clamped(x - 1, lo[0], size[0]), last = clamped(x + n, lo[0], size[0]);
    const char *row = (const char *)b->data + component * (int64_t)vv_type_bytes(b->type) +
                      (clamped(y, lo[1], size[1]) - lo[1]) * b->stride[1] +
                      (clamped(z, lo[2], size[2]) - lo[2]) * b->stride[2];
    double *inside = out + (first - (x - 1));
    vvi_reals_of_samples(inside, true, row + (first - lo[0]) * b->stride[0], b->stride[0], b->type, last - first + 1);
    if (first > x - 1)
        out[0] = inside[0];
    if (last < x + n)
        out[n + 1] = out[n];
    for (int64_t i = 0; i < n + 2; i++)
        out[i] = isfinite(out[i]) ? out[i] : NAN;
}

static double second(double before, double here, double behind)
{
    return ((before == before ? before : here) - here) + ((behind == behind ? behind : here) - here);
}

/* A quarter of it; nothing is known of it where one of the four is missing. */
static double mixed(double low_low, double low_high, double high_low, double high_high)
{
    const double d = (high_high - high_low) - (low_high - low_low);
    return d == d ? 0.25 * d : 0;
}

/* r[dz][dy]: rows beside the sample, from the one before it on. */
static void index_entries(double h[VVI_SYMMETRIC], const double *const r[3][3], int64_t i)
{
    const double *row = r[1][1] + i;
    h[VVI_XX] = second(row[0], row[1], row[2]);
    h[VVI_YY] = second(r[1][0][i + 1], row[1], r[1][2][i + 1]);
    h[VVI_ZZ] = second(r[0][1][i + 1], row[1], r[2][1][i + 1]);
    h[VVI_XY] = mixed(r[1][0][i], r[1][2][i], r[1][0][i + 2], r[1][2][i + 2]);
    h[VVI_XZ] = mixed(r[0][1][i], r[2][1][i], r[0][1][i + 2], r[2][1][i + 2]);
    h[VVI_YZ] = mixed(r[0][0][i + 1], r[2][0][i + 1], r[0][2][i + 1], r[2][2][i + 1]);
}

static void world_row(double *const out[VVI_SYMMETRIC], const shared *s, const double *const r[3][3], int64_t n)
{
    for (int64_t i = 0; i < n; i++) {
        double h[VVI_SYMMETRIC];
        index_entries(h, r, i);
        const double there = r[1][1][i + 1] - r[1][1][i + 1]; /* NaN stay */
        for (int e = 0; e < VVI_SYMMETRIC; e++) {
            double sum = there;
            for (int f = 0; f < VVI_SYMMETRIC; f++)
                sum += s->turn[e][f] * h[f];
            out[e][i] = sum;
        }
    }
}

static vv_status item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->slabs, index);
    const size_t room = row_room(s);
    double *numbers = scratch, *out[VVI_SYMMETRIC];
    const double *r[3][3];
    vvi_hessian_row row = {.n = box.n[0], .item = index};
    for (int e = 0; e < VVI_SYMMETRIC; e++)
        row.entry[e] = out[e] = numbers + (size_t)(ROWS + e) * room;
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++)
            for (row.component = 0; row.component < s->smooth.components; row.component++) {
                for (int a = 0; a < ROWS; a++) {
                    double *to = numbers + (size_t)a * room;
                    load_row(to, s, row.component, box.lo[0], box.n[0], box.lo[1] + j + a % 3 - 1,
                             box.lo[2] + k + a / 3 - 1);
                    r[a / 3][a % 3] = to;
                }
                row.at = vvi_slabs_row(&s->slabs, &box, j, k);
                world_row(out, s, (const double *const(*)[3])r, box.n[0]);
                s->take(s->user, &row);
            }
    return vvi_job_poll(s->job);
}

/* Slopes along index axes turn with the inverse of the grid's map, on both sides of the matrix. Along an axis of one
 * sample nothing changes. */
static void set_turn(shared *s, const vv_field_info *info, double sigma)
{
    static const int first[VVI_SYMMETRIC] = {0, 1, 2, 0, 0, 1}, other[VVI_SYMMETRIC] = {0, 1, 2, 1, 2, 2};
    vv_affine inverse = vv_affine_identity();
    vv_affine_invert(&inverse, info->grid.index_to_world);
    const double scale = info->value_scale;
    for (int e = 0; e < VVI_SYMMETRIC; e++)
        for (int f = 0; f < VVI_SYMMETRIC; f++) {
            const double *column_a = &inverse.axis[first[e]].x, *column_b = &inverse.axis[other[e]].x;
            const int p = first[f], q = other[f];
            const double one = sigma * column_a[p] * (sigma * column_b[q]),
                         two = sigma * column_a[q] * (sigma * column_b[p]);
            s->turn[e][f] = scale * (p == q ? one : one + two);
        }
}

size_t vvi_hessian_items(const vv_box *box)
{
    return vvi_slabs_of(box, ITEM_SAMPLES).n;
}

double vvi_hessian_bytes(const vv_field_info *info, const vv_box *box, double sigma)
{
    double samples = 1;
    for (int a = 0; a < 3; a++) {
        const double n = (double)info->grid.dims[a];
        const double reach = n > 1 ? floor(4 * sigma / vv_grid_spacing(&info->grid, a) + 0.5) + 1 : 0;
        samples *= fmin(n, (double)box->n[a] + 2 * reach);
    }
    return 2 * samples * info->components * (double)vvi_reals_bytes(vvi_reals_wide(info->type));
}

vv_status vvi_hessian_each(const vv_field *in, const vv_box *box, double sigma, vvi_hessian_take *take, void *user,
                           vv_job *job)
{
    static const vvi_work work = {.stage = "second derivatives", .start = start, .item = item, .finish = finish};
    static const int64_t one[3] = {1, 1, 1};
    const vv_field_info *info = vv_field_get_info(in);
    const vv_box around = vvi_window_reach(box, one, info->grid.dims);
    vv_field *smooth = NULL;
    shared s = {.take = take, .user = user, .job = job};
    vv_box here = *box;
    vv_status st = vvi_smoothed(&smooth, in, &around, sigma, job);
    if (st != VV_OK)
        return st;
    const vv_box all = vv_field_box(smooth);
    for (int a = 0; a < 3; a++)
        here.lo[a] -= around.lo[a];
    s.slabs = vvi_slabs_of(&here, ITEM_SAMPLES);
    set_turn(&s, info, sigma);
    if ((st = vv_field_brick(&s.smooth, smooth, &all, job)) == VV_OK)
        st = vvi_parallel_for(job, &work, &s, s.slabs.n);
    vv_brick_release(&s.smooth);
    vv_field_release(smooth);
    return st;
}
