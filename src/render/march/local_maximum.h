/** @file
 * The first local maximum above a threshold along each ray of a packet; where there is none, the largest value
 * (Sato et al. 1998). For kernels only. Samples lie where those of the maximum lie.
 */
#ifndef VVI_RENDER_MARCH_LOCAL_MAXIMUM_H
#define VVI_RENDER_MARCH_LOCAL_MAXIMUM_H
#include "render/march/extremum.h"

/** A ray is over when its best value is above the threshold and the value after it is smaller. */
VV_INLINE vm local_sample(extremum_state *s, const packet *r, const vvi_march_volume *f, int type, bool nearest, vf k,
                          vm m)
{
    const vf value =
        sample_value(&f->sampler.lattice, type, nearest, packet_point(r, k), m) * vf_set1(f->projection.sign);
    const vm more = vm_and(m, vf_lt(s->best, value));
    const vm over = vm_and(m, vm_and(vf_le(vf_set1(f->projection.threshold), s->best), vf_lt(value, s->best)));
    s->best = vf_select(more, value, s->best);
    s->depth = vf_select(more, k, s->depth);
    s->samples += (uint64_t)vm_count(m);
    return over;
}

VV_INLINE void local_march(extremum_state *s, const packet *r, const vvi_march_volume *f, int type, bool nearest)
{
    const vf one = vf_set1(1.0f), threshold = vf_set1(f->projection.threshold);
    vf k = vf_set1(0.0f);
    vm run = r->hit, over = vm_none();
    while (vm_any(run)) {
        vf leave = vf_set1(1e30f);
        if (f->skipper.block_bound) {
            const block_at b = find_block(f, nearest, packet_point(r, k));
            const vf most = vf_gather4(f->skipper.block_bound, b.index, run) * vf_set1(f->projection.sign);
            leave = sample_after(k, block_exit(r, f, nearest, &b, vi_set1(1)), vf_set1(0.0f));
            /* a ray that waits for its value to fall looks at everything */
            const vm useless = vm_and(run, vm_and(vf_le(most, s->best), vf_lt(s->best, threshold)));
            if (vm_any(useless)) {
                k = vf_select(useless, leave, k);
                run = vm_and(run, vf_le(k, r->n));
                continue;
            }
        }
        do {
            over = vm_or(over, local_sample(s, r, f, type, nearest, k, run));
            k = vf_select(run, k + one, k);
            run = vm_andnot(vm_and(run, vf_le(k, r->n)), over);
        } while (vm_any(run) && !vm_any(vm_and(run, vf_le(leave, k))));
    }
    local_sample(s, r, f, type, nearest, r->n, vm_andnot(r->hit, over));
}

VV_INLINE void local_packet(vvi_sink *out, const vvi_march_volume *f, const packet *r, size_t at, int type,
                            bool nearest, vv_render_counts *counts)
{
    const vf none = vf_set1(-INFINITY);
    extremum_state s = {none, vf_set1(-1.0f), 0};
    if (vm_any(r->hit))
        local_march(&s, r, f, type, nearest);
    counts->samples += s.samples;
    store_values(out, r, f, at, s.best * vf_set1(f->projection.sign), vf_lt(none, s.best), s.depth);
}

#endif
