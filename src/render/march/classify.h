/** @file
 * What samples are seen as: by a table, by integrals over a step, by value and gradient, by the label that wins. For
 * kernels only.
 */
#ifndef VVI_RENDER_MARCH_CLASSIFY_H
#define VVI_RENDER_MARCH_CLASSIFY_H
#include "render/common/transfer_plane.h"
#include "render/march/kernels.h"
#include "render/march/packet.h"

/** One volume along the rays of a packet. Where it is alone, steps are counted from where rays enter it; beside others
 * from where they enter the first of all, and `first` is where this one begins. */
typedef struct march_part march_part;

/** What one sample of each lane is seen as. */
typedef struct sight {
    vf depth;     /* optical depth */
    vi entry;     /* table, labels: of the table */
    vf rgb[3];    /* integrated, plane: times the depth */
    vf label;     /* labels: the one that won; else the value */
    vm may_be;    /* lanes that may see it, as far as the value tells */
    vf3 gradient; /* plane, and where opacity goes by gradients: in the world */
} sight;

/** Its whole part is the entry. */
VV_INLINE vf entry_place(const vvi_march_volume *f, vf value)
{
    const vf place = vf_fma(value, vf_set1(f->classifier.entry_scale),
                            vf_set1(f->classifier.entry_shift)); /* may be beyond integers */
    return vf_clamp(place, vf_set1(0.0f), vf_set1(f->classifier.last_place));
}

/** In place of entries that are split (those of `split`, by their alpha) the one of theirs that holds. */
VV_INLINE vi split_entry(const vvi_march_volume *f, vf place, vi entry, vf alpha, vm split)
{
    const vf parts = vf_gather4(f->classifier.color, vi_shl(entry, 2), split);
    const vi part = vi_trunc((place - vf_from_vi(entry)) * parts);
    return vi_select(split, vi_trunc(alpha) - vi_set1(VVI_ENTRY_SPLIT) + part, entry);
}

VV_INLINE vi find_entry(const vvi_march_volume *f, vf value, vm m)
{
    const vf place = entry_place(f, value);
    const vi entry = vi_trunc(place);
    const vf alpha = vf_gather4(f->classifier.alpha, entry, m);
    const vm split = vf_lt(vf_set1(1.0f), alpha);
    return vm_any(split) ? split_entry(f, place, entry, alpha, split) : entry;
}

/** The table's optical depth of a full step, times `share`; where the entry is split, it says so itself. */
VV_INLINE void look_up(sight *s, const vvi_march_volume *f, vf value, vf share, vm m)
{
    const vf place = entry_place(f, value), zero = vf_set1(0.0f);
    const float *depths = f->classifier.color + 3;
    s->entry = vi_trunc(place);
    vf depth = vf_gather4(depths, vi_shl(s->entry, 2), m);
    const vm split = vf_lt(depth, zero);
    if (vm_any(split)) {
        s->entry = split_entry(f, place, s->entry, zero - depth, split);
        depth = vf_gather4(depths, vi_shl(s->entry, 2), m);
    }
    s->depth = depth * share;
}

/** Where a value stands among the rows of the integrals, and its row. */
typedef struct row_place {
    vf place, fraction; /* the fraction is beyond [0, 1] where there are no more rows */
    vi row;
    vf mean[4], sum[4]; /* sums are whole numbers of 32 bits */
} row_place;

VV_INLINE void find_row(row_place *r, const vvi_classifier *c, vf value)
{
    const vf most = vf_set1(2e9f); /* as far as whole numbers reach */
    r->place = vf_fma(value, vf_set1(c->row_scale), vf_set1(c->row_shift));
    r->place = vf_min(vf_max(r->place, vf_set1(0.0f) - most), most);
    r->row = vi_clamp(vi_trunc(r->place), vi_set1(0), vi_set1(c->n_rows - 1));
    r->fraction = r->place - vf_from_vi(r->row);
    vf_rows4(r->mean, c->mean, vi_shl(r->row, 2));
    vf_rows4(r->sum, (const float *)(const void *)c->sum, vi_shl(r->row, 2));
}

VV_INLINE void select_row(row_place *r, vm m, const row_place *yes)
{
    r->place = vf_select(m, yes->place, r->place);
    r->fraction = vf_select(m, yes->fraction, r->fraction);
    r->row = vi_select(m, yes->row, r->row);
    VV_UNROLL
    for (int c = 0; c < 4; c++) {
        r->mean[c] = vf_select(m, yes->mean[c], r->mean[c]);
        r->sum[c] = vf_select(m, yes->sum[c], r->sum[c]);
    }
}

/** Where a value stays within a row that is too steep for one mean, what it is seen as: the table's finer rows. */
VV_INLINE void in_steep_row(sight *s, const vvi_march_volume *f, vf value, vf share, vm m)
{
    const vf place = entry_place(f, value);
    const vi entry = vi_trunc(place);
    const vf alpha = vf_gather4(f->classifier.alpha, entry, m);
    const vm split = vm_and(m, vf_lt(vf_set1(1.0f), alpha));
    if (!vm_any(split))
        return;
    vf row[4];
    const vi of = vi_select(split, split_entry(f, place, entry, alpha, split), vi_set1(0));
    vf_rows4(row, f->classifier.color, vi_shl(of, 2));
    s->depth = vf_select(split, row[3] * share, s->depth);
    VV_UNROLL
    for (int c = 0; c < 3; c++)
        s->rgb[c] = vf_select(split, row[c] * s->depth, s->rgb[c]);
}

