/** @file
 * The largest value along each ray of a packet. For kernels only. Blocks that cannot raise it are jumped.
 *
 * Samples lie at whole steps from where a ray enters, and where it leaves: a ray along an axis with steps of one voxel
 * meets every sample of the grid exactly.
 */
#ifndef VVI_RENDER_RAYCAST_MAXIMUM_H
#define VVI_RENDER_RAYCAST_MAXIMUM_H
#include "render/raycast/composite.h"

typedef struct maximum_state {
    vf best, depth;
    uint64_t samples;
} maximum_state;

VV_INLINE void maximum_sample(maximum_state *s, const packet *r, const vvi_ray_frame *f, int type, bool nearest, vf k,
                              vm m)
{
    const vf value = sample_value(&f->lattice, type, nearest, packet_point(r, k), m);
    const vm more = vm_and(m, vf_lt(s->best, value)); /* false for NaN */
    s->best = vf_select(more, value, s->best);
    s->depth = vf_select(more, k, s->depth);
    s->samples += (uint64_t)vm_count(m);
}

VV_INLINE void maximum_march(maximum_state *s, const packet *r, const vvi_ray_frame *f, int type, bool nearest)
{
    const vf one = vf_set1(1.0f);
    vf k = vf_set1(0.0f);
    vm run = r->hit;
    while (vm_any(run)) {
        vf leave = vf_set1(1e30f);
        if (f->block_hi) {
            const block_at b = find_block(f, nearest, packet_point(r, k));
            const vf most = vf_gather4(f->block_hi, b.index, run);
            leave = sample_after(k, block_exit(r, f, nearest, &b, vi_set1(1)), vf_set1(0.0f));
            const vm useless = vm_and(run, vf_le(most, s->best));
            if (vm_any(useless)) {
                k = vf_select(useless, leave, k);
                run = vm_and(run, vf_le(k, r->n));
                continue;
            }
        }
        do {
            maximum_sample(s, r, f, type, nearest, k, run);
            k = vf_select(run, k + one, k);
            run = vm_and(run, vf_le(k, r->n));
        } while (vm_any(run) && !vm_any(vm_and(run, vf_le(leave, k))));
    }
    maximum_sample(s, r, f, type, nearest, r->n, r->hit);
}

VV_INLINE void maximum_packet(const vvi_ray_frame *f, const packet *r, vm live, int type, bool nearest,
                              vv_render_counts *counts)
{
    const vf none = vf_set1(-INFINITY);
    maximum_state s = {none, vf_set1(-1.0f), 0};
    if (vm_any(r->hit))
        maximum_march(&s, r, f, type, nearest);
    counts->samples += s.samples;
    const vm found = vf_lt(none, s.best);
    const vi at = vi_shl(find_entry(f, s.best), 2);
    vf rgba[4];
    for (int c = 0; c < 3; c++)
        rgba[c] = vf_gather4(f->color + c, at, found);
    rgba[3] = vf_select(found, vf_set1(1.0f), vf_set1(0.0f));
    packet_store(r, f, live, rgba, s.depth);
}

#endif
