/** @file
 * The mean of the values along each ray of a packet, and their sum over its length, as in an X-ray. For kernels only.
 *
 * Samples lie in the middle of steps, the last and shorter one included, so that both are integrals by the midpoint
 * rule. Samples that are no finite number count as nothing, and their steps as no length. Where blocks have one value,
 * or none, all steps through them are taken at once: which is the same to rounding.
 */
#ifndef VVI_RENDER_MARCH_AVERAGE_H
#define VVI_RENDER_MARCH_AVERAGE_H
#include "render/march/extremum.h"

typedef struct average_state {
    vf sum, length; /* of value times steps, of steps */
    vf lost;        /* what rounding took from the sum (Kahan 1965): rays may have a million steps */
    uint64_t samples;
} average_state;

/** One value over `share` steps. */
VV_INLINE void average_add(average_state *s, const vvi_march_volume *f, vf value, vf share, vm m)
{
    const vf zero = vf_set1(0.0f);
    m = vm_and(m, vf_eq(value - value, zero)); /* neither NaN nor infinite */
    value = vf_select(m, (value - vf_set1(f->projection.stored_zero)) * share, zero);
    const vf add = value - s->lost, sum = s->sum + add;
    s->lost = (sum - s->sum) - add;
    s->sum = sum;
    s->length = s->length + vf_select(m, share, zero);
}

VV_INLINE void average_sample(average_state *s, const packet *r, const vvi_march_volume *f, int type, bool nearest,
                              vf k, vf share, vm m)
{
    s->samples += (uint64_t)vm_count(m);
    average_add(s, f, sample_value(&f->sampler.lattice, type, nearest, packet_point(r, k), m), share, m);
}

/** The whole steps. */
VV_INLINE void average_march(average_state *s, const packet *r, const vvi_march_volume *f, int type, bool nearest,
                             vf whole)
{
    const vf one = vf_set1(1.0f);
    vf k = vf_set1(0.0f);
    vm run = vm_and(r->hit, vf_lt(k, whole));
    while (vm_any(run)) {
        vf leave = whole;
        if (f->skipper.reach) {
            vm even;
            const block_at b = find_block(f, nearest, packet_point(r, k + r->phase));
            const vi reach = look_at_blocks(f, &b, run, &even);
            leave = vf_min(sample_after(k, block_exit(r, f, nearest, &b, reach), r->phase), whole);
            if (vm_any(even)) {
                average_add(s, f, vf_gather4(f->skipper.block_bound, b.index, even), leave - k, even);
                k = vf_select(even, leave, k);
                run = vm_and(run, vf_lt(k, whole));
                continue;
            }
        }
        do {
            average_sample(s, r, f, type, nearest, k + r->phase, one, run);
            k = vf_select(run, k + one, k);
            run = vm_and(run, vf_lt(k, whole));
        } while (vm_any(run) && !vm_any(vm_and(run, vf_le(leave, k))));
    }
}

VV_INLINE void average_packet(vvi_sink *out, const vvi_march_volume *f, const packet *r, size_t at, int type,
                              bool nearest, vv_render_counts *counts)
{
    const vf zero = vf_set1(0.0f), one = vf_set1(1.0f);
    average_state s = {zero, zero, zero, 0};
    const vf whole = vf_floor(r->n + vf_set1(1e-6f)), rest = r->n - whole;
    average_march(&s, r, f, type, nearest, whole);
    const vm more = vm_and(r->hit, vf_lt(vf_set1(1e-6f), rest));
    if (vm_any(more))
        average_sample(&s, r, f, type, nearest, vf_fma(rest, r->phase, whole), rest, more);
    counts->samples += s.samples;
    const vm found = vf_lt(zero, s.length);
    const vf length = f->projection.over_longest ? vf_set1(f->projection.longest) : vf_select(found, s.length, one);
    store_values(out, r, f, at, s.sum / length + vf_set1(f->projection.stored_zero), found, vf_set1(-1.0f));
}

#endif
