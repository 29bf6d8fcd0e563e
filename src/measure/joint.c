/* Joint histogram of values and lengths of gradients, slice by slice. */
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "grid/field.h"
#include "measure/sums.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum { AUTOMATIC = 256, MOST = 1024 };

/* What one slice has. */
typedef struct found {
    uint64_t count, unknown;
    double value_lo, value_hi, gradient_max, gradient_sum;
} found;

typedef struct looking {
    const vv_field *field;
    int component;
    const vvi_object *object; /* NULL: all samples */
    const vvi_region *region;
    double scale, offset;
    vv_vec3 per_step[3]; /* the gradient of an index coordinate */
    found *found;        /* of each slice; NULL: bins are counted */
    vv_joint *out;
    _Atomic uint64_t *total;
    vv_job *job;
} looking;

/* Rows as numbers: before, here and after along y, and in the slices before and after. */
enum { ROW_HERE = 1, ROW_BELOW = 3, ROW_ABOVE, N_ROWS };

typedef struct worker {
    uint64_t *bits, *count;
    double *row[N_ROWS];
} worker;

static size_t words_of(const looking *s)
{
    return s->object ? s->object->words : 0;
}

static size_t n_bins(const looking *s)
{
    return s->found ? 0 : s->out->n_values * s->out->n_gradients;
}

static vv_status start(void **scratch_out, void *user, int number)
{
    (void)number;
    const looking *s = user;
    const vv_box all = vv_field_box(s->field);
    const size_t bits = (size_t)all.n[1] * words_of(s), n = (size_t)all.n[0];
    const size_t bytes = sizeof(worker) + (bits + n_bins(s) + N_ROWS * n) * 8;
    worker *w = vvi_alloc_zeroed(s->job, bytes, VVI_MEM_SCRATCH);
    *scratch_out = w;
    if (!w)
        return vv_fail_memory(bytes);
    w->bits = (uint64_t *)(w + 1);
    w->count = w->bits + bits;
    for (size_t r = 0; r < N_ROWS; r++)
        w->row[r] = (double *)(w->count + n_bins(s)) + r * n;
    return VV_OK;
}

static void finish(void *scratch, void *user)
{
    looking *s = user;
    worker *w = scratch;
    for (size_t i = 0; w && i < n_bins(s); i++)
        if (w->count[i])
            atomic_fetch_add_explicit(&s->total[i], w->count[i], memory_order_relaxed);
    vvi_free(w);
}

/* Rows --------------------------------------------------------------------------------------------------------------
 */

static void load_row(double *out, const looking *s, const vv_brick *brick, int64_t j, int64_t k, int64_t n)
{
    const size_t bytes = vv_type_bytes(brick->type);
    const char *at =
        (const char *)brick->data + (size_t)s->component * bytes + j * brick->stride[1] + k * brick->stride[2];
    if (brick->stride[0] == (int64_t)bytes)
        vvi_samples_to_f64(out, at, brick->type, (size_t)n);
    for (int64_t i = 0; brick->stride[0] != (int64_t)bytes && i < n; i++)
        vvi_samples_to_f64(&out[i], at + i * brick->stride[0], brick->type, 1);
    for (int64_t i = 0; i < n; i++)
        out[i] = out[i] * s->scale + s->offset;
}

/* Differences to neighbours: over two steps, over one at the border, 0 of a single sample. */
static double length_at(const looking *s, const double *const row[N_ROWS], const double share[2], int64_t i, int64_t n)
{
    const int64_t before = i > 0 ? i - 1 : i, after = i < n - 1 ? i + 1 : i;
    const double d[3] = {after > before ? (row[ROW_HERE][after] - row[ROW_HERE][before]) / (double)(after - before) : 0,
                         (row[2][i] - row[0][i]) * share[0], (row[ROW_ABOVE][i] - row[ROW_BELOW][i]) * share[1]};
    vv_vec3 g = vvi_scaled(s->per_step[0], d[0]);
    g = vvi_add(g, vvi_scaled(s->per_step[1], d[1]));
    return vvi_length(vvi_add(g, vvi_scaled(s->per_step[2], d[2])));
}

