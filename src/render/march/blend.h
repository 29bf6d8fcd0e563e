/** @file
 * Several volumes along one ray a lane, their extinctions added (algorithms: section 2.2). For kernels only.
 *
 * Steps are counted from where a ray enters the first of its volumes. In each step a volume takes the part that lies
 * inside it, which it is sampled in the middle of: so entry, exit and what lies between two volumes are exact. A step
 * in which every volume's block is empty is jumped, and with it all up to the first that may not be.
 */
#ifndef VVI_RENDER_MARCH_BLEND_H
#define VVI_RENDER_MARCH_BLEND_H
#include "render/march/blend_sample.h"

/* Parts of a step below this are rounding. */
#define LEAST_PART 1e-6f
#define NEVER 1e30f

typedef struct blend_state {
    blend_part part[VVI_BLEND_VOLUMES];
    size_t n;
    double t0[VV_WIDTH]; /* world distance of step 0 */
    vm hit;
    vf limit; /* steps until the last volume is left */
    vf rgb[3], transmittance;
    vf depth; /* step at which half of the light was gone; -1: not yet */
    uint64_t samples;
} blend_state;

/* Puts every volume's entry and exit in steps of the common lattice. */
VV_INLINE void blend_align(blend_state *s, const vvi_blend_setup *f)
{
    for (int l = 0; l < VV_WIDTH; l++)
        s->t0[l] = INFINITY;
    for (size_t i = 0; i < s->n; i++) {
        const uint32_t bits = vm_bits(s->part[i].r.hit);
        for (int l = 0; l < VV_WIDTH; l++)
            if (bits >> l & 1 && s->part[i].r.t0[l] < s->t0[l])
                s->t0[l] = s->part[i].r.t0[l];
    }
    s->limit = vf_set1(0.0f);
    s->hit = vm_none();
    for (size_t i = 0; i < s->n; i++) {
        blend_part *part = &s->part[i];
        float first[VV_WIDTH];
        const uint32_t bits = vm_bits(part->r.hit);
        for (int l = 0; l < VV_WIDTH; l++)
            first[l] = bits >> l & 1 ? (float)((part->r.t0[l] - s->t0[l]) / f->step) : 0.0f;
        part->first = vf_load(first);
        part->last = vf_select(part->r.hit, part->first + part->r.n, part->first);
        part->look = vf_set1(0.0f);
        part->busy = vm_none();
        part->known_at = vf_set1(-1.0f);
        part->known = vf_set1(0.0f);
        s->limit = vf_max(s->limit, part->last);
        s->hit = vm_or(s->hit, part->r.hit);
    }
}

VV_INLINE void blend_begin(blend_state *s, const vvi_blend_setup *f, const vvi_rays *rays, size_t at)
{
    s->n = f->n_volumes;
    for (size_t i = 0; i < s->n; i++) {
        s->part[i].volume = &f->volume[i];
        packet_begin(&s->part[i].r, &f->volume[i].ray, rays, at);
    }
    blend_align(s, f);
    s->rgb[0] = s->rgb[1] = s->rgb[2] = vf_set1(0.0f);
    s->transmittance = vf_set1(1.0f);
    s->depth = vf_set1(-1.0f);
    s->samples = 0;
}

VV_INLINE blend_span find_span(const blend_part *p, vf k)
{
    blend_span b;
    b.from = vf_max(k, p->first);
    b.to = vf_min(k + vf_set1(1.0f), p->last);
    b.some = vf_lt(vf_set1(LEAST_PART), b.to - b.from);
    return b;
}

/** Lanes of run whose look is due at step k learn whether the volume may show something, and when to ask again. */
VV_INLINE void blend_look(blend_part *p, vf k, vm run)
{
    const vvi_march_volume *f = &p->volume->ray;
    const vm due = vm_and(run, vf_le(p->look, k));
    if (!vm_any(due))
        return;
    const vf next = k + vf_set1(1.0f);
    const blend_span b = find_span(p, k);
    /* PARC: nothing is visible before `near` and after `far` */
    const vf near = vf_floor(p->first + p->r.first), far = p->first + p->r.last;
    const vm inside = vm_and(vm_andnot(vm_and(due, b.some), vf_lt(k, near)), vf_lt(k, far));
    const vm before = vm_or(vf_lt(k, p->first), vf_lt(k, near));
    /* outside: asked again when the ray enters, or never; without blocks: when it leaves */
    vf look = vf_select(before, vf_max(near, next), vf_set1(NEVER));
    vm busy = inside;
    vf leave = vf_max(vf_floor(vf_min(p->last, far)), next);
    if (f->skipper.reach && vm_any(inside)) {
        /* blocks of an integrated volume speak for all within a step of them, so its front decides */
        const vf middle = p->volume->classify == VVI_CLASSIFY_INTEGRATED ? vf_set1(0.0f) : p->r.phase;
        const vf at = vf_fma(b.to - b.from, middle, b.from) - p->first;
        const block_at block = find_block(f, p->volume->nearest, packet_point(&p->r, at));
        vm empty;
        const vi reach = look_at_blocks(f, &block, inside, &empty);
        const vf exit = block_exit(&p->r, f, p->volume->nearest, &block, reach);
        leave = sample_after(k, exit + p->first, middle);
        busy = vm_andnot(inside, empty);
    }
    look = vf_select(inside, leave, look);
    p->look = vf_select(due, look, p->look);
    p->busy = vm_or(vm_andnot(p->busy, due), busy);
}

