/** @file
 * Vertices onto the picture, and triangles to their tiles. For kernels only.
 */
#ifndef VVI_GFX_PROJECT_SIMD_H
#define VVI_GFX_PROJECT_SIMD_H
#include "core/simd.h"
#include "gfx/kernels.h"

/* Numbers `each` apart from `first` on, one for each lane. */
VV_INLINE vi lanes_from(int32_t first, int32_t each)
{
    int32_t at[VV_WIDTH];
    for (int l = 0; l < VV_WIDTH; l++)
        at[l] = first + l * each;
    return vi_load(at);
}

VV_INLINE vf affine_row(const float row[4], vf x, vf y, vf z)
{
    return vf_fma(vf_set1(row[0]), x, vf_fma(vf_set1(row[1]), y, vf_fma(vf_set1(row[2]), z, vf_set1(row[3]))));
}

VV_INLINE vi flag(vm m, uint32_t bit)
{
    return vi_select(m, vi_set1((int32_t)bit), vi_set1(0));
}

VV_INLINE vf rounded(vf a)
{
    return vf_floor(a + vf_set1(0.5f));
}

static void project(vvi_gfx_vertex *out, const float *positions, size_t n, const vvi_gfx_projection *p)
{
    const vf zero = vf_set1(0), one = vf_set1(1), reach = vf_set1(VVI_GFX_REACH * (float)VVI_GFX_STEPS);
    for (size_t i = 0; i < n; i += VV_WIDTH) {
        const vm live = vm_first_n(n - i);
        const vi at = lanes_from(0, 3);
        const float *from = positions + 3 * i;
        const vf x = vf_gather4(from, at, live), y = vf_gather4(from + 1, at, live), z = vf_gather4(from + 2, at, live);
        const vf a = affine_row(p->row[0], x, y, z), b = affine_row(p->row[1], x, y, z),
                 c = affine_row(p->row[2], x, y, z);
        const vm before = vf_le(vf_set1(p->nearest), c);
        vf w = one, nearness = zero - c;
        if (!p->parallel)
            nearness = w = one / vf_select(before, c, one);
        const vf px = vf_set1(p->scale[0]) * a * w, py = vf_set1(p->scale[1]) * b * w, sum = a + b + c;
        vi bits = vi_select(vf_eq(sum - sum, zero), vi_set1(0), vi_set1(VVI_GFX_OUT_NAN));
        bits = bits | vi_select(before, vi_set1(0), vi_set1(VVI_GFX_OUT_NEAR));
        bits = bits | flag(vf_lt(px, zero - reach), VVI_GFX_OUT_SIDES) | flag(vf_lt(reach, px), VVI_GFX_OUT_SIDES << 1);
        bits = bits | flag(vf_lt(reach, py), VVI_GFX_OUT_SIDES << 2) |
               flag(vf_lt(py, zero - reach), VVI_GFX_OUT_SIDES << 3);
        const vm usable = vi_eq(bits, vi_set1(0));
        for (size_t k = 0; k < p->n_cuts; k++) {
            const vf d =
                affine_row((const float[4]){p->cuts[k][0], p->cuts[k][1], p->cuts[k][2], -p->cuts[k][3]}, x, y, z);
            bits = bits | flag(vf_lt(d, zero), k < 25 ? (uint32_t)VVI_GFX_OUT_CUTS << k : 1u << 31);
        }
        int32_t sx[VV_WIDTH], sy[VV_WIDTH], flags[VV_WIDTH];
        float near[VV_WIDTH];
        vi_store(sx, vi_trunc(rounded(vf_set1(p->middle[0]) + vf_select(usable, px, zero))));
        vi_store(sy, vi_trunc(rounded(vf_set1(p->middle[1]) - vf_select(usable, py, zero))));
        vf_store(near, nearness);
        vi_store(flags, bits);
        const size_t left = n - i < VV_WIDTH ? n - i : VV_WIDTH;
        for (size_t l = 0; l < left; l++)
            out[i + l] = (vvi_gfx_vertex){sx[l], sy[l], near[l], (uint32_t)flags[l]};
    }
}

