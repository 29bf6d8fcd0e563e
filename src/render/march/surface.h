/** @file
 * The first point along each ray of a packet where the value enters [solid_lo, solid_hi]: cell by cell, with the exact
 * root of the cubic that a trilinear cell is along a ray (after Marmitt 2004). For kernels only.
 *
 * A ray that starts inside the solid (a cut plane, the border of the data, the eye) shows the cut: a flat face.
 */
#ifndef VVI_RENDER_MARCH_SURFACE_H
#define VVI_RENDER_MARCH_SURFACE_H
#include "render/march/hits.h"
#include "render/march/paint_simd.h"
#include "render/march/shade_simd.h"
#include "render/march/texture_simd.h"

/** Walk of a packet through cells. Cells are integers, so each step gets on, whatever the rounding of s. */
typedef struct walk {
    vi cell[3], step[3];
    vi last[3];
    vf3 start; /* in cell coordinates: nearest cells begin half a voxel earlier */
    vf s;      /* where the ray enters the cell, in steps */
} walk;

VV_INLINE vi walk_clamp(const walk *w, vi cell, int a)
{
    return vi_clamp(cell, vi_set1(0), w->last[a]);
}

VV_INLINE void walk_begin(walk *w, const packet *r, const vvi_march_volume *f, bool nearest)
{
    const vf shift = vf_set1(nearest ? 0.5f : 0.0f), zero = vf_set1(0.0f);
    const vf start[3] = {r->start.x + shift, r->start.y + shift, r->start.z + shift};
    const vf delta[3] = {r->delta.x, r->delta.y, r->delta.z};
    VV_UNROLL
    for (int a = 0; a < 3; a++) {
        const int32_t cells = nearest ? f->sampler.lattice.n[a] : f->sampler.lattice.n[a] - 1;
        w->last[a] = vi_set1(cells > 0 ? cells - 1 : 0);
        w->cell[a] = walk_clamp(w, vi_trunc(vf_fma(r->first, delta[a], start[a])), a);
        w->step[a] = vi_select(vf_le(zero, delta[a]), vi_set1(1), vi_set1(-1));
    }
    w->start = vf3_set(start[0], start[1], start[2]);
    w->s = r->first;
}

/** Cells [low, high) on each axis. */
typedef struct cell_box {
    vi low[3], high[3];
} cell_box;

/* Where a ray leaves cells [low, high) on one axis. */
VV_INLINE vf walk_exit(vf start, vf inverse, vi step, vi low, vi high)
{
    const vi side = vi_select(vi_lt(vi_set1(0), step), high, low);
    return (vf_from_vi(side) - start) * inverse;
}

/** Where a ray leaves a box of cells: by axis, and the nearest, s. */
typedef struct walk_out {
    vf s, axis_s[3];
} walk_out;

VV_INLINE walk_out walk_find_exit(const walk *w, const packet *r, const cell_box *b)
{
    walk_out o;
    o.axis_s[0] = walk_exit(w->start.x, r->inverse.x, w->step[0], b->low[0], b->high[0]);
    o.axis_s[1] = walk_exit(w->start.y, r->inverse.y, w->step[1], b->low[1], b->high[1]);
    o.axis_s[2] = walk_exit(w->start.z, r->inverse.z, w->step[2], b->low[2], b->high[2]);
    o.s = vf_max(vf_min(o.axis_s[0], vf_min(o.axis_s[1], o.axis_s[2])), w->s);
    return o;
}

/** The box of each lane's own cell. */
VV_INLINE cell_box walk_cell(const walk *w)
{
    cell_box b;
    VV_UNROLL
    for (int a = 0; a < 3; a++) {
        b.low[a] = w->cell[a];
        b.high[a] = w->cell[a] + vi_set1(1);
    }
    return b;
}

/** Lanes of m go to the neighbour beyond the side that they leave by. The rest stay. Returns lanes still in the grid.
 */
