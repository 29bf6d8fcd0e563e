/** @file
 * Sampling a lattice with vectors: values and gradients at many points. For kernels only.
 *
 * `how` is a compile-time constant everywhere: sample type and way to fetch (fetch.h), or VVI_SAMPLE_ANY. What comes
 * out is the same to the bit however samples are fetched.
 */
#ifndef VVI_RENDER_LATTICE_SIMD_H
#define VVI_RENDER_LATTICE_SIMD_H
#include "render/march/fetch.h"

/** Where a point lies: the cell's lowest sample and the fraction inside it. */
typedef struct cell_at {
    vi i, j, k;
    vf fx, fy, fz;
} cell_at;

/* With VVI_SAMPLE_ANY, out of line: any_simd.h. */
static void any_place(sample_place *out, const vvi_lattice *g, const sample_place *sample, vm m);
static void any_pair(vf out[2], const vvi_lattice *g, const spot *s, vm m);
static vf any_value(const vvi_lattice *g, bool nearest, const vf3 *p, vm m);
static void any_gradient(vf3 *out, const vvi_lattice *g, const cell_at *c, vm m);

/** NaN and infinity are no numbers: clear, as are cells that touch one. */
VV_INLINE vm is_number(vf v)
{
    return vf_lt(vf_abs(v), vf_set1(INFINITY));
}

/** p in index space, inside the grid or no more than rounding beyond it; a point on the last sample is in the last cell
 * with fraction 1. */
VV_INLINE cell_at find_cell(const vvi_lattice *g, vf3 p)
{
    cell_at c;
    const int32_t lx = g->n[0] > 1 ? g->n[0] - 2 : 0, ly = g->n[1] > 1 ? g->n[1] - 2 : 0;
    const int32_t lz = g->n[2] > 1 ? g->n[2] - 2 : 0;
    const vi zero = vi_set1(0);
    c.i = vi_max(vi_min(vi_trunc(p.x), vi_set1(lx)), zero);
    c.j = vi_max(vi_min(vi_trunc(p.y), vi_set1(ly)), zero);
    c.k = vi_max(vi_min(vi_trunc(p.z), vi_set1(lz)), zero);
    c.fx = p.x - vf_from_vi(c.i);
    c.fy = p.y - vf_from_vi(c.j);
    c.fz = p.z - vf_from_vi(c.k);
    return c;
}

