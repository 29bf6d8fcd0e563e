/** @file
 * One step through several volumes, their extinctions added (algorithms: section 2.2). For kernels only.
 *
 * Common steps are as long as those of the finest volume that a ray is in, and are counted from where that changes
 * (stretch.h). In each step a volume takes the part that lies inside it, which it is sampled in the middle of: so
 * entry, exit and what lies between two volumes are exact. A step in which every volume's block is empty is jumped, and
 * with it all up to the first that may not be.
 */
#ifndef VVI_RENDER_MARCH_BLEND_H
#define VVI_RENDER_MARCH_BLEND_H
#include "render/march/hits.h"
#include "render/march/steep.h"
#include "render/march/stretch.h"

/* Parts of a step below this are rounding. */
#define LEAST_PART 1e-6f
#define NEVER 1e30f

typedef struct composite_state {
    march_part *part; /* n of them */
    size_t n;
    vf rgb[3], transmittance;
    vf depth; /* steps after which half of the light was gone; -1: not yet */
    vi most;  /* several volumes: the number of the part that took most of it there */
    uint64_t samples;
    float opaque;
    vf limit;                  /* several volumes: steps until the stretch is over */
    struct steep_queue *steep; /* one volume whose opacity goes by gradients: NULL: it does not */
} composite_state;

/** The part of a common step inside a volume. */
typedef struct part_span {
    vf from, to;
    vm some; /* lanes where it is more than rounding */
} part_span;

/** The value of lanes of m, k of the volume's own steps from where it begins. */
typedef vf value_fn(const march_part *p, vf k, vm m);

/** What lanes of m see of it over their span. `middle` is where light is taken; the value is that there, or of an
 * integrated volume that at the back of the span. */
typedef void classify_fn(sight *out, march_part *p, const part_span *span, vf middle, vf value, vm m);

/** Finds the gradients of samples that wait for them, and then their light. */
typedef void steep_fn(steep_queue *q, composite_state *s);

/** What is built for each way of sampling. */
typedef struct sampler_row {
    value_fn *value;
    classify_fn *classify;
    color_fn *color;
    steep_fn *steep; /* of one volume */
} sampler_row;

VV_INLINE part_span find_span(const march_part *p, vf k)
{
    part_span b;
    b.from = vf_max(k, p->first);
    b.to = vf_min(k + vf_set1(1.0f), p->last);
    b.some = vf_lt(vf_set1(LEAST_PART), b.to - b.from);
    return b;
}

/** Once for all packets of a batch; lanes without a sample are computed as well, so with numbers. */
VV_INLINE void part_open(march_part *p, const vvi_march_volume *f, const sampler_row *by)
{
    p->f = f;
    p->by = by;
    memset(&p->queue, 0, sizeof p->queue);
    memset(&p->known_row, 0, sizeof p->known_row);
}

/* Of samplers, once for all packets of a batch. */
VV_INLINE void blend_open(march_part *part, const vvi_blend_setup *f, const sampler_row *samplers)
{
    for (size_t i = 0; i < f->n_volumes; i++)
        part_open(&part[i], &f->volume[i], &samplers[vvi_march_sampler(&f->volume[i].sampler)]);
}

/* The volumes that each ray meets, and with that its stretches. Out of line: one ray after the other. */
static __attribute__((noinline)) void blend_divide(stretches *out, const march_part *part, size_t n)
{
    passage p[VV_WIDTH][VVI_BLEND_VOLUMES];
    size_t met[VV_WIDTH] = {0};
    for (size_t i = 0; i < n; i++) {
        const packet *r = &part[i].r;
        const uint32_t bits = vm_bits(r->hit);
        float steps[VV_WIDTH];
        vf_store(steps, r->n);
        for (int l = 0; l < VV_WIDTH; l++)
            if (bits >> l & 1)
                p[l][met[l]++] = (passage){r->t0[l], r->t0[l] + (double)steps[l] * part[i].f->step, part[i].f->step};
    }
    out->most = 0;
    for (int l = 0; l < VV_WIDTH; l++) {
        out->n[l] = find_stretches(out->of[l], p[l], met[l]);
        out->most = out->n[l] > out->most ? out->n[l] : out->most;
    }
}

VV_INLINE void blend_begin(stretches *out, composite_state *s, const vvi_rays *rays, size_t at)
{
    for (size_t i = 0; i < s->n; i++) {
        packet_begin(&s->part[i].r, s->part[i].f, rays, at);
        queue_begin(&s->part[i].queue);
    }
    blend_divide(out, s->part, s->n);
}