VV_INLINE vm walk_step(walk *w, const walk_out *o, vm m)
{
    const vm x = vm_and(vf_le(o->axis_s[0], o->axis_s[1]), vf_le(o->axis_s[0], o->axis_s[2]));
    const vm y = vm_andnot(vf_le(o->axis_s[1], o->axis_s[2]), x);
    const vm z = vm_andnot(vm_andnot(m, x), y);
    const vm go[3] = {vm_and(m, x), vm_and(m, y), z};
    vm inside = m;
    VV_UNROLL
    for (int a = 0; a < 3; a++) {
        w->cell[a] = vi_select(go[a], w->cell[a] + w->step[a], w->cell[a]);
        inside = vm_andnot(inside, vi_lt(w->cell[a], vi_set1(0)));
        inside = vm_andnot(inside, vi_lt(w->last[a], w->cell[a]));
    }
    w->s = vf_select(m, o->s, w->s);
    return inside;
}

/** Lanes of m jump out of a box that holds their cells at once. */
VV_INLINE vm walk_jump(walk *w, const packet *r, const cell_box *b, vm m)
{
    const vi one = vi_set1(1);
    const walk_out o = walk_find_exit(w, r, b);
    const vf p[3] = {vf_fma(o.s, r->delta.x, w->start.x), vf_fma(o.s, r->delta.y, w->start.y),
                     vf_fma(o.s, r->delta.z, w->start.z)};
    const vm x = vm_and(vf_le(o.axis_s[0], o.axis_s[1]), vf_le(o.axis_s[0], o.axis_s[2]));
    const vm y = vm_andnot(vf_le(o.axis_s[1], o.axis_s[2]), x);
    const vm by[3] = {x, y, vm_andnot(vm_andnot(m, x), y)};
    VV_UNROLL
    for (int a = 0; a < 3; a++) {
        /* the cell where it leaves, still inside the box; on the axis that it leaves by, the last one of the box,
         * whatever the rounding */
        const vi in = vi_clamp(vi_trunc(p[a]), b->low[a], b->high[a] - one);
        const vi end = vi_select(vi_lt(vi_set1(0), w->step[a]), b->high[a] - one, b->low[a]);
        w->cell[a] = vi_select(m, walk_clamp(w, vi_select(by[a], end, in), a), w->cell[a]);
    }
    return walk_step(w, &o, m);
}

/* The interpolated value along the ray inside one cell, over tau in [0, 1] from entry to exit. */
typedef struct cubic {
    vf c[4];
} cubic;

VV_INLINE vf cubic_at(const cubic *q, vf t)
{
    return vf_fma(vf_fma(vf_fma(q->c[3], t, q->c[2]), t, q->c[1]), t, q->c[0]);
}

/** v[z][y][x] corners; (x, y, z) entry point inside the cell; d: from entry to exit. */
VV_INLINE cubic cell_cubic(vf v[2][2][2], vf x, vf y, vf z, vf3 d)
{
    const vf k0 = v[0][0][0], kx = v[0][0][1] - k0, ky = v[0][1][0] - k0, kz = v[1][0][0] - k0;
    const vf kxy = v[0][1][1] - v[0][1][0] - kx, kxz = v[1][0][1] - v[1][0][0] - kx;
    const vf kyz = v[1][1][0] - v[1][0][0] - ky;
    const vf kxyz = v[1][1][1] - v[1][1][0] - v[1][0][1] + v[1][0][0] - kxy;
    cubic q;
    q.c[0] = k0 + kx * x + ky * y + kz * z + kxy * x * y + kxz * x * z + kyz * y * z + kxyz * x * y * z;
    q.c[1] = kx * d.x + ky * d.y + kz * d.z + kxy * (x * d.y + y * d.x) + kxz * (x * d.z + z * d.x) +
             kyz * (y * d.z + z * d.y) + kxyz * (x * y * d.z + y * z * d.x + x * z * d.y);
    q.c[2] =
        kxy * d.x * d.y + kxz * d.x * d.z + kyz * d.y * d.z + kxyz * (x * d.y * d.z + y * d.x * d.z + z * d.x * d.y);
    q.c[3] = kxyz * d.x * d.y * d.z;
    return q;
}

