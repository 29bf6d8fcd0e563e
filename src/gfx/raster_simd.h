/** @file
 * Triangles into the samples of a tile, 16 samples at a time. For kernels only.
 *
 * Edge functions are whole numbers, and exact: at the corner of a block they are divided by the unit of the samples'
 * places and rounded down, which does not change on which side of an edge a sample is, since within the block they
 * change by whole multiples of that unit.
 */
#ifndef VVI_GFX_RASTER_SIMD_H
#define VVI_GFX_RASTER_SIMD_H
#include "core/simd.h"
#include "gfx/kernels.h"

#define VECTORS (16 / VV_WIDTH)

/* Places of samples in their block. */
typedef struct places {
    vi x[VECTORS], y[VECTORS];
    vi both[VECTORS];            /* x, and y in the higher 16 bits */
    vf fx[VECTORS], fy[VECTORS]; /* steps */
} places;

/* What SIMD has worked out for VV_WIDTH triangles, places from the tile's corner in steps. */
typedef struct setup {
    int32_t x[3][VV_WIDTH], y[3][VV_WIDTH], id[VV_WIDTH];
    float near[3][VV_WIDTH];
    int32_t a[3][VV_WIDTH], b[3][VV_WIDTH], c[3][VV_WIDTH];     /* edges; c: at the corner of the first block */
    float slope_x[VV_WIDTH], slope_y[VV_WIDTH], base[VV_WIDTH]; /* nearness, base: at that corner */
    float lo[VV_WIDTH], hi[VV_WIDTH];
    int32_t bx0[VV_WIDTH], by0[VV_WIDTH], bx1[VV_WIDTH], by1[VV_WIDTH]; /* blocks; the last included */
    uint32_t small, big;
} setup;

VV_INLINE void get(setup *t, int l, const vvi_gfx_rastering *r, uint32_t entry, int32_t x0, int32_t y0)
{
    if (entry & 0x80000000u) {
        const vvi_gfx_triangle *piece = &r->pieces[entry & 0x7fffffffu];
        for (int k = 0; k < 3; k++) {
            t->x[k][l] = piece->x[k] - x0;
            t->y[k][l] = piece->y[k] - y0;
            t->near[k][l] = piece->near[k];
        }
        t->id[l] = (int32_t)piece->id;
        return;
    }
    const uint32_t *index = r->triangles + 3 * (size_t)entry;
    VV_UNROLL
    for (int k = 0; k < 3; k++) {
        const vvi_gfx_vertex *v = r->vertices + index[k];
        t->x[k][l] = v->x - x0;
        t->y[k][l] = v->y - y0;
        t->near[k][l] = v->near;
    }
    t->id[l] = (int32_t)(r->first + entry);
}

/* Asks for what get() will read. */
VV_INLINE void ask_for(const vvi_gfx_rastering *r, size_t i)
{
    if (i >= r->n || r->entry[i] & 0x80000000u)
        return;
    const uint32_t *index = r->triangles + 3 * (size_t)r->entry[i];
    for (int k = 0; k < 3; k++)
        __builtin_prefetch(r->vertices + index[k]);
}

/* Upper and left edges have the samples on them: 0, the others -1. */
VV_INLINE vi edge_bias(vi dx, vi dy)
{
    const vi zero = vi_set1(0);
    const vm owned = vm_or(vi_lt(dy, zero), vm_and(vi_eq(dy, zero), vi_lt(zero, dx)));
    return vi_select(owned, zero, vi_set1(-1));
}

VV_INLINE int log2_of(int32_t n)
{
    return n == 1 ? 0 : n == 2 ? 1 : 2;
}

