/** @file
 * Emission and absorption along a packet of rays (algorithms: section 2.2). For kernels only.
 *
 * Samples lie in the middle of steps counted from where a ray enters the clipped volume; the last, shorter step has its
 * own length. Blocks where nothing is visible are jumped, so that the samples taken are the same with and without.
 */
#ifndef VVI_RENDER_RAYCAST_COMPOSITE_H
#define VVI_RENDER_RAYCAST_COMPOSITE_H
#include "render/common/shade_simd.h"
#include "render/raycast/packet.h"

typedef struct composite_state {
    vf rgb[3], transmittance;
    vf depth; /* step at which half of the light was gone; -1: not yet */
    uint64_t samples;
} composite_state;

VV_INLINE vi find_entry(const vvi_ray_frame *f, vf value)
{
    const vi e = vi_trunc(vf_fma(value, vf_set1(f->entry_scale), vf_set1(f->entry_shift)));
    return vi_clamp(e, vi_set1(0), vi_set1(f->n_entries - 1));
}

/** One sample of every lane in m, k steps from entry; share: how much of a full step it stands for (1 for all but the
 * last). */
VV_INLINE void composite_sample(composite_state *s, const packet *r, const vvi_ray_frame *f, int type, bool nearest,
                                bool shaded, vf k, bool partial, vf share, vm m)
{
    const vvi_lattice *g = &f->lattice;
    const vf3 p = packet_point(r, k);
    const vf value = sample_value(g, type, nearest, p, m);
    if (type == VVI_SAMPLE_F32) {
        m = vm_and(m, vf_eq(value, value)); /* NaN is clear */
    }
    const vi entry = find_entry(f, value);
    vf alpha = vf_gather4(f->alpha, entry, m);
    const vm seen = vf_lt(vf_set1(0.0f), alpha);
    s->samples += (uint64_t)vm_count(m);
    if (!vm_any(seen))
        return;
    const vi at = vi_shl(entry, 2);
    if (partial) { /* from the optical depth: the table's alpha is rounded too near 1 to be scaled */
        const vf depth = vf_gather4(f->color + 3, at, seen) * share;
        alpha = vf_select(seen, vf_set1(1.0f) - vf_exp(vf_set1(0.0f) - depth), vf_set1(0.0f));
    }
    vf rgb[3];
    for (int c = 0; c < 3; c++)
        rgb[c] = vf_gather4(f->color + c, at, seen);
    if (shaded) {
        const cell_at cell = find_gradient_cell(g, nearest, p);
        shade(f, p, r->direction, world_gradient(f, sample_gradient(g, type, &cell, seen)), false, rgb);
    }
    const vf weight = alpha * s->transmittance;
    for (int c = 0; c < 3; c++)
        s->rgb[c] = vf_fma(weight, vf_select(seen, rgb[c], vf_set1(0.0f)), s->rgb[c]);
    s->transmittance = s->transmittance - weight;
    const vm halved = vm_and(vf_lt(s->depth, vf_set1(0.0f)), vf_lt(s->transmittance, vf_set1(0.5f)));
    s->depth = vf_select(vm_and(halved, m), k, s->depth);
}

/** Samples k .. limit - 1 of each lane in `run`, each `middle` steps into its own step. */
VV_INLINE void composite_march(composite_state *s, const packet *r, const vvi_ray_frame *f, int type, bool nearest,
                               bool shaded, vf k, vf limit, vf middle, bool partial, vm run)
{
    const vf one = vf_set1(1.0f), opaque = vf_set1(f->opaque);
    while (vm_any(run)) {
        vf leave = vf_set1(1e30f);
        if (f->distance) {
            const block_at b = find_block(f, nearest, packet_point(r, k + middle));
            const vi far = vi_gather(f->distance, b.index, run) & vi_set1(255);
            const vf exit = block_exit(r, f, nearest, &b, vi_max(far, vi_set1(1)));
            leave = sample_after(k, exit, 0.5f);
            const vm empty = vm_and(run, vi_lt(vi_set1(0), far));
            if (vm_any(empty)) { /* jump, and look again before any lane samples */
                k = vf_select(empty, leave, k);
                run = vm_and(run, vf_lt(k, limit));
                continue;
            }
        }
        do { /* every running lane is in a block that may show something */
            composite_sample(s, r, f, type, nearest, shaded, k + middle, partial, middle + middle, run);
            k = vf_select(run, k + one, k);
            run = vm_and(run, vm_and(vf_lt(k, limit), vf_lt(opaque, s->transmittance)));
        } while (vm_any(run) && !vm_any(vm_and(run, vf_le(leave, k))));
    }
}

VV_INLINE void composite_packet(const vvi_ray_frame *f, const packet *r, vm live, int type, bool nearest, bool shaded,
                                vv_render_counts *counts)
{
    const vf zero = vf_set1(0.0f), one = vf_set1(1.0f);
    composite_state s = {{zero, zero, zero}, one, vf_set1(-1.0f), 0};
    if (vm_any(packet_promising(r))) {
        /* a rest below a millionth of a step is rounding, not a step */
        const vf whole = vf_floor(r->n + vf_set1(1e-6f));
        vf k = r->first, limit = vf_min(whole, r->last), middle = vf_set1(0.5f);
        vm run = vm_and(r->hit, vf_lt(k, limit));
        for (int partial = 0; partial < 2; partial++) { /* one loop in the program for both, not two copies */
            composite_march(&s, r, f, type, nearest, shaded, k, limit, middle, partial, run);
            const vf rest = r->n - whole;
            k = whole;
            limit = whole + one;
            middle = rest * vf_set1(0.5f);
            run = vm_and(vm_and(r->hit, vf_lt(vf_set1(1e-6f), rest)), vf_lt(vf_set1(f->opaque), s.transmittance));
            run = vm_and(run, vf_lt(whole, r->last));
        }
    }
    counts->samples += s.samples;
    const vf rgba[4] = {s.rgb[0], s.rgb[1], s.rgb[2], one - s.transmittance};
    packet_store(r, f, live, rgba, s.depth);
}

#endif
