#include "filter/resample_weights.h"
#include "core/memory.h"
#include <math.h>

/* Keys (1981), a = -1/2: interpolates, reproduces parabolas. */
static double cubic(double x)
{
    x = fabs(x);
    if (x >= 2)
        return 0;
    return x < 1 ? (1.5 * x - 2.5) * x * x + 1 : ((-0.5 * x + 2.5) * x - 4) * x + 2;
}

static double kernel_at(vvi_resample_kernel kernel, double x)
{
    if (kernel == VVI_RESAMPLE_CUBIC)
        return cubic(x);
    return fabs(x) < 1 ? 1 - fabs(x) : 0;
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

static void weigh(vvi_resample_axis *axis, int64_t i, vvi_resample_kernel kernel, int64_t n_old, double at,
                  double width)
{
    double *w = axis->w + i * axis->most;
    if (kernel == VVI_RESAMPLE_NEAREST) {
        axis->first[i] = clamp(floor(at + 0.5), n_old);
        axis->count[i] = 1;
        w[0] = 1;
        return;
    }
    /* outside the samples the value of the nearest holds */
    at = fmin(fmax(at, 0), (double)(n_old - 1));
    const double reach = (kernel == VVI_RESAMPLE_CUBIC ? 2 : 1) * width;
    const int64_t lo = clamp(ceil(at - reach), n_old), hi = clamp(floor(at + reach), n_old);
    double sum = 0;
    int n = 0;
    axis->first[i] = lo;
    for (int64_t k = lo; k <= hi && n < axis->most; k++, n++) {
        w[n] = kernel_at(kernel, ((double)k - at) / width);
        sum += w[n];
    }
    for (int64_t k = (int64_t)ceil(at - reach); kernel == VVI_RESAMPLE_CUBIC && k <= (int64_t)floor(at + reach); k++)
        if (k < 0 || k >= n_old) {
            const double weight = kernel_at(kernel, ((double)k - at) / width);
            weigh_beyond(w, lo, k, n_old, weight);
            sum += weight;
        }
    for (; n > 1 && w[n - 1] == 0; n--)
        ;
    for (; n > 1 && w[0] == 0; n--) {
        axis->first[i]++;
        for (int k = 1; k < n; k++)
            w[k - 1] = w[k];
    }
    axis->count[i] = n;
    for (int k = 0; k < n; k++)
        w[k] /= sum;
}

vv_status vvi_resample_axis_make(vvi_resample_axis *out, vvi_resample_kernel kernel, int64_t n_old, int64_t n,
                                 double start, double step, vv_job *job)
{
    const double width = step > 1 ? step : 1;
    const double most = fmin(2 * (kernel == VVI_RESAMPLE_CUBIC ? 2 : 1) * width + 2, (double)n_old + 1);
    *out = (vvi_resample_axis){.n = n, .most = (int)fmin(most, 1 << 24)};
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
        weigh(out, i, kernel, n_old, start + (double)i * step, width);
    return VV_OK;
}

void vvi_resample_axis_free(vvi_resample_axis *axis)
{
    vvi_free(axis->first);
    vvi_free(axis->count);
    vvi_free(axis->w);
    *axis = (vvi_resample_axis){0};
}
