/** @file
 * Emission and absorption along a packet of rays (algorithms: section 2.2): the one loop of all kernels that do this.
 * For kernels only.
 *
 * What a kernel does is a constant of the program: `how` is the same in all calls of one. Samples of a single volume
 * lie in the middle of steps counted from where a ray enters it, or where the ray's phase says; the last, shorter step
 * has its own length. Of several volumes, whose steps may differ, each takes the part of one that lies inside it
 * (blend.h). Blocks where nothing is visible are jumped, so that the samples taken are the same with and without.
 */
#ifndef VVI_RENDER_MARCH_COMPOSITE_H
#define VVI_RENDER_MARCH_COMPOSITE_H
#include "render/march/blend.h"

typedef enum composite_how {
    HOW_TABLE, /* one volume, colours and opacities from its table */
    HOW_LIT,   /* the same, and colours are found later */
    HOW_ONE,   /* one volume, classified in any way */
    HOW_ANY    /* any number of volumes, each in its own way */
} composite_how;

/** One sample of each lane of a single volume, and what its table says of it. */
typedef struct table_sample {
    vf k, place, alpha; /* k steps from entry */
    vi entry;
    vf row[4];
    vm m; /* lanes that have one */
} table_sample;

VV_INLINE void fetch_sample(table_sample *out, const march_part *p, composite_how how, int sampler, vf k, vm m)
{
    const vvi_march_volume *f = p->f;
    const vf value = part_value(f, sampler, packet_point(&p->r, k), m);
    if (sampler == VVI_SAMPLE_F32 || sampler == VVI_SAMPLE_ANY)
        m = vm_and(m, is_number(value));
    out->k = k;
    out->m = m;
    out->place = entry_place(f, value);
    out->entry = vi_trunc(out->place);
    if (how == HOW_TABLE) {
        vf_rows4(out->row, f->classifier.seen, vi_shl(out->entry, 2));
        out->alpha = out->row[3];
    } else {
        out->alpha = vf_gather4(f->classifier.alpha, out->entry, m);
    }
}

/** Where half of the light is gone, of steps that begin at `from`, of which `share` lies in the volume; at: their
 * samples. */
VV_INLINE void find_half(composite_state *s, vf before, vf from, vf share, vf at, vm m)
{
    const vm halved = vm_and(m, vm_and(vf_lt(s->depth, vf_set1(0.0f)), vf_lt(s->transmittance, vf_set1(0.5f))));
    if (vm_any(halved))
        s->depth = vf_select(halved, half_place(from, share, at, before, s->transmittance), s->depth);
}

/** What lanes of m see of it in steps from `from`; share: how much of a full step it stands for (1 for all but the
 * last). */
VV_INLINE void add_sample(composite_state *s, composite_how how, color_fn *color, table_sample *t, vf from,
                          bool partial, vf share, vm m)
{
    march_part *p = s->part;
    const vvi_march_volume *f = p->f;
    const vf zero = vf_set1(0.0f);
    m = vm_and(m, t->m);
    vf alpha = vf_select(m, t->alpha, zero);
    vm seen = vf_lt(zero, alpha);
    s->samples += (uint64_t)vm_count(m);
    if (!vm_any(seen))
        return;
    const vm split = vf_lt(vf_set1(1.0f), alpha);
    if (vm_any(split)) {
        t->entry = split_entry(f, t->place, t->entry, alpha, split);
        if (how == HOW_TABLE)
            vf_rows4(t->row, f->classifier.seen, vi_shl(t->entry, 2));
        alpha = vf_gather4(f->classifier.alpha, t->entry, seen);
        seen = vf_lt(zero, alpha);
        if (!vm_any(seen))
            return;
    }
    if (partial) { /* from the optical depth: the table's alpha is rounded too near 1 to be scaled */
        const vf depth = vf_gather4(f->classifier.color + 3, vi_shl(t->entry, 2), seen) * share;
        alpha = vf_select(seen, vf_set1(1.0f) - vf_exp(zero - depth), zero);
    }
    const vf weight = alpha * s->transmittance;
    if (how == HOW_TABLE) {
        VV_UNROLL
        for (int c = 0; c < 3; c++)
            s->rgb[c] = vf_fma(weight, t->row[c], s->rgb[c]);
    } else {
        if (f->paint.kind == VVI_PAINT_COLORS)
            expect_part_colors(p, t->k, seen);
        queue_push(&p->queue, t->k, t->entry, weight, seen);
        if (p->queue.n >= QUEUE_FULL)
            color(&p->queue, p);
    }
    const vf before = s->transmittance;
    s->transmittance = before - weight;
    find_half(s, before, from, share, t->k, m);
}

