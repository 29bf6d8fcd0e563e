/** @file
 * Emission and absorption along a packet of rays (algorithms: section 2.2). For kernels only.
 *
 * Samples lie in the middle of steps counted from where a ray enters the clipped volume, or where the ray's phase says;
 * the last, shorter step has its own length. Blocks where nothing is visible are jumped, so that the samples taken are
 * the same with and without.
 */
#ifndef VVI_RENDER_MARCH_COMPOSITE_H
#define VVI_RENDER_MARCH_COMPOSITE_H
#include "render/march/classify.h"
#include "render/march/entry.h"
#include "render/march/shade_simd.h"

enum { QUEUE_BATCHES = 4, QUEUE_FULL = QUEUE_BATCHES * VV_WIDTH };

/**
 * Samples that can be seen wait here until there are some for every lane, whichever rays they are of: light costs
 * several times what sampling does. Colour adds up ray by ray in the order of the samples, however they are grouped.
 */
typedef struct light_queue {
    float k[QUEUE_FULL + VV_WIDTH], weight[QUEUE_FULL + VV_WIDTH];
    int32_t entry[QUEUE_FULL + VV_WIDTH], lane[QUEUE_FULL + VV_WIDTH];
    uint32_t pushed[QUEUE_FULL + VV_WIDTH]; /* the lanes of each push */
    int n, n_pushes;
    vf rgb[3]; /* what has arrived, by ray */
} light_queue;

/** Gives colour to all that wait. */
typedef void light_fn(light_queue *q, const packet *r, const vvi_march_volume *f);

typedef struct composite_state {
    vf rgb[3], transmittance;
    vf depth; /* step at which half of the light was gone; -1: not yet */
    uint64_t samples;
    light_queue queue; /* shaded only */
} composite_state;

VV_INLINE vf3 permuted(vf3 a, vi lane)
{
    return vf3_set(vf_permute(a.x, lane), vf_permute(a.y, lane), vf_permute(a.z, lane));
}

/** Colour of the samples from `at` on, at most one a lane. */
VV_INLINE void light_batch(float *const part[3], const light_queue *q, const packet *r, const vvi_march_volume *f,
                           int type, bool nearest, int at)
{
    const vvi_lattice *g = &f->sampler.lattice;
    const int n = q->n - at < VV_WIDTH ? q->n - at : VV_WIDTH;
    const vm m = vm_first_n((uint64_t)n);
    const vi lane = vi_load(q->lane + at), row = vi_shl(vi_load(q->entry + at), 2);
    const vf k = vf_load(q->k + at), weight = vf_load(q->weight + at);
    const vf3 start = permuted(r->start, lane), delta = permuted(r->delta, lane);
    const vf3 p = vf3_set(vf_fma(k, delta.x, start.x), vf_fma(k, delta.y, start.y), vf_fma(k, delta.z, start.z));
    vf rgb[3];
    for (int c = 0; c < 3; c++)
        rgb[c] = vf_gather4(f->classifier.color + c, row, m);
    vf3 gradient = p; /* which clouds without shading do not need */
    if (!f->light.unlit) {
        const cell_at cell = find_gradient_cell(g, nearest, p);
        gradient = world_gradient(f, gradient_by(f->sampler.cell_gradient, g, type, &cell, m));
        gradient = cap_gradient(gradient, r, f, k, lane, m);
    }
    shade(f, p, permuted(r->direction, lane), gradient, false, rgb);
    for (int c = 0; c < 3; c++)
        vf_store(part[c] + at, rgb[c] * weight);
}

VV_INLINE void light_all(light_queue *q, const packet *r, const vvi_march_volume *f, int type, bool nearest)
{
    float red[QUEUE_FULL + 2 * VV_WIDTH], green[QUEUE_FULL + 2 * VV_WIDTH], blue[QUEUE_FULL + 2 * VV_WIDTH];
    memset(red, 0, sizeof red); /* lanes without a sample read what lies behind the last */
    memset(green, 0, sizeof green);
    memset(blue, 0, sizeof blue);
    float *const part[3] = {red, green, blue};
    for (int at = 0; at < q->n; at += VV_WIDTH)
        light_batch(part, q, r, f, type, nearest, at);
    int at = 0;
    for (int i = 0; i < q->n_pushes; i++) {
        const vm m = vm_from_bits(q->pushed[i]);
        for (int c = 0; c < 3; c++)
            q->rgb[c] = q->rgb[c] + vf_expand(part[c] + at, m);
        at += vm_count(m);
    }
    q->n = q->n_pushes = 0;
}

VV_INLINE void queue_push(light_queue *q, vf k, vi entry, vf weight, vm m)
{
    vf_compress(q->k + q->n, k, m);
    vf_compress(q->weight + q->n, weight, m);
    vi_compress(q->entry + q->n, entry, m);
    vi_compress(q->lane + q->n, own_lanes(), m);
    q->pushed[q->n_pushes++] = vm_bits(m);
    q->n += vm_count(m);
}

/** One sample of every lane in m, k steps from entry; share: how much of a full step it stands for (1 for all but the
 * last). */
