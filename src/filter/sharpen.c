#include "filter/sharpen.h"

#include <complex.h>
#include <math.h>

enum { BINS = VVI_SHARPEN_BINS, PADDED = 512, BEFORE = (PADDED - BINS) / 2 };

typedef double _Complex number;

/* In place, of a power of two; forwards (sign -1) or back, not divided by it (Cooley & Tukey 1965). */
static void transform(number *a, int sign)
{
    for (int i = 1, j = 0; i < PADDED; i++) {
        int bit = PADDED >> 1;
        for (; j & bit; bit >>= 1)
            j ^= bit;
        j ^= bit;
        if (i < j) {
            const number t = a[i];
            a[i] = a[j];
            a[j] = t;
        }
    }
    for (int length = 2; length <= PADDED; length *= 2)
        for (int k = 0; k < length / 2; k++) {
            const double angle = sign * 2 * M_PI * k / length;
            const number turn = cos(angle) + sin(angle) * (number)I;
            for (int i = k; i < PADDED; i += length) {
                const number t = turn * a[i + length / 2];
                a[i + length / 2] = a[i] - t;
                a[i] += t;
            }
        }
}

/* What lies between two bins counts for both. */
static void count(number *histogram, const vvi_sharpened *s, const double *v, size_t n)
{
    double bins[BINS + 1] = {0};
    for (size_t i = 0; i < n; i++) {
        if (isnan(v[i]))
            continue;
        const double at = (v[i] - s->lo) / s->width;
        const int bin = at >= BINS - 1 ? BINS - 1 : (int)at;
        bins[bin] += 1 - (at - bin);
        bins[bin + 1] += at - bin;
    }
    for (int i = 0; i < PADDED; i++)
        histogram[i] = i >= BEFORE && i < BEFORE + BINS ? bins[i - BEFORE] : 0;
}

/* The transform of a Gaussian around 0. */
static void blur_of(number *out, double bins_wide)
{
    const double height = 2 * sqrt(M_LN2 / M_PI) / bins_wide, fall = 4 * M_LN2 / (bins_wide * bins_wide);
    for (int i = 0; i < PADDED; i++) {
        const double away = i <= PADDED / 2 ? i : PADDED - i;
        out[i] = height * exp(-away * away * fall);
    }
    transform(out, -1);
}

static void blurred(number *a, const number *blur)
{
    transform(a, -1);
    for (int i = 0; i < PADDED; i++)
        a[i] *= blur[i];
    transform(a, 1);
}

static double center(const vvi_sharpened *s, int bin)
{
    return s->lo + s->width * bin;
}

bool vvi_sharpen(vvi_sharpened *out, const double *v, size_t n, double blur, double noise)
{
    number gaussian[PADDED], sharp[PADDED], weighted[PADDED];
    double lo = INFINITY, hi = -INFINITY;
    for (size_t i = 0; i < n; i++) {
        lo = v[i] < lo ? v[i] : lo;
        hi = v[i] > hi ? v[i] : hi;
    }
    if (!(lo < hi))
        return false;
    out->lo = lo;
    out->width = (hi - lo) / (BINS - 1);
    count(sharp, out, v, n);
    blur_of(gaussian, blur / out->width);
    transform(sharp, -1);
    for (int i = 0; i < PADDED; i++)
        sharp[i] *= creal(conj(gaussian[i]) / (conj(gaussian[i]) * gaussian[i] + noise));
    transform(sharp, 1);
    for (int i = 0; i < PADDED; i++) {
        sharp[i] = fmax(creal(sharp[i]) / PADDED, 0);
        weighted[i] = sharp[i] * center(out, i - BEFORE);
    }
    blurred(sharp, gaussian);
    blurred(weighted, gaussian);
    for (int i = 0; i < BINS; i++) {
        const double below = creal(sharp[i + BEFORE]);
        out->expected[i] = below > 0 ? creal(weighted[i + BEFORE]) / below : center(out, i);
    }
    return true;
}

double vvi_sharpened_value(const vvi_sharpened *s, double v)
{
    const double at = (v - s->lo) / s->width;
    const int bin = at >= BINS - 1 ? BINS - 2 : at > 0 ? (int)at : 0;
    const double t = fmin(fmax(at - bin, 0), 1);
    return s->expected[bin] + t * (s->expected[bin + 1] - s->expected[bin]);
}