/* t->small: triangles whose edge functions fit into 32 bits; t->big: the others. */
VV_INLINE void prepare(setup *t, const vvi_gfx_samples *s, const vvi_gfx_area *window, uint32_t live)
{
    const vi zero = vi_set1(0), reach = vi_set1(16384);
    vi x[3], y[3];
    vf q[3];
    for (int k = 0; k < 3; k++) {
        x[k] = vi_load(t->x[k]);
        y[k] = vi_load(t->y[k]);
        q[k] = vf_load(t->near[k]);
    }
    const vi x0 = vi_min(x[0], vi_min(x[1], x[2])), x1 = vi_max(x[0], vi_max(x[1], x[2]));
    const vi y0 = vi_min(y[0], vi_min(y[1], y[2])), y1 = vi_max(y[0], vi_max(y[1], y[2]));
    const vm small = vm_and(vi_lt(x1 - x0, reach), vi_lt(y1 - y0, reach));
    for (int k = 1; k < 3; k++) { /* of what is not small the products would not fit, and nobody asks for them */
        x[k] = vi_select(small, x[k], x[0]);
        y[k] = vi_select(small, y[k], y[0]);
    }
    const vi area = (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]);
    const vm turned = vi_lt(area, zero);
    const vi xs[3] = {x[0], vi_select(turned, x[2], x[1]), vi_select(turned, x[1], x[2])};
    const vi ys[3] = {y[0], vi_select(turned, y[2], y[1]), vi_select(turned, y[1], y[2])};
    const vf qs[3] = {q[0], vf_select(turned, q[2], q[1]), vf_select(turned, q[1], q[2])};
    const int wide = 8 + log2_of(s->pattern->width), high = 8 + log2_of(s->pattern->height);
    const int32_t wx0 = (window->x0 - s->x0) * VVI_GFX_STEPS, wx1 = (window->x1 - s->x0) * VVI_GFX_STEPS - 1;
    const int32_t wy0 = (window->y0 - s->y0) * VVI_GFX_STEPS, wy1 = (window->y1 - s->y0) * VVI_GFX_STEPS - 1;
    const vi bx0 = vi_shr_by(vi_max(x0, vi_set1(wx0)), wide), bx1 = vi_shr_by(vi_min(x1, vi_set1(wx1)), wide);
    const vi by0 = vi_shr_by(vi_max(y0, vi_set1(wy0)), high), by1 = vi_shr_by(vi_min(y1, vi_set1(wy1)), high);
    const vi left = vi_shl(bx0, wide), top = vi_shl(by0, high);
    for (int k = 0; k < 3; k++) {
        const int from = (k + 1) % 3, to = (k + 2) % 3;
        const vi dx = xs[to] - xs[from], dy = ys[to] - ys[from];
        vi_store(t->a[k], zero - dy);
        vi_store(t->b[k], dx);
        vi_store(t->c[k], dx * (top - ys[from]) - dy * (left - xs[from]) + edge_bias(dx, dy));
    }
    const vf inverse = vf_set1(1) / vf_from_vi(vi_select(turned, zero - area, area));
    const vf q1 = qs[1] - qs[0], q2 = qs[2] - qs[0];
    const vf dx1 = vf_from_vi(xs[1] - xs[0]), dy1 = vf_from_vi(ys[1] - ys[0]);
    const vf dx2 = vf_from_vi(xs[2] - xs[0]), dy2 = vf_from_vi(ys[2] - ys[0]);
    const vf gx = (q1 * dy2 - q2 * dy1) * inverse, gy = (q2 * dx1 - q1 * dx2) * inverse;
    vf_store(t->slope_x, gx);
    vf_store(t->slope_y, gy);
    vf_store(t->base, vf_fma(gx, vf_from_vi(left - xs[0]), vf_fma(gy, vf_from_vi(top - ys[0]), qs[0])));
    vf_store(t->lo, vf_min(q[0], vf_min(q[1], q[2])));
    vf_store(t->hi, vf_max(q[0], vf_max(q[1], q[2])));
    vi_store(t->bx0, bx0);
    vi_store(t->bx1, bx1);
    vi_store(t->by0, by0);
    vi_store(t->by1, by1);
    /* those within one block that are behind all of its samples */
    const int across = 6 - log2_of(s->pattern->width);
    const vm some = vm_andnot(vm_from_bits(live), vm_or(vi_lt(bx1, bx0), vi_lt(by1, by0)));
    const vm single = vm_and(vm_and(vi_eq(bx0, bx1), vi_eq(by0, by1)), some);
    const vf far = vf_gather4(s->far, vi_shl(by0, across) + bx0, single);
    const vm hidden = vm_and(single, vf_le(vf_max(q[0], vf_max(q[1], q[2])), far));
    const uint32_t empty = ~vm_bits(vm_andnot(some, hidden));
    t->small = vm_bits(small) & live & ~(empty | vm_bits(vi_eq(area, zero)));
    t->big = live & ~vm_bits(small) & ~empty;
}

/* Samples of a block that lie in the window. */
VV_INLINE uint32_t window_lanes(const vvi_gfx_samples *s, const vvi_gfx_area *w, int32_t bx, int32_t by)
{
    const vvi_gfx_pattern *p = s->pattern;
    uint32_t lanes = 0;
    for (int l = 0; l < 16; l++) {
        const int32_t in = l / p->samples, x = s->x0 + bx * p->width + in % p->width,
                      y = s->y0 + by * p->height + in / p->width;
        lanes |= (uint32_t)(x >= w->x0 && x < w->x1 && y >= w->y0 && y < w->y1) << l;
    }
    return lanes;
}

/* What of one triangle is the same in all blocks. */
typedef struct planes {
    vi edge[3][VECTORS]; /* from the corner of a block */
    vf near[VECTORS];
    vf lo, hi;
    vi id;
} planes;