/* A volume's entry and exit in the common steps of a stretch. */
VV_INLINE void blend_align(march_part *p, const stretches *along, int number)
{
    float first[VV_WIDTH] = {0}, scale[VV_WIDTH] = {0}, inverse[VV_WIDTH] = {0};
    for (int l = 0; l < VV_WIDTH; l++) {
        const stretch *to = &along->of[l][number];
        if (number >= along->n[l])
            continue;
        first[l] = (float)((p->r.t0[l] - to->from) / to->step);
        scale[l] = (float)(to->step / p->f->step);
        inverse[l] = (float)(p->f->step / to->step);
    }
    p->scale = vf_load(scale);
    p->inverse = vf_load(inverse);
    p->first = vf_select(p->r.hit, vf_load(first), vf_set1(0.0f));
    p->last = vf_select(p->r.hit, p->first + p->r.n * p->inverse, p->first);
    p->look = vf_set1(0.0f);
    p->busy = vm_none();
    p->known_at = vf_set1(-1.0f);
    p->known = vf_set1(0.0f);
}

/** Rays that have that many stretches, and go on. */
VV_INLINE vm blend_enter(composite_state *s, const stretches *along, int number)
{
    float end[VV_WIDTH];
    for (int l = 0; l < VV_WIDTH; l++) {
        const stretch *to = &along->of[l][number];
        end[l] = number < along->n[l] ? (float)((to->to - to->from) / to->step) : 0.0f;
    }
    s->limit = vf_set1(0.0f);
    for (size_t i = 0; i < s->n; i++) {
        march_part *p = &s->part[i];
        blend_align(p, along, number);
        p->last = vf_min(p->last, vf_load(end));
        s->limit = vf_max(s->limit, p->last);
    }
    return vm_and(vf_lt(vf_set1(0.0f), s->limit), vf_lt(vf_set1(s->opaque), s->transmittance));
}

/* Of each volume those lanes of `ended` in which it took most. */
VV_INLINE void blend_hits(vvi_sink *out, const composite_state *s, size_t at, vm ended)
{
    for (size_t i = 0; i < s->n; i++) {
        const march_part *p = &s->part[i];
        const vf k = vf_max(s->depth - p->first, vf_set1(0.0f)) * p->scale;
        const vf3 point = packet_point(&p->r, k);
        find_hits(out, &p->r, p->f, at, &k, &point, vm_and(ended, vi_eq(s->most, vi_set1((int32_t)i))));
    }
}

/** Where half of the light was gone, and what was met there, if that was in this stretch. */
VV_INLINE void blend_leave(vvi_sink *out, size_t at, const composite_state *s, const stretches *along, int number)
{
    float depth[VV_WIDTH], *to = out->depth + at;
    uint32_t ended = 0;
    vf_store(depth, s->depth);
    for (int l = 0; l < VV_WIDTH; l++) {
        const stretch *in = &along->of[l][number];
        if (!(depth[l] >= 0 && isinf(to[l]) && number < along->n[l]))
            continue;
        to[l] = (float)(in->from + (double)depth[l] * in->step);
        ended |= 1u << l;
    }
    if (out->hits && ended)
        blend_hits(out, s, at, vm_from_bits(ended));
}

/** Lanes of run whose look is due at step k learn whether the volume may show something, and when to ask again. */
VV_INLINE void part_look(march_part *p, vf k, vm run)
{
    const vvi_march_volume *f = p->f;
    const vm due = vm_and(run, vf_le(p->look, k));
    if (!vm_any(due))
        return;
    const vf next = k + vf_set1(1.0f);
    const part_span b = find_span(p, k);
    /* PARC: nothing is visible before `near` and after `far` */
    const vf near = vf_floor(p->first + p->r.first * p->inverse), far = p->first + p->r.last * p->inverse;
    const vm inside = vm_and(vm_andnot(vm_and(due, b.some), vf_lt(k, near)), vf_lt(k, far));
    const vm before = vm_or(vf_lt(k, p->first), vf_lt(k, near));
    /* outside: asked again when the ray enters, or never; without blocks: when it leaves */
    vf look = vf_select(before, vf_max(near, next), vf_set1(NEVER));
    vm busy = inside;
    vf leave = vf_max(vf_floor(vf_min(p->last, far)), next);
    if (f->skipper.reach && vm_any(inside)) {
        const bool whole = f->classifier.kind == VVI_CLASSIFY_INTEGRATED;
        const vf middle = vf_select(whole ? inside : vm_none(), vf_set1(0.0f), p->r.phase);
        const vf at = (vf_fma(b.to - b.from, middle, b.from) - p->first) * p->scale;
        const block_at block = find_block(f, f->sampler.nearest, packet_point(&p->r, at));
        vm empty;
        const vi reach = look_at_blocks(f, &block, inside, &empty);
        const vf exit = block_exit(&p->r, f, f->sampler.nearest, &block, reach);
        const vf slack = (p->inverse - vf_set1(1.0f)) * vf_set1(0.01f); /* a hundredth is one of its own steps */
        const vf end = exit * p->inverse + p->first - slack;
        if (whole)
            leave = step_after(k, end, &empty);
        else
            leave = sample_after(k, end, middle);
        busy = vm_andnot(inside, empty);
    }
    look = vf_select(inside, leave, look);
    p->look = vf_select(due, look, p->look);
    p->busy = vm_or(vm_andnot(p->busy, due), busy);
}