/** A sample of a volume that is classified in any way. */
typedef struct one_sample {
    vf value;
} one_sample;

/** Light of what lanes of m see in steps k, of which `share` lies in the volume. */
VV_INLINE void add_sight(composite_state *s, const sight *found, vf k, vf share, vm m)
{
    march_part *p = s->part;
    const vf zero = vf_set1(0.0f), depth = vf_select(m, found->depth, zero);
    const vm seen = vf_lt(zero, depth);
    if (!vm_any(seen))
        return;
    const vf weight = absorbed_share(depth, seen) * s->transmittance;
    part_add(s, p, found, vf_fma(share, p->r.phase, k), weight, seen);
    const vf before = s->transmittance;
    s->transmittance = vf_max(before - weight * depth, zero);
    find_half(s, before, k, share, vf_fma(share, vf_set1(0.5f), k), seen);
}

/** The same of values, at once or where gradients are needed, later. */
VV_INLINE void add_one(composite_state *s, const one_sample *t, vf k, vf share, vm m)
{
    march_part *p = s->part;
    const part_span span = {k, k + share, m};
    sight found;
    s->samples += (uint64_t)vm_count(m);
    p->by->classify(&found, p, &span, k, t->value, m);
    if (!s->steep) {
        add_sight(s, &found, k, share, m);
        return;
    }
    const vm seen = vm_and(m, found.may_be);
    if (!vm_any(seen))
        return;
    steep_push(s->steep, p->f, k, share, &found, seen);
    if (s->steep->n >= QUEUE_FULL)
        p->by->steep(s->steep, s);
}

VV_INLINE bool sees_whole_steps(const vvi_march_volume *f, composite_how how)
{
    return how == HOW_ONE && f->classifier.kind == VVI_CLASSIFY_INTEGRATED;
}

/** Which lanes of `run` are in blocks that show nothing, and when blocks are to be looked at again. */
VV_INLINE vm composite_look(composite_state *s, composite_how how, vf k, vf middle, vm run, vf *next)
{
    if (how == HOW_ANY)
        return blend_look(s, k, run, next);
    const march_part *p = s->part;
    vm empty = vm_none();
    *next = vf_set1(NEVER);
    if (p->f->skipper.reach) {
        const bool nearest = p->f->sampler.nearest;
        const bool whole = sees_whole_steps(p->f, how);
        vf at = k + middle;
        if (whole)
            at = k;
        const block_at b = find_block(p->f, nearest, packet_point(&p->r, at));
        const vi reach = look_at_blocks(p->f, &b, run, &empty);
        const vf exit = block_exit(&p->r, p->f, nearest, &b, reach);
        if (whole)
            *next = step_after(k, exit, &empty);
        else
            *next = sample_after(k, exit, middle);
    }
    return empty;
}

/** A sample of a single volume, or of all. */
typedef union any_sample {
    table_sample of_table;
    one_sample of_one;
    blend_sample of_all;
} any_sample;

VV_INLINE void fetch_any(any_sample *out, composite_state *s, composite_how how, int sampler, vf k, vf middle, vm run)
{
    if (how == HOW_ANY)
        blend_fetch(&out->of_all, s, k, run);
    else if (how == HOW_ONE)
        out->of_one.value = classified_value(s->part, sampler, k + middle, run);
    else
        fetch_sample(&out->of_table, s->part, how, sampler, k + middle, run);
}