/* The least of all lanes. */
VV_INLINE float least_lane(vf a)
{
#if VV_WIDTH == 16
    return _mm512_reduce_min_ps(a);
#else
    float lane[VV_WIDTH];
    vf_store(lane, a);
    for (int n = VV_WIDTH / 2; n; n /= 2)
        for (int l = 0; l < n; l++)
            lane[l] = lane[l] < lane[l + n] ? lane[l] : lane[l + n];
    return lane[0];
#endif
}

VV_INLINE void draw_block(vvi_gfx_samples *s, const planes *t, const int32_t corner[3], float base, int32_t block,
                          uint32_t lanes)
{
    float *near = s->near + 16 * (ptrdiff_t)block;
    int32_t *id = (int32_t *)s->id + 16 * (ptrdiff_t)block;
    vf far = vf_set1(INFINITY);
    VV_UNROLL
    for (int v = 0; v < VECTORS; v++) {
        const vi e = (vi_set1(corner[0]) + t->edge[0][v]) | (vi_set1(corner[1]) + t->edge[1][v]) |
                     (vi_set1(corner[2]) + t->edge[2][v]);
        const vf q = vf_min(vf_max(vf_set1(base) + t->near[v], t->lo), t->hi), old = vf_load(near + v * VV_WIDTH);
        vm m = vm_andnot(vf_lt(old, q), vi_lt(e, vi_set1(0)));
        if (lanes != 0xffff)
            m = vm_and(m, vm_from_bits(lanes >> (v * VV_WIDTH) & ((1u << VV_WIDTH) - 1)));
        const vf now = vf_select(m, q, old);
        far = vf_min(far, now);
        vf_store(near + v * VV_WIDTH, now);
        vi_store(id + v * VV_WIDTH, vi_select(m, t->id, vi_load(id + v * VV_WIDTH)));
    }
    s->far[block] = least_lane(far);
}

/* small: a and b have 16 bits. */
VV_INLINE void fill_planes(planes *p, const int32_t a[3], const int32_t b[3], float slope_x, float slope_y,
                           const places *at, bool small)
{
    VV_UNROLL
    for (int v = 0; v < VECTORS; v++) {
        VV_UNROLL
        for (int k = 0; k < 3; k++)
            p->edge[k][v] =
                small ? vi_madd16(vi_set1((int32_t)((uint32_t)b[k] << 16 | ((uint32_t)a[k] & 0xffff))), at->both[v])
                      : vi_set1(a[k]) * at->x[v] + vi_set1(b[k]) * at->y[v];
        p->near[v] = vf_fma(vf_set1(slope_x), at->fx[v], vf_set1(slope_y) * at->fy[v]);
    }
}

VV_INLINE void draw_small(vvi_gfx_samples *s, const vvi_gfx_rastering *r, const setup *t, int l, const places *at)
{
    const int shift = s->pattern->shift;
    const int32_t width = s->pattern->width * VVI_GFX_STEPS, height = s->pattern->height * VVI_GFX_STEPS,
                  across = VVI_GFX_TILE / s->pattern->width;
    const int32_t a[3] = {t->a[0][l], t->a[1][l], t->a[2][l]}, b[3] = {t->b[0][l], t->b[1][l], t->b[2][l]};
    planes p;
    fill_planes(&p, a, b, t->slope_x[l], t->slope_y[l], at, true);
    p.lo = vf_set1(t->lo[l]);
    p.hi = vf_set1(t->hi[l]);
    p.id = vi_set1(t->id[l]);
    int32_t row[3] = {t->c[0][l], t->c[1][l], t->c[2][l]};
    for (int32_t by = t->by0[l]; by <= t->by1[l]; by++) {
        int32_t e[3] = {row[0], row[1], row[2]};
        const float down = t->base[l] + t->slope_y[l] * (float)((by - t->by0[l]) * height);
        for (int32_t bx = t->bx0[l]; bx <= t->bx1[l]; bx++) {
            const int32_t corner[3] = {e[0] >> shift, e[1] >> shift, e[2] >> shift};
            if (t->hi[l] > s->far[by * across + bx])
                draw_block(s, &p, corner, down + t->slope_x[l] * (float)((bx - t->bx0[l]) * width), by * across + bx,
                           r->partly ? window_lanes(s, &r->window, bx, by) : 0xffff);
            VV_UNROLL
            for (int k = 0; k < 3; k++)
                e[k] += a[k] * width;
        }
        VV_UNROLL
        for (int k = 0; k < 3; k++)
            row[k] += b[k] * height;
    }
}

/* Numbers that are this far from 0 stay on their side whatever is added within a block. */
#define FAR ((int64_t)1 << 30)

VV_INLINE int32_t corner_of(int64_t e, int shift)
{
    const int64_t c = e >> shift;
    return (int32_t)(c > FAR ? FAR : c < -FAR ? -FAR : c);
}

