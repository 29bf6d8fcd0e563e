/** @file
 * Sampling a lattice with vectors: values and gradients at many points. For kernels only.
 *
 * `type` is a compile-time constant everywhere. A 32-bit gather at an 8- or 16-bit sample fetches its right neighbour
 * as well, so a trilinear value takes 4 gathers, and an 8-bit value with its central-difference gradient 12: that is
 * why lattices need guard bytes after the last sample (vv_field_new).
 */
#ifndef VVI_RENDER_LATTICE_SIMD_H
#define VVI_RENDER_LATTICE_SIMD_H
#include "core/simd.h"
#include "render/common/lattice.h"

typedef struct vf3 {
    vf x, y, z;
} vf3;

VV_INLINE vf3 vf3_set(vf x, vf y, vf z)
{
    return (vf3){x, y, z};
}
VV_INLINE vf vf3_dot(vf3 a, vf3 b)
{
    return vf_fma(a.x, b.x, vf_fma(a.y, b.y, a.z * b.z));
}
VV_INLINE vf3 vf3_scale(vf3 a, vf s)
{
    return (vf3){a.x * s, a.y * s, a.z * s};
}

/** Where a point lies: the cell's lowest sample and the fraction inside it. */
typedef struct cell_at {
    vi i, j, k;
    vf fx, fy, fz;
} cell_at;

/** p in index space, clamped to [0, n - 1]; a point on the last sample is in the last cell with fraction 1. */
VV_INLINE cell_at find_cell(const vvi_lattice *g, vf3 p)
{
    cell_at c;
    const vf zero = vf_set1(0.0f);
    p.x = vf_clamp(p.x, zero, vf_set1((float)(g->n[0] - 1)));
    p.y = vf_clamp(p.y, zero, vf_set1((float)(g->n[1] - 1)));
    p.z = vf_clamp(p.z, zero, vf_set1((float)(g->n[2] - 1)));
    c.i = vi_max(vi_min(vi_trunc(p.x), vi_set1(g->n[0] - 2)), vi_set1(0));
    c.j = vi_max(vi_min(vi_trunc(p.y), vi_set1(g->n[1] - 2)), vi_set1(0));
    c.k = vi_max(vi_min(vi_trunc(p.z), vi_set1(g->n[2] - 2)), vi_set1(0));
    c.fx = p.x - vf_from_vi(c.i);
    c.fy = p.y - vf_from_vi(c.j);
    c.fz = p.z - vf_from_vi(c.k);
    return c;
}

/** The sample whose box of side 1 holds the point. */
VV_INLINE cell_at find_sample(const vvi_lattice *g, vf3 p)
{
    cell_at c;
    const vf half = vf_set1(0.5f);
    c.i = vi_clamp(vi_trunc(vf_floor(p.x + half)), vi_set1(0), vi_set1(g->n[0] - 1));
    c.j = vi_clamp(vi_trunc(vf_floor(p.y + half)), vi_set1(0), vi_set1(g->n[1] - 1));
    c.k = vi_clamp(vi_trunc(vf_floor(p.z + half)), vi_set1(0), vi_set1(g->n[2] - 1));
    c.fx = c.fy = c.fz = vf_set1(0.0f);
    return c;
}

/** The cell to take a gradient in: the point's own, or with the nearest sample at one of its corners. */
VV_INLINE cell_at find_gradient_cell(const vvi_lattice *g, bool nearest, vf3 p)
{
    if (!nearest)
        return find_cell(g, p);
    const cell_at s = find_sample(g, p);
    return find_cell(g, vf3_set(vf_from_vi(s.i), vf_from_vi(s.j), vf_from_vi(s.k)));
}

/** Offsets in y and z: elements, but whole slices in z where the lattice is wide. */
VV_INLINE vi y_offset(const vvi_lattice *g, vi j)
{
    return j * vi_set1(g->row);
}
VV_INLINE vi z_offset(const vvi_lattice *g, vi k)
{
    return g->wide ? k : k * vi_set1((int32_t)g->slice);
}

/** Loads of single lanes with 64-bit addresses, for lattices beyond 2^31 elements. Kept out of line: it is in every
 * load of every kernel, and rare. */
static __attribute__((noinline)) vi gather_wide(const vvi_lattice *g, vi x, vi yo, vi zo, int element_bytes, vm m)
{
    int32_t lx[VV_WIDTH], ly[VV_WIDTH], lz[VV_WIDTH], w[VV_WIDTH];
    vi_store(lx, x);
    vi_store(ly, yo);
    vi_store(lz, zo);
    const uint32_t live = vm_bits(m);
    for (int l = 0; l < VV_WIDTH; l++) {
        w[l] = 0;
        if (live >> l & 1)
            memcpy(&w[l], (const char *)g->data + (lz[l] * g->slice + ly[l] + (int64_t)lx[l]) * element_bytes, 4);
    }
    return vi_load(w);
}

