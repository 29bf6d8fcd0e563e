/** @file
 * Light of points of a volume with vectors. For kernels only. The definition is shade_ref.h.
 */
#ifndef VVI_RENDER_SHADE_SIMD_H
#define VVI_RENDER_SHADE_SIMD_H
#include "gfx/lamp_simd.h"
#include "render/march/kernels.h"
#include "render/march/lattice_simd.h"
#include "render/march/light_volume_simd.h"

/** Index-space gradient of the stored values to the world's. */
VV_INLINE vf3 world_gradient(const vvi_march_volume *f, vf3 g)
{
    return vf3_turn(f->sampler.gradient_to_world, g);
}

VV_INLINE vf3 world_point(const vvi_march_volume *f, vf3 p)
{
    const float(*m)[4] = f->sampler.index_to_world;
    vf out[3];
    VV_UNROLL
    for (int a = 0; a < 3; a++)
        out[a] = vf_fma(vf_set1(m[a][0]), p.x,
                        vf_fma(vf_set1(m[a][1]), p.y, vf_fma(vf_set1(m[a][2]), p.z, vf_set1(m[a][3]))));
    return vf3_set(out[0], out[1], out[2]);
}

/** A normal on the viewer's side; 0: there is no surface. */
VV_INLINE vf3 seen_side(vf3 n, vf3 view, vm surface)
{
    const vf away = vf_select(vf_lt(vf3_dot(n, view), vf_set1(0.0f)), vf_set1(-1.0f), vf_set1(1.0f));
    return vf3_scale(n, vf_select(surface, away, vf_set1(0.0f)));
}

/** Of the colour as it is, what is left in the light that arrives: on a surface ahead of it, in a cloud right there, so
 * that it needs no gradient. */
VV_INLINE void shade_unlit(const vvi_march_volume *f, vf3 p_index, vf3 direction, vf3 gradient, bool facing, vf rgb[3])
{
    vf3 ahead;
    if (facing)
        ahead = seen_side(vf3_unit(gradient), vf3_scale(direction, vf_set1(-1.0f)),
                          vf_lt(vf_set1(f->light.flat_gradient), vf_sqrt(vf3_dot(gradient, gradient))));
    const vf left = scattered_light(&f->light, p_index, facing ? &ahead : NULL);
    VV_UNROLL
    for (int c = 0; c < 3; c++)
        rgb[c] = rgb[c] * left;
}

/**
 * Colour of a point with material colour `rgb` (changed in place).
 *
 * gradient  of the values, world space; its direction turned towards lower values is the normal
 * facing    the normal is turned to the viewer (surfaces); else two_sided or one-sided as the material says
 */
VV_INLINE void shade(const vvi_march_volume *f, vf3 p_index, vf3 direction, vf3 gradient, bool facing, vf rgb[3])
{
    if (f->light.unlit) {
        shade_unlit(f, p_index, direction, gradient, facing, rgb);
        return;
    }
    const vf length2 = vf3_dot(gradient, gradient), least = vf_set1(f->light.flat_gradient * f->light.flat_gradient);
    const vf3 view = vf3_scale(direction, vf_set1(-1.0f));
    const vm steep = vf_lt(vf_set1(1e36f), length2); /* beside a fill far outside; its square may be infinite */
    if (vm_any(steep))
        gradient = vf3_select(steep, vf3_scale(gradient, vf_set1(0x1p-64f)), gradient);
    vf3 n = vf3_select(vf_le(length2, least), view, vf3_scale(vf3_unit(gradient), vf_set1(-1.0f)));
    if (facing) {
        const vf turn = vf_select(vf_lt(vf3_dot(n, view), vf_set1(0.0f)), vf_set1(-1.0f), vf_set1(1.0f));
        n = vf3_scale(n, turn);
    }
    const vm surface = vf_lt(least, length2);
    vf arrives[VVI_LIGHT_SHARES];
    if (f->light.volume.cells)
        light_shares(arrives, &f->light, p_index, seen_side(n, view, surface));
    const lit_points points = {world_point(f, p_index),
                               n,
                               view,
                               surface,
                               f->light.two_sided && !facing,
                               f->light.volume.cells ? arrives : NULL,
                               f->light.volume.n_shares};
    light_points(rgb, &points, &f->light.gloss, f->light.lamps, f->light.n_lamps);
}

#endif