static size_t bin_of(double v, double lo, double hi, size_t n)
{
    const double at = (v - lo) / (hi - lo) * (double)n;
    return at < (double)n - 1 ? (size_t)at : n - 1;
}

static void take(const looking *s, worker *w, found *f, double value, double gradient)
{
    const vv_joint *o = s->out;
    if (!isfinite(gradient) || !isfinite(value)) {
        f->unknown++;
        return;
    }
    f->count++;
    f->value_lo = fmin(f->value_lo, value);
    f->value_hi = fmax(f->value_hi, value);
    f->gradient_max = fmax(f->gradient_max, gradient);
    f->gradient_sum += gradient;
    if (s->found || !(value >= o->value_lo && value <= o->value_hi && gradient <= o->gradient_hi))
        return;
    w->count[bin_of(gradient, 0, o->gradient_hi, o->n_gradients) * o->n_values +
             bin_of(value, o->value_lo, o->value_hi, o->n_values)]++;
}

static void take_row(const looking *s, worker *w, found *f, const double share[2], int64_t j, int64_t k, int64_t n)
{
    const double *const row[N_ROWS] = {w->row[0], w->row[1], w->row[2], w->row[3], w->row[4]};
    const uint64_t *bits = w->bits + (size_t)j * words_of(s);
    const vvi_interval in =
        s->region ? vvi_region_points(s->region, (vv_vec3){0, 0, 0}, j, k, 0, n) : (vvi_interval){0, n};
    for (int64_t i = in.lo; i < in.end; i++)
        if (!s->object || bits[i >> 6] >> (i & 63) & 1)
            take(s, w, f, row[ROW_HERE][i], length_at(s, row, share, i, n));
}

static void take_slice(const looking *s, worker *w, found *f, const vv_brick *brick, const int64_t n[3], int64_t k)
{
    const int64_t first = k > 0 ? k - 1 : 0, last = k < n[2] - 1 ? k + 1 : k;
    for (int64_t j = 0; j < n[1]; j++) {
        const int64_t before = j > 0 ? j - 1 : 0, after = j < n[1] - 1 ? j + 1 : j;
        const double share[2] = {after > before ? 1 / (double)(after - before) : 0,
                                 last > first ? 1 / (double)(last - first) : 0};
        double *const reused = w->row[0]; /* rows of this slice move on by one */
        w->row[0] = w->row[1];
        w->row[1] = w->row[2];
        w->row[2] = reused;
        if (j == 0) {
            load_row(w->row[1], s, brick, 0, k - first, n[0]);
            memcpy(w->row[0], w->row[1], (size_t)n[0] * sizeof(double));
        }
        load_row(w->row[2], s, brick, after, k - first, n[0]);
        load_row(w->row[ROW_BELOW], s, brick, j, 0, n[0]);
        load_row(w->row[ROW_ABOVE], s, brick, j, last - first, n[0]);
        take_row(s, w, f, share, j, k, n[0]);
    }
}

static vv_status slice_item(void *scratch, void *user, size_t index)
{
    looking *s = user;
    const vv_box all = vv_field_box(s->field);
    const int64_t k = (int64_t)index, first = k > 0 ? k - 1 : 0, last = k < all.n[2] - 1 ? k + 1 : k;
    const vv_box box = {{0, 0, first}, {all.n[0], all.n[1], last - first + 1}};
    found f = {.value_lo = INFINITY, .value_hi = -INFINITY};
    vv_brick brick;
    vv_status st = s->object ? vvi_object_slice(((worker *)scratch)->bits, s->object, k) : VV_OK;
    if (st != VV_OK || (st = vv_field_brick(&brick, s->field, &box, s->job)) != VV_OK)
        return st;
    take_slice(s, scratch, &f, &brick, all.n, k);
    vv_brick_release(&brick);
    if (s->found)
        s->found[index] = f;
    return VV_OK;
}