/** Two neighbours along x, as they are stored. For 8 and 16 bits, both come in one word. */
VV_INLINE void load_pair(const vvi_lattice *g, int type, vi x, vi yo, vi zo, vm m, vf *a, vf *b)
{
    const vi at = x + yo + zo;
    if (type == VVI_SAMPLE_U8) {
        const vi w = g->wide ? gather_wide(g, x, yo, zo, 1, m) : vi_gather(g->data, at, m);
        *a = vf_from_vi(w & vi_set1(255));
        *b = vf_from_vi(vi_shr_u(w, 8) & vi_set1(255));
    } else if (type == VVI_SAMPLE_F32) {
        const vi right = vi_set1(g->n[0] > 1);
        if (g->wide) {
            *a = vf_bits(gather_wide(g, x, yo, zo, 4, m));
            *b = vf_bits(gather_wide(g, x + right, yo, zo, 4, m));
        } else {
            *a = vf_gather4(g->data, at, m);
            *b = vf_gather4(g->data, at + right, m);
        }
    } else {
        const vi w = g->wide ? gather_wide(g, x, yo, zo, 2, m) : vi_gather2(g->data, at, m);
        if (type == VVI_SAMPLE_U16) {
            *a = vf_from_vi(w & vi_set1(0xffff));
            *b = vf_from_vi(vi_shr_u(w, 16));
        } else {
            *a = vf_from_vi(vi_shr_by(vi_shl(w, 16), 16));
            *b = vf_from_vi(vi_shr_by(w, 16));
        }
    }
}

VV_INLINE vf load_one(const vvi_lattice *g, int type, vi x, vi yo, vi zo, vm m)
{
    vf a, b;
    load_pair(g, type, x, yo, zo, m, &a, &b);
    (void)b;
    return a;
}

/** Corner values of a cell: v[z][y][x]. */
VV_INLINE void load_corners(const vvi_lattice *g, int type, const cell_at *c, vm m, vf v[2][2][2])
{
    const vi up_y = vi_set1(g->n[1] > 1), up_z = vi_set1(g->n[2] > 1);
    const vi y0 = y_offset(g, c->j), y1 = y_offset(g, c->j + up_y);
    const vi z0 = z_offset(g, c->k), z1 = z_offset(g, c->k + up_z);
    load_pair(g, type, c->i, y0, z0, m, &v[0][0][0], &v[0][0][1]);
    load_pair(g, type, c->i, y1, z0, m, &v[0][1][0], &v[0][1][1]);
    load_pair(g, type, c->i, y0, z1, m, &v[1][0][0], &v[1][0][1]);
    load_pair(g, type, c->i, y1, z1, m, &v[1][1][0], &v[1][1][1]);
    if (g->n[0] == 1) /* what lies to the right is the next row */
        for (int i = 0; i < 4; i++)
            v[i >> 1][i & 1][1] = v[i >> 1][i & 1][0];
}

/** The stored value at points inside the grid, trilinear or of the nearest sample. */
VV_INLINE vf sample_value(const vvi_lattice *g, int type, bool nearest, vf3 p, vm m)
{
    if (nearest) {
        const cell_at s = find_sample(g, p);
        return load_one(g, type, s.i, y_offset(g, s.j), z_offset(g, s.k), m);
    }
    const cell_at c = find_cell(g, p);
    vf v[2][2][2];
    load_corners(g, type, &c, m, v);
    const vf a = vf_lerp(vf_lerp(v[0][0][0], v[0][0][1], c.fx), vf_lerp(v[0][1][0], v[0][1][1], c.fx), c.fy);
    const vf b = vf_lerp(vf_lerp(v[1][0][0], v[1][0][1], c.fx), vf_lerp(v[1][1][0], v[1][1][1], c.fx), c.fy);
    return vf_lerp(a, b, c.fz);
}

