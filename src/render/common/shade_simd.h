/** @file
 * Local illumination with vectors: ambient + diffuse + Phong or Blinn specular of every lamp. For kernels only.
 * The definition is shade_ref.h.
 */
#ifndef VVI_RENDER_SHADE_SIMD_H
#define VVI_RENDER_SHADE_SIMD_H
#include "core/simd_math.h"
#include "render/common/lattice_simd.h"
#include "render/raycast/raycast_kernels.h"

VV_INLINE vf3 normalized(vf3 a)
{
    return vf3_scale(a, vf_rsqrt(vf_max(vf3_dot(a, a), vf_set1(1e-30f))));
}

/** Index-space gradient of the stored values to the world's. */
VV_INLINE vf3 world_gradient(const vvi_ray_frame *f, vf3 g)
{
    const float(*m)[3] = f->gradient_to_world;
    return vf3_set(vf_fma(vf_set1(m[0][0]), g.x, vf_fma(vf_set1(m[0][1]), g.y, vf_set1(m[0][2]) * g.z)),
                   vf_fma(vf_set1(m[1][0]), g.x, vf_fma(vf_set1(m[1][1]), g.y, vf_set1(m[1][2]) * g.z)),
                   vf_fma(vf_set1(m[2][0]), g.x, vf_fma(vf_set1(m[2][1]), g.y, vf_set1(m[2][2]) * g.z)));
}

VV_INLINE vf3 world_point(const vvi_ray_frame *f, vf3 p)
{
    const float(*m)[4] = f->index_to_world;
    vf out[3];
    for (int a = 0; a < 3; a++)
        out[a] = vf_fma(vf_set1(m[a][0]), p.x,
                        vf_fma(vf_set1(m[a][1]), p.y, vf_fma(vf_set1(m[a][2]), p.z, vf_set1(m[a][3]))));
    return vf3_set(out[0], out[1], out[2]);
}

/** Unit vector to a lamp, and what of its light arrives. */
VV_INLINE vf3 lamp_at(const vvi_ray_lamp *lamp, vf3 p_world, vf *strength)
{
    const vf3 axis = vf3_set(vf_set1(lamp->to_light[0]), vf_set1(lamp->to_light[1]), vf_set1(lamp->to_light[2]));
    *strength = vf_set1(1.0f);
    if (lamp->kind == VV_LIGHT_DIRECTIONAL)
        return axis;
    vf3 to = vf3_set(vf_set1(lamp->position[0]) - p_world.x, vf_set1(lamp->position[1]) - p_world.y,
                     vf_set1(lamp->position[2]) - p_world.z);
    const vf d2 = vf_max(vf3_dot(to, to), vf_set1(1e-30f));
    const vf d = vf_sqrt(d2);
    to = vf3_scale(to, vf_set1(1.0f) / d);
    const vf loss =
        vf_fma(vf_set1(lamp->falloff[2]), d2, vf_fma(vf_set1(lamp->falloff[1]), d, vf_set1(lamp->falloff[0])));
    *strength = vf_set1(1.0f) / vf_max(loss, vf_set1(1e-30f));
    if (lamp->kind == VV_LIGHT_SPOT) {
        const vf fade = (vf3_dot(to, axis) - vf_set1(lamp->cos_outer)) * vf_set1(lamp->inverse_fade);
        const vf x = vf_clamp(fade, vf_set1(0.0f), vf_set1(1.0f));
        *strength = *strength * x * x * (vf_set1(3.0f) - x - x);
    }
    return to;
}

/**
 * Colour of a point with material colour `rgb` (changed in place).
 *
 * gradient  of the values, world space; its direction turned towards lower values is the normal
 * facing    the normal is turned to the viewer (surfaces); else two_sided or one-sided as the material says
 */
VV_INLINE void shade(const vvi_ray_frame *f, vf3 p_index, vf3 direction, vf3 gradient, bool facing, vf rgb[3])
{
    const vf zero = vf_set1(0.0f);
    const vf length2 = vf3_dot(gradient, gradient);
    const vm flat = vf_le(length2, vf_set1(f->flat_gradient * f->flat_gradient));
    const vf3 view = vf3_scale(direction, vf_set1(-1.0f));
    vf3 n = vf3_scale(gradient, vf_set1(0.0f) - vf_rsqrt(vf_max(length2, vf_set1(1e-30f))));
    n = vf3_set(vf_select(flat, view.x, n.x), vf_select(flat, view.y, n.y), vf_select(flat, view.z, n.z));
    if (facing) {
        const vf turn = vf_select(vf_lt(vf3_dot(n, view), zero), vf_set1(-1.0f), vf_set1(1.0f));
        n = vf3_scale(n, turn);
    }
    const bool both = f->two_sided && !facing;
    vf diffuse[3], specular[3];
    for (int c = 0; c < 3; c++) {
        diffuse[c] = vf_set1(f->light_ambient[c]);
        specular[c] = zero;
    }
    const vf3 p_world = world_point(f, p_index);
    for (size_t i = 0; i < f->n_lamps; i++) {
        const vvi_ray_lamp *lamp = &f->lamps[i];
        vf strength;
        const vf3 to = lamp_at(lamp, p_world, &strength);
        const vf raw = vf3_dot(n, to);
        vf nl = both ? vf_abs(raw) : raw;
        const vm lit = vf_lt(zero, nl);
        nl = vf_max(nl, zero);
        vf s;
        if (f->phong) { /* view . reflection of the light */
            const vf nv = vf3_dot(n, view), lv = vf3_dot(to, view);
            s = vf_fma(raw + raw, nv, zero - lv);
        } else { /* normal . half-way */
            const vf3 h = normalized(vf3_set(to.x + view.x, to.y + view.y, to.z + view.z));
            s = vf3_dot(n, h);
            s = vf_select(vf_lt(raw, zero), zero - s, s);
        }
        s = vf_clamp(s, zero, vf_set1(1.0f));
        s = f->whole_shininess ? vf_pow01_whole(s, f->whole_shininess) : vf_pow01(s, f->shininess);
        s = vf_select(vm_andnot(lit, flat), s, zero) * vf_set1(f->specular) * strength;
        nl = nl * vf_set1(f->diffuse) * strength;
        for (int c = 0; c < 3; c++) {
            diffuse[c] = vf_fma(nl, vf_set1(lamp->color[c]), diffuse[c]);
            specular[c] = vf_fma(s, vf_set1(lamp->color[c]), specular[c]);
        }
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = vf_fma(rgb[c], diffuse[c], specular[c]);
}

#endif
