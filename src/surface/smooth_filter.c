#include "surface/smooth_filter.h"
#include "core/memory.h"

#include <math.h>

/* Probability of j successes in n trials of probability t, 0 < t < 1. */
static double binomial(int n, int j, double t)
{
    return exp(lgamma(n + 1.) - lgamma(j + 1.) - lgamma(n - j + 1.) + j * log(t) + (n - j) * log1p(-t));
}

double vvi_smooth_gain(int steps, double m, double t)
{
    const int whole = (int)floor(m);
    double sum = 0;
    if (t <= 0 || m >= steps)
        return 1;
    if (t >= 1)
        return fmax(0, m - (steps - 1));
    const double middle = steps * t, width = sqrt(steps * t * (1 - t)) + 1;
    if (m > middle + 12 * width) /* 0 and 1 to rounding */
        return 1;
    if (m + 1 < middle - 12 * width)
        return 0;
    const int first = (int)fmax(0, floor(middle - 12 * width));
    for (int j = first; j <= whole; j++)
        sum += binomial(steps, j, t);
    return fmin(1, sum + (m - whole) * binomial(steps, whole + 1, t));
}

double vvi_smooth_order(int steps, double pass_band)
{
    const double least = steps < 2 ? 0 : 1, t = pass_band / 2;
    double lo = least, hi = steps;
    if (vvi_smooth_gain(steps, least, t) >= VVI_SMOOTH_KEPT)
        return least;
    for (int i = 0; i < 50; i++) {
        const double middle = (lo + hi) / 2;
        if (vvi_smooth_gain(steps, middle, t) < VVI_SMOOTH_KEPT)
            lo = middle;
        else
            hi = middle;
    }
    return hi;
}

/* c[i], from what the filter is at the extremes of T_n: exact for polynomials of that degree. turn[i]: cos(pi i / n).
 */
static double coefficient(const double *gain, const double *turn, size_t n, size_t i)
{
    double sum = (gain[0] + gain[n] * (i % 2 ? -1 : 1)) / 2;
    for (size_t k = 1, angle = i; k < n; k++, angle = (angle + i) % (2 * n))
        sum += gain[k] * turn[angle];
    return sum * (i == 0 || i == n ? 1 : 2) / (double)n;
}

/* Without the last ones, as far as all of them are less than rounding. */
static int shorten(const double *c, int n)
{
    double rest = 0;
    while (n > 1 && (rest += fabs(c[n - 1])) < 1e-8)
        n--;
    return n;
}

vv_status vvi_smooth_filter_make(vvi_smooth_filter *out, int steps, double pass_band, vv_job *job)
{
    const size_t n = (size_t)steps;
    const double m = vvi_smooth_order(steps, pass_band);
    *out = (vvi_smooth_filter){0};
    double *gain = vvi_alloc(job, (3 * n + 1) * sizeof *gain, VVI_MEM_SCRATCH);
    out->c = vvi_alloc(job, (n + 1) * sizeof *out->c, VVI_MEM_SCRATCH);
    const bool made = gain && out->c;
    if (made) {
        double *turn = gain + n + 1;
        for (size_t i = 0; i < 2 * n; i++)
            turn[i] = cos(M_PI * (double)i / (double)n);
        for (size_t i = 0; i <= n; i++)
            gain[i] = vvi_smooth_gain(steps, m, (1 - turn[i]) / 2);
        for (size_t i = 0; i <= n; i++)
            out->c[i] = coefficient(gain, turn, n, i);
        out->n = shorten(out->c, steps + 1);
    }
    vvi_free(gain);
    return made ? VV_OK : vv_fail_memory((3 * n + 1) * sizeof *gain);
}
