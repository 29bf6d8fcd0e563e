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

/** Where the coefficients around a place are, and what each counts. */
typedef struct cubic_place {
    cubic_weights x, y, z;
    vi i[4], j[4], k[4]; /* offsets of columns, rows and slices */
    vi first;            /* of the columns, where all four lie beside each other */
    bool inner;          /* they do in all lanes */
} cubic_place;

VV_INLINE void find_cubic_place(cubic_place *c, const vvi_lattice *g, vf3 p, vm m)
{
    const cell_at cell = find_cell(g, p);
    const int32_t last = g->n[0] - 4;
    c->x = find_cubic_weights(cell.fx);
    c->y = find_cubic_weights(cell.fy);
    c->z = find_cubic_weights(cell.fz);
    find_cubic_samples(c->i, cell.i, g->n[0]);
    find_cubic_samples(c->j, cell.j, g->n[1]);
    find_cubic_samples(c->k, cell.k, g->n[2]);
    const sample_place at = cell_place(g, VVI_SAMPLE_ANY, &cell, m);
    const vi before = cell.i - vi_set1(1), first = vi_clamp(before, vi_set1(0), vi_set1(last > 0 ? last : 0));
    for (int o = 0; o < 4; o++) {
        c->i[o] = at.x + (c->i[o] - cell.i);
        c->j[o] = at.y + (c->j[o] - cell.j) * vi_set1(g->row);
        c->k[o] = at.z + (c->k[o] - cell.k) * vi_set1((int32_t)g->slice);
    }
    c->first = at.x + (first - cell.i);
    c->inner = last >= 0 && !vm_any(vm_andnot(m, vi_eq(first, before)));
}

/** The four coefficients of a row. */
VV_INLINE void load_cubic_row(vf v[4], const vvi_lattice *g, const cubic_place *c, vi row, vm m)
{
    if (c->inner) {
        vf_rows4(v, g->data, c->first + row);
        return;
    }
    for (int o = 0; o < 4; o++)
        v[o] = vf_gather4(g->data, c->i[o] + row, m);
}

VV_INLINE vf weighted(const vf v[4], const vf w[4])
{
    return vf_fma(v[0], w[0], vf_fma(v[1], w[1], vf_fma(v[2], w[2], v[3] * w[3])));
}

/** The value alone. The lattice is near (fetch.h). */
static __attribute__((noinline)) vf cubic_value(const vvi_lattice *g, const vf3 *p, vm m)
{
    cubic_place c;
    vf sum = vf_set1(0.0f);
    find_cubic_place(&c, g, *p, m);
    for (int k = 0; k < 4; k++) {
        vf in_slice = vf_set1(0.0f);
        for (int j = 0; j < 4; j++) {
            vf v[4];
            load_cubic_row(v, g, &c, c.j[j] + c.k[k], m);
            in_slice = vf_fma(weighted(v, c.x.w), c.y.w[j], in_slice);
        }
        sum = vf_fma(in_slice, c.z.w[k], sum);
    }
    return sum;
}

/** The gradient in index space, from the same 64 coefficients. */
static __attribute__((noinline)) void cubic_gradient(vf3 *out, const vvi_lattice *g, const vf3 *p, vm m)
{
    const vf zero = vf_set1(0.0f);
    cubic_place c;
    find_cubic_place(&c, g, *p, m);
    *out = vf3_set(zero, zero, zero);
    for (int k = 0; k < 4; k++) {
        vf in_slice = zero, dx = zero, dy = zero;
        for (int j = 0; j < 4; j++) {
            vf v[4];
            load_cubic_row(v, g, &c, c.j[j] + c.k[k], m);
            const vf value = weighted(v, c.x.w);
            in_slice = vf_fma(value, c.y.w[j], in_slice);
            dx = vf_fma(weighted(v, c.x.d), c.y.w[j], dx);
            dy = vf_fma(value, c.y.d[j], dy);
        }
        out->x = vf_fma(dx, c.z.w[k], out->x);
        out->y = vf_fma(dy, c.z.w[k], out->y);
        out->z = vf_fma(in_slice, c.z.d[k], out->z);
    }
}

#endif
