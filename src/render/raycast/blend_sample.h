/** @file
 * One volume of a blend at one point of every ray of a packet: its optical depth and colour. For kernels only.
 *
 * What the composite kernels have as constants of the program is chosen here at run time, the same way for all lanes.
 * Samplers stand out of line: one copy of each serves all volumes.
 */
#ifndef VVI_RENDER_RAYCAST_BLEND_SAMPLE_H
#define VVI_RENDER_RAYCAST_BLEND_SAMPLE_H
#include "render/common/shade_simd.h"
#include "render/raycast/blend_kernel.h"
#include "render/raycast/packet.h"

#define OUT_OF_LINE static __attribute__((noinline))

/** What a volume adds to one segment. */
typedef struct blend_sample {
    vf depth; /* optical depth */
    vf rgb[3];
} blend_sample;

OUT_OF_LINE vf value_linear(const vvi_lattice *g, const vf3 *p, vm m)
{
    switch (vvi_lattice_kernel(g)) {
    case VVI_SAMPLE_U8:
        return sample_value(g, VVI_SAMPLE_U8, false, *p, m);
    case VVI_SAMPLE_U16:
        return sample_value(g, VVI_SAMPLE_U16, false, *p, m);
    case VVI_SAMPLE_I16:
        return sample_value(g, VVI_SAMPLE_I16, false, *p, m);
    case VVI_SAMPLE_F32:
        return sample_value(g, VVI_SAMPLE_F32, false, *p, m);
    default:
        return sample_value(g, VVI_SAMPLE_WIDE, false, *p, m);
    }
}

OUT_OF_LINE vf value_nearest(const vvi_lattice *g, const vf3 *p, vm m)
{
    switch (vvi_lattice_kernel(g)) {
    case VVI_SAMPLE_U8:
        return sample_value(g, VVI_SAMPLE_U8, true, *p, m);
    case VVI_SAMPLE_U16:
        return sample_value(g, VVI_SAMPLE_U16, true, *p, m);
    case VVI_SAMPLE_I16:
        return sample_value(g, VVI_SAMPLE_I16, true, *p, m);
    case VVI_SAMPLE_F32:
        return sample_value(g, VVI_SAMPLE_F32, true, *p, m);
    default:
        return sample_value(g, VVI_SAMPLE_WIDE, true, *p, m);
    }
}

OUT_OF_LINE void gradient_in_cell(vf3 *out, const vvi_lattice *g, const cell_at *c, vm m)
{
    switch (vvi_lattice_kernel(g)) {
    case VVI_SAMPLE_U8:
        *out = sample_gradient(g, VVI_SAMPLE_U8, c, m);
        break;
    case VVI_SAMPLE_U16:
        *out = sample_gradient(g, VVI_SAMPLE_U16, c, m);
        break;
    case VVI_SAMPLE_I16:
        *out = sample_gradient(g, VVI_SAMPLE_I16, c, m);
        break;
    case VVI_SAMPLE_F32:
        *out = sample_gradient(g, VVI_SAMPLE_F32, c, m);
        break;
    default:
        *out = sample_gradient(g, VVI_SAMPLE_WIDE, c, m);
        break;
    }
}

VV_INLINE vf volume_value(const vvi_blend_volume *v, const vf3 *p, vm m)
{
    return v->nearest ? value_nearest(&v->ray.lattice, p, m) : value_linear(&v->ray.lattice, p, m);
}

/** In the world, as the light wants it. */
VV_INLINE vf3 volume_gradient(const vvi_blend_volume *v, const vf3 *p, vm m)
{
    const cell_at c = find_gradient_cell(&v->ray.lattice, v->nearest, *p);
    vf3 g;
    gradient_in_cell(&g, &v->ray.lattice, &c, m);
    return world_gradient(&v->ray, g);
}

OUT_OF_LINE void light_sample(const vvi_blend_volume *v, const vf3 *p, const vf3 *direction, vm m, vf rgb[3])
{
    shade(&v->ray, *p, *direction, volume_gradient(v, p, m), false, rgb);
}

VV_INLINE vi row_of(const vvi_ray_frame *f, vf value)
{
    const vi e = vi_trunc(vf_fma(value, vf_set1(f->entry_scale), vf_set1(f->entry_shift)));
    return vi_clamp(e, vi_set1(0), vi_set1(f->n_entries - 1));
}

/** The table's colour and optical depth of a full step, times `share`. */
VV_INLINE void classify_by_table(blend_sample *s, const vvi_blend_volume *v, const vf3 *p, vf share, vm m)
{
    const vvi_ray_frame *f = &v->ray;
    const vf value = volume_value(v, p, m);
    const vi at = vi_shl(row_of(f, value), 2);
    m = vm_and(m, vf_eq(value, value)); /* NaN is clear */
    s->depth = vf_gather4(f->color + 3, at, m) * share;
    for (int c = 0; c < 3; c++)
        s->rgb[c] = vf_gather4(f->color + c, at, m);
}

/** What lanes of m see of a volume at p, which stands for `share` of a step; clear in all others. */
VV_INLINE void sample_volume(blend_sample *s, const vvi_blend_volume *v, const packet *r, vf at, vf share, vm m)
{
    const vf3 p = packet_point(r, at);
    classify_by_table(s, v, &p, share, m);
    s->depth = vf_select(m, s->depth, vf_set1(0.0f));
    const vm seen = vf_lt(vf_set1(0.0f), s->depth);
    if (v->ray.shaded && vm_any(seen))
        light_sample(v, &p, &r->direction, seen, s->rgb);
}

#endif