VV_INLINE vi least3(const vi v[3])
{
    return vi_min(v[0], vi_min(v[1], v[2]));
}

VV_INLINE vi most3(const vi v[3])
{
    return vi_max(v[0], vi_max(v[1], v[2]));
}

/* No row (or column) of samples lies between lo and hi, steps. */
VV_INLINE vm between_samples(vi lo, vi hi, int samples)
{
    const int shift = samples == 1 ? 8 : samples == 4 ? 6 : 5;
    const vi half = vi_set1(1 << (shift - 1));
    return vi_eq(vi_shr_by(hi - half, shift), vi_shr_by(lo - half - vi_set1(1), shift));
}

static void sort(vvi_gfx_sorted *out, const vvi_gfx_sorting *s, size_t n)
{
    const vi zero = vi_set1(0), most = vi_set1(16384);
    size_t singles = 0, others = 0;
    for (size_t i = 0; i < n; i += VV_WIDTH) {
        const vm live = vm_first_n(n - i);
        const vi at = lanes_from(0, 12);
        vi x[3], y[3], any = zero, all = vi_set1(-1);
        for (int k = 0; k < 3; k++) {
            const vi v = vi_shl(vi_gather(s->triangles + 3 * i + k, at, live), 4);
            x[k] = vi_gather(&s->vertices->x, v, live);
            y[k] = vi_gather(&s->vertices->y, v, live);
            const vi bits = vi_gather(&s->vertices->out, v, live);
            any = any | bits;
            all = all & bits;
        }
        const vm whole = vm_and(live, vi_eq(any, zero));
        const vm cut = vm_andnot(vm_and(vi_eq(all & vi_set1(INT32_MAX), zero), live), vi_eq(any, zero));
        const vi x0 = least3(x), x1 = most3(x), y0 = least3(y), y1 = most3(y);
        const vm small = vm_and(vi_lt(x1 - x0, most), vi_lt(y1 - y0, most));
        for (int k = 1; k < 3; k++) { /* products of others would not fit */
            x[k] = vi_select(small, x[k], x[0]);
            y[k] = vi_select(small, y[k], y[0]);
        }
        const vi area = (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]);
        vm gone = vi_eq(area, zero);
        if (s->no_clockwise)
            gone = vm_or(gone, vi_lt(zero, area));
        if (s->no_counterclockwise)
            gone = vm_or(gone, vi_lt(area, zero));
        gone = vm_or(gone, vm_or(between_samples(x0, x1, s->samples), between_samples(y0, y1, s->samples)));
        gone = vm_and(gone, small);
        const vi p0 = vi_shr_by(x0, 8), p1 = vi_shr_by(x1, 8), q0 = vi_shr_by(y0, 8), q1 = vi_shr_by(y1, 8);
        gone = vm_or(gone, vm_or(vm_or(vi_lt(p1, vi_set1(s->window.x0)), vi_lt(q1, vi_set1(s->window.y0))),
                                 vm_or(vi_lt(vi_set1(s->window.x1 - 1), p0), vi_lt(vi_set1(s->window.y1 - 1), q0))));
        /* in one tile of those that there are */
        const vi tx = vi_shr_by(p0, 6), ty = vi_shr_by(q0, 6);
        vm one = vm_and(vi_eq(tx, vi_shr_by(p1, 6)), vi_eq(ty, vi_shr_by(q1, 6)));
        one = vm_and(vm_and(one, small), vm_andnot(whole, gone));
        const vm other = vm_or(vm_andnot(vm_andnot(whole, gone), one), cut);
        const vi number = lanes_from((int32_t)i, 1);
        vi_compress(out->single + singles, number, one);
        vi_compress(out->tile + singles, ty * vi_set1(s->across) + tx, one);
        vi_compress(out->other + others, number, other);
        singles += (size_t)vm_count(one);
        others += (size_t)vm_count(other);
    }
    out->n_single = singles;
    out->n_other = others;
}

#endif
