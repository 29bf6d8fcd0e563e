/** @file
 * Light at VV_WIDTH points: lamp.h with vectors. For kernels only.
 */
#ifndef VVI_GFX_LAMP_SIMD_H
#define VVI_GFX_LAMP_SIMD_H
#include "core/simd_vec.h"
#include "gfx/lamp.h"
#include <volvis/model.h>

/** The way to a lamp, length 1, and how much of its light arrives. */
VV_INLINE vf3 lamp_at(const vvi_lamp *lamp, vf3 position, vf *share)
{
    const vf3 axis = vf3_set1(lamp->to_light);
    const vf zero = vf_set1(0), one = vf_set1(1);
    *share = one;
    if (lamp->kind == VV_LIGHT_DIRECTIONAL)
        return axis;
    const vf3 to = vf3_sub(vf3_set1(lamp->position), position);
    const vf d2 = vf_max(vf3_dot(to, to), vf_set1(VF3_NOTHING)), d = vf_sqrt(d2);
    const vf3 way = vf3_scale(to, one / d);
    const vf loss =
        vf_fma(vf_set1(lamp->falloff[2]), d2, vf_fma(vf_set1(lamp->falloff[1]), d, vf_set1(lamp->falloff[0])));
    *share = one / vf_max(loss, vf_set1(1e-30f));
    if (lamp->kind == VV_LIGHT_SPOT) {
        const vf fade = (vf3_dot(way, axis) - vf_set1(lamp->cos_outer)) * vf_set1(lamp->inverse_fade);
        const vf t = vf_clamp(fade, zero, one);
        *share = *share * t * t * (vf_set1(3) - t - t);
    }
    return way;
}

VV_INLINE vf highlight(const vvi_gloss *g, vf3 n, vf3 l, vf3 to_eye, vf n_l)
{
    const vf zero = vf_set1(0);
    vf s;
    if (g->phong) {
        s = vf_fma(n_l + n_l, vf3_dot(n, to_eye), zero - vf3_dot(l, to_eye));
    } else {
        s = vf3_dot(n, vf3_unit(vf3_add(l, to_eye)));
        s = vf_select(vf_lt(n_l, zero), zero - s, s);
    }
    s = vf_clamp(s, zero, vf_set1(1));
    return g->whole_shininess ? vf_pow01_whole(s, g->whole_shininess, g->least_shine)
                              : vf_select(vf_lt(zero, s), vf_pow01(s, g->shininess), zero);
}

/** Points to be lit. */
typedef struct lit_points {
    vf3 position, normal, to_eye;
    vm surface; /**< else `normal` is not the one of a surface: no highlight */
    bool two_sided;
    const vf *arrives; /**< shares of the ambient light, then of lamps, that arrive; NULL, and beyond n_arrive: all */
    int n_arrive;
} lit_points;

/** Changes their colours to the light that they send to the eye. */
VV_INLINE void light_points(vf rgb[3], const lit_points *p, const vvi_gloss *g, const vvi_lamp *lamps, size_t n_lamps)
{
    const vf zero = vf_set1(0);
    vf diffuse[3], specular[3];
    VV_UNROLL
    for (int c = 0; c < 3; c++) {
        diffuse[c] = vf_set1(g->ambient[c]);
        if (p->arrives)
            diffuse[c] = diffuse[c] * p->arrives[0];
        specular[c] = zero;
    }
    for (size_t i = 0; i < n_lamps; i++) {
        const vvi_lamp *lamp = &lamps[i];
        vf share;
        const vf3 l = lamp_at(lamp, p->position, &share);
        if (p->arrives && (int)i + 1 < p->n_arrive)
            share = share * p->arrives[i + 1];
        const vf n_l = vf3_dot(p->normal, l);
        const vf seen = vf_max(p->two_sided ? vf_abs(n_l) : n_l, zero); /* 0 of NaN too */
        const vm shines = vm_and(vf_lt(zero, seen), p->surface);
        const vf s = vf_select(shines, highlight(g, p->normal, l, p->to_eye, n_l), zero) * vf_set1(g->specular) * share;
        const vf d = seen * vf_set1(g->diffuse) * share;
        VV_UNROLL
        for (int c = 0; c < 3; c++) {
            diffuse[c] = vf_fma(d, vf_set1(lamp->color[c]), diffuse[c]);
            specular[c] = vf_fma(s, vf_set1(lamp->color[c]), specular[c]);
        }
    }
    VV_UNROLL
    for (int c = 0; c < 3; c++)
        rgb[c] = vf_fma(rgb[c], diffuse[c], specular[c]);
}

#endif