static void draw_big(vvi_gfx_samples *s, const vvi_gfx_rastering *r, const setup *t, int l, const places *at)
{
    const vvi_gfx_pattern *pattern = s->pattern;
    const int64_t width = pattern->width * VVI_GFX_STEPS, height = pattern->height * VVI_GFX_STEPS;
    const int32_t across = VVI_GFX_TILE / pattern->width;
    int64_t x[3], y[3], first[3];
    double q[3];
    for (int k = 0; k < 3; k++)
        x[k] = t->x[k][l], y[k] = t->y[k][l], q[k] = t->near[k][l];
    int64_t area = (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]);
    if (!area)
        return;
    if (area < 0) {
        const int64_t x1 = x[1], y1 = y[1];
        const double q1 = q[1];
        x[1] = x[2], y[1] = y[2], q[1] = q[2];
        x[2] = x1, y[2] = y1, q[2] = q1;
        area = -area;
    }
    const int64_t left = t->bx0[l] * width, top = t->by0[l] * height;
    int32_t a[3], b[3];
    for (int k = 0; k < 3; k++) {
        const int from = (k + 1) % 3, to = (k + 2) % 3;
        const int64_t dx = x[to] - x[from], dy = y[to] - y[from];
        a[k] = (int32_t)-dy;
        b[k] = (int32_t)dx;
        first[k] = dx * (top - y[from]) - dy * (left - x[from]) - (dy < 0 || (dy == 0 && dx > 0) ? 0 : 1);
    }
    const double scale = 1 / (double)area;
    const double gx = ((q[1] - q[0]) * (double)(y[2] - y[0]) - (q[2] - q[0]) * (double)(y[1] - y[0])) * scale;
    const double gy = ((q[2] - q[0]) * (double)(x[1] - x[0]) - (q[1] - q[0]) * (double)(x[2] - x[0])) * scale;
    const double base = q[0] + gx * (double)(left - x[0]) + gy * (double)(top - y[0]);
    planes p;
    fill_planes(&p, a, b, (float)gx, (float)gy, at, false);
    p.lo = vf_set1(t->lo[l]);
    p.hi = vf_set1(t->hi[l]);
    p.id = vi_set1(t->id[l]);
    for (int32_t by = t->by0[l]; by <= t->by1[l]; by++)
        for (int32_t bx = t->bx0[l]; bx <= t->bx1[l]; bx++) {
            const int64_t right = (bx - t->bx0[l]) * width, down = (by - t->by0[l]) * height;
            int32_t corner[3];
            bool outside = false;
            for (int k = 0; k < 3; k++) {
                const int64_t e = first[k] + a[k] * right + b[k] * down;
                outside |= e + (a[k] > 0 ? a[k] * width : 0) + (b[k] > 0 ? b[k] * height : 0) < 0;
                corner[k] = corner_of(e, pattern->shift);
            }
            if (!outside && t->hi[l] > s->far[by * across + bx])
                draw_block(s, &p, corner, (float)(base + gx * (double)right + gy * (double)down), by * across + bx,
                           r->partly ? window_lanes(s, &r->window, bx, by) : 0xffff);
        }
}

static void raster(vvi_gfx_samples *s, const vvi_gfx_rastering *r)
{
    const vvi_gfx_pattern *p = s->pattern;
    const float unit = (float)(1 << p->shift);
    places at;
    setup t = {.small = 0};
    for (int v = 0; v < VECTORS; v++) {
        at.x[v] = vi_load(p->x + v * VV_WIDTH);
        at.y[v] = vi_load(p->y + v * VV_WIDTH);
        at.both[v] = at.x[v] + vi_shl(at.y[v], 16);
        at.fx[v] = vf_from_vi(at.x[v]) * vf_set1(unit);
        at.fy[v] = vf_from_vi(at.y[v]) * vf_set1(unit);
    }
    for (size_t i = 0; i < r->n; i += VV_WIDTH) {
        const int n = r->n - i < VV_WIDTH ? (int)(r->n - i) : VV_WIDTH;
        for (size_t ahead = i + VV_WIDTH; ahead < i + (size_t)2 * VV_WIDTH; ahead++) {
            ask_for(r, ahead);
            if (ahead + VV_WIDTH < r->n)
                __builtin_prefetch(r->triangles + 3 * (size_t)(r->entry[ahead + VV_WIDTH] & 0x7fffffffu));
        }
        for (int l = 0; l < n; l++)
            get(&t, l, r, r->entry[i + (size_t)l], s->x0 * VVI_GFX_STEPS, s->y0 * VVI_GFX_STEPS);
        prepare(&t, s, &r->window, vm_bits(vm_first_n((uint64_t)n)));
        for (uint32_t left = t.small | t.big; left; left &= left - 1) {
            const int l = __builtin_ctz(left);
            if (t.big >> l & 1)
                draw_big(s, r, &t, l, &at);
            else
                draw_small(s, r, &t, l, &at);
        }
    }
}

#endif
