#include "render/common/cubic_spline.h"
#include "core/cache.h"
#include "core/job.h"
#include "grid/field.h"
#include <math.h>
#include <string.h>

#define POLE (-0.26794919243112270647) /* sqrt(3) - 2 */
/* Where its powers are below the last bit of a float. */
enum { HORIZON = 16 };

/* Lines of n numbers, `stride` apart, `width` of them side by side. */
typedef struct lines {
    float *v;
    size_t n, stride, width;
} lines;

static float *row(const lines *l, size_t k)
{
    return l->v + k * l->stride;
}

static void add_row(float *restrict to, const float *restrict from, float factor, size_t width)
{
    for (size_t i = 0; i < width; i++)
        to[i] += factor * from[i];
}

/* The first number of the forward pass: the sum over all mirror images, z^k of the k-th sample. Rows beyond the end
 * come back: 0 1 .. n-1 n-2 .. 1 0 1 .. */
static void begin_forward(const lines *l)
{
    const size_t period = 2 * (l->n - 1);
    const float z = (float)POLE;
    if (l->n > HORIZON) {
        float power = z;
        for (size_t k = 1; k < HORIZON; k++, power *= z)
            add_row(row(l, 0), row(l, k), power, l->width);
        return;
    }
    const float all = (float)(1 / (1 - pow(POLE, (double)period)));
    for (size_t i = 0; i < l->width; i++) {
        float sum = row(l, 0)[i], power = z;
        for (size_t k = 1; k < period; k++, power *= z)
            sum += power * row(l, k < l->n ? k : period - k)[i];
        row(l, 0)[i] = sum * all;
    }
}

/* Samples to coefficients, in place: one pass forwards, one backwards. */
static void filter(const lines *l)
{
    const float z = (float)POLE, end = (float)(POLE / (POLE * POLE - 1));
    if (l->n < 2)
        return;
    for (size_t k = 0; k < l->n; k++)
        for (size_t i = 0; i < l->width; i++)
            row(l, k)[i] *= 6.0f;
    begin_forward(l);
    for (size_t k = 1; k < l->n; k++)
        add_row(row(l, k), row(l, k - 1), z, l->width);
    float *last = row(l, l->n - 1);
    const float *before = row(l, l->n - 2);
    for (size_t i = 0; i < l->width; i++)
        last[i] = end * (last[i] + z * before[i]);
    for (size_t k = l->n - 1; k-- > 0;)
        for (size_t i = 0; i < l->width; i++)
            row(l, k)[i] = z * (row(l, k + 1)[i] - row(l, k)[i]);
}

typedef struct spline {
    const vv_brick *from;
    float *to;
    size_t n[3];
} spline;

/* Item: one slice, along x and y. */
static vv_status filter_slice(void *scratch, void *shared, size_t k)
{
    const spline *s = shared;
    float *slice = s->to + k * s->n[0] * s->n[1];
    (void)scratch;
    for (size_t j = 0; j < s->n[1]; j++) {
        const char *in =
            (const char *)s->from->data + (int64_t)k * s->from->stride[2] + (int64_t)j * s->from->stride[1];
        float *out = slice + j * s->n[0];
        for (size_t i = 0; i < s->n[0]; i++) {
            double v;
            vvi_samples_to_f64(&v, in + (int64_t)i * s->from->stride[0], s->from->type, 1);
            out[i] = (float)v;
        }
        filter(&(lines){out, s->n[0], 1, 1});
    }
    filter(&(lines){slice, s->n[1], s->n[0], s->n[0]});
    return VV_OK;
}

/* Item: one row of every slice, along z. */
static vv_status filter_rows(void *scratch, void *shared, size_t j)
{
    const spline *s = shared;
    (void)scratch;
    filter(&(lines){s->to + j * s->n[0], s->n[2], s->n[0] * s->n[1], s->n[0]});
    return VV_OK;
}