/** Sums over the volumes of one step. */
typedef struct step_sum {
    vf depth, rgb[3]; /* optical depth; optical depth times colour */
    vf from, to;
} step_sum;

VV_INLINE void blend_add(step_sum *sum, blend_state *s, blend_part *p, vf k, vm run)
{
    const blend_span b = find_span(p, k);
    const vm m = vm_and(vm_and(run, p->busy), b.some);
    if (!vm_any(m))
        return;
    blend_sample here;
    sample_volume(&here, p, &b, m);
    s->samples += (uint64_t)vm_count(m);
    sum->depth = sum->depth + here.depth;
    for (int c = 0; c < 3; c++)
        sum->rgb[c] = sum->rgb[c] + vf_select(m, here.depth * here.rgb[c], vf_set1(0.0f));
    sum->from = vf_select(m, vf_min(sum->from, b.from), sum->from);
    sum->to = vf_select(m, vf_max(sum->to, b.to), sum->to);
}

/** (1 - exp(-x)) / x for x >= 0, to rounding also where 1 - exp(-x) would cancel. */
VV_INLINE vf absorbed_share(vf x)
{
    const vf one = vf_set1(1.0f);
    vf small = vf_set1(1.0f / 5040);
    small = vf_fma(small, x, vf_set1(-1.0f / 720));
    small = vf_fma(small, x, vf_set1(1.0f / 120));
    small = vf_fma(small, x, vf_set1(-1.0f / 24));
    small = vf_fma(small, x, vf_set1(1.0f / 6));
    small = vf_fma(small, x, vf_set1(-0.5f));
    small = vf_fma(small, x, one);
    const vf large = (one - vf_exp(vf_set1(0.0f) - x)) / vf_max(x, vf_set1(0.25f));
    return vf_select(vf_lt(x, vf_set1(0.3f)), small, large);
}

VV_INLINE void blend_step(blend_state *s, vf k, vm run)
{
    const vf zero = vf_set1(0.0f);
    step_sum sum = {zero, {zero, zero, zero}, k + vf_set1(1.0f), k};
    for (size_t i = 0; i < s->n; i++)
        blend_add(&sum, s, &s->part[i], k, run);
    const vm seen = vf_lt(zero, sum.depth);
    if (!vm_any(seen))
        return;
    const vf weight = absorbed_share(sum.depth) * s->transmittance;
    for (int c = 0; c < 3; c++)
        s->rgb[c] = vf_fma(weight, sum.rgb[c], s->rgb[c]);
    s->transmittance = vf_max(s->transmittance - weight * sum.depth, zero);
    const vm halved = vm_and(vf_lt(s->depth, zero), vf_lt(s->transmittance, vf_set1(0.5f)));
    s->depth = vf_select(vm_and(halved, seen), (sum.from + sum.to) * vf_set1(0.5f), s->depth);
}

VV_INLINE void blend_march(blend_state *s, const vvi_blend_setup *f)
{
    const vf one = vf_set1(1.0f), opaque = vf_set1(f->opaque);
    vf k = vf_set1(0.0f);
    vm run = vm_and(s->hit, vf_lt(k, s->limit));
    while (vm_any(run)) {
        vf next = vf_set1(NEVER);
        vm busy = vm_none();
        for (size_t i = 0; i < s->n; i++) {
            blend_look(&s->part[i], k, run);
            busy = vm_or(busy, s->part[i].busy);
            next = vf_min(next, s->part[i].look);
        }
        const vm idle = vm_andnot(run, busy);
        if (vm_any(idle)) { /* jump, and look again before any lane samples */
            k = vf_select(idle, next, k);
            run = vm_and(run, vf_lt(k, s->limit));
            continue;
        }
        blend_step(s, k, run);
        k = vf_select(run, k + one, k);
        run = vm_and(run, vm_and(vf_lt(k, s->limit), vf_lt(opaque, s->transmittance)));
    }
}

VV_INLINE void blend_store(vvi_sink *out, const blend_state *s, const vvi_blend_setup *f, size_t at)
{
    float depth[VV_WIDTH];
    for (int i = 0; i < 3; i++)
        vf_store(out->rgb[i] + at, s->rgb[i]);
    vf_store(out->through + at, s->transmittance);
    vf_store(depth, s->depth);
    for (int l = 0; l < VV_WIDTH; l++)
        out->depth[at + (size_t)l] = depth[l] < 0 ? INFINITY : (float)(s->t0[l] + (double)depth[l] * f->step);
}

VV_INLINE void blend_packet(vvi_sink *out, const vvi_blend_setup *f, const vvi_rays *rays, size_t at,
                            vv_render_counts *counts)
{
    blend_state s;
    blend_begin(&s, f, rays, at);
    blend_march(&s, f);
    counts->samples += s.samples;
    blend_store(out, &s, f, at);
}

#endif