/* Both looks --------------------------------------------------------------------------------------------------------
 */

static vv_status find_ranges(found *out, looking *s)
{
    static const vvi_work work = {.stage = "gradients", .start = start, .item = slice_item, .finish = finish};
    const size_t n = (size_t)vv_field_box(s->field).n[2];
    *out = (found){.value_lo = INFINITY, .value_hi = -INFINITY};
    if (!(s->found = vvi_alloc_zeroed(s->job, n * sizeof *s->found, VVI_MEM_SCRATCH)))
        return vv_fail_memory(n * sizeof *s->found);
    const vv_status st = vvi_parallel_for(s->job, &work, s, n);
    for (size_t i = 0; i < n; i++) {
        const found *f = &s->found[i];
        out->count += f->count;
        out->unknown += f->unknown;
        out->value_lo = fmin(out->value_lo, f->value_lo);
        out->value_hi = fmax(out->value_hi, f->value_hi);
        out->gradient_max = fmax(out->gradient_max, f->gradient_max);
        out->gradient_sum += f->gradient_sum;
    }
    vvi_free(s->found);
    s->found = NULL;
    return st;
}

/* Bins of whole numbers are equally many of them wide, so that none gets more of them than its neighbour. */
static void choose_values(vv_joint *out, const found *f, const vv_joint_options *o, const vv_field_info *info)
{
    const size_t most = o->n_values ? (size_t)o->n_values : AUTOMATIC;
    const double lo = isnan(o->value_lo) ? f->value_lo : o->value_lo,
                 hi = isnan(o->value_hi) ? f->value_hi : o->value_hi;
    const double step = fabs(info->value_scale);
    out->n_values = most;
    out->value_lo = lo;
    out->value_hi = hi > lo ? hi : lo + 1;
    if (vv_type_is_float(info->type) || !isnan(o->value_lo) || !isnan(o->value_hi))
        return;
    const double numbers = nearbyint((hi - lo) / step) + 1, width = ceil(numbers / (double)most);
    out->n_values = (size_t)ceil(numbers / width);
    out->value_lo = lo - step / 2;
    out->value_hi = out->value_lo + (double)out->n_values * width * step;
}

static vv_status make_result(looking *s, const found *f, const vv_joint_options *o)
{
    vv_joint head = {.size = sizeof head,
                     .count = f->count,
                     .unknown = f->unknown,
                     .gradient_mean = f->count ? f->gradient_sum / (double)f->count : NAN,
                     .gradient_max = f->count ? f->gradient_max : NAN,
                     .n_gradients = o->n_gradients ? (size_t)o->n_gradients : AUTOMATIC,
                     .gradient_hi = isnan(o->gradient_hi) ? f->gradient_max : o->gradient_hi};
    const found none = {.value_lo = 0, .value_hi = 0};
    head.gradient_hi = head.gradient_hi > 0 ? head.gradient_hi : 1;
    choose_values(&head, f->count ? f : &none, o, vv_field_get_info(s->field));
    const size_t n = head.n_values * head.n_gradients, bytes = sizeof head + n * sizeof *head.bins;
    if (!(s->out = vvi_alloc_zeroed(s->job, bytes, VVI_MEM_DERIVED)))
        return vv_fail_memory(bytes);
    head.bins = (uint64_t *)(s->out + 1);
    *s->out = head;
    return VV_OK;
}

