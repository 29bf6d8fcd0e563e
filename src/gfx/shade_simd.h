/** @file
 * Light of fragments, VV_WIDTH at a time; the definition is vvi_gfx_shade_ref(). For kernels only.
 */
#ifndef VVI_GFX_SHADE_SIMD_H
#define VVI_GFX_SHADE_SIMD_H
#include "gfx/kernels.h"
#include "gfx/lamp_simd.h"

VV_INLINE vf3 gather3(const float *numbers, vi index, vm live)
{
    const vi at = index + index + index;
    return (vf3){vf_gather4(numbers, at, live), vf_gather4(numbers + 1, at, live), vf_gather4(numbers + 2, at, live)};
}

/* Linear, from bytes: a fourth of the word at each vertex. */
VV_INLINE void vertex_colors(vf rgba[4], const vvi_gfx_lighting *g, const vi index[3], const vf share[3], vm live)
{
    vi word[3];
    for (int k = 0; k < 3; k++)
        word[k] = vi_gather(g->colors, vi_shl(index[k], 2), live);
    for (int c = 0; c < 4; c++) {
        vf sum = vf_set1(0);
        for (int k = 0; k < 3; k++) {
            const vi byte = vi_shr_u(vi_shl(word[k], 24 - 8 * c), 24);
            vf v = vf_from_vi(byte) * vf_set1(g->opacity / 255);
            if (c < 3)
                v = vf_gather4(g->decode, byte, live);
            sum = vf_fma(share[k], v, sum);
        }
        rgba[c] = sum;
    }
}

/* Of values between those of vertices; where one of these is NaN the colours stay. */
VV_INLINE void value_colors(vf rgba[4], const vvi_gfx_lighting *g, const vi index[3], const vf share[3], vm live)
{
    const vf zero = vf_set1(0), last = vf_set1(VVI_GFX_RAMP - 1);
    vf above = zero; /* the first row's value: numbers that are large for their range lose nothing */
    for (int k = 0; k < 3; k++)
        above = vf_fma(vf_gather4(g->values, index[k], live) - vf_set1(g->ramp_lo), share[k], above);
    const vf row = above * vf_set1(g->ramp_scale);
    const vm known = vf_eq(above - above, zero); /* infinite ones are not, either */
    const vf at = vf_clamp(vf_select(known, row, zero), zero, last), below = vf_floor(at);
    const vi first = vi_trunc(below) * vi_set1(3);
    for (int c = 0; c < 3; c++) {
        const vf a = vf_gather4(g->ramp + c, first, live), b = vf_gather4(g->ramp + 3 + c, first, live);
        rgba[c] = vf_select(known, vf_fma(at - below, b - a, a), rgba[c]);
    }
    rgba[3] = vf_select(known, vf_set1(g->opacity), rgba[3]);
}

static void shade(vvi_gfx_fragments *f, const vvi_gfx_lighting *g)
{
    const vf zero = vf_set1(0), one = vf_set1(1);
    const float linear[3][3] = {{g->to_eye[0][0], g->to_eye[0][1], g->to_eye[0][2]},
                                {g->to_eye[1][0], g->to_eye[1][1], g->to_eye[1][2]},
                                {g->to_eye[2][0], g->to_eye[2][1], g->to_eye[2][2]}};
    const vf3 origin = {vf_set1(g->to_eye[0][3]), vf_set1(g->to_eye[1][3]), vf_set1(g->to_eye[2][3])};
    for (size_t i = 0; i < f->n; i += VV_WIDTH) {
        const vm live = vm_first_n(f->n - i);
        const vi corner = vi_load((const int32_t *)f->triangle + i) * vi_set1(3);
        vi index[3];
        for (int k = 0; k < 3; k++)
            index[k] = vi_bits(vf_gather4((const float *)(const void *)g->triangles + k, corner, live));
        const vf px = vf_load(f->x + i) - vf_set1(g->middle[0]), py = vf_set1(g->middle[1]) - vf_load(f->y + i);
        const vf3 across = vf3_fma(vf3_set1(g->right), px, vf3_scale(vf3_set1(g->up), py));
        const vf3 start = g->parallel ? across : (vf3){zero, zero, zero};
        const vf3 way = g->parallel ? vf3_set1(g->forward) : vf3_unit(vf3_add(across, vf3_set1(g->forward)));
        /* where the ray meets the triangle's plane (Moeller & Trumbore 1997) */
        const vf3 p0 = gather3(g->positions, index[0], live);
        const vf3 e1 = vf3_turn(linear, vf3_sub(gather3(g->positions, index[1], live), p0));
        const vf3 e2 = vf3_turn(linear, vf3_sub(gather3(g->positions, index[2], live), p0));
        const vf3 c0 = vf3_add(vf3_turn(linear, p0), origin), from = vf3_sub(start, c0), p = vf3_cross(way, e2);
        const vf det = vf3_dot(e1, p), inverse = one / vf_select(vf_eq(det, zero), one, det);
        const vf u = vf_clamp(vf3_dot(from, p) * inverse, zero, one);
        const vf v = vf_clamp(vf3_dot(way, vf3_cross(from, e1)) * inverse, zero, one), w = vf_max(one - u - v, zero);
        const vf whole = one / (u + v + w), share[3] = {w * whole, u * whole, v * whole};
        const vf3 place = vf3_fma(e1, share[1], vf3_fma(e2, share[2], c0)),
                  to_eye = vf3_sub((vf3){zero, zero, zero}, way);
        const vf3 flat = vf3_cross(e1, e2);
        vf3 n = vf3_scale(vf3_unit(flat), vf_set1(g->side));
        vm known = vf_lt(vf_set1(VF3_NOTHING), vf3_dot(flat, flat));
        if (g->normals) {
            vf3 sum = vf3_scale(gather3(g->normals, index[0], live), share[0]);
            sum = vf3_fma(gather3(g->normals, index[1], live), share[1], sum);
            sum = vf3_turn(g->normal_to_world, vf3_fma(gather3(g->normals, index[2], live), share[2], sum));
            const vm there = vf_lt(vf_set1(VF3_NOTHING), vf3_dot(sum, sum));
            n = vf3_select(there, vf3_unit(sum), n);
            known = vm_or(known, there);
        }
        n = vf3_select(known, n, to_eye);
        if (g->sides == VVI_GFX_FACING) {
            const vf turn = vf_select(vf_lt(vf3_dot(n, to_eye), zero), vf_set1(-1), one);
            n = vf3_scale(n, turn);
        }
        vf rgba[4];
        for (int c = 0; c < 4; c++)
            rgba[c] = vf_load(f->rgba[c] + i);
        if (g->colors)
            vertex_colors(rgba, g, index, share, live);
        if (g->values)
            value_colors(rgba, g, index, share, live);
        const lit_points points = {place, n, to_eye, known, g->sides == VVI_GFX_BOTH};
        if (g->model != VV_SHADING_NONE)
            light_points(rgba, &points, &g->gloss, g->lamps, g->n_lamps);
        for (int c = 0; c < 4; c++)
            vf_store(f->rgba[c] + i, rgba[c]);
        vf_store(f->depth + i, vf_max(vf3_dot(vf3_sub(place, start), way), vf_set1(g->nearest)));
        vf_store(f->normal[0] + i, n.x);
        vf_store(f->normal[1] + i, n.y);
        vf_store(f->normal[2] + i, n.z);
    }
}

#endif
