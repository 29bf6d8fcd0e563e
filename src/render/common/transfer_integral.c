#include "render/common/transfer_integral.h"
#include "core/memory.h"
#include <math.h>
#include <string.h>

/* Gauss and Legendre, three points: exact to the fifth degree, and never at an end, where a jump may be. */
static const double point[3] = {0.1127016653792583, 0.5, 0.8872983346207417};
static const double weight[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};

static void add_smooth(double sum[4], const vv_classification *classes, double a, double b)
{
    for (int i = 0; i < 3; i++) {
        double rgbk[4];
        vvi_transfer_evaluate(rgbk, classes, a + point[i] * (b - a));
        const double part = weight[i] * (b - a) * rgbk[3];
        for (int c = 0; c < 3; c++)
            sum[c] += part * rgbk[c];
        sum[3] += part;
    }
}

/* The first node above x, of opacity or colour; INFINITY: none. `at` remembers where in both lists, for ascending x. */
static double next_node(const vv_classification *c, double x, size_t at[2])
{
    while (at[0] < c->n_opacity && c->opacity[2 * at[0]] <= x)
        at[0]++;
    while (at[1] < c->n_color && c->color[4 * at[1]] <= x)
        at[1]++;
    return fmin(at[0] < c->n_opacity ? c->opacity[2 * at[0]] : INFINITY,
                at[1] < c->n_color ? c->color[4 * at[1]] : INFINITY);
}

/* Over [a, b], piece by piece between nodes. */
static void add_pieces(double sum[4], const vv_classification *classes, double a, double b, size_t at[2])
{
    while (a < b) {
        const double end = fmin(next_node(classes, a, at), b);
        add_smooth(sum, classes, a, end);
        a = end;
    }
}

void vvi_transfer_mean(double out[4], const vv_classification *classes, double a, double b)
{
    const double lo = fmin(a, b), hi = fmax(a, b);
    size_t at[2] = {0, 0};
    double sum[4] = {0};
    if (!(hi - lo > 1e-12 * fmax(fabs(lo), fabs(hi)))) {
        vvi_transfer_evaluate(out, classes, lo);
        for (int c = 0; c < 3; c++)
            out[c] *= out[3];
        return;
    }
    for (int i = 0; i < 64; i++) { /* wide ramps bend: -log(1 - opacity) is no polynomial */
        const double from = lo + (hi - lo) * i / 64, to = i == 63 ? hi : lo + (hi - lo) * (i + 1) / 64;
        add_pieces(sum, classes, from, to, at);
    }
    for (int c = 0; c < 4; c++)
        out[c] = sum[c] / (hi - lo);
}

/* Means of all rows, and the whole integral, in rows. A table over one value has that value's everywhere. */
static void fill_means(vvi_transfer_integral *out, double total[4], const vvi_transfer_table *table,
                       const vv_classification *classes)
{
    const double width = (table->hi - table->lo) / (double)out->n;
    size_t at[2] = {0, 0};
    for (size_t i = 0; i < out->n; i++) {
        const double a = table->lo + (double)i * width, b = i + 1 == out->n ? table->hi : a + width;
        double sum[4] = {0};
        if (b > a)
            add_pieces(sum, classes, a, b, at);
        else
            vvi_transfer_mean(sum, classes, a, a);
        for (int c = 0; c < 4; c++) {
            out->mean[4 * i + (size_t)c] = (float)(b > a ? sum[c] / (b - a) : sum[c]);
            total[c] += (double)out->mean[4 * i + (size_t)c];
        }
    }
}

static void fill_sums(vvi_transfer_integral *out, const double total[4])
{
    for (int c = 0; c < 4; c++) {
        double sum = 0;
        out->unit[c] = total[c] / (INT32_MAX - 1);
        for (size_t i = 0; i <= out->n; i++) {
            out->sum[4 * i + (size_t)c] = out->unit[c] > 0 ? (int32_t)lrint(fmin(sum / out->unit[c], INT32_MAX)) : 0;
            if (i < out->n)
                sum += (double)out->mean[4 * i + (size_t)c];
        }
    }
}

/* Rows and those beside them: the place of a value is a float. */
static void fill_running(vvi_transfer_table *table, const vvi_transfer_integral *from)
{
    for (size_t i = 0; i < table->n; i++) {
        const size_t first = i < 2 ? 0 : i - 2, last = i + 1 < from->n ? i + 1 : from->n - 1;
        bool any = false;
        for (size_t r = first; r <= last; r++)
            any |= from->mean[4 * r + 3] > 0;
        table->running[i + 1] = table->running[i] + any;
    }
}

vv_status vvi_transfer_integral_init(vvi_transfer_integral *out, vvi_transfer_table *table,
                                     const vv_classification *classes, vv_job *job)
{
    size_t bytes = 0;
    double total[4] = {0};
    *out = (vvi_transfer_integral){.n = table->n - 1};
    const vv_status st = vvi_mul3_size(&bytes, table->n, 4, sizeof(float));
    if (st != VV_OK)
        return st;
    out->mean = vvi_alloc(job, bytes, VVI_MEM_DERIVED);
    out->sum = vvi_alloc(job, bytes, VVI_MEM_DERIVED);
    if (!out->mean || !out->sum) {
        vvi_transfer_integral_finish(out);
        return vv_fail_memory(2 * bytes);
    }
    fill_means(out, total, table, classes);
    fill_sums(out, total);
    fill_running(table, out);
    return VV_OK;
}

void vvi_transfer_integral_finish(vvi_transfer_integral *integral)
{
    vvi_free(integral->mean);
    vvi_free(integral->sum);
    *integral = (vvi_transfer_integral){0};
}