/** Four neighbours along x, from x - 1 to x + 2; past the border the border's own sample again. */
VV_INLINE void load_quad(const vvi_lattice *g, int type, vi x, vi yo, vi zo, vm first, vm last, vm m, vf v[4])
{
    const vi one = vi_set1(1);
    if (type == VVI_SAMPLE_U8 && !g->wide) {
        /* one word from x - 1, but from x on the first column, so that nothing before the data is touched */
        const vi w0 = vi_gather(g->data, vi_select(first, x, x - one) + yo + zo, m);
        const vi w = vi_select(first, vi_shl(w0, 8) | (w0 & vi_set1(255)), w0);
        v[0] = vf_from_vi(w & vi_set1(255));
        v[1] = vf_from_vi(vi_shr_u(w, 8) & vi_set1(255));
        v[2] = vf_from_vi(vi_shr_u(w, 16) & vi_set1(255));
        v[3] = vf_select(last, v[2], vf_from_vi(vi_shr_u(w, 24)));
        return;
    }
    load_pair(g, type, x, yo, zo, m, &v[1], &v[2]);
    v[0] = load_one(g, type, vi_select(first, x, x - one), yo, zo, m);
    v[3] = load_one(g, type, vi_select(last, x, x + one + one), yo, zo, m);
    v[3] = vf_select(last, v[2], v[3]);
}

/** Differences at the two samples of a cell along one axis: halved inside, one-sided at the border, 0 on a flat axis.
 */
typedef struct axis_differences {
    vf low, high;
    vm first, last;
} axis_differences;

VV_INLINE axis_differences find_differences(vi i, int32_t n)
{
    axis_differences d;
    const vf on = vf_set1(n > 1 ? 1.0f : 0.0f), half = vf_set1(n > 1 ? 0.5f : 0.0f);
    d.first = vi_lt(i, vi_set1(1));
    d.last = vi_lt(vi_set1(n - 3), i);
    d.low = vf_select(d.first, on, half);
    d.high = vf_select(d.last, on, half);
    return d;
}

VV_INLINE vf difference(const axis_differences *d, vf below, vf a, vf b, vf above, vf f)
{
    return vf_lerp((b - below) * d->low, (above - a) * d->high, f);
}

/** x-interpolated values of one row through a cell. */
VV_INLINE vf load_row(const vvi_lattice *g, int type, const cell_at *c, vi yo, vi zo, vm m)
{
    vf l, r;
    load_pair(g, type, c->i, yo, zo, m, &l, &r);
    return vf_lerp(l, r, c->fx);
}

/**
 * The gradient of the stored values in index space: central differences at the samples, interpolated like the value,
 * which inside the grid is the central difference of the interpolated field over two voxels.
 */
VV_INLINE vf3 sample_gradient(const vvi_lattice *g, int type, const cell_at *c, vm m)
{
    const vi one = vi_set1(1);
    const axis_differences dx = find_differences(c->i, g->n[0]);
    const axis_differences dy = find_differences(c->j, g->n[1]);
    const axis_differences dz = find_differences(c->k, g->n[2]);
    const vi jmax = vi_set1(g->n[1] - 1), kmax = vi_set1(g->n[2] - 1);
    vi y[4], z[4];
    y[0] = y_offset(g, vi_select(dy.first, c->j, c->j - one));
    y[1] = y_offset(g, c->j);
    y[2] = y_offset(g, vi_min(c->j + one, jmax));
    y[3] = y_offset(g, vi_min(c->j + one + one, jmax));
    z[0] = z_offset(g, vi_select(dz.first, c->k, c->k - one));
    z[1] = z_offset(g, c->k);
    z[2] = z_offset(g, vi_min(c->k + one, kmax));
    z[3] = z_offset(g, vi_min(c->k + one + one, kmax));

    vf in[2][2], gx[2][2]; /* [z][y]: value and x difference of the four rows through the cell */
    for (int b = 0; b < 2; b++)
        for (int a = 0; a < 2; a++) {
            vf q[4];
            load_quad(g, type, c->i, y[a + 1], z[b + 1], dx.first, dx.last, m, q);
            in[b][a] = vf_lerp(q[1], q[2], c->fx);
            gx[b][a] = difference(&dx, q[0], q[1], q[2], q[3], c->fx);
        }
    vf gy[2], gz[2]; /* at the two z, at the two y */
    for (int a = 0; a < 2; a++) {
        gy[a] = difference(&dy, load_row(g, type, c, y[0], z[a + 1], m), in[a][0], in[a][1],
                           load_row(g, type, c, y[3], z[a + 1], m), c->fy);
        gz[a] = difference(&dz, load_row(g, type, c, y[a + 1], z[0], m), in[0][a], in[1][a],
                           load_row(g, type, c, y[a + 1], z[3], m), c->fz);
    }
    return (vf3){vf_lerp(vf_lerp(gx[0][0], gx[0][1], c->fy), vf_lerp(gx[1][0], gx[1][1], c->fy), c->fz),
                 vf_lerp(gy[0], gy[1], c->fz), vf_lerp(gz[0], gz[1], c->fy)};
}

#endif