/** Lanes of run in which no volume may show something, and the step at which one of them has to look again. */
VV_INLINE vm blend_look(composite_state *s, vf k, vm run, vf *next)
{
    vm busy = vm_none();
    *next = vf_set1(NEVER);
    for (size_t i = 0; i < s->n; i++) {
        part_look(&s->part[i], k, run);
        busy = vm_or(busy, s->part[i].busy);
        *next = vf_min(*next, s->part[i].look);
    }
    return vm_andnot(run, busy);
}

/** (1 - exp(-x)) / x for x >= 0, to rounding also where 1 - exp(-x) would cancel. */
VV_INLINE vf absorbed_share(vf x, vm m)
{
    const vf one = vf_set1(1.0f);
    vf small = vf_set1(1.0f / 5040);
    small = vf_fma(small, x, vf_set1(-1.0f / 720));
    small = vf_fma(small, x, vf_set1(1.0f / 120));
    small = vf_fma(small, x, vf_set1(-1.0f / 24));
    small = vf_fma(small, x, vf_set1(1.0f / 6));
    small = vf_fma(small, x, vf_set1(-0.5f));
    small = vf_fma(small, x, one);
    const vm few = vf_lt(x, vf_set1(0.3f));
    if (!vm_any(vm_andnot(m, few)))
        return small;
    const vf large = (one - vf_exp(vf_set1(0.0f) - x)) / vf_max(x, vf_set1(0.25f));
    return vf_select(few, small, large);
}

/** Where half of all light is gone, in a step of `length` from `from` that leaves `after` of `before` and has its
 * sample at `at`. Fog absorbs evenly in it, so that it does not matter where steps begin; what takes more than three
 * quarters at once is a surface, and where that begins is not known better than from its sample. */
VV_INLINE vf half_place(vf from, vf length, vf at, vf before, vf after)
{
    const vf start = vf_log2(before), end = vf_log2(vf_max(after, vf_set1(1e-30f)));
    const vf share = vf_clamp((vf_set1(1.0f) + start) / (start - end), vf_set1(0.0f), vf_set1(1.0f));
    return vf_select(vf_lt(after, before * vf_set1(0.25f)), at, vf_fma(length, share, from));
}

/** The share of a step's light that comes from a volume: at once where its colours are known, else later. */
VV_INLINE void part_add(composite_state *s, march_part *p, const sight *found, vf at, vf weight, vm m)
{
    const vvi_march_volume *f = p->f;
    if (f->light.shaded || f->paint.kind != VVI_PAINT_NONE || f->texture) {
        if (f->paint.kind == VVI_PAINT_COLORS)
            expect_part_colors(p, at, m);
        queue_push_sight(&p->queue, f, at, found, weight * found->depth, m);
        if (p->queue.n >= QUEUE_FULL)
            p->by->color(&p->queue, p);
        return;
    }
    vf row[4] = {found->rgb[0], found->rgb[1], found->rgb[2]};
    if (!has_colors(f)) {
        vf_rows4(row, f->classifier.color, vi_shl(found->entry, 2));
        weight = weight * found->depth;
    }
    weight = vf_select(m, weight, vf_set1(0.0f));
    VV_UNROLL
    for (int c = 0; c < 3; c++)
        s->rgb[c] = vf_fma(weight, row[c], s->rgb[c]);
}