static vv_status count_bins(looking *s)
{
    static const vvi_work work = {.stage = "histogram", .start = start, .item = slice_item, .finish = finish};
    const size_t n = n_bins(s);
    uint64_t *bins = (uint64_t *)(s->out + 1), inside = 0;
    if (!(s->total = vvi_alloc_zeroed(s->job, n * sizeof *s->total, VVI_MEM_SCRATCH)))
        return vv_fail_memory(n * sizeof *s->total);
    const vv_status st = vvi_parallel_for(s->job, &work, s, (size_t)vv_field_box(s->field).n[2]);
    for (size_t i = 0; i < n; i++)
        inside += bins[i] = atomic_load_explicit(&s->total[i], memory_order_relaxed);
    s->out->beyond = s->out->count - inside;
    vvi_free(s->total);
    return st;
}

static vv_status measure(looking *s, const vv_joint_options *o)
{
    found f;
    vv_status st = find_ranges(&f, s);
    if (st == VV_OK && (st = make_result(s, &f, o)) == VV_OK && (st = count_bins(s)) == VV_OK)
        st = vv_field_health(s->field);
    return st;
}

static vv_status with_object(looking *s, const vv_joint_options *o)
{
    vvi_object object;
    vvi_region region;
    vv_status st = vvi_object_open(&object, s->field, o->of, 1, s->job);
    if (st == VV_OK && o->of->seeded)
        st = vvi_object_track(&object, o->of->seed);
    if (st == VV_OK)
        st = vvi_region_init(&region, &vv_field_get_info(s->field)->grid, &o->of->box, 0.5, o->of->planes,
                             o->of->n_planes);
    s->object = &object;
    s->region = &region;
    if (st == VV_OK)
        st = measure(s, o);
    s->object = NULL;
    s->region = NULL;
    vvi_object_close(&object);
    return st;
}

static vv_status check(looking *s, const vv_joint_options *o)
{
    const vv_field_info *info = vv_field_get_info(s->field);
    const int64_t n[2] = {o->n_values, o->n_gradients};
    vv_affine inverse;
    if (o->component < 0 || o->component >= info->components)
        return vv_fail(VV_E_ARGUMENT, "channel %d does not exist; the field has %d, counted from 0", o->component,
                       info->components);
    for (int i = 0; i < 2; i++)
        if (n[i] && (n[i] < 2 || n[i] > MOST))
            return vv_fail(VV_E_ARGUMENT, "%lld bins: expected 2 to %d", (long long)n[i], MOST);
    if (o->value_lo >= o->value_hi || o->gradient_hi <= 0)
        return vv_fail(VV_E_ARGUMENT, "the end of the bins must be above their beginning");
    if (!vv_affine_invert(&inverse, info->grid.index_to_world))
        return vv_fail(VV_E_ARGUMENT, "the grid's axes lie in one plane: there are no gradients in the world");
    for (int a = 0; a < 3; a++)
        s->per_step[a] = vvi_vec((&inverse.axis[0].x)[a], (&inverse.axis[1].x)[a], (&inverse.axis[2].x)[a]);
    return VV_OK;
}

void vv_joint_options_init(vv_joint_options *options, size_t size)
{
    const vv_joint_options all = {.size = size, .value_lo = NAN, .value_hi = NAN, .gradient_hi = NAN};
    memcpy(options, &all, size < sizeof all ? size : sizeof all);
}

vv_status vv_measure_joint(vv_joint **out, const vv_field *field, const vv_joint_options *options, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    looking s = {.field = field, .scale = info->value_scale, .offset = info->value_offset, .job = job};
    vv_joint_options o;
    vv_joint_options_init(&o, sizeof o);
    if (options)
        memcpy(&o, options, options->size < sizeof o ? options->size : sizeof o);
    s.component = o.component;
    *out = NULL;
    vv_status st = check(&s, &o);
    if (st == VV_OK)
        st = o.of ? with_object(&s, &o) : measure(&s, &o);
    if (st == VV_OK)
        *out = s.out;
    else
        vv_joint_free(s.out);
    return st;
}

void vv_joint_free(vv_joint *joint)
{
    vvi_free(joint);
}