VV_INLINE void add_any(composite_state *s, composite_how how, color_fn *color, any_sample *t, vf k, bool partial,
                       vf share, vm run)
{
    if (how == HOW_ANY)
        blend_add(s, &t->of_all, k, run);
    else if (how == HOW_ONE)
        add_one(s, &t->of_one, k, share, run);
    else
        add_sample(s, how, color, &t->of_table, k, partial, share, run);
}

/* Two samples at once, so that one is on its way from memory while the other is worked on: a step is longer than what a
 * processor looks ahead. With few lanes there is less to wait for. */
enum { PAIRS = VV_WIDTH > 4 };

/** Lanes of run, unless many of them have left the blocks that they looked at. */
VV_INLINE vm still_here(vm run, vf k, vf next)
{
    const vm left = vm_and(run, vf_le(next, k));
    return vm_count(left) * 4 <= vm_count(run) ? run : vm_none();
}

/** To the next step; whether there is one before blocks have to be looked at. */
VV_INLINE bool composite_advance(const composite_state *s, vf *k, vm *run, vf limit, vf next)
{
    *k = vf_select(*run, *k + vf_set1(1.0f), *k);
    *run = vm_and(*run, vm_and(vf_lt(*k, limit), vf_lt(vf_set1(s->opaque), s->transmittance)));
    return vm_any(still_here(*run, *k, next));
}

/** Samples k .. limit - 1 of each lane in `run`, each `middle` steps into its own step, which is `share` of one long.
 */
VV_INLINE void composite_march(composite_state *s, composite_how how, int sampler, color_fn *color, vf k, vf limit,
                               vf middle, bool partial, vf share, vm run)
{
    const vf one = vf_set1(1.0f);
    while (vm_any(run)) {
        vf next;
        const vm empty = composite_look(s, how, k, middle, run, &next);
        if (vm_any(empty)) { /* jump, and look again before any lane samples */
            k = vf_select(empty, next, k);
            run = vm_and(run, vf_lt(k, limit));
            continue;
        }
        bool here;
        do { /* every running lane is in a block that may show something, or soon was */
            any_sample now, then;
            fetch_any(&now, s, how, sampler, k, middle, run);
            const vm both = PAIRS ? still_here(vm_and(run, vf_lt(k + one, limit)), k + one, next) : vm_none();
            const bool pair = vm_any(both);
            if (pair)
                fetch_any(&then, s, how, sampler, k + one, middle, both);
            else if (how == HOW_ONE)
                then.of_one = now.of_one;
            else if (how != HOW_ANY)
                then.of_table = (table_sample){0};
            add_any(s, how, color, &now, k, partial, share, run);
            here = composite_advance(s, &k, &run, limit, next);
            if (pair && here) {
                add_any(s, how, color, &then, k, partial, share, run);
                here = composite_advance(s, &k, &run, limit, next);
            }
        } while (here);
    }
}

/** The whole steps of a single volume, and the rest. */
VV_INLINE void composite_one(composite_state *s, composite_how how, int sampler, color_fn *color)
{
    const packet *r = &s->part->r;
    if (!vm_any(packet_promising(r)))
        return;
    /* a rest below a millionth of a step is rounding, not a step */
    const vf whole = vf_floor(r->n + vf_set1(LEAST_PART)), one = vf_set1(1.0f), opaque = vf_set1(s->opaque);
    vf phase = r->phase;
    if (sees_whole_steps(s->part->f, how))
        phase = one; /* the value at the back of each step */
    vf k = r->first, limit = vf_min(whole, r->last), middle = phase, share = one;
    vm run = vm_and(r->hit, vf_lt(k, limit));
    for (int partial = 0; partial < 2; partial++) { /* one loop in the program for both, not two copies */
        composite_march(s, how, sampler, color, k, limit, middle, partial, share, run);
        if (how == HOW_ONE && s->steep && s->steep->n)
            s->part->by->steep(s->steep, s);
        share = r->n - whole;
        k = whole;
        limit = whole + one;
        middle = share * phase;
        run = vm_and(vm_and(r->hit, vf_lt(vf_set1(LEAST_PART), share)), vf_lt(opaque, s->transmittance));
        run = vm_and(run, vf_lt(whole, r->last));
    }
}

