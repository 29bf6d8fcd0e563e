/** @file
 * The mean of the values along each ray of a packet, and their sum over its length, as in an X-ray. For kernels only.
 *
 * Samples lie in the middle of steps, the last and shorter one included, so that both are integrals by the midpoint
 * rule. Samples that are no finite number count as nothing, and their steps as no length.
 */
#ifndef VVI_RENDER_MARCH_AVERAGE_H
#define VVI_RENDER_MARCH_AVERAGE_H
#include "render/march/extremum.h"

typedef struct average_state {
    vf sum, length; /* of value times steps, of steps */
    vf lost;        /* what rounding took from the sum (Kahan 1965): rays may have a million steps */
    uint64_t samples;
} average_state;

VV_INLINE void average_sample(average_state *s, const packet *r, const vvi_march_volume *f, int type, bool nearest,
                              vf k, vf share, vm m)
{
    const vf zero = vf_set1(0.0f);
    vf value = sample_value(&f->sampler.lattice, type, nearest, packet_point(r, k), m);
    s->samples += (uint64_t)vm_count(m);
    m = vm_and(m, vf_eq(value - value, zero)); /* neither NaN nor infinite */
    value = vf_select(m, (value - vf_set1(f->projection.stored_zero)) * share, zero);
    const vf add = value - s->lost, sum = s->sum + add;
    s->lost = (sum - s->sum) - add;
    s->sum = sum;
    s->length = s->length + vf_select(m, share, zero);
}

VV_INLINE void average_packet(vvi_sink *out, const vvi_march_volume *f, const packet *r, size_t at, int type,
                              bool nearest, vv_render_counts *counts)
{
    const vf zero = vf_set1(0.0f), one = vf_set1(1.0f);
    average_state s = {zero, zero, zero, 0};
    const vf whole = vf_floor(r->n + vf_set1(1e-6f)), rest = r->n - whole;
    vf k = zero;
    for (vm run = vm_and(r->hit, vf_lt(k, whole)); vm_any(run); run = vm_and(run, vf_lt(k, whole))) {
        average_sample(&s, r, f, type, nearest, k + r->phase, one, run);
        k = k + one;
    }
    const vm more = vm_and(r->hit, vf_lt(vf_set1(1e-6f), rest));
    if (vm_any(more))
        average_sample(&s, r, f, type, nearest, vf_fma(rest, r->phase, whole), rest, more);
    counts->samples += s.samples;
    const vm found = vf_lt(zero, s.length);
    const vf length = f->projection.over_longest ? vf_set1(f->projection.longest) : vf_select(found, s.length, one);
    store_values(out, r, f, at, s.sum / length + vf_set1(f->projection.stored_zero), found, vf_set1(-1.0f));
}

#endif