/** The nearest point of the grid. */
VV_INLINE vf3 clamp_to_grid(const vvi_lattice *g, vf3 p)
{
    const vf zero = vf_set1(0.0f);
    return vf3_set(vf_clamp(p.x, zero, vf_set1((float)(g->n[0] - 1))),
                   vf_clamp(p.y, zero, vf_set1((float)(g->n[1] - 1))),
                   vf_clamp(p.z, zero, vf_set1((float)(g->n[2] - 1))));
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

/** Where samples (i, j, k) are. */
VV_INLINE sample_place find_place(const vvi_lattice *g, int how, vi i, vi j, vi k, vm m)
{
    sample_place out = {i, j, k};
    if (how == VVI_SAMPLE_ANY)
        any_place(&out, g, &out, m);
    else
        fetch_place(&out, g, how >> FETCH_SHIFT, i, j, k, m);
    return out;
}

VV_INLINE sample_place cell_place(const vvi_lattice *g, int how, const cell_at *c, vm m)
{
    return find_place(g, how, c->i, c->j, c->k, m);
}

/** From y to y + 1 and from z to z + 1; 0 on a flat axis. */
VV_INLINE vi y_up(const vvi_lattice *g)
{
    return vi_set1(g->n[1] > 1 ? g->row : 0);
}
VV_INLINE vi z_up(const vvi_lattice *g, int how)
{
    if (g->n[2] < 2)
        return vi_set1(0);
    return fetch_slice(g, how == VVI_SAMPLE_ANY ? g->fetch : how >> FETCH_SHIFT);
}

/** The two numbers of 16 bits in a word, the lower first. */
VV_INLINE void split_16(int type, vi word, vf *a, vf *b)
{
    if (type == VVI_SAMPLE_U16) {
        *a = vf_from_vi(word & vi_set1(0xffff));
        *b = vf_from_vi(vi_shr_u(word, 16));
    } else {
        *a = vf_from_vi(vi_shr_by(vi_shl(word, 16), 16));
        *b = vf_from_vi(vi_shr_by(word, 16));
    }
}

/** Two neighbours along x, as they are stored: both come in one word. Where there is one alone, that twice: what lies
 * to the right is the next row. */
VV_INLINE void load_pair(const vvi_lattice *g, int how, vi x, vi yo, vi zo, vm m, vf *a, vf *b)
{
    const spot s = {x + yo, zo};
    const int type = type_of(how);
    vi low, high;
    if (how == VVI_SAMPLE_ANY) {
        vf both[2] = {vf_set1(0.0f), vf_set1(0.0f)};
        any_pair(both, g, &s, m);
        *a = both[0];
        *b = both[1];
    } else if (type == VVI_SAMPLE_U8) {
        fetch_words(&low, NULL, g, how, &s, m);
        *a = vf_from_vi(low & vi_set1(255));
        *b = vf_from_vi(vi_shr_u(low, 8) & vi_set1(255));
    } else if (type == VVI_SAMPLE_F32) {
        fetch_words(&low, &high, g, how, &s, m); /* the guard bytes are behind the last sample */
        *a = vf_bits(low);
        *b = vf_bits(high);
    } else {
        fetch_words(&low, NULL, g, how, &s, m);
        split_16(type, low, a, b);
    }
    if (how != VVI_SAMPLE_ANY && g->n[0] == 1)
        *b = *a;
}

VV_INLINE vf load_one(const vvi_lattice *g, int how, vi x, vi yo, vi zo, vm m)
{
    vf a, b;
    load_pair(g, how, x, yo, zo, m, &a, &b);
    (void)b;
    return a;
}

/** Corner values of a cell: v[z][y][x]. */
VV_INLINE void load_corners(const vvi_lattice *g, int how, const cell_at *c, vm m, vf v[2][2][2])
{
    const sample_place at = cell_place(g, how, c, m);
    const vi y1 = at.y + y_up(g), z1 = at.z + z_up(g, how);
    load_pair(g, how, at.x, at.y, at.z, m, &v[0][0][0], &v[0][0][1]);
    load_pair(g, how, at.x, y1, at.z, m, &v[0][1][0], &v[0][1][1]);
    load_pair(g, how, at.x, at.y, z1, m, &v[1][0][0], &v[1][0][1]);
    load_pair(g, how, at.x, y1, z1, m, &v[1][1][0], &v[1][1][1]);
}

/* Numbers of 8 and 16 bits are interpolated along x as integers, two products in one instruction, with the fraction in
 * 1/16384 of a voxel: as fine as floats place points in a grid of 1000 voxels. Rows are then 16384 times too large, and
 * those of VVI_SAMPLE_U16 have 32768 too little, until row_scale() and row_shift() mend it. */
enum { FRACTION_BITS = 14, FRACTION_ONE = 1 << FRACTION_BITS };

VV_INLINE bool is_integer(int how)
{
    return type_of(how) == VVI_SAMPLE_U8 || type_of(how) == VVI_SAMPLE_U16 || type_of(how) == VVI_SAMPLE_I16;
}
VV_INLINE float row_scale(int how)
{
    return is_integer(how) ? 1.0f / FRACTION_ONE : 1.0f;
}
VV_INLINE float row_shift(int how)
{
    return type_of(how) == VVI_SAMPLE_U16 ? 32768.0f : 0.0f;
}

/** Weights of the left and the right sample, in the two halves of a word. */
VV_INLINE vi row_weights(const vvi_lattice *g, vf fx)
{
    const vi right = g->n[0] > 1 ? vi_trunc(vf_fma(fx, vf_set1(FRACTION_ONE), vf_set1(0.5f))) : vi_set1(0);
    return vi_shl(right, 16) | (vi_set1(FRACTION_ONE) - right);
}

/** Two neighbours along x as signed numbers of 16 bits. */
VV_INLINE vi load_pair_16(const vvi_lattice *g, int how, spot s, vm m)
{
    vi w;
    fetch_words(&w, NULL, g, how, &s, m);
    if (type_of(how) == VVI_SAMPLE_U8)
        return vi_bytes01(w);
    return type_of(how) == VVI_SAMPLE_U16 ? w ^ vi_set1((int32_t)0x80008000) : w;
}

/** A row of a cell, interpolated along x in floats, whatever its type. */
VV_INLINE vf row_of_floats(const vvi_lattice *g, int how, vi x, vi yo, vi zo, vf fx, vm m)
{
    vf l, r;
    load_pair(g, how, x, yo, zo, m, &l, &r);
    return vf_lerp(l, r, fx);
}

/** A row of a cell, interpolated along x. */
VV_INLINE vf load_row(const vvi_lattice *g, int how, vi x, vi yo, vi zo, vf fx, vi weights, vm m)
{
    if (is_integer(how))
        return vf_from_vi(vi_madd16(load_pair_16(g, how, (spot){x + yo, zo}, m), weights));
    return row_of_floats(g, how, x, yo, zo, fx, m);
}

/** The stored value at points inside the grid, trilinear or of the nearest sample. */
VV_INLINE vf sample_value(const vvi_lattice *g, int how, bool nearest, vf3 p, vm m)
{
    if (how == VVI_SAMPLE_ANY)
        return any_value(g, nearest, &p, m);
    if (nearest) {
        const cell_at s = find_sample(g, p);
        const sample_place at = cell_place(g, how, &s, m);
        return load_one(g, how, at.x, at.y, at.z, m);
    }
    const cell_at c = find_cell(g, p);
    const vi weights = row_weights(g, c.fx);
    const sample_place at = cell_place(g, how, &c, m);
    const vi y1 = at.y + y_up(g), z1 = at.z + z_up(g, how);
    const vf a = vf_lerp(load_row(g, how, at.x, at.y, at.z, c.fx, weights, m),
                         load_row(g, how, at.x, y1, at.z, c.fx, weights, m), c.fy);
    const vf b = vf_lerp(load_row(g, how, at.x, at.y, z1, c.fx, weights, m),
                         load_row(g, how, at.x, y1, z1, c.fx, weights, m), c.fy);
    const vf v = vf_lerp(a, b, c.fz);
    return is_integer(how) ? vf_fma(v, vf_set1(row_scale(how)), vf_set1(row_shift(how))) : v;
}

/** Four neighbours along x, from x - 1 to x + 2; past the border the border's own sample again. */
VV_INLINE void load_quad(const vvi_lattice *g, int how, vi x, vi yo, vi zo, vm first, vm last, vm m, vf v[4])
{
    const vi one = vi_set1(1);
    load_pair(g, how, x, yo, zo, m, &v[1], &v[2]);
    if (type_of(how) == VVI_SAMPLE_F32) {
        vf far[2]; /* as pairs, like the two in the middle: x - 1 with x, x + 1 with x + 2 */
        load_pair(g, how, vi_select(first, x, x - one), yo, zo, m, &v[0], &far[0]);
        load_pair(g, how, vi_select(last, x, x + one), yo, zo, m, &far[1], &v[3]);
    } else {
        v[0] = load_one(g, how, vi_select(first, x, x - one), yo, zo, m);
        v[3] = load_one(g, how, vi_select(last, x, x + one + one), yo, zo, m);
    }
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

/** Offsets of the four rows (slices) around a cell on one axis; past the border the border's own again. */
VV_INLINE void find_rows(vi out[4], vi at, vi up, const axis_differences *d)
{
    out[1] = at;
    out[0] = vi_select(d->first, at, at - up);
    out[2] = at + up;
    out[3] = vi_select(d->last, out[2], out[2] + up);
}

/** sample_gradient() where differences may be one-sided, and of all types. */
VV_INLINE vf3 border_gradient(const vvi_lattice *g, int how, const cell_at *c, vm m)
{
    const axis_differences dx = find_differences(c->i, g->n[0]);
    const axis_differences dy = find_differences(c->j, g->n[1]);
    const axis_differences dz = find_differences(c->k, g->n[2]);
    const sample_place at = cell_place(g, how, c, m);
    vi y[4], z[4];
    find_rows(y, at.y, y_up(g), &dy);
    find_rows(z, at.z, z_up(g, how), &dz);

    vf in[2][2], gx[2][2]; /* [z][y]: value and x difference of the four rows through the cell */
    VV_UNROLL
    for (int i = 0; i < 4; i++) {
        vf q[4];
        const int b = i >> 1, a = i & 1;
        load_quad(g, how, at.x, y[a + 1], z[b + 1], dx.first, dx.last, m, q);
        in[b][a] = vf_lerp(q[1], q[2], c->fx);
        gx[b][a] = difference(&dx, q[0], q[1], q[2], q[3], c->fx);
    }
    vf gy[2], gz[2]; /* at the two z, at the two y */
    VV_UNROLL
    for (int a = 0; a < 2; a++) {
        gy[a] = difference(&dy, row_of_floats(g, how, at.x, y[0], z[a + 1], c->fx, m), in[a][0], in[a][1],
                           row_of_floats(g, how, at.x, y[3], z[a + 1], c->fx, m), c->fy);
        gz[a] = difference(&dz, row_of_floats(g, how, at.x, y[a + 1], z[0], c->fx, m), in[0][a], in[1][a],
                           row_of_floats(g, how, at.x, y[a + 1], z[3], c->fx, m), c->fz);
    }
    return (vf3){vf_lerp(vf_lerp(gx[0][0], gx[0][1], c->fy), vf_lerp(gx[1][0], gx[1][1], c->fy), c->fz),
                 vf_lerp(gy[0], gy[1], c->fz), vf_lerp(gz[0], gz[1], c->fy)};
}

/** Differences over two voxels along x of the four samples from x - 1, and the row of the middle two. */
VV_INLINE vi quad_differences(const vvi_lattice *g, int how, spot s, vi weights, vm m, vi *row)
{
    vi low, high; /* x - 1 and x, x + 1 and x + 2 */
    s.at = s.at - vi_set1(1);
    if (type_of(how) == VVI_SAMPLE_U8) {
        vi w;
        fetch_words(&w, NULL, g, how, &s, m);
        low = vi_bytes01(w);
        high = vi_bytes01(vi_shr_u(w, 16));
    } else {
        fetch_words(&low, &high, g, how, &s, m);
        const vi flip = vi_set1(type_of(how) == VVI_SAMPLE_U16 ? (int32_t)0x80008000 : 0);
        low = low ^ flip;
        high = high ^ flip;
    }
    *row = vi_madd16(vi_shr_u(low, 16) | vi_shl(high, 16), weights);
    return vi_madd16(high, weights) - vi_madd16(low, weights);
}

/* Differences along y and z of rows. */
VV_INLINE vf inner_difference(vi below, vi a, vi b, vi above, vf f)
{
    return vf_lerp(vf_from_vi(b - below), vf_from_vi(above - a), f);
}

/* The spot `rows` further on in y and `slices` in z. */
VV_INLINE spot beyond(const vvi_lattice *g, int how, spot s, int rows, int slices)
{
    const vi up = z_up(g, how), y = y_up(g);
    vi *z = fetch_is_near(how >> FETCH_SHIFT) ? &s.at : &s.z;
    for (int i = 0; i < (slices < 0 ? -slices : slices); i++)
        *z = slices < 0 ? *z - up : *z + up;
    for (int i = 0; i < (rows < 0 ? -rows : rows); i++)
        s.at = rows < 0 ? s.at - y : s.at + y;
    return s;
}

/** sample_gradient() of integers where no lane of m touches the border. */
VV_INLINE vf3 inner_gradient(const vvi_lattice *g, int how, const cell_at *c, vm m)
{
    const vi weights = row_weights(g, c->fx);
    const sample_place p = cell_place(g, how, c, m);
    const bool near = fetch_is_near(how >> FETCH_SHIFT);
    const spot at = {near ? p.x + p.y + p.z : p.x + p.y, near ? vi_set1(0) : p.z};
    vi in[2][2]; /* [z][y] */
#define AT(rows, slices) beyond(g, how, at, rows, slices)
#define ROW(rows, slices) vi_madd16(load_pair_16(g, how, AT(rows, slices), m), weights)
    const vf gx0 = vf_lerp(vf_from_vi(quad_differences(g, how, at, weights, m, &in[0][0])),
                           vf_from_vi(quad_differences(g, how, AT(1, 0), weights, m, &in[0][1])), c->fy);
    const vf gx1 = vf_lerp(vf_from_vi(quad_differences(g, how, AT(0, 1), weights, m, &in[1][0])),
                           vf_from_vi(quad_differences(g, how, AT(1, 1), weights, m, &in[1][1])), c->fy);
    const vf gy0 = inner_difference(ROW(-1, 0), in[0][0], in[0][1], ROW(2, 0), c->fy);
    const vf gy1 = inner_difference(ROW(-1, 1), in[1][0], in[1][1], ROW(2, 1), c->fy);
    const vf gz0 = inner_difference(ROW(0, -1), in[0][0], in[1][0], ROW(0, 2), c->fz);
    const vf gz1 = inner_difference(ROW(1, -1), in[0][1], in[1][1], ROW(1, 2), c->fz);
#undef ROW
#undef AT
    const vf scale = vf_set1(0.5f * row_scale(how));
    return vf3_scale((vf3){vf_lerp(gx0, gx1, c->fz), vf_lerp(gy0, gy1, c->fz), vf_lerp(gz0, gz1, c->fy)}, scale);
}

/** Lanes whose gradient takes samples that are all in the grid. */
VV_INLINE vm find_inner(const vvi_lattice *g, const cell_at *c)
{
    const vi one = vi_set1(1);
    const vm x = vm_and(vi_lt(vi_set1(0), c->i), vi_lt(c->i + one, vi_set1(g->n[0] - 1)));
    const vm y = vm_and(vi_lt(vi_set1(0), c->j), vi_lt(c->j + one, vi_set1(g->n[1] - 1)));
    const vm z = vm_and(vi_lt(vi_set1(0), c->k), vi_lt(c->k + one, vi_set1(g->n[2] - 1)));
    return vm_and(x, vm_and(y, z));
}

static __attribute__((noinline)) void border_gradient_of(float out[3][VV_WIDTH], const vvi_lattice *g, const cell_at *c,
                                                         vm m)
{
    const vf3 d = border_gradient(g, VVI_SAMPLE_ANY, c, m);
    vf_store(out[0], d.x);
    vf_store(out[1], d.y);
    vf_store(out[2], d.z);
}

/**
 * The gradient of the stored values in index space: central differences at the samples, one-sided at the border,
 * interpolated like the value, which inside the grid is the central difference of the interpolated field over two
 * voxels.
 */
VV_INLINE vf3 sample_gradient(const vvi_lattice *g, int how, const cell_at *c, vm m)
{
    if (how == VVI_SAMPLE_ANY) {
        vf3 out;
        any_gradient(&out, g, c, m);
        return out;
    }
    if (!is_integer(how))
        return border_gradient(g, how, c, m);
    /* lane by lane, whatever the other lanes do: a picture must not depend on who stands beside whom */
    const vm inner = vm_and(m, find_inner(g, c)), border = vm_andnot(m, inner);
    vf3 d = inner_gradient(g, how, c, inner);
    if (vm_any(border)) {
        float out[3][VV_WIDTH];
        border_gradient_of(out, g, c, border);
        d.x = vf_select(border, vf_load(out[0]), d.x);
        d.y = vf_select(border, vf_load(out[1]), d.y);
        d.z = vf_select(border, vf_load(out[2]), d.z);
    }
    return d;
}

/** The derivative of the trilinear value itself: from the 8 corners of the cell alone, with a jump from cell to cell.
 */
VV_INLINE vf3 cell_gradient(const vvi_lattice *g, int how, const cell_at *c, vm m)
{
    vf v[2][2][2];
    load_corners(g, how, c, m, v);
    const vf x0 = vf_lerp(v[0][0][1] - v[0][0][0], v[0][1][1] - v[0][1][0], c->fy);
    const vf x1 = vf_lerp(v[1][0][1] - v[1][0][0], v[1][1][1] - v[1][1][0], c->fy);
    const vf a = vf_lerp(v[0][0][0], v[0][0][1], c->fx), b = vf_lerp(v[0][1][0], v[0][1][1], c->fx);
    const vf d = vf_lerp(v[1][0][0], v[1][0][1], c->fx), e = vf_lerp(v[1][1][0], v[1][1][1], c->fx);
    return (vf3){vf_lerp(x0, x1, c->fz), vf_lerp(b - a, e - d, c->fz), vf_lerp(d - a, e - b, c->fy)};
}

VV_INLINE vf3 gradient_by(bool of_cell, const vvi_lattice *g, int how, const cell_at *c, vm m)
{
    return of_cell ? cell_gradient(g, how, c, m) : sample_gradient(g, how, c, m);
}

#include "render/march/any_simd.h"
#endif
