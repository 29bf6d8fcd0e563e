/* Inner loops have a constant number of turns and no branches: they become vectors. */
#include "filter/slopes_kernel.h"
#include "core/simd.h"

enum { BLOCK = VVI_SLOPES_GUARD };

/* Central, one-sided beside what is missing. */
VV_INLINE void add_slope(double g[3][BLOCK], const double *at, int64_t step, double lone, const double world[3])
{
    const double *before = at - step, *behind = at + step;
    for (int i = 0; i < BLOCK; i++) {
        const double a = before[i], b = behind[i], c = at[i];
        const double one = b != b ? lone : 1, both = b != b ? 1 : 0.5;
        const double up = (b != b ? c : b) - (a != a ? c : a);
        const double d = up * (a != a ? one : both) + (c - c); /* NaN stay */
        g[0][i] += d * world[0];
        g[1][i] += d * world[1];
        g[2][i] += d * world[2];
    }
}

VV_INLINE void gradient(double g[3][BLOCK], const double *at, const vvi_slopes *s)
{
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < BLOCK; i++)
            g[c][i] = 0;
    for (int a = 0; a < 3; a++)
        add_slope(g, at, s->step[a], s->lone[a], s->world[a]);
}

VV_INLINE void put(double *out, const double *block, int64_t n)
{
    if (n < BLOCK)
        memcpy(out, block, (size_t)n * sizeof *out);
    else
        memcpy(out, block, BLOCK * sizeof *out);
}

static void length(double *out, const double *row, const vvi_slopes *s, int64_t n)
{
    for (int64_t at = 0; at < n; at += BLOCK) {
        double g[3][BLOCK], block[BLOCK];
        gradient(g, row + at, s);
        for (int i = 0; i < BLOCK; i++)
            block[i] = sqrt(g[0][i] * g[0][i] + g[1][i] * g[1][i] + g[2][i] * g[2][i]);
        put(out + at, block, n - at);
    }
}

static void vector(double *out, const double *row, const vvi_slopes *s, int64_t n)
{
    for (int64_t at = 0; at < n; at += BLOCK) {
        double g[3][BLOCK];
        gradient(g, row + at, s);
        for (int64_t i = 0; i < BLOCK && at + i < n; i++)
            for (int c = 0; c < 3; c++)
                out[3 * (at + i) + c] = g[c][i];
    }
}

/* What is missing counts as what is here. */
VV_INLINE double or_here(double v, double here)
{
    return v != v ? here : v;
}

VV_INLINE void add_second(double *sum, const double *at, int64_t step, double counts)
{
    const double *before = at - step, *behind = at + step;
    for (int i = 0; i < BLOCK; i++) {
        const double c = at[i];
        sum[i] += counts * ((or_here(before[i], c) - c) + (or_here(behind[i], c) - c)) + (c - c);
    }
}

/* a, b and b, a: a quarter each. */
VV_INLINE void add_mixed(double *sum, const double *at, int64_t a, int64_t b, double counts)
{
    for (int i = 0; i < BLOCK; i++) {
        const double c = at[i];
        const double same = or_here(at[i + a + b], c) + or_here(at[i - a - b], c);
        const double other = or_here(at[i + a - b], c) + or_here(at[i - a + b], c);
        sum[i] += 0.5 * counts * (same - other);
    }
}

static void laplacian(double *out, const double *row, const vvi_slopes *s, int64_t n)
{
    for (int64_t at = 0; at < n; at += BLOCK) {
        double sum[BLOCK] = {0};
        for (int a = 0; a < 3; a++)
            add_second(sum, row + at, s->step[a], s->second[a][a]);
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < a; b++)
                if (s->second[a][b] != 0)
                    add_mixed(sum, row + at, s->step[a], s->step[b], s->second[a][b]);
        put(out + at, sum, n - at);
    }
}

const vvi_slopes_kernels VV_KERNEL_TABLE(vvi_slopes_kernels) = {
    .isa = VV_ISA_NAME,
    .needs = VV_ISA_NEEDS,
    .length = length,
    .vector = vector,
    .laplacian = laplacian,
};