VV_INLINE void composite_begin(composite_state *s, march_part *part, size_t n, float opaque)
{
    s->part = part;
    s->n = n;
    s->rgb[0] = s->rgb[1] = s->rgb[2] = vf_set1(0.0f);
    s->transmittance = vf_set1(1.0f);
    s->opaque = opaque;
    s->depth = vf_set1(-1.0f);
    s->most = vi_set1(0);
    s->samples = 0;
    s->steep = NULL;
}

/* A volume alone begins where its rays enter it, in steps of its own. */
VV_INLINE void one_begin(march_part *p)
{
    queue_begin(&p->queue);
    p->scale = vf_set1(1.0f);
    p->first = vf_set1(0.0f);
    p->known_at = vf_set1(-1.0f);
    p->known = vf_set1(0.0f);
}

VV_INLINE void composite_rays(vvi_sink *out, const vvi_march_volume *f, const vvi_rays *rays, vv_render_counts *counts,
                              composite_how how, int sampler, const sampler_row *by)
{
    march_part part;
    color_fn *const color = by ? by->color : NULL;
    steep_queue steep;
    part.f = f;
    if (how == HOW_LIT)
        memset(&part.queue, 0, sizeof part.queue);
    else if (how == HOW_ONE)
        part_open(&part, f, by);
    if (how == HOW_ONE)
        memset(&steep, 0, sizeof steep); /* lanes without a sample are computed as well, so with numbers */
    for (size_t at = 0; at < rays->n; at += VV_WIDTH) {
        composite_state s;
        composite_begin(&s, &part, 1, f->opaque);
        packet_begin(&part.r, f, rays, at);
        if (how == HOW_LIT)
            queue_begin(&part.queue);
        else if (how == HOW_ONE)
            one_begin(&part);
        if (how == HOW_ONE && has_gradient(f))
            s.steep = &steep;
        composite_one(&s, how, sampler, color);
        if (how == HOW_ONE)
            blend_finish(&s);
        if (how == HOW_LIT)
            color(&part.queue, &part);
        counts->samples += s.samples;
        packet_store(out, &part.r, f, at, how == HOW_LIT ? part.queue.rgb : s.rgb, s.transmittance, s.depth);
        store_hits(out, &part.r, f, at, s.depth);
    }
}

/** The same through all volumes of a blend. */
VV_INLINE void composite_blend(vvi_sink *out, const vvi_blend_setup *f, const vvi_rays *rays, vv_render_counts *counts,
                               const sampler_row *samplers)
{
    march_part part[VVI_BLEND_VOLUMES];
    stretches along;
    blend_open(part, f, samplers);
    for (size_t at = 0; at < rays->n; at += VV_WIDTH) {
        composite_state s;
        composite_begin(&s, part, f->n_volumes, f->opaque);
        blend_begin(&along, &s, rays, at);
        vf_store(out->depth + at, vf_set1(INFINITY));
        hits_begin(out, at);
        for (int i = 0; i < along.most; i++) {
            const vm run = blend_enter(&s, &along, i);
            composite_march(&s, HOW_ANY, 0, NULL, vf_set1(0.0f), s.limit, vf_set1(0.0f), false, vf_set1(1.0f), run);
            blend_leave(out, at, &s, &along, i);
        }
        blend_finish(&s);
        counts->samples += s.samples;
        blend_store(out, &s, at);
    }
}

#endif
