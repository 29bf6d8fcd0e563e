/** @file
 * One volume of a blend at one point of every ray of a packet: its optical depth and colour. For kernels only.
 *
 * What the composite kernels have as constants of the program is chosen here at run time, the same way for all lanes.
 * Samplers stand out of line: one copy of each serves all volumes.
 */
#ifndef VVI_RENDER_MARCH_BLEND_SAMPLE_H
#define VVI_RENDER_MARCH_BLEND_SAMPLE_H
#include "render/march/blend_cubic.h"
#include "render/march/blend_labels.h"
#include "render/march/blend_paint.h"
#include "render/march/classify.h"
#include "render/march/entry.h"
#include "render/march/shade_simd.h"
#include "render/march/texture_simd.h"

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
    vf label;     /* labels: the one that won */
    vf3 gradient; /* plane: in the world */
} blend_sample;

VV_INLINE vf volume_value(const vvi_blend_volume *v, const vf3 *p, vm m)
{
    if (v->cubic) {
        vf value;
        vf3 unused;
        cubic_sample(&value, &unused, &v->ray.sampler.lattice, p, m);
        return value;
    }
    return v->nearest ? value_nearest(&v->ray.sampler.lattice, p, m) : value_linear(&v->ray.sampler.lattice, p, m);
}

/** Of the cells or by central differences, in index space. */
OUT_OF_LINE void gradient_in_cell(vf3 *out, const vvi_lattice *g, bool of_cell, const cell_at *c, vm m)
{
    switch (vvi_lattice_kernel(g)) {
    case VVI_SAMPLE_U8:
        *out = gradient_by(of_cell, g, VVI_SAMPLE_U8, c, m);
        break;
    case VVI_SAMPLE_U16:
        *out = gradient_by(of_cell, g, VVI_SAMPLE_U16, c, m);
        break;
    case VVI_SAMPLE_I16:
        *out = gradient_by(of_cell, g, VVI_SAMPLE_I16, c, m);
        break;
    case VVI_SAMPLE_F32:
        *out = gradient_by(of_cell, g, VVI_SAMPLE_F32, c, m);
        break;
    default:
        *out = gradient_by(of_cell, g, VVI_SAMPLE_WIDE, c, m);
        break;
    }
}

/** In the world, as the light wants it. */
VV_INLINE vf3 volume_gradient(const vvi_blend_volume *v, const vf3 *p, vm m)
{
    vf3 g;
    if (v->cubic) {
        vf unused;
        cubic_sample(&unused, &g, &v->ray.sampler.lattice, p, m);
    } else {
        const cell_at c = find_gradient_cell(&v->ray.sampler.lattice, v->nearest, *p);
        gradient_in_cell(&g, &v->ray.sampler.lattice, v->ray.sampler.cell_gradient, &c, m);
    }
    return world_gradient(&v->ray, g);
}

/** The table's colour and optical depth of a full step, times `share`. */
VV_INLINE void look_up(blend_sample *s, const vvi_blend_volume *v, vf value, vf share, vm m)
{
    const vvi_march_volume *f = &v->ray;
    m = vm_and(m, is_number(value));
    const vi at = vi_shl(find_entry(f, value, m), 2);
    s->depth = vf_gather4(f->classifier.color + 3, at, m) * share;
    for (int c = 0; c < 3; c++)
        s->rgb[c] = vf_gather4(f->classifier.color + c, at, m);
}

/** Where a value stands among the rows of the integrals. */
typedef struct row_place {
    vf place, fraction; /* the fraction is beyond [0, 1] where there are no more rows */
    vi row;
} row_place;

VV_INLINE row_place find_row(const vvi_blend_volume *v, vf value)
{
    row_place r;
    const vf most = vf_set1(2e9f); /* as far as whole numbers reach */
    r.place = vf_fma(value, vf_set1(v->row_scale), vf_set1(v->row_shift));
    r.place = vf_min(vf_max(r.place, vf_set1(0.0f) - most), most);
    r.row = vi_clamp(vi_trunc(r.place), vi_set1(0), vi_set1(v->n_rows - 1));
    r.fraction = r.place - vf_from_vi(r.row);
    return r;
}

/** Where a value stays within a row that is too steep for one mean, what it is seen as: the table's finer rows. */
VV_INLINE void in_steep_row(blend_sample *s, const vvi_blend_volume *v, vf value, vf share, vm m)
{
    const vvi_march_volume *f = &v->ray;
    const vf place = entry_place(f, value);
    const vi entry = vi_trunc(place);
    const vf alpha = vf_gather4(f->classifier.alpha, entry, m);
    const vm split = vm_and(m, vf_lt(vf_set1(1.0f), alpha));
    if (!vm_any(split))
        return;
    const vi at = vi_shl(split_entry(f, place, entry, alpha, split), 2);
    s->depth = vf_select(split, vf_gather4(f->classifier.color + 3, at, split) * share, s->depth);
    for (int c = 0; c < 3; c++)
        s->rgb[c] = vf_select(split, vf_gather4(f->classifier.color + c, at, split), s->rgb[c]);
}

/**
 * The mean of optical depth and colour over all values from front to back, as if the value ran evenly from one to the
 * other (algorithms: section 2.3). Sums are integers: differences of neighbours do not cancel. Within one row, however
 * far beyond the table, and within a sixty-fourth of a row, the mean of the two rows; of a steep row its part in the
 * middle of the way.
 */