VV_INLINE void composite_sample(composite_state *s, const packet *r, const vvi_march_volume *f, int type, bool nearest,
                                light_fn *light, vf k, bool partial, vf share, vm m)
{
    const vf3 p = packet_point(r, k);
    const vf value = sample_value(&f->sampler.lattice, type, nearest, p, m);
    if (type == VVI_SAMPLE_F32 || type == VVI_SAMPLE_WIDE) {
        m = vm_and(m, is_number(value));
    }
    const vf place = entry_place(f, value);
    vi entry = vi_trunc(place);
    vf alpha = vf_gather4(f->classifier.alpha, entry, m);
    vm seen = vf_lt(vf_set1(0.0f), alpha);
    s->samples += (uint64_t)vm_count(m);
    if (!vm_any(seen))
        return;
    const vm split = vf_lt(vf_set1(1.0f), alpha);
    if (vm_any(split)) {
        entry = split_entry(f, place, entry, alpha, split);
        alpha = vf_gather4(f->classifier.alpha, entry, seen);
        seen = vf_lt(vf_set1(0.0f), alpha);
        if (!vm_any(seen))
            return;
    }
    if (partial) { /* from the optical depth: the table's alpha is rounded too near 1 to be scaled */
        const vf depth = vf_gather4(f->classifier.color + 3, vi_shl(entry, 2), seen) * share;
        alpha = vf_select(seen, vf_set1(1.0f) - vf_exp(vf_set1(0.0f) - depth), vf_set1(0.0f));
    }
    const vf weight = alpha * s->transmittance;
    if (light) {
        queue_push(&s->queue, k, entry, weight, seen);
        if (s->queue.n >= QUEUE_FULL)
            light(&s->queue, r, f);
    } else {
        const vi at = vi_shl(entry, 2);
        for (int c = 0; c < 3; c++)
            s->rgb[c] = vf_fma(weight, vf_gather4(f->classifier.color + c, at, seen), s->rgb[c]);
    }
    s->transmittance = s->transmittance - weight;
    const vm halved = vm_and(vf_lt(s->depth, vf_set1(0.0f)), vf_lt(s->transmittance, vf_set1(0.5f)));
    s->depth = vf_select(vm_and(halved, m), k, s->depth);
}

/** Samples k .. limit - 1 of each lane in `run`, each `middle` steps into its own step, which is `share` of one long.
 */
VV_INLINE void composite_march(composite_state *s, const packet *r, const vvi_march_volume *f, int type, bool nearest,
                               light_fn *light, vf k, vf limit, vf middle, bool partial, vf share, vm run)
{
    const vf one = vf_set1(1.0f), opaque = vf_set1(f->opaque);
    while (vm_any(run)) {
        vf leave = vf_set1(1e30f);
        if (f->skipper.reach) {
            const block_at b = find_block(f, nearest, packet_point(r, k + middle));
            vm empty;
            const vi reach = look_at_blocks(f, &b, run, &empty);
            leave = sample_after(k, block_exit(r, f, nearest, &b, reach), middle);
            if (vm_any(empty)) { /* jump, and look again before any lane samples */
                k = vf_select(empty, leave, k);
                run = vm_and(run, vf_lt(k, limit));
                continue;
            }
        }
        vm left;
        do { /* every running lane is in a block that may show something, or soon was */
            composite_sample(s, r, f, type, nearest, light, k + middle, partial, share, run);
            k = vf_select(run, k + one, k);
            run = vm_and(run, vm_and(vf_lt(k, limit), vf_lt(opaque, s->transmittance)));
            left = vm_and(run, vf_le(leave, k));
        } while (vm_any(run) && vm_count(left) * 4 <= vm_count(run));
    }
}

VV_INLINE void composite_packet(vvi_sink *out, const vvi_march_volume *f, const packet *r, size_t at, int type,
                                bool nearest, light_fn *light, vv_render_counts *counts)
{
    const vf zero = vf_set1(0.0f), one = vf_set1(1.0f);
    composite_state s;
    s.rgb[0] = s.rgb[1] = s.rgb[2] = zero;
    s.transmittance = one;
    s.depth = vf_set1(-1.0f);
    s.samples = 0;
    if (light)
        memset(&s.queue, 0, sizeof s.queue); /* lanes without a sample are computed as well: with numbers */
    if (vm_any(packet_promising(r))) {
        /* a rest below a millionth of a step is rounding, not a step */
        const vf whole = vf_floor(r->n + vf_set1(1e-6f));
        vf k = r->first, limit = vf_min(whole, r->last), middle = r->phase, share = one;
        vm run = vm_and(r->hit, vf_lt(k, limit));
        for (int partial = 0; partial < 2; partial++) { /* one loop in the program for both, not two copies */
            composite_march(&s, r, f, type, nearest, light, k, limit, middle, partial, share, run);
            share = r->n - whole;
            k = whole;
            limit = whole + one;
            middle = share * r->phase;
            run = vm_and(vm_and(r->hit, vf_lt(vf_set1(1e-6f), share)), vf_lt(vf_set1(f->opaque), s.transmittance));
            run = vm_and(run, vf_lt(whole, r->last));
        }
    }
    if (light) {
        light(&s.queue, r, f);
        for (int c = 0; c < 3; c++)
            s.rgb[c] = s.queue.rgb[c];
    }
    counts->samples += s.samples;
    packet_store(out, r, f, at, s.rgb, s.transmittance, s.depth);
}

#endif
