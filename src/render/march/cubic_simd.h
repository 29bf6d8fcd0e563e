/** @file
 * Values and gradients of a cubic B-spline whose coefficients are a lattice of floats. For kernels only.
 *
 * The coefficients were made so that the spline goes through the samples (cubic_spline.h). Past the border they are
 * mirrored about the last sample.
 */
#ifndef VVI_RENDER_MARCH_CUBIC_SIMD_H
#define VVI_RENDER_MARCH_CUBIC_SIMD_H
#include "render/march/lattice_simd.h"

/** Weights of the four coefficients around a place, and their derivatives. */
typedef struct cubic_weights {
    vf w[4], d[4];
} cubic_weights;

VV_INLINE cubic_weights find_cubic_weights(vf t)
{
    cubic_weights c;
    const vf sixth = vf_set1(1.0f / 6), half = vf_set1(0.5f), one = vf_set1(1.0f), t2 = t * t, u = one - t;
    c.w[0] = u * u * u * sixth;
    c.w[1] = vf_fma(vf_fma(half, t, vf_set1(-1.0f)), t2, vf_set1(2.0f / 3));
    c.w[3] = t2 * t * sixth;
    c.w[2] = one - c.w[0] - c.w[1] - c.w[3];
    c.d[0] = vf_set1(-0.5f) * u * u;
    c.d[1] = vf_fma(vf_set1(1.5f), t2, vf_set1(-2.0f) * t);
    c.d[3] = half * t2;
    c.d[2] = vf_set1(0.0f) - c.d[0] - c.d[1] - c.d[3];
    return c;
}

/** Numbers of the four samples around cell i of n, mirrored into the grid. */
VV_INLINE void find_cubic_samples(vi out[4], vi i, int32_t n)
{
    const vi zero = vi_set1(0), last = vi_set1(n - 1), twice = vi_set1(2 * (n - 1));
    for (int o = 0; o < 4; o++) {
        vi at = i + vi_set1(o - 1);
        at = vi_max(at, zero - at);
        out[o] = vi_max(vi_select(vi_lt(last, at), twice - at, at), zero);
    }
}

/** Four coefficients of a row: value and derivative along x. */
VV_INLINE void cubic_row(const vvi_lattice *g, const vi x[4], vi yz, const cubic_weights *c, vm m, vf *value, vf *slope)
{
    vi low, high;
    vf v[4];
    v[0] = vf_gather4(g->data, x[0] + yz, m);
    vi_gather_pair4(g->data, x[1] + yz, m, &low, &high);
    v[1] = vf_bits(low);
    v[2] = g->n[0] > 1 ? vf_bits(high) : v[1];
    v[3] = vf_gather4(g->data, x[3] + yz, m);
    *value = vf_fma(v[0], c->w[0], vf_fma(v[1], c->w[1], vf_fma(v[2], c->w[2], v[3] * c->w[3])));
    *slope = vf_fma(v[0], c->d[0], vf_fma(v[1], c->d[1], vf_fma(v[2], c->d[2], v[3] * c->d[3])));
}

/** Value, and gradient in index space, from the same 64 coefficients. The lattice is not wide. */
static __attribute__((noinline)) void cubic_sample(vf *value, vf3 *gradient, const vvi_lattice *g, const vf3 *p, vm m)
{
    const vf zero = vf_set1(0.0f);
    const cell_at c = find_cell(g, *p);
    const cubic_weights wx = find_cubic_weights(c.fx), wy = find_cubic_weights(c.fy), wz = find_cubic_weights(c.fz);
    vi x[4], y[4], z[4];
    find_cubic_samples(x, c.i, g->n[0]);
    find_cubic_samples(y, c.j, g->n[1]);
    find_cubic_samples(z, c.k, g->n[2]);
    *value = zero;
    *gradient = vf3_set(zero, zero, zero);
    for (int k = 0; k < 4; k++) {
        vf in_slice = zero, dx = zero, dy = zero;
        for (int j = 0; j < 4; j++) {
            vf v, slope;
            cubic_row(g, x, y_offset(g, y[j]) + z_offset(g, VVI_SAMPLE_F32, z[k]), &wx, m, &v, &slope);
            in_slice = vf_fma(v, wy.w[j], in_slice);
            dx = vf_fma(slope, wy.w[j], dx);
            dy = vf_fma(v, wy.d[j], dy);
        }
        *value = vf_fma(in_slice, wz.w[k], *value);
        gradient->x = vf_fma(dx, wz.w[k], gradient->x);
        gradient->y = vf_fma(dy, wz.w[k], gradient->y);
        gradient->z = vf_fma(in_slice, wz.d[k], gradient->z);
    }
}

#endif
