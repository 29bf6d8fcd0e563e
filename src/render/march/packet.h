/** @file
 * A packet of rays, one a lane: taken from a batch, clipped to the volume, marched through blocks. For kernels only.
 */
#ifndef VVI_RENDER_MARCH_PACKET_H
#define VVI_RENDER_MARCH_PACKET_H
#include "render/march/kernels.h"
#include "render/march/lattice_simd.h"

/** p(k) = start + k * delta in index space, k in steps from where the ray enters; n steps until it leaves. */
typedef struct packet {
    vf3 start, delta;
    vf3 inverse; /* 1 / delta, huge where delta is 0 */
    vf n;
    vf first, last; /* steps before and after which nothing is visible: 0 <= first, last <= n */
    vf phase;       /* where in each step its sample lies, 0 to 1 */
    vf3 direction;  /* world, unit */
    double t0[VV_WIDTH];
    const double *origin[3], *dir[3]; /* of the batch, lane 0 */
    vm hit;
} packet;

/* Entry and exit distance for one pair of parallel planes or one half-space, tightened lane by lane. A ray along the
 * planes stays in or out: the division by a signed tiny number puts both crossings at the right infinity. */
VV_INLINE void clip_slab(double *restrict t0, double *restrict t1, const double *o, const double *d, double lo,
                         double hi)
{
    for (int l = 0; l < VV_WIDTH; l++) {
        const double dd = fabs(d[l]) < 1e-200 ? 1e-200 : d[l];
        const double a = (lo - o[l]) / dd, b = (hi - o[l]) / dd;
        const double near = a < b ? a : b, far = a < b ? b : a;
        t0[l] = near > t0[l] ? near : t0[l];
        t1[l] = far < t1[l] ? far : t1[l];
    }
}

VV_INLINE void clip_plane(double *restrict t0, double *restrict t1, const packet *r, const double plane[4])
{
    for (int l = 0; l < VV_WIDTH; l++) {
        const double d = plane[0] * r->dir[0][l] + plane[1] * r->dir[1][l] + plane[2] * r->dir[2][l];
        const double o = plane[0] * r->origin[0][l] + plane[1] * r->origin[1][l] + plane[2] * r->origin[2][l];
        const double t = (plane[3] - o) / (fabs(d) < 1e-200 ? 1e-200 : d);
        const double in = d >= 0 ? t : -INFINITY, out = d >= 0 ? INFINITY : t;
        t0[l] = in > t0[l] ? in : t0[l];
        t1[l] = out < t1[l] ? out : t1[l];
    }
}

/* Between which steps a ray can meet something visible. */
VV_INLINE void packet_bound(packet *r, const vvi_march_volume *f, const int32_t cell[VV_WIDTH])
{
    const vvi_parc *p = f->skipper.parc;
    float first[VV_WIDTH], last[VV_WIDTH];
    r->first = vf_set1(0.0f);
    r->last = r->n;
    if (!p)
        return;
    for (int l = 0; l < VV_WIDTH; l++) {
        first[l] = 0;
        last[l] = INFINITY;
        if (cell[l] < 0)
            continue;
        /* depth to distance along this ray: 1 / cosine to the axis of the lens */
        const double cosine = r->dir[0][l] * p->forward.x + r->dir[1][l] * p->forward.y + r->dir[2][l] * p->forward.z;
        const double steps = 1 / (cosine * f->step), begin = r->t0[l] / f->step;
        first[l] = (float)((p->origin + (double)p->near[cell[l]]) * steps - begin);
        last[l] = (float)((p->origin + (double)p->far[cell[l]]) * steps - begin);
    }
    /* a step more on both sides: what single precision loses of the numbers of steps; there are less than 2^24 */
    r->first = vf_floor(vf_clamp(vf_load(first), vf_set1(1.0f), vf_set1(16777216.0f))) - vf_set1(1.0f);
    r->last = vf_min(vf_load(last) + vf_set1(1.0f), r->n);
}

/** Rays that may meet something visible. */
VV_INLINE vm packet_promising(const packet *r)
{
    return vm_and(r->hit, vf_lt(r->first, r->last));
}