VV_INLINE void mean_between(blend_sample *s, const vvi_blend_volume *v, vf front, vf back, vf share, vm m)
{
    const row_place a = find_row(v, front), b = find_row(v, back);
    const vf way = b.place - a.place;
    const vm same = vm_or(vf_lt(vf_abs(way), vf_set1(1.0f / 64)), vi_eq(a.row, b.row));
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
    const vm still = vm_and(m, same);
    if (vm_any(still))
        in_steep_row(s, v, (front + back) * vf_set1(0.5f), share, still);
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
    const vm real = vm_and(m, vm_and(is_number(front), is_number(back)));
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

/** The place in the plane of values and gradients, and the four of its numbers around it, interpolated. */
OUT_OF_LINE void classify_by_plane(blend_sample *s, const vvi_blend_volume *v, const vf3 *p, vf share, vm m)
{
    const vf zero = vf_set1(0.0f), last = vf_set1(VVI_PLANE_SIDE - 1);
    const vf value = volume_value(v, p, m);
    s->gradient = volume_gradient(v, p, m);
    const vf length = vf_sqrt(vf3_dot(s->gradient, s->gradient));
    const vf x = vf_clamp(vf_fma(value, vf_set1(v->plane_scale), vf_set1(v->plane_shift)), zero, last);
    const vf y = vf_clamp(length * vf_set1(v->plane_gradient), zero, last);
    const vi i = vi_min(vi_trunc(x), vi_set1(VVI_PLANE_SIDE - 2)), j = vi_min(vi_trunc(y), vi_set1(VVI_PLANE_SIDE - 2));
    const vf fx = x - vf_from_vi(i), fy = y - vf_from_vi(j);
    const vi at = vi_shl(j * vi_set1(VVI_PLANE_SIDE) + i, 2);
    vf sum[4];
    m = vm_and(m, is_number(value));
    for (int c = 0; c < 4; c++) {
        const float *from = v->plane + c, *above = from + 4 * VVI_PLANE_SIDE;
        sum[c] = vf_lerp(vf_lerp(vf_gather4(from, at, m), vf_gather4(from + 4, at, m), fx),
                         vf_lerp(vf_gather4(above, at, m), vf_gather4(above + 4, at, m), fx), fy);
    }
    s->depth = sum[3] * share;
    const vf each = vf_set1(1.0f) / vf_max(sum[3], vf_set1(1e-30f));
    for (int c = 0; c < 3; c++)
        s->rgb[c] = sum[c] * each;
}

OUT_OF_LINE void classify_label(blend_sample *s, const vvi_blend_volume *v, const vf3 *p, vf share, vm m)
{
    s->label = winning_label(&v->ray.sampler.lattice, p, m);
    look_up(s, v, s->label, share, m);
}

VV_INLINE void classify(blend_sample *s, blend_part *p, const blend_span *span, vf middle, vm m)
{
    const vvi_blend_volume *v = p->volume;
    const vf3 point = packet_point(&p->r, middle);
    const vf share = span->to - span->from;
    switch (v->classify) {
    case VVI_CLASSIFY_INTEGRATED:
        classify_integrated(s, p, span, m);
        break;
    case VVI_CLASSIFY_PLANE:
        classify_by_plane(s, v, &point, share, m);
        break;
    case VVI_CLASSIFY_LABELS:
        classify_label(s, v, &point, share, m);
        break;
    default:
        look_up(s, v, volume_value(v, &point, m), share, m);
        break;
    }
}

/** The gradient of what was classified, in the world. */
VV_INLINE vf3 classified_gradient(const blend_sample *s, const vvi_blend_volume *v, const vf3 *p, vm m)
{
    if (v->classify == VVI_CLASSIFY_PLANE)
        return s->gradient;
    if (v->classify != VVI_CLASSIFY_LABELS)
        return volume_gradient(v, p, m);
    vf3 g;
    label_gradient(&g, &v->ray.sampler.lattice, p, &s->label, m);
    return world_gradient(&v->ray, vf3_scale(g, vf_set1(v->label_range)));
}

/** Colours, texture, gradient and light, where there is something to light. */
OUT_OF_LINE void finish_sample(blend_sample *s, const blend_part *p, const vf *at, vm m)
{
    const vvi_blend_volume *v = p->volume;
    const vf3 point = packet_point(&p->r, *at);
    take_paint(s->rgb, &v->ray.paint, &point, m);
    if (v->ray.texture)
        texture_colors(s->rgb, &v->ray, &point, p->r.t0, *at, m);
    if (!v->ray.light.shaded && !(v->modulate_power > 0))
        return;
    const vf3 gradient = classified_gradient(s, v, &point, m);
    if (v->modulate_power > 0)
        s->depth = vf_select(m, s->depth * modulation(v, gradient), s->depth);
    if (v->ray.light.shaded)
        shade(&v->ray, point, p->r.direction, cap_gradient(gradient, &p->r, &v->ray, *at, own_lanes(), m), false,
              s->rgb);
}

/** What lanes of m see of a volume over their span; clear in all others. */
VV_INLINE void sample_volume(blend_sample *s, blend_part *p, const blend_span *span, vm m)
{
    const vvi_blend_volume *v = p->volume;
    const vf middle = vf_lerp(span->from, span->to, p->r.phase) - p->first;
    classify(s, p, span, middle, m);
    s->depth = vf_select(m, s->depth, vf_set1(0.0f));
    const vm seen = vf_lt(vf_set1(0.0f), s->depth);
    const bool more =
        v->ray.light.shaded || v->modulate_power > 0 || v->ray.paint.kind != VVI_PAINT_NONE || v->ray.texture;
    if (more && vm_any(seen))
        finish_sample(s, p, &middle, seen);
}

#endif
