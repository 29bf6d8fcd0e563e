/** @file
 * The first point along each ray of a packet where a cubic B-spline enters [solid_lo, solid_hi]. For kernels only.
 *
 * Along a ray the spline is a polynomial of degree 9 in each cell, so there is no closed form: the value at the middle
 * and the end of a ray's way through a cell brackets the border, and halving finds it. Two crossings within half a cell
 * are not seen.
 */
#ifndef VVI_RENDER_MARCH_SURFACE_CUBIC_H
#define VVI_RENDER_MARCH_SURFACE_CUBIC_H
#include "render/march/cubic_simd.h"
#include "render/march/surface.h"

/* Halvings of half a cell: to the last bit of the place in it. */
enum { HALVINGS = 22 };

/** How far inside a value is, below 0 outside. */
VV_INLINE vf cubic_inside(const surface_side *side, const packet *r, const vvi_march_volume *f, vf s, vm m)
{
    const vf3 p = packet_point(r, s);
    return (cubic_value(&f->sampler.lattice, &p, m) - side->target) * side->sign;
}

VV_INLINE void surface_cubic_cell(surface_state *st, const walk *w, const packet *r, const vvi_march_volume *f,
                                  int type, const surface_side *side, vf s_out, vm run)
{
    const vf zero = vf_set1(0.0f), middle = (w->s + s_out) * vf_set1(0.5f);
    const vm first = vm_and(run, vf_le(zero, cubic_inside(side, r, f, middle, run)));
    const vm found = vm_or(first, vm_and(run, vf_le(zero, cubic_inside(side, r, f, s_out, vm_andnot(run, first)))));
    st->samples += 2 * (uint64_t)vm_count(run);
    if (!vm_any(found))
        return;
    vf out = vf_select(first, w->s, middle), in = vf_select(first, middle, s_out);
    for (int i = 0; i < HALVINGS; i++) {
        const vf half = (out + in) * vf_set1(0.5f);
        const vm inside = vf_le(zero, cubic_inside(side, r, f, half, found));
        in = vf_select(inside, half, in);
        out = vf_select(inside, out, half);
    }
    st->s = vf_select(found, in, st->s);
    st->hit = vm_or(st->hit, found);
}

VV_INLINE void surface_cubic_march(surface_state *st, const packet *r, const vvi_march_volume *f)
{
    const vf v0 = cubic_value(&f->sampler.lattice, &r->start, packet_promising(r));
    surface_walk(st, r, f, v0, VVI_SAMPLE_F32, false, surface_cubic_cell);
}

VV_INLINE void light_cubic_hit(const surface_state *st, const packet *r, const vvi_march_volume *f, vf rgb[3])
{
    const vf3 p = packet_point(r, st->s);
    vf3 g;
    cubic_gradient(&g, &f->sampler.lattice, &p, st->hit);
    g = world_gradient(f, g);
    if (vm_any(st->flat)) {
        const vf3 e = entry_gradient(r, f, st->flat);
        g = vf3_set(vf_select(st->flat, e.x, g.x), vf_select(st->flat, e.y, g.y), vf_select(st->flat, e.z, g.z));
    }
    shade(f, p, r->direction, g, true, rgb);
}

VV_INLINE void surface_cubic_packet(vvi_sink *out, const vvi_march_volume *f, const packet *r, size_t at,
                                    vv_render_counts *counts)
{
    const vf zero = vf_set1(0.0f);
    surface_state st = {zero, vm_none(), vm_none(), {zero, zero, zero}, 0};
    vf rgb[3] = {zero, zero, zero};
    if (vm_any(packet_promising(r)))
        surface_cubic_march(&st, r, f);
    counts->samples += st.samples;
    if (vm_any(st.hit)) {
        surface_colors(rgb, &st, r, f);
        if (f->light.shaded)
            light_cubic_hit(&st, r, f, rgb);
    }
    surface_store(out, r, f, at, &st, rgb);
}

#endif
