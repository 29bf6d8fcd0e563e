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

/** One volume along the rays of a packet. Step numbers are the common ones; `first` is where the volume begins. */
typedef struct blend_part {
    const vvi_blend_volume *volume;
    packet r;
    vf first, last;     /* the same where a ray misses it */
    vf look;            /* step at which its block is looked at again */
    vm busy;            /* lanes in a block that may show something */
    vf known_at, known; /* integrated: a place and the value there, which the next step begins with */
} blend_part;

/** The part of a step inside a volume, in common steps. */
typedef struct blend_span {
    vf from, to;
    vm some; /* lanes where it is more than rounding */
} blend_span;

/** What a volume adds to one step: optical depth, and colour. */
typedef struct blend_sample {
    vf depth;
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

/** Where a value stands among the rows of the integrals. */
typedef struct row_place {
    vf place, fraction; /* the fraction is beyond [0, 1] where there are no more rows */
    vi row;
} row_place;

VV_INLINE row_place find_row(const vvi_blend_volume *v, vf value)
{
    row_place r;
    const vf most = vf_set1(1e6f);
    r.place = vf_fma(value, vf_set1(v->row_scale), vf_set1(v->row_shift));
    r.place = vf_min(vf_max(r.place, vf_set1(0.0f) - most), most);
    r.row = vi_clamp(vi_trunc(r.place), vi_set1(0), vi_set1(v->n_rows - 1));
    r.fraction = r.place - vf_from_vi(r.row);
    return r;
}

/**
 * The mean of optical depth and colour over all values from front to back, as if the value ran evenly from one to the
 * other (algorithms: section 2.3). Sums are integers: differences of neighbours do not cancel. Within a sixty-fourth of
 * a row, the mean of the two rows.
 */
VV_INLINE void mean_between(blend_sample *s, const vvi_blend_volume *v, vf front, vf back, vf share, vm m)
{
    const row_place a = find_row(v, front), b = find_row(v, back);
    const vf way = b.place - a.place;
    const vm same = vf_lt(vf_abs(way), vf_set1(1.0f / 64));
    const vf inverse = vf_set1(1.0f) / vf_select(same, vf_set1(1.0f), way);
    const vi at_a = vi_shl(a.row, 2), at_b = vi_shl(b.row, 2);
    vf mean[4];
    for (int c = 0; c < 4; c++) {
        const vf ma = vf_gather4(v->mean + c, at_a, m), mb = vf_gather4(v->mean + c, at_b, m);
        const vi rows = vi_gather(v->sum + c, vi_shl(at_b, 2), m) - vi_gather(v->sum + c, vi_shl(at_a, 2), m);
        const vf ends = vf_fma(b.fraction, mb, vf_set1(0.0f) - a.fraction * ma);
        const vf over = vf_fma(vf_from_vi(rows), vf_set1(v->sum_unit[c]), ends) * inverse;
        mean[c] = vf_max(vf_select(same, (ma + mb) * vf_set1(0.5f), over), vf_set1(0.0f));
    }
    s->depth = mean[3] * share;
    const vf each = vf_set1(1.0f) / vf_max(mean[3], vf_set1(1e-30f));
    for (int c = 0; c < 3; c++)
        s->rgb[c] = mean[c] * each;
}

OUT_OF_LINE void classify_integrated(blend_sample *s, blend_part *p, const blend_span *span, vm m)
{
    const vvi_blend_volume *v = p->volume;
    vf front = p->known;
    const vm fresh = vm_andnot(m, vf_eq(p->known_at, span->from));
    if (vm_any(fresh)) {
        const vf3 at = packet_point(&p->r, span->from - p->first);
        front = vf_select(fresh, volume_value(v, &at, fresh), front);
    }
    const vf3 at = packet_point(&p->r, span->to - p->first);
    const vf back = volume_value(v, &at, m);
    p->known = vf_select(m, back, p->known);
    p->known_at = vf_select(m, span->to, p->known_at);
    const vm real = vm_and(m, vm_and(vf_eq(front, front), vf_eq(back, back))); /* NaN is clear */
    mean_between(s, v, front, back, span->to - span->from, real);
    s->depth = vf_select(real, s->depth, vf_set1(0.0f));
}

/** What a gradient leaves of the optical depth. */
VV_INLINE vf modulation(const vvi_blend_volume *v, vf3 gradient)
{
    const vf length = vf_sqrt(vf3_dot(gradient, gradient)) * vf_set1(v->modulate_scale);
    const vf share = vf_min(length, vf_set1(1.0f));
    return vf_select(vf_lt(vf_set1(0.0f), share), vf_pow01(share, v->modulate_power), vf_set1(0.0f));
}

/** Gradient and light, where there is something to light. */
OUT_OF_LINE void finish_sample(blend_sample *s, const blend_part *p, vf at, vm m)
{
    const vvi_blend_volume *v = p->volume;
    const vf3 point = packet_point(&p->r, at);
    const vf3 gradient = volume_gradient(v, &point, m);
    if (v->modulate_power > 0)
        s->depth = vf_select(m, s->depth * modulation(v, gradient), s->depth);
    if (v->ray.shaded)
        shade(&v->ray, point, p->r.direction, gradient, false, s->rgb);
}

/** What lanes of m see of a volume over their span; clear in all others. */
VV_INLINE void sample_volume(blend_sample *s, blend_part *p, const blend_span *span, vm m)
{
    const vvi_blend_volume *v = p->volume;
    const vf middle = vf_lerp(span->from, span->to, p->r.phase) - p->first;
    if (v->classify == VVI_CLASSIFY_INTEGRATED) {
        classify_integrated(s, p, span, m);
    } else {
        const vf3 point = packet_point(&p->r, middle);
        classify_by_table(s, v, &point, span->to - span->from, m);
    }
    s->depth = vf_select(m, s->depth, vf_set1(0.0f));
    const vm seen = vf_lt(vf_set1(0.0f), s->depth);
    if ((v->ray.shaded || v->modulate_power > 0) && vm_any(seen))
        finish_sample(s, p, middle, seen);
}

#endif
