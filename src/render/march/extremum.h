/** @file
 * The largest or the smallest value along each ray of a packet. For kernels only. Blocks that cannot change it are
 * jumped.
 *
 * Samples lie at whole steps from where a ray enters, and where it leaves: a ray along an axis with steps of one voxel
 * meets every sample of the grid exactly. The smallest is found as the largest of the negated values.
 */
#ifndef VVI_RENDER_MARCH_EXTREMUM_H
#define VVI_RENDER_MARCH_EXTREMUM_H
#include "render/march/composite.h"

typedef struct extremum_state {
    vf best, depth;
    uint64_t samples;
} extremum_state;

VV_INLINE void extremum_sample(extremum_state *s, const packet *r, const vvi_march_volume *f, int type, bool nearest,
                               vf k, vm m)
{
    const vf value =
        sample_value(&f->sampler.lattice, type, nearest, packet_point(r, k), m) * vf_set1(f->projection.sign);
    const vm more = vm_and(m, vf_lt(s->best, value)); /* false for NaN */
    s->best = vf_select(more, value, s->best);
    s->depth = vf_select(more, k, s->depth);
    s->samples += (uint64_t)vm_count(m);
}

/* Where blocks turn out to be of use, the next ones are taken on trust: a look costs as much as a sample. */
enum { MOST_TRUST = 4 };

VV_INLINE void extremum_march(extremum_state *s, const packet *r, const vvi_march_volume *f, int type, bool nearest)
{
    const vf one = vf_set1(1.0f);
    const vi alone = vi_set1(1);
    vi trust = alone;
    vf k = vf_set1(0.0f);
    vm run = r->hit;
    while (vm_any(run)) {
        vf leave = vf_set1(1e30f);
        if (f->skipper.block_bound) {
            const block_at b = find_block(f, nearest, packet_point(r, k));
            const vf most = vf_gather4(f->skipper.block_bound, b.index, run) * vf_set1(f->projection.sign);
            const vm useless = vm_and(run, vf_le(most, s->best));
            trust = vi_select(useless, alone, trust);
            leave = sample_after(k, block_exit(r, f, nearest, &b, trust), vf_set1(0.0f));
            if (vm_any(useless)) {
                k = vf_select(useless, leave, k);
                run = vm_and(run, vf_le(k, r->n));
                continue;
            }
            trust = vi_min(trust + trust, vi_set1(MOST_TRUST));
        }
        do {
            extremum_sample(s, r, f, type, nearest, k, run);
            k = vf_select(run, k + one, k);
            run = vm_and(run, vf_le(k, r->n));
        } while (vm_any(run) && !vm_any(vm_and(run, vf_le(leave, k))));
    }
    extremum_sample(s, r, f, type, nearest, r->n, r->hit);
}

/** The table's colour for one value of each ray (stored numbers), as dense as the layer is, and where it was found. */
VV_INLINE void store_values(vvi_sink *out, const packet *r, const vvi_march_volume *f, size_t to, vf value, vm found,
                            vf depth)
{
    const vi entry = find_entry(f, value, found), at = vi_shl(entry, 2);
    vf rgb[3], weight = vf_select(found, vf_set1(f->projection.opacity), vf_set1(0.0f));
    if (f->projection.by_value)
        weight = weight * vf_gather4(f->classifier.alpha, entry, found);
    VV_UNROLL
    for (int c = 0; c < 3; c++)
        rgb[c] = vf_gather4(f->classifier.color + c, at, found) * weight;
    packet_store(out, r, f, to, rgb, vf_set1(1.0f) - weight, depth);
    store_hits(out, r, f, to, depth);
}

VV_INLINE void extremum_packet(vvi_sink *out, const vvi_march_volume *f, const packet *r, size_t at, int type,
                               bool nearest, vv_render_counts *counts)
{
    const vf none = vf_set1(-INFINITY);
    extremum_state s = {none, vf_set1(-1.0f), 0};
    if (vm_any(r->hit))
        extremum_march(&s, r, f, type, nearest);
    counts->samples += s.samples;
    store_values(out, r, f, at, s.best * vf_set1(f->projection.sign), vf_lt(none, s.best), s.depth);
}

#endif