typedef struct request {
    const vv_field *field;
    const vv_brick *from;
} request;

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    vv_field_info info = *vv_field_get_info(r->field);
    vv_field *field = NULL;
    void *data = NULL;
    info.type = VV_TYPE_F32;
    info.components = 1;
    info.meaning = VV_MEANING_SCALAR;
    vv_status st = vv_field_info_bytes(bytes_out, &info);
    if (st != VV_OK || (st = vv_field_new_empty(&field, &data, &info, job)) != VV_OK)
        return st;
    spline s = {.from = r->from, .to = data};
    for (int a = 0; a < 3; a++)
        s.n[a] = (size_t)info.grid.dims[a];
    const vvi_work slices = {.stage = "spline", .item = filter_slice};
    const vvi_work rows = {.stage = "spline", .item = filter_rows};
    if ((st = vvi_parallel_for(job, &slices, &s, s.n[2])) != VV_OK ||
        (st = vvi_parallel_for(job, &rows, &s, s.n[1])) != VV_OK) {
        vv_field_release(field);
        return st;
    }
    *value_out = field;
    return VV_OK;
}

static void drop(void *value)
{
    vv_field_release(value);
}

static vv_status replace(vvi_lattice_hold *h, const vv_field *field, int component, vv_job *job)
{
    request r = {field, &h->brick};
    const vvi_cache_key key = {"cubic spline", vv_field_identity(field), (uint64_t)component};
    struct vvi_cached *cached = NULL;
    vv_status st = vvi_cache_get(&cached, &key, make, drop, &r, job);
    if (st != VV_OK)
        return st;
    vv_brick_release(&h->brick);
    vvi_cache_release(h->cached);
    h->brick = (vv_brick){0};
    h->cached = cached;
    const vv_field *coefficients = vvi_cached_value(cached);
    const vv_box box = vv_field_box(coefficients);
    if ((st = vv_field_brick(&h->brick, coefficients, &box, job)) != VV_OK)
        return st;
    h->lattice.data = h->brick.data;
    h->lattice.sample_type = VVI_SAMPLE_F32;
    return VV_OK;
}

vv_status vvi_lattice_open_cubic(vvi_lattice_hold *out, const vv_field *field, int component, vv_job *job)
{
    vv_status st = vvi_lattice_open(out, field, component, job);
    if (st != VV_OK)
        return st;
    if (out->lattice.fetch == VVI_FETCH_WIDE)
        st = vv_fail(VV_E_UNSUPPORTED, "cubic interpolation takes at most 2^31 samples; use linear, crop or resample");
    else
        st = replace(out, field, component, job);
    if (st != VV_OK)
        vvi_lattice_close(out);
    return st;
}

/* Its value ------------------------------------------------------------------------------------------------------- */

static double coefficient(const vvi_lattice *g, int64_t i, int64_t j, int64_t k)
{
    return (double)((const float *)g->data)[k * g->slice + j * g->row + i];
}

/* The cubic B-spline and its derivative at a distance from a coefficient. */
static double weight_at(double x, bool derivative)
{
    const double a = fabs(x), u = 2 - a;
    if (a >= 2)
        return 0;
    if (derivative)
        return (x < 0 ? -1 : 1) * (a < 1 ? 1.5 * a * a - 2 * a : -u * u / 2);
    return a < 1 ? 2.0 / 3 - a * a + a * a * a / 2 : u * u * u / 6;
}

/* Of the numbers 0 .. n-1, mirrored about the first and the last. */
static int64_t mirrored(int64_t i, int64_t n)
{
    if (n == 1)
        return 0;
    i = i < 0 ? -i : i;
    return i > n - 1 ? 2 * (n - 1) - i : i;
}

double vvi_cubic_at(const vvi_lattice *g, const double p[3], int axis)
{
    double x[3], sum = 0;
    int64_t c[3];
    for (int a = 0; a < 3; a++) {
        x[a] = fmin(fmax(p[a], 0), g->n[a] - 1);
        c[a] = x[a] < g->n[a] - 2 ? (int64_t)x[a] : g->n[a] > 1 ? g->n[a] - 2 : 0;
    }
    for (int o = 0; o < 64; o++) {
        const int64_t at[3] = {c[0] + o % 4 - 1, c[1] + o / 4 % 4 - 1, c[2] + o / 16 - 1};
        double w = 1;
        for (int a = 0; a < 3; a++)
            w *= weight_at(x[a] - (double)at[a], a == axis);
        if (w != 0)
            sum += w * coefficient(g, mirrored(at[0], g->n[0]), mirrored(at[1], g->n[1]), mirrored(at[2], g->n[2]));
    }
    return sum;
}
