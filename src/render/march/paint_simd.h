/** @file
 * Colours of a sample from a lattice of their own: those of an RGB or RGBA volume, or another volume's values through a
 * colour map. For kernels only.
 */
#ifndef VVI_RENDER_MARCH_PAINT_SIMD_H
#define VVI_RENDER_MARCH_PAINT_SIMD_H
#include "render/march/kernels.h"
#include "render/march/lattice_simd.h"

/** Premultiplied red, green, blue and alpha of one sample, 0 to 65535. */
VV_INLINE void load_colors(vf out[4], const vvi_lattice *g, vi at, vm m)
{
    vi rg, ba;
    vi_gather_pair4(g->data, vi_shl(at, 1), m, &rg, &ba);
    split_16(VVI_SAMPLE_U16, rg, &out[0], &out[1]);
    split_16(VVI_SAMPLE_U16, ba, &out[2], &out[3]);
}

/** A row of a cell, interpolated along x: two samples stand in 16 bytes. */
VV_INLINE void load_color_row(vf out[4], const vvi_lattice *g, vi at, vf fx)
{
    vf two[4], a[4], b[4];
    vf_rows4(two, g->data, vi_shl(at, 1));
    split_16(VVI_SAMPLE_U16, vi_bits(two[0]), &a[0], &a[1]);
    split_16(VVI_SAMPLE_U16, vi_bits(two[1]), &a[2], &a[3]);
    split_16(VVI_SAMPLE_U16, vi_bits(two[2]), &b[0], &b[1]);
    split_16(VVI_SAMPLE_U16, vi_bits(two[3]), &b[2], &b[3]);
    VV_UNROLL
    for (int i = 0; i < 4; i++)
        out[i] = g->n[0] > 1 ? vf_lerp(a[i], b[i], fx) : a[i];
}

/** Asks memory for the colours of lanes m, which are wanted some samples later: they are too many for a cache, and most
 * of their time went by waiting. Inline: to gcc 12 a function that does no more has no effect, and it drops the calls.
 */
VV_INLINE void expect_colors(const vvi_paint *paint, const vf3 *p, vm m)
{
    const vvi_lattice *g = &paint->lattice;
    const cell_at c = paint->nearest ? find_sample(g, *p) : find_cell(g, *p);
    const sample_place first = cell_place(g, VVI_SAMPLE_U16, &c, m);
    const vi y = paint->nearest ? vi_set1(0) : y_up(g), z = paint->nearest ? vi_set1(0) : z_up(g, VVI_SAMPLE_U16);
    int32_t at[VV_WIDTH], along_y[VV_WIDTH], along_z[VV_WIDTH];
    vi_store(at, first.x + first.y + first.z);
    vi_store(along_y, y);
    vi_store(along_z, z);
    const char *colors = g->data, *next = colors + 8 * (ptrdiff_t)along_y[0];
    const ptrdiff_t up = 8 * (ptrdiff_t)along_z[0];
    for (uint32_t left = vm_bits(m); left; left &= left - 1) {
        const ptrdiff_t of = 8 * (ptrdiff_t)at[__builtin_ctz(left)];
        __builtin_prefetch(colors + of);
        __builtin_prefetch(next + of);
        __builtin_prefetch(colors + of + up);
        __builtin_prefetch(next + of + up);
    }
}

/** Colours of the volume itself: interpolated premultiplied, so that what is clear has no colour to give. */
static __attribute__((noinline)) void paint_colors(vf rgb[3], const vvi_paint *paint, const vf3 *p, vm m)
{
    const vvi_lattice *g = &paint->lattice;
    const vf one = vf_set1(1.0f), zero = vf_set1(0.0f);
    const cell_at c = paint->nearest ? find_sample(g, *p) : find_cell(g, *p);
    const sample_place first =
        cell_place(g, VVI_SAMPLE_U16, &c, m); /* one array, whatever the volume's own samples are */
    const vi at = first.x + first.y + first.z;
    vf sum[4] = {zero, zero, zero, zero};
    if (paint->nearest) {
        load_colors(sum, g, at, m);
    } else {
        const vi y = y_up(g), z = z_up(g, VVI_SAMPLE_U16);
        vf row[4][4];
        load_color_row(row[0], g, at, c.fx);
        load_color_row(row[1], g, at + y, c.fx);
        load_color_row(row[2], g, at + z, c.fx);
        load_color_row(row[3], g, at + y + z, c.fx);
        VV_UNROLL
        for (int i = 0; i < 4; i++)
            sum[i] = vf_lerp(vf_lerp(row[0][i], row[1][i], c.fy), vf_lerp(row[2][i], row[3][i], c.fy), c.fz);
    }
    const vf each = one / vf_max(sum[3], vf_set1(1e-20f));
    VV_UNROLL
    for (int i = 0; i < 3; i++)
        rgb[i] = sum[i] * each;
}

/** Colours by another volume's value at the same point of the World; where it ends, those that were there. */
static __attribute__((noinline)) void paint_map(vf rgb[3], const vvi_paint *paint, const vf3 *p, vm m)
{
    const float(*f)[4] = paint->from_index;
    vf q[3];
    VV_UNROLL
    for (int a = 0; a < 3; a++) {
        q[a] = vf_fma(vf_set1(f[a][0]), p->x,
                      vf_fma(vf_set1(f[a][1]), p->y, vf_fma(vf_set1(f[a][2]), p->z, vf_set1(f[a][3]))));
        m = vm_and(m, vm_and(vf_le(vf_set1(paint->lo[a]), q[a]), vf_le(q[a], vf_set1(paint->hi[a]))));
    }
    if (!vm_any(m))
        return;
    const vf3 at = clamp_to_grid(&paint->lattice, vf3_set(q[0], q[1], q[2]));
    const vf value = any_value(&paint->lattice, paint->nearest, &at, m);
    const vf place = vf_fma(value, vf_set1(paint->entry_scale), vf_set1(paint->entry_shift));
    const vi entry = vi_shl(vi_trunc(vf_clamp(place, vf_set1(0.0f), vf_set1((float)(paint->n_entries - 1)))), 2);
    vf row[4];
    m = vm_and(m, vf_eq(value, value));
    vf_rows4(row, paint->color, entry);
    m = vm_and(m, vf_lt(row[3], vf_set1(VVI_PAINT_LEAVES)));
    VV_UNROLL
    for (int c = 0; c < 3; c++)
        rgb[c] = vf_select(m, row[c], rgb[c]);
}

/** The colours of a volume that has some from elsewhere, in place of those of lanes m. */
VV_INLINE void take_paint(vf rgb[3], const vvi_paint *paint, const vf3 *p, vm m)
{
    if (paint->kind == VVI_PAINT_COLORS)
        paint_colors(rgb, paint, p, m);
    else if (paint->kind == VVI_PAINT_MAP)
        paint_map(rgb, paint, p, m);
}

#endif