/** Lanes whose ray is somebody's. */
VV_INLINE vm packet_lanes(const vvi_rays *rays, size_t at)
{
    return vi_lt(vi_set1(-1), vi_load(rays->pixel + at));
}

/** Rays of the batch from `at` on, clipped to the volume's domain, the cut planes and the ray's own range. */
static __attribute__((noinline)) void packet_begin(packet *r, const vvi_march_volume *f, const vvi_rays *rays,
                                                   size_t at)
{
    double t0[VV_WIDTH], t1[VV_WIDTH], io[3][VV_WIDTH], id[3][VV_WIDTH];
    float start[3][VV_WIDTH], delta[3][VV_WIDTH], inverse[3][VV_WIDTH], n[VV_WIDTH], dir[3][VV_WIDTH];
    VV_UNROLL
    for (int a = 0; a < 3; a++) {
        r->origin[a] = rays->origin[a] + at;
        r->dir[a] = rays->direction[a] + at;
    }
    for (int l = 0; l < VV_WIDTH; l++) {
        t0[l] = rays->near[at + (size_t)l];
        t1[l] = rays->far[at + (size_t)l];
    }
    VV_UNROLL
    for (int a = 0; a < 3; a++) {
        const double *m = f->sampler.world_to_index[a];
        for (int l = 0; l < VV_WIDTH; l++) {
            io[a][l] = m[0] * r->origin[0][l] + m[1] * r->origin[1][l] + m[2] * r->origin[2][l] + m[3];
            id[a][l] = m[0] * r->dir[0][l] + m[1] * r->dir[1][l] + m[2] * r->dir[2][l];
        }
        clip_slab(t0, t1, io[a], id[a], f->sampler.lo[a], f->sampler.hi[a]);
    }
    for (size_t p = 0; p < f->sampler.n_planes; p++)
        clip_plane(t0, t1, r, f->sampler.planes[p]);
    for (int l = 0; l < VV_WIDTH; l++) {
        const bool in = t1[l] > t0[l];
        const double from = in ? t0[l] : 0;
        r->t0[l] = from;
        n[l] = in ? (float)((t1[l] - from) / f->step) : 0.0f;
        VV_UNROLL
        for (int a = 0; a < 3; a++) {
            const double s = id[a][l] * f->step;
            start[a][l] = (float)(io[a][l] + id[a][l] * from);
            delta[a][l] = (float)s;
            inverse[a][l] = fabs(s) < 1e-12 ? 1e30f : (float)(1 / s);
            dir[a][l] = (float)r->dir[a][l];
        }
    }
    r->start = vf3_set(vf_load(start[0]), vf_load(start[1]), vf_load(start[2]));
    r->delta = vf3_set(vf_load(delta[0]), vf_load(delta[1]), vf_load(delta[2]));
    r->inverse = vf3_set(vf_load(inverse[0]), vf_load(inverse[1]), vf_load(inverse[2]));
    r->direction = vf3_set(vf_load(dir[0]), vf_load(dir[1]), vf_load(dir[2]));
    r->n = vf_load(n);
    r->hit = vm_and(packet_lanes(rays, at), vf_lt(vf_set1(0.0f), r->n));
    r->phase = vf_load(rays->phase + at);
    packet_bound(r, f, rays->cell + at);
}

VV_INLINE vf3 packet_point(const packet *r, vf k)
{
    return vf3_set(vf_fma(k, r->delta.x, r->start.x), vf_fma(k, r->delta.y, r->start.y),
                   vf_fma(k, r->delta.z, r->start.z));
}

/** What came along the rays; depth in steps, negative: nowhere. */
VV_INLINE void packet_store(vvi_sink *out, const packet *r, const vvi_march_volume *f, size_t at, const vf rgb[3],
                            vf through, vf depth)
{
    float k[VV_WIDTH];
    VV_UNROLL
    for (int i = 0; i < 3; i++)
        vf_store(out->rgb[i] + at, rgb[i]);
    vf_store(out->through + at, through);
    vf_store(k, depth);
    for (int l = 0; l < VV_WIDTH; l++)
        out->depth[at + (size_t)l] = k[l] < 0 ? INFINITY : (float)(r->t0[l] + (double)k[l] * f->step);
}

