/** @file
 * Light of fragments, VV_WIDTH at a time; the definition is vvi_gfx_shade_ref(). For kernels only.
 */
#ifndef VVI_GFX_SHADE_SIMD_H
#define VVI_GFX_SHADE_SIMD_H
#include "core/simd_math.h"
#include "gfx/kernels.h"
#include <volvis/model.h>

typedef struct v3 {
    vf x, y, z;
} v3;

VV_INLINE v3 v3_of(const float v[3])
{
    return (v3){vf_set1(v[0]), vf_set1(v[1]), vf_set1(v[2])};
}
VV_INLINE v3 v3_add(v3 a, v3 b)
{
    return (v3){a.x + b.x, a.y + b.y, a.z + b.z};
}
VV_INLINE v3 v3_sub(v3 a, v3 b)
{
    return (v3){a.x - b.x, a.y - b.y, a.z - b.z};
}
VV_INLINE v3 v3_scale(v3 a, vf s)
{
    return (v3){a.x * s, a.y * s, a.z * s};
}
VV_INLINE v3 v3_fma(v3 a, vf s, v3 b)
{
    return (v3){vf_fma(a.x, s, b.x), vf_fma(a.y, s, b.y), vf_fma(a.z, s, b.z)};
}
VV_INLINE vf v3_dot(v3 a, v3 b)
{
    return vf_fma(a.x, b.x, vf_fma(a.y, b.y, a.z * b.z));
}
VV_INLINE v3 v3_cross(v3 a, v3 b)
{
    return (v3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
VV_INLINE v3 v3_select(vm m, v3 a, v3 b)
{
    return (v3){vf_select(m, a.x, b.x), vf_select(m, a.y, b.y), vf_select(m, a.z, b.z)};
}
/* The squares of lengths below this are taken for 0: far below what floats of positions can tell apart. */
#define NOTHING 1e-36f
VV_INLINE v3 v3_unit(v3 a)
{
    return v3_scale(a, vf_rsqrt(vf_max(v3_dot(a, a), vf_set1(NOTHING))));
}
VV_INLINE v3 v3_turn(const float m[3][3], v3 a)
{
    return (v3){v3_dot(v3_of(m[0]), a), v3_dot(v3_of(m[1]), a), v3_dot(v3_of(m[2]), a)};
}

VV_INLINE v3 gather3(const float *numbers, vi index, vm live)
{
    const vi at = index + index + index;
    return (v3){vf_gather4(numbers, at, live), vf_gather4(numbers + 1, at, live), vf_gather4(numbers + 2, at, live)};
}

/* The way to a lamp, length 1, and how much of its light arrives. */
VV_INLINE v3 way_to_lamp(const vvi_gfx_lamp *lamp, v3 place, vf *share)
{
    const v3 axis = v3_of(lamp->to_light);
    const vf zero = vf_set1(0), one = vf_set1(1);
    *share = one;
    if (lamp->kind == VV_LIGHT_DIRECTIONAL)
        return axis;
    const v3 to = v3_sub(v3_of(lamp->position), place);
    const vf d2 = vf_max(v3_dot(to, to), vf_set1(NOTHING)), d = vf_sqrt(d2);
    const v3 way = v3_scale(to, one / d);
    const vf loss =
        vf_fma(vf_set1(lamp->falloff[2]), d2, vf_fma(vf_set1(lamp->falloff[1]), d, vf_set1(lamp->falloff[0])));
    *share = one / vf_max(loss, vf_set1(1e-30f));
    if (lamp->kind == VV_LIGHT_SPOT) {
        const vf fade = (v3_dot(way, axis) - vf_set1(lamp->cos_outer)) * vf_set1(lamp->inverse_fade);
        const vf t = vf_clamp(fade, zero, one);
        *share = *share * t * t * (vf_set1(3) - t - t);
    }
    return way;
}

VV_INLINE vf highlight(const vvi_gfx_lighting *g, v3 n, v3 l, v3 to_eye, vf n_l)
{
    const vf zero = vf_set1(0);
    vf s;
    if (g->model == VV_SHADING_PHONG) {
        s = vf_fma(n_l + n_l, v3_dot(n, to_eye), zero - v3_dot(l, to_eye));
    } else {
        s = v3_dot(n, v3_unit(v3_add(l, to_eye)));
        s = vf_select(vf_lt(n_l, zero), zero - s, s);
    }
    s = vf_clamp(s, zero, vf_set1(1));
    return g->whole_shininess ? vf_pow01_whole(s, g->whole_shininess)
                              : vf_select(vf_lt(zero, s), vf_pow01(s, g->shininess), zero);
}

VV_INLINE void light(vf rgb[3], const vvi_gfx_lighting *g, v3 place, v3 n, vm known, v3 to_eye)
{
    const vf zero = vf_set1(0);
    vf diffuse[3], specular[3];
    for (int c = 0; c < 3; c++) {
        diffuse[c] = vf_set1(g->ambient[c]);
        specular[c] = zero;
    }
    for (size_t i = 0; i < g->n_lamps; i++) {
        const vvi_gfx_lamp *lamp = &g->lamps[i];
        vf share;
        const v3 l = way_to_lamp(lamp, place, &share);
        const vf n_l = v3_dot(n, l), seen = g->sides == VVI_GFX_BOTH ? vf_abs(n_l) : vf_max(n_l, zero);
        const vm lit = vm_and(vf_lt(zero, seen), known);
        const vf s = vf_select(lit, highlight(g, n, l, to_eye, n_l), zero) * share * vf_set1(g->specular);
        const vf d = seen * share * vf_set1(g->diffuse);
        for (int c = 0; c < 3; c++) {
            diffuse[c] = vf_fma(d, vf_set1(lamp->color[c]), diffuse[c]);
            specular[c] = vf_fma(s, vf_set1(lamp->color[c]), specular[c]);
        }
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = vf_fma(rgb[c], diffuse[c], specular[c]);
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

static void shade(vvi_gfx_fragments *f, const vvi_gfx_lighting *g)
{
    const vf zero = vf_set1(0), one = vf_set1(1);
    const float linear[3][3] = {{g->to_eye[0][0], g->to_eye[0][1], g->to_eye[0][2]},
                                {g->to_eye[1][0], g->to_eye[1][1], g->to_eye[1][2]},
                                {g->to_eye[2][0], g->to_eye[2][1], g->to_eye[2][2]}};
    const v3 origin = {vf_set1(g->to_eye[0][3]), vf_set1(g->to_eye[1][3]), vf_set1(g->to_eye[2][3])};
    for (size_t i = 0; i < f->n; i += VV_WIDTH) {
        const vm live = vm_first_n(f->n - i);
        const vi corner = vi_load((const int32_t *)f->triangle + i) * vi_set1(3);
        vi index[3];
        for (int k = 0; k < 3; k++)
            index[k] = vi_bits(vf_gather4((const float *)(const void *)g->triangles + k, corner, live));
        const vf px = vf_load(f->x + i) - vf_set1(g->middle[0]), py = vf_set1(g->middle[1]) - vf_load(f->y + i);
        const v3 across = v3_fma(v3_of(g->right), px, v3_scale(v3_of(g->up), py));
        const v3 start = g->parallel ? across : (v3){zero, zero, zero};
        const v3 way = g->parallel ? v3_of(g->forward) : v3_unit(v3_add(across, v3_of(g->forward)));
        /* where the ray meets the triangle's plane (Moeller & Trumbore 1997) */
        const v3 p0 = gather3(g->positions, index[0], live);
        const v3 e1 = v3_turn(linear, v3_sub(gather3(g->positions, index[1], live), p0));
        const v3 e2 = v3_turn(linear, v3_sub(gather3(g->positions, index[2], live), p0));
        const v3 c0 = v3_add(v3_turn(linear, p0), origin), from = v3_sub(start, c0), p = v3_cross(way, e2);
        const vf det = v3_dot(e1, p), inverse = one / vf_select(vf_eq(det, zero), one, det);
        const vf u = vf_clamp(v3_dot(from, p) * inverse, zero, one);
        const vf v = vf_clamp(v3_dot(way, v3_cross(from, e1)) * inverse, zero, one), w = vf_max(one - u - v, zero);
        const vf whole = one / (u + v + w), share[3] = {w * whole, u * whole, v * whole};
        const v3 place = v3_fma(e1, share[1], v3_fma(e2, share[2], c0)), to_eye = v3_sub((v3){zero, zero, zero}, way);
        const v3 flat = v3_cross(e1, e2);
        v3 n = v3_scale(v3_unit(flat), vf_set1(g->side));
        vm known = vf_lt(vf_set1(NOTHING), v3_dot(flat, flat));
        if (g->normals) {
            v3 sum = v3_scale(gather3(g->normals, index[0], live), share[0]);
            sum = v3_fma(gather3(g->normals, index[1], live), share[1], sum);
            sum = v3_turn(g->normal_to_world, v3_fma(gather3(g->normals, index[2], live), share[2], sum));
            const vm there = vf_lt(vf_set1(NOTHING), v3_dot(sum, sum));
            n = v3_select(there, v3_unit(sum), n);
            known = vm_or(known, there);
        }
        n = v3_select(known, n, to_eye);
        if (g->sides == VVI_GFX_FACING) {
            const vf turn = vf_select(vf_lt(v3_dot(n, to_eye), zero), vf_set1(-1), one);
            n = v3_scale(n, turn);
        }
        vf rgba[4];
        for (int c = 0; c < 4; c++)
            rgba[c] = vf_load(f->rgba[c] + i);
        if (g->colors)
            vertex_colors(rgba, g, index, share, live);
        if (g->model != VV_SHADING_NONE)
            light(rgba, g, place, n, known, to_eye);
        for (int c = 0; c < 4; c++)
            vf_store(f->rgba[c] + i, rgba[c]);
        vf_store(f->depth + i, vf_max(v3_dot(v3_sub(place, start), way), vf_set1(g->nearest)));
        vf_store(f->normal[0] + i, n.x);
        vf_store(f->normal[1] + i, n.y);
        vf_store(f->normal[2] + i, n.z);
    }
}

#endif