/** First tau where a cubic that begins below 0 is not negative any more. Its values are of the order of 1. */
VV_INLINE vm cubic_first_root(const cubic *u, vf *tau)
{
    const vf zero = vf_set1(0.0f), one = vf_set1(1.0f);
    /* extrema: 3 c3 t^2 + 2 c2 t + c1 = 0, by the form that does not cancel */
    const vf a = u->c[3] * vf_set1(3.0f), b = u->c[2], c = u->c[1];
    const vf root = vf_sqrt(vf_max(b * b - a * c, zero));
    const vf w = zero - b - vf_select(vf_lt(b, zero), zero - root, root);
    const vf tiny = vf_set1(1e-30f);
    const vf r1 = w / vf_select(vf_lt(vf_abs(a), tiny), tiny, a);
    const vf r2 = c / vf_select(vf_lt(vf_abs(w), tiny), tiny, w);
    const vf e1 = vf_clamp(vf_min(r1, r2), zero, one), e2 = vf_clamp(vf_max(r1, r2), zero, one);
    const vm at0 = vf_le(zero, u->c[0]);
    const vm at1 = vf_le(zero, cubic_at(u, e1)), at2 = vf_le(zero, cubic_at(u, e2));
    const vm at3 = vf_le(zero, cubic_at(u, one));
    vf lo = vf_select(at1, zero, vf_select(at2, e1, e2));
    vf hi = vf_select(at1, e1, vf_select(at2, e2, one));
    hi = vf_select(at0, zero, hi);
    lo = vf_select(at0, zero, lo);
    const vm found = vm_or(vm_or(at0, at1), vm_or(at2, at3));
    if (vm_any(found))
        for (int i = 0; i < 24; i++) { /* to the last bit that a float in [0, 1] has */
            const vf mid = (lo + hi) * vf_set1(0.5f);
            const vm in = vf_le(zero, cubic_at(u, mid));
            hi = vf_select(in, mid, hi);
            lo = vf_select(in, lo, mid);
        }
    *tau = hi;
    return found;
}

typedef struct surface_state {
    vf s;         /* steps to the hit */
    vm hit, flat; /* flat: on the face of a cut */
    vf3 sample;   /* nearest: the sample that was hit, for a point on its face lies as near to the one before */
    uint64_t samples;
} surface_state;

/** Lanes whose block is empty, and for each the cube of empty blocks around it as a box of cells. The last block has
 * all cells up to the border: with nearest samples there is one more than cells between samples. */
VV_INLINE vm surface_empty(const walk *w, const vvi_march_volume *f, vm run, cell_box *box)
{
    const vi one = vi_set1(1);
    vi block[3];
    VV_UNROLL
    for (int a = 0; a < 3; a++)
        block[a] = vi_min(vi_shr_by(w->cell[a], f->skipper.shift), vi_set1(f->skipper.blocks[a] - 1));
    const vi index = (block[2] * vi_set1(f->skipper.blocks[1]) + block[1]) * vi_set1(f->skipper.blocks[0]) + block[0];
    const vi reach = vi_gather(f->skipper.reach, index, run) & vi_set1(255);
    const vi far = vi_select(vi_lt(reach, vi_set1(VVI_SKIP_OCCUPIED)), reach, vi_set1(0));
    VV_UNROLL
    for (int a = 0; a < 3; a++) {
        const vi high = vi_shl(block[a] + far, f->skipper.shift);
        const vm border = vi_lt(vi_set1(f->skipper.blocks[a] - 1), block[a] + far);
        box->low[a] = vi_shl(block[a] - far + one, f->skipper.shift);
        box->high[a] = vi_select(border, vi_max(high, w->last[a] + one), high);
    }
    return vm_and(run, vi_lt(vi_set1(0), far));
}

/** Which of the solid's bounds each ray comes from, and the sign by which a value beyond it is inside. */
typedef struct surface_side {
    vf target, sign;
} surface_side;

/** Looks for the border in the cells of lanes `run`, which they leave at s_out. */
typedef void surface_cell_fn(surface_state *st, const walk *w, const packet *r, const vvi_march_volume *f, int type,
                             const surface_side *side, vf s_out, vm run);