/** One step through all volumes. */
typedef struct blend_sample {
    vf value[VVI_BLEND_VOLUMES];
    part_span span[VVI_BLEND_VOLUMES]; /* none where nothing was sampled */
} blend_sample;

/* Where light is taken, in steps of the volume's own. */
VV_INLINE vf span_middle(const march_part *p, const part_span *b)
{
    return (vf_lerp(b->from, b->to, p->r.phase) - p->first) * p->scale;
}

/** Samples of the lanes in run, in step k. */
VV_INLINE void blend_fetch(blend_sample *out, composite_state *s, vf k, vm run)
{
    for (size_t i = 0; i < s->n; i++) {
        march_part *p = &s->part[i];
        part_span *b = &out->span[i];
        *b = find_span(p, k);
        /* lanes that are to look again take the sample: they may be in another block by now */
        b->some = vm_and(vm_and(run, b->some), vm_or(p->busy, vf_le(p->look, k)));
        if (!vm_any(b->some))
            continue;
        vf at = span_middle(p, b);
        if (p->f->classifier.kind == VVI_CLASSIFY_INTEGRATED)
            at = (b->to - p->first) * p->scale;
        out->value[i] = p->by->value(p, at, b->some);
    }
}

/* The part with most opacity in a step. */
VV_INLINE vi densest_part(const sight *found, const vm *some, size_t n)
{
    vf most = vf_set1(0.0f);
    vi part = vi_set1(0);
    for (size_t i = 0; i < n; i++) {
        if (!vm_any(some[i]))
            continue;
        const vm more = vm_and(some[i], vf_lt(most, found[i].depth));
        most = vf_select(more, found[i].depth, most);
        part = vi_select(more, vi_set1((int32_t)i), part);
    }
    return part;
}

/** What lanes of run see of them. */
VV_INLINE void blend_add(composite_state *s, const blend_sample *t, vf k, vm run)
{
    const vf zero = vf_set1(0.0f);
    vf sum = zero, from = k + vf_set1(1.0f), to = k;
    vm some[VVI_BLEND_VOLUMES];
    vf middle[VVI_BLEND_VOLUMES];
    sight found[VVI_BLEND_VOLUMES];
    const size_t n = s->n;
    for (size_t i = 0; i < n; i++) {
        march_part *p = &s->part[i];
        const part_span *b = &t->span[i];
        some[i] = vm_and(run, b->some);
        if (!vm_any(some[i]))
            continue;
        middle[i] = span_middle(p, b);
        p->by->classify(&found[i], p, b, middle[i], t->value[i], some[i]);
        s->samples += (uint64_t)vm_count(some[i]);
        sum = sum + vf_select(some[i], found[i].depth, zero);
        from = vf_select(some[i], vf_min(from, b->from), from);
        to = vf_select(some[i], vf_max(to, b->to), to);
        some[i] = vm_and(some[i], vf_lt(zero, found[i].depth));
    }
    const vm seen = vf_lt(zero, sum);
    if (!vm_any(seen))
        return;
    const vf weight = absorbed_share(sum, seen) * s->transmittance;
    for (size_t i = 0; i < n; i++)
        if (vm_any(some[i]))
            part_add(s, &s->part[i], &found[i], middle[i], weight, some[i]);
    const vf before = s->transmittance;
    s->transmittance = vf_max(before - weight * sum, zero);
    const vm halved = vm_and(seen, vm_and(vf_lt(s->depth, zero), vf_lt(s->transmittance, vf_set1(0.5f))));
    if (vm_any(halved)) {
        s->depth = vf_select(halved, half_place(from, to - from, (from + to) * vf_set1(0.5f), before, s->transmittance),
                             s->depth);
        s->most = vi_select(halved, densest_part(found, some, n), s->most);
    }
}

/** The light that came later. */
VV_INLINE void blend_finish(composite_state *s)
{
    for (size_t i = 0; i < s->n; i++) {
        march_part *p = &s->part[i];
        if (p->queue.n)
            p->by->color(&p->queue, p);
        VV_UNROLL
        for (int c = 0; c < 3; c++)
            s->rgb[c] = s->rgb[c] + p->queue.rgb[c];
    }
}

VV_INLINE void blend_store(vvi_sink *out, const composite_state *s, size_t at)
{
    VV_UNROLL
    for (int i = 0; i < 3; i++)
        vf_store(out->rgb[i] + at, s->rgb[i]);
    vf_store(out->through + at, s->transmittance);
}

#endif
