#include "filter/resample_weights.h"
#include "core/memory.h"
#include <math.h>
#include <string.h>

#define LOBES 3
#define SLACK 1e-6 /* of a sample: what maps between grids lose */

/* Keys (1981), a = -1/2: interpolates, reproduces parabolas. */
static double cubic(double x)
{
    x = fabs(x);
    if (x >= 2)
        return 0;
    return x < 1 ? (1.5 * x - 2.5) * x * x + 1 : ((-0.5 * x + 2.5) * x - 4) * x + 2;
}

/* A sinc under the middle of another that is LOBES times as wide: Lanczos, after Duchon (1979). */
static double lanczos(double x)
{
    const double p = 3.14159265358979323846 * fabs(x);
    if (x == nearbyint(x)) /* where sines of multiples of pi are not quite 0 */
        return x == 0;
    return fabs(x) < LOBES ? LOBES * sin(p) * sin(p / LOBES) / (p * p) : 0;
}

static double kernel_at(vvi_resample_kernel kernel, double x)
{
    switch (kernel) {
    case VVI_RESAMPLE_CUBIC:
        return cubic(x);
    case VVI_RESAMPLE_LANCZOS:
        return lanczos(x);
    default:
        return fabs(x) < 1 ? 1 - fabs(x) : 0;
    }
}

/* How far it goes to each side, in its own widths. */
static double reach_of(vvi_resample_kernel kernel)
{
    return kernel == VVI_RESAMPLE_CUBIC ? 2 : kernel == VVI_RESAMPLE_LANCZOS ? LOBES : 1;
}

static int64_t clamp(double i, int64_t n)
{
    return i < 0 ? 0 : i > (double)(n - 1) ? n - 1 : (int64_t)i;
}

/* What a sample beyond the ends, k, would weigh: it is taken as the samples mirrored there in place and in value, 2 s0
 * - s1 before s0, so that what rises evenly rises on. */
static void weigh_beyond(double *w, int64_t first, int64_t k, int64_t n_old, double weight)
{
    const int64_t end = k < 0 ? 0 : n_old - 1, mirrored = clamp(2. * (double)end - (double)k, n_old);
    w[end - first] += 2 * weight;
    w[mirrored - first] -= weight;
}

int vvi_resample_most(vvi_resample_kernel kernel, double width, int64_t n_old)
{
    return (int)fmin(fmin(2 * reach_of(kernel) * width + 2, (double)n_old + 1), 1 << 24);
}

int vvi_resample_weigh(double *w, int64_t *first, int most, vvi_resample_kernel kernel, int64_t n_old, double at,
                       double width)
{
    if (kernel == VVI_RESAMPLE_NEAREST) {
        *first = clamp(floor(at + 0.5), n_old);
        w[0] = 1;
        return 1;
    }
    /* outside the samples the value of the nearest holds */
    at = fmin(fmax(at, 0), (double)(n_old - 1));
    const double reach = reach_of(kernel) * width;
    const int64_t lo = clamp(ceil(at - reach), n_old), hi = clamp(floor(at + reach), n_old);
    double sum = 0;
    int n = 0;
    *first = lo;
    for (int64_t k = lo; k <= hi && n < most; k++, n++) {
        w[n] = kernel_at(kernel, ((double)k - at) / width);
        sum += w[n];
    }
    for (int64_t k = (int64_t)ceil(at - reach); reach > width && k <= (int64_t)floor(at + reach); k++)
        if (k < 0 || k >= n_old) {
            const double weight = kernel_at(kernel, ((double)k - at) / width);
            weigh_beyond(w, lo, k, n_old, weight);
            sum += weight;
        }
    for (; n > 1 && w[n - 1] == 0; n--)
        ;
    for (; n > 1 && w[0] == 0; n--) {
        ++*first;
        memmove(w, w + 1, (size_t)(n - 1) * sizeof *w);
    }
    for (int k = 0; k < n; k++)
        w[k] /= sum;
    return n;
}

bool vvi_resample_inside(double at, int64_t n_old)
{
    return at >= -0.5 - SLACK && at <= (double)n_old - 0.5 + SLACK;
}

vv_status vvi_resample_axis_make(vvi_resample_axis *out, vvi_resample_kernel kernel, int64_t n_old, int64_t n,
                                 double start, double step, vv_job *job)
{
    const double width = fmax(fabs(step), 1);
    *out = (vvi_resample_axis){.n = n, .most = vvi_resample_most(kernel, width, n_old)};
    size_t bytes;
    vv_status st = vvi_mul3_size(&bytes, (size_t)n, (size_t)out->most, sizeof *out->w);
    if (st != VV_OK || (st = vvi_memory_plan(job, bytes, "the weights of an axis")) != VV_OK)
        return st;
    out->first = vvi_alloc(job, (size_t)n * sizeof *out->first, VVI_MEM_SCRATCH);
    out->count = vvi_alloc(job, (size_t)n * sizeof *out->count, VVI_MEM_SCRATCH);
    out->w = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    if (!out->first || !out->count || !out->w) {
        vvi_resample_axis_free(out);
        return vv_fail_memory(bytes);
    }
    for (int64_t i = 0; i < n; i++)
        out->count[i] = vvi_resample_weigh(out->w + i * out->most, &out->first[i], out->most, kernel, n_old,
                                           start + (double)i * step, width);
    return VV_OK;
}

void vvi_resample_axis_cut(vvi_resample_axis *axis, int64_t n_old, double start, double step)
{
    for (int64_t i = 0; i < axis->n; i++)
        if (!vvi_resample_inside(start + (double)i * step, n_old))
            axis->count[i] = 0;
}

void vvi_resample_axis_free(vvi_resample_axis *axis)
{
    vvi_free(axis->first);
    vvi_free(axis->count);
    vvi_free(axis->w);
    *axis = (vvi_resample_axis){0};
}