VV_INLINE void surface_nearest_cell(surface_state *st, const walk *w, const packet *r, const vvi_march_volume *f,
                                    int type, const surface_side *side, vf s_out, vm run)
{
    const vvi_lattice *g = &f->sampler.lattice;
    const sample_place at = find_place(g, type, w->cell[0], w->cell[1], w->cell[2], run);
    const vf v = load_one(g, type, at.x, at.y, at.z, run);
    const vm in = vm_and(run, vm_and(vf_le(vf_set1(f->solid.lo), v), vf_le(v, vf_set1(f->solid.hi))));
    st->s = vf_select(in, w->s, st->s);
    st->sample.x = vf_select(in, vf_from_vi(w->cell[0]), st->sample.x);
    st->sample.y = vf_select(in, vf_from_vi(w->cell[1]), st->sample.y);
    st->sample.z = vf_select(in, vf_from_vi(w->cell[2]), st->sample.z);
    st->hit = vm_or(st->hit, in);
    st->samples += (uint64_t)vm_count(run);
}

VV_INLINE void surface_linear_cell(surface_state *st, const walk *w, const packet *r, const vvi_march_volume *f,
                                   int type, const surface_side *side, vf s_out, vm run)
{
    const vf zero = vf_set1(0.0f), one = vf_set1(1.0f);
    const cell_at c = {w->cell[0], w->cell[1], w->cell[2], zero, zero, zero};
    vf v[2][2][2];
    load_corners(&f->sampler.lattice, type, &c, run, v);
    st->samples += (uint64_t)vm_count(run);
    vf best = vf_set1(-INFINITY);
    for (int i = 0; i < 8; i++) { /* from here on: how far inside the solid, as a share of the data's range */
        vf *corner = &v[i >> 2][i >> 1 & 1][i & 1];
        *corner = (*corner - side->target) * side->sign;
        best = vf_max(*corner, best);
    }
    const vm may = vm_and(run, vf_le(zero, best));
    if (!vm_any(may))
        return;
    const vf length = s_out - w->s;
    const vf3 d = vf3_scale(r->delta, length);
    const vf x = vf_clamp(vf_fma(w->s, r->delta.x, w->start.x) - vf_from_vi(c.i), zero, one);
    const vf y = vf_clamp(vf_fma(w->s, r->delta.y, w->start.y) - vf_from_vi(c.j), zero, one);
    const vf z = vf_clamp(vf_fma(w->s, r->delta.z, w->start.z) - vf_from_vi(c.k), zero, one);
    const cubic q = cell_cubic(v, x, y, z, d);
    vf tau;
    const vm found = vm_and(may, cubic_first_root(&q, &tau));
    st->s = vf_select(found, vf_fma(tau, length, w->s), st->s);
    st->hit = vm_or(st->hit, found);
}

/* Asked at run time, as by all kernels of a type. */
VV_INLINE void surface_own_cell(surface_state *st, const walk *w, const packet *r, const vvi_march_volume *f, int type,
                                const surface_side *side, vf s_out, vm run)
{
    if (f->sampler.nearest)
        surface_nearest_cell(st, w, r, f, type, side, s_out, run);
    else
        surface_linear_cell(st, w, r, f, type, side, s_out, run);
}

/** From where rays enter, with the value v0 there, cell by cell to the border. */
VV_INLINE void surface_walk(surface_state *st, const packet *r, const vvi_march_volume *f, vf v0, int type,
                            bool nearest, surface_cell_fn *look)
{
    const vf lo = vf_set1(f->solid.lo), hi = vf_set1(f->solid.hi), unit = vf_set1(f->solid.unit);
    const vm rays = packet_promising(r);
    st->flat = vm_and(rays, vm_and(vf_le(lo, v0), vf_le(v0, hi)));
    st->hit = st->flat;
    /* outside, a value stays on its side of the solid's range until it enters */
    const vm above = vf_lt(hi, v0);
    const surface_side side = {vf_select(above, hi, lo), vf_select(above, vf_set1(0.0f) - unit, unit)};
    walk w;
    walk_begin(&w, r, f, nearest);
    vm run = vm_andnot(rays, st->hit);
    while (vm_any(run)) {
        cell_box box;
        const vm empty = f->skipper.reach ? surface_empty(&w, f, run, &box) : vm_none();
        if (vm_any(empty)) {
            const vm inside = walk_jump(&w, r, &box, empty);
            run = vm_and(vm_or(vm_andnot(run, empty), inside), vf_lt(w.s, r->last));
            continue;
        }
        box = walk_cell(&w);
        const walk_out o = walk_find_exit(&w, r, &box);
        look(st, &w, r, f, type, &side, vf_min(o.s, r->n), run);
        run = vm_andnot(run, st->hit);
        run = vm_and(walk_step(&w, &o, run), vf_lt(w.s, r->last));
    }
}

