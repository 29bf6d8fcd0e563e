/** @file
 * Label maps with smooth borders: of the labels around a point the one with the most trilinear weight. For kernels
 * only.
 */
#ifndef VVI_RENDER_MARCH_LABELS_SIMD_H
#define VVI_RENDER_MARCH_LABELS_SIMD_H
#include "render/march/lattice_simd.h"

/** Trilinear weights of a cell's corners, x fastest. */
VV_INLINE void corner_weights(vf w[8], const cell_at *c)
{
    const vf one = vf_set1(1.0f);
    const vf x[2] = {one - c->fx, c->fx}, y[2] = {one - c->fy, c->fy}, z[2] = {one - c->fz, c->fz};
    for (int i = 0; i < 8; i++)
        w[i] = x[i & 1] * y[i >> 1 & 1] * z[i >> 2];
}

/** The sum of the weights of the corners that have a label; in the order of corners, so that it is the same number
 * whichever of them asks. */
VV_INLINE vf label_weight(const vf v[8], const vf w[8], vf label)
{
    vf sum = vf_set1(0.0f);
    for (int i = 0; i < 8; i++)
        sum = sum + vf_select(vf_eq(v[i], label), w[i], vf_set1(0.0f));
    return sum;
}

/** Of more than two labels. Out of line: only where three meet. */
static __attribute__((noinline)) vf winner_of_many(const vf v[8], const vf w[8])
{
    vf label = v[0], most = vf_set1(-1.0f);
    for (int i = 0; i < 8; i++) {
        const vf sum = label_weight(v, w, v[i]);
        const vm tie = vm_and(vf_eq(sum, most), vf_lt(v[i], label));
        const vm more = vm_or(vf_lt(most, sum), tie);
        label = vf_select(more, v[i], label);
        most = vf_select(more, sum, most);
    }
    return label;
}

/** The stored label; of two with the same weight the smaller. */
VV_INLINE vf winning_label(const vvi_lattice *g, int how, vf3 p, vm m)
{
    const cell_at c = find_cell(g, p);
    vf v[8], w[8];
    load_corners(g, how, &c, m, (vf(*)[2][2])v);
    vf low = v[0], high = v[0];
    for (int i = 1; i < 8; i++) {
        low = vf_min(low, v[i]);
        high = vf_max(high, v[i]);
    }
    vm one = m, two = m;
    for (int i = 0; i < 8; i++) { /* never of what is no number */
        one = vm_and(one, vf_eq(v[i], low));
        two = vm_and(two, vm_or(vf_eq(v[i], low), vf_eq(v[i], high)));
    }
    if (!vm_any(vm_andnot(m, one)))
        return low;
    corner_weights(w, &c);
    const vf of_low = label_weight(v, w, low), of_high = label_weight(v, w, high);
    const vf winner = vf_select(vf_lt(of_low, of_high), high, low);
    const vm many = vm_andnot(m, two);
    return vm_any(many) ? vf_select(many, winner_of_many(v, w), winner) : winner;
}

VV_INLINE vf is_label(vf v, vf label)
{
    return vf_select(vf_eq(v, label), vf_set1(1.0f), vf_set1(0.0f));
}

/** A row through a cell, interpolated along x. */
VV_INLINE vf label_row(const vvi_lattice *g, int how, vi x, vi yo, vi zo, vf fx, vf label, vm m)
{
    vf l, r;
    load_pair(g, how, x, yo, zo, m, &l, &r);
    return vf_lerp(is_label(l, label), is_label(r, label), fx);
}

/** The gradient, as border_gradient() has it, of the field that is 1 where the label is and 0 elsewhere. */
VV_INLINE vf3 label_gradient_of(const vvi_lattice *g, int how, const cell_at *c, vf label, vm m)
{
    const axis_differences dx = find_differences(c->i, g->n[0]);
    const axis_differences dy = find_differences(c->j, g->n[1]);
    const axis_differences dz = find_differences(c->k, g->n[2]);
    const sample_place at = cell_place(g, how, c, m);
    vi y[4], z[4];
    find_rows(y, at.y, y_up(g), &dy);
    find_rows(z, at.z, z_up(g, how), &dz);
    vf in[2][2], gx[2][2], gy[2], gz[2];
    for (int i = 0; i < 4; i++) {
        vf q[4];
        const int b = i >> 1, a = i & 1;
        load_quad(g, how, at.x, y[a + 1], z[b + 1], dx.first, dx.last, m, q);
        for (int k = 0; k < 4; k++)
            q[k] = is_label(q[k], label);
        in[b][a] = vf_lerp(q[1], q[2], c->fx);
        gx[b][a] = difference(&dx, q[0], q[1], q[2], q[3], c->fx);
    }
    for (int a = 0; a < 2; a++) {
        gy[a] = difference(&dy, label_row(g, how, at.x, y[0], z[a + 1], c->fx, label, m), in[a][0], in[a][1],
                           label_row(g, how, at.x, y[3], z[a + 1], c->fx, label, m), c->fy);
        gz[a] = difference(&dz, label_row(g, how, at.x, y[a + 1], z[0], c->fx, label, m), in[0][a], in[1][a],
                           label_row(g, how, at.x, y[a + 1], z[3], c->fx, label, m), c->fz);
    }
    return (vf3){vf_lerp(vf_lerp(gx[0][0], gx[0][1], c->fy), vf_lerp(gx[1][0], gx[1][1], c->fy), c->fz),
                 vf_lerp(gy[0], gy[1], c->fz), vf_lerp(gz[0], gz[1], c->fy)};
}

static __attribute__((noinline)) void label_gradient(vf3 *out, const vvi_lattice *g, const vf3 *p, const vf *label,
                                                     vm m)
{
    const cell_at c = find_cell(g, *p);
    switch (vvi_lattice_kernel(g)) {
    case VVI_SAMPLE_U8:
        *out = label_gradient_of(g, VVI_SAMPLE_U8, &c, *label, m);
        break;
    case VVI_SAMPLE_U16:
        *out = label_gradient_of(g, VVI_SAMPLE_U16, &c, *label, m);
        break;
    case VVI_SAMPLE_I16:
        *out = label_gradient_of(g, VVI_SAMPLE_I16, &c, *label, m);
        break;
    case VVI_SAMPLE_F32:
        *out = label_gradient_of(g, VVI_SAMPLE_F32, &c, *label, m);
        break;
    default:
        *out = label_gradient_of(g, VVI_SAMPLE_ANY, &c, *label, m);
        break;
    }
}

#endif