/**
 * The mean of optical depth and colour over all values from front to back, as if the value ran evenly from one to the
 * other (algorithms: section 2.3). Sums are integers: differences of neighbours do not cancel. Within one row, however
 * far beyond the table, and within a sixty-fourth of a row, the mean of the two rows; of a steep row its part in the
 * middle of the way.
 */
VV_INLINE void mean_between(sight *s, const vvi_march_volume *f, const row_place *a, const row_place *b, vf value,
                            vf share, vm m)
{
    const vf way = b->place - a->place;
    const vm same = vm_or(vf_lt(vf_abs(way), vf_set1(1.0f / 64)), vi_eq(a->row, b->row));
    vf mean[4];
    VV_UNROLL
    for (int c = 0; c < 4; c++)
        mean[c] = (a->mean[c] + b->mean[c]) * vf_set1(0.5f);
    if (vm_any(vm_andnot(m, same))) {
        const vf inverse = vf_set1(1.0f) / vf_select(same, vf_set1(1.0f), way);
        VV_UNROLL
        for (int c = 0; c < 4; c++) {
            const vf ends = vf_fma(b->fraction, b->mean[c], vf_set1(0.0f) - a->fraction * a->mean[c]);
            const vf rows = vf_from_vi(vi_bits(b->sum[c]) - vi_bits(a->sum[c]));
            const vf over = vf_fma(rows, vf_set1(f->classifier.sum_unit[c]), ends) * inverse;
            mean[c] = vf_select(same, mean[c], over);
        }
    }
    s->depth = vf_max(mean[3], vf_set1(0.0f)) * share;
    VV_UNROLL
    for (int c = 0; c < 3; c++)
        s->rgb[c] = vf_max(mean[c], vf_set1(0.0f)) * share;
    const vm still = vm_and(m, same);
    if (f->classifier.has_split && vm_any(still))
        in_steep_row(s, f, value, share, still);
}

/** What a gradient leaves of the optical depth. */
VV_INLINE vf modulation(const vvi_march_volume *f, vf3 gradient)
{
    const vf length = vf_sqrt(vf3_dot(gradient, gradient)) * vf_set1(f->classifier.modulate_scale);
    const vf share = vf_min(length, vf_set1(1.0f));
    const float power = f->classifier.modulate_power;
    const vf left = power == 1 ? share : vf_pow01(share, power);
    return vf_select(vf_lt(vf_set1(0.0f), share), left, vf_set1(0.0f));
}

/** Whether values are seen with any gradient at all. */
VV_INLINE vm may_be_in_plane(const vvi_march_volume *f, vf value, vm m)
{
    const vf x = vf_fma(value, vf_set1(f->classifier.plane_scale), vf_set1(f->classifier.plane_shift));
    const vi i = vi_trunc(vf_clamp(x, vf_set1(0.0f), vf_set1(VVI_PLANE_SIDE - 1)));
    return vf_lt(vf_set1(0.0f), vf_gather4(f->classifier.plane_any, i, m));
}

/** The place in the plane of values and gradients, and the four of its numbers around it, interpolated. */
VV_INLINE void in_plane(sight *s, const vvi_march_volume *f, vf value, vf share)
{
    const vf zero = vf_set1(0.0f), last = vf_set1(VVI_PLANE_SIDE - 1);
    const vf length = vf_sqrt(vf3_dot(s->gradient, s->gradient));
    const vf x =
        vf_clamp(vf_fma(value, vf_set1(f->classifier.plane_scale), vf_set1(f->classifier.plane_shift)), zero, last);
    const vf y = vf_clamp(length * vf_set1(f->classifier.plane_gradient), zero, last);
    const vi i = vi_min(vi_trunc(x), vi_set1(VVI_PLANE_SIDE - 2)), j = vi_min(vi_trunc(y), vi_set1(VVI_PLANE_SIDE - 2));
    const vf fx = x - vf_from_vi(i), fy = y - vf_from_vi(j);
    const vi at = vi_shl(j * vi_set1(VVI_PLANE_SIDE) + i, 2);
    vf a[4], b[4], c[4], d[4], sum[4];
    vf_rows4(a, f->classifier.plane, at);
    vf_rows4(b, f->classifier.plane + 4, at);
    vf_rows4(c, f->classifier.plane + 4 * VVI_PLANE_SIDE, at);
    vf_rows4(d, f->classifier.plane + 4 * VVI_PLANE_SIDE + 4, at);
    VV_UNROLL
    for (int q = 0; q < 4; q++)
        sum[q] = vf_lerp(vf_lerp(a[q], b[q], fx), vf_lerp(c[q], d[q], fx), fy) * share;
    s->depth = sum[3];
    VV_UNROLL
    for (int q = 0; q < 3; q++)
        s->rgb[q] = sum[q];
}

#endif