VV_INLINE void surface_march(surface_state *st, const packet *r, const vvi_march_volume *f, int type, bool nearest)
{
    const vf v0 = sample_value(&f->sampler.lattice, type, nearest, r->start, packet_promising(r));
    surface_walk(st, r, f, v0, type, nearest, surface_own_cell);
}

/** The colour of a surface where rays hit it. */
VV_INLINE void surface_colors(vf rgb[3], const surface_state *st, const packet *r, const vvi_march_volume *f)
{
    VV_UNROLL
    for (int c = 0; c < 3; c++)
        rgb[c] = vf_set1(f->solid.color[c]);
    const vf3 p = packet_point(r, st->s);
    if (f->paint.kind != VVI_PAINT_NONE) {
        const bool own = f->sampler.nearest && f->paint.kind == VVI_PAINT_COLORS;
        const vf3 at = own ? vf3_select(st->flat, p, st->sample) : p;
        take_paint(rgb, &f->paint, &at, st->hit);
    }
    if (f->texture)
        texture_colors(rgb, f, &p, entry_distance(r), st->s, st->hit);
}

/** To the sink: colours where rays hit, and how far along them. */
VV_INLINE void surface_store(vvi_sink *out, const packet *r, const vvi_march_volume *f, size_t at,
                             const surface_state *st, vf rgb[3])
{
    const vf zero = vf_set1(0.0f);
    VV_UNROLL
    for (int i = 0; i < 3; i++)
        rgb[i] = vf_select(st->hit, rgb[i], zero);
    packet_store(out, r, f, at, rgb, vf_select(st->hit, zero, vf_set1(1.0f)),
                 vf_select(st->hit, st->s, vf_set1(-1.0f)));
    if (!out->hits)
        return;
    const vf3 p = packet_point(r, st->s), met = f->sampler.nearest ? vf3_select(st->flat, p, st->sample) : p;
    hits_begin(out, at);
    find_hits(out, r, f, at, &st->s, &met, st->hit);
}

VV_INLINE void surface_packet(vvi_sink *out, const vvi_march_volume *f, const packet *r, size_t at, int type,
                              bool nearest, vv_render_counts *counts)
{
    const vf zero = vf_set1(0.0f);
    surface_state st = {zero, vm_none(), vm_none(), {zero, zero, zero}, 0};
    vf rgb[3] = {zero, zero, zero};
    if (vm_any(packet_promising(r)))
        surface_march(&st, r, f, type, nearest);
    counts->samples += st.samples;
    if (vm_any(st.hit)) {
        surface_colors(rgb, &st, r, f);
        if (f->light.shaded) {
            const vf3 p = packet_point(r, st.s);
            const cell_at c = find_cell(&f->sampler.lattice, nearest ? st.sample : p);
            vf3 g = world_gradient(f, gradient_by(f->sampler.cell_gradient, &f->sampler.lattice, type, &c, st.hit));
            if (vm_any(st.flat)) {
                const vf3 e = entry_gradient(r, f, st.flat);
                g = vf3_set(vf_select(st.flat, e.x, g.x), vf_select(st.flat, e.y, g.y), vf_select(st.flat, e.z, g.z));
            }
            shade(f, p, r->direction, g, true, rgb);
        }
    }
    surface_store(out, r, f, at, &st, rgb);
}

#endif