/* Blocks -------------------------------------------------------------------------------------------------------- */

/** The block a sample lies in, and its number in the block arrays. */
typedef struct block_at {
    vi i, j, k, index;
} block_at;

VV_INLINE block_at find_block(const vvi_march_volume *f, bool nearest, vf3 p)
{
    const cell_at c = nearest ? find_sample(&f->sampler.lattice, p) : find_cell(&f->sampler.lattice, p);
    block_at b;
    b.i = vi_min(vi_shr_by(c.i, f->skipper.shift), vi_set1(f->skipper.blocks[0] - 1));
    b.j = vi_min(vi_shr_by(c.j, f->skipper.shift), vi_set1(f->skipper.blocks[1] - 1));
    b.k = vi_min(vi_shr_by(c.k, f->skipper.shift), vi_set1(f->skipper.blocks[2] - 1));
    b.index = (b.k * vi_set1(f->skipper.blocks[1]) + b.j) * vi_set1(f->skipper.blocks[0]) + b.i;
    return b;
}

/* Where a ray leaves [b - r, b + r + 1) blocks on one axis, in steps. Nearest samples own half a voxel to each side. */
VV_INLINE vf axis_exit(vf start, vf delta, vf inverse, vi b, vi reach, vi last, int shift, float half)
{
    const vm up = vf_le(vf_set1(0.0f), delta);
    const vi side = vi_select(up, b + reach, b - reach + vi_set1(1));
    const vf bound = vf_from_vi(vi_shl(side, shift)) - vf_set1(half);
    /* the last block reaches to the border, however few voxels it has */
    const vm beyond = vm_and(up, vi_lt(last, b + reach));
    return vf_select(beyond, vf_set1(1e30f), (bound - start) * inverse);
}

/** What vvi_skip.reach says of the lanes' blocks: which may show something, and how far their like goes on. */
VV_INLINE vi look_at_blocks(const vvi_march_volume *f, const block_at *b, vm m, vm *empty)
{
    const vi reach = vi_gather(f->skipper.reach, b->index, m);
    *empty = vm_and(m, vi_eq(reach & vi_set1(VVI_SKIP_OCCUPIED), vi_set1(0)));
    return vi_max(reach & vi_set1(VVI_SKIP_DISTANCE), vi_set1(1));
}

/** Steps from entry to where the ray leaves the cube of blocks that reaches `reach` blocks around b (1: b alone). */
VV_INLINE vf block_exit(const packet *r, const vvi_march_volume *f, bool nearest, const block_at *b, vi reach)
{
    const float half = nearest ? 0.5f : 0.0f;
    const vi lx = vi_set1(f->skipper.blocks[0] - 1), ly = vi_set1(f->skipper.blocks[1] - 1),
             lz = vi_set1(f->skipper.blocks[2] - 1);
    const vf x = axis_exit(r->start.x, r->delta.x, r->inverse.x, b->i, reach, lx, f->skipper.shift, half);
    const vf y = axis_exit(r->start.y, r->delta.y, r->inverse.y, b->j, reach, ly, f->skipper.shift, half);
    const vf z = axis_exit(r->start.z, r->delta.z, r->inverse.z, b->k, reach, lz, f->skipper.shift, half);
    return vf_min(x, vf_min(y, z));
}

/** The first sample number after the exit, where sample k lies at k + offset steps. A sample within a hundredth of a
 * step of the face is looked at again from the other side rather than lost to rounding. */
VV_INLINE vf sample_after(vf k, vf exit, vf offset)
{
    const vf next = vf_floor(exit - offset - vf_set1(0.01f)) + vf_set1(1.0f);
    return vf_max(next, k + vf_set1(1.0f));
}

/** The same where steps are seen as a whole, from front to back: empty are those that end before an empty block does,
 * and lanes that have none such there take their sample. */
VV_INLINE vf step_after(vf k, vf exit, vm *empty)
{
    const vf next = vf_floor(exit - vf_set1(0.01f));
    *empty = vm_and(*empty, vf_lt(k, next));
    return vf_select(*empty, next, sample_after(k, exit, vf_set1(0.0f)));
}

#endif
