/** @file
 * Colours of samples that can be seen: what they are painted with, textures, light. For kernels only.
 *
 * Samples wait until there are some for every lane, whichever rays they are of: colours cost several times what
 * sampling does. Light adds up ray by ray in the order of the samples, however they are grouped.
 */
#ifndef VVI_RENDER_MARCH_COLOR_H
#define VVI_RENDER_MARCH_COLOR_H
#include "render/march/classify.h"
#include "render/march/cubic_simd.h"
#include "render/march/entry.h"
#include "render/march/labels_simd.h"
#include "render/march/paint_simd.h"
#include "render/march/shade_simd.h"
#include "render/march/texture_simd.h"

enum { QUEUE_BATCHES = 4, QUEUE_FULL = QUEUE_BATCHES * VV_WIDTH, QUEUE_ROOM = QUEUE_FULL + VV_WIDTH };

/** Samples that wait, with what their classification has found already (sight). */
typedef struct color_queue {
    float k[QUEUE_ROOM], weight[QUEUE_ROOM];
    int32_t entry[QUEUE_ROOM], lane[QUEUE_ROOM];
    uint32_t pushed[QUEUE_ROOM]; /* the lanes of each push */
    int n, n_pushes;
    vf rgb[3];                  /* what has arrived, by ray */
    float found[6][QUEUE_ROOM]; /* red, green, blue (labels: the label), gradient */
} color_queue;

struct march_part {
    const vvi_march_volume *f;
    const struct sampler_row *by; /* several volumes: how this one is classified and coloured */
    packet r;                     /* in steps of its own, from where a ray enters it */
    vf scale, inverse;            /* several volumes: of its own steps in a common one, and the other way round */
    vf first, last;               /* common steps; where a ray misses it the same */
    vf look;                      /* step at which its block is looked at again */
    vm busy;                      /* lanes in a block that may show something */
    vf known_at; /* integrated: a place, the value there, and its rows, which the next step begins with */
    vf known;
    row_place known_row;
    color_queue queue;
};

/** Gives colour to all that wait. */
typedef void color_fn(color_queue *q, const march_part *p);

/** What a kernel of the volume's samples knows before colours are looked for. */
VV_INLINE bool has_colors(const vvi_march_volume *f)
{
    return f->classifier.kind == VVI_CLASSIFY_INTEGRATED || f->classifier.kind == VVI_CLASSIFY_PLANE;
}
VV_INLINE bool has_gradient(const vvi_march_volume *f)
{
    return f->classifier.kind == VVI_CLASSIFY_PLANE || f->classifier.modulate_power > 0;
}

VV_INLINE vf3 permuted(vf3 a, vi lane)
{
    return vf3_set(vf_permute(a.x, lane), vf_permute(a.y, lane), vf_permute(a.z, lane));
}

/** How a volume is sampled is a constant of each kernel: VVI_SAMPLE_*, or VVI_RAY_CUBIC. */
VV_INLINE vf part_value(const vvi_march_volume *f, int sampler, vf3 p, vm m)
{
    if (sampler != VVI_RAY_CUBIC)
        return sample_value(&f->sampler.lattice, sampler, f->sampler.nearest, p, m);
    return cubic_value(&f->sampler.lattice, &p, m);
}

/** In the world, as the light wants it. */
VV_INLINE vf3 part_gradient(const vvi_march_volume *f, int sampler, vf3 p, vm m)
{
    vf3 g;
    if (sampler == VVI_RAY_CUBIC) {
        cubic_gradient(&g, &f->sampler.lattice, &p, m);
    } else {
        const cell_at cell = find_gradient_cell(&f->sampler.lattice, f->sampler.nearest, p);
        g = gradient_by(f->sampler.cell_gradient, &f->sampler.lattice, sampler, &cell, m);
    }
    return world_gradient(f, g);
}

VV_INLINE bool has_labels(const vvi_march_volume *f, int sampler)
{
    return f->classifier.kind == VVI_CLASSIFY_LABELS && sampler != VVI_RAY_CUBIC;
}

/** What is classified, k steps of the volume's own from where rays enter it. */
VV_INLINE vf classified_value(const march_part *p, int sampler, vf k, vm m)
{
    const vf3 at = packet_point(&p->r, k);
    return has_labels(p->f, sampler) ? winning_label(&p->f->sampler.lattice, sampler, at, m)
                                     : part_value(p->f, sampler, at, m);
}

VV_INLINE vf3 part_label_gradient(const vvi_march_volume *f, vf3 p, vf label, vm m)
{
    vf3 g;
    label_gradient(&g, &f->sampler.lattice, &p, &label, m);
    return world_gradient(f, vf3_scale(g, vf_set1(f->classifier.label_range)));
}

/** Before samples of lanes m are pushed. */
VV_INLINE void expect_part_colors(const march_part *p, vf k, vm m)
{
    const vf3 at = packet_point(&p->r, k);
    expect_colors(&p->f->paint, &at, m);
}

/** Paint and texture, in place of lanes' colours or on them. Out of line: rare beside light. */
static __attribute__((noinline)) void paint_samples(vf rgb[3], const march_part *p, const vf3 *at, vf k, vi lane, vm m)
{
    take_paint(rgb, &p->f->paint, at, m);
    if (p->f->texture)
        texture_colors(rgb, p->f, at, vf_permute(entry_distance(&p->r), lane), k, m);
}

/** Colour of the samples from `at` on, at most one a lane. */
VV_INLINE void color_batch(float *const part[3], const color_queue *q, const march_part *p, int sampler, int at)
{
    const vvi_march_volume *f = p->f;
    const packet *r = &p->r;
    const int n = q->n - at < VV_WIDTH ? q->n - at : VV_WIDTH;
    const vm m = vm_first_n((uint64_t)n);
    const vi lane = vi_load(q->lane + at);
    const vf k = vf_load(q->k + at), weight = vf_load(q->weight + at);
    const vf3 start = permuted(r->start, lane), delta = permuted(r->delta, lane);
    const vf3 point = vf3_set(vf_fma(k, delta.x, start.x), vf_fma(k, delta.y, start.y), vf_fma(k, delta.z, start.z));
    vf rgb[4];
    if (has_colors(f))
        VV_UNROLL
    for (int c = 0; c < 3; c++)
        rgb[c] = vf_load(q->found[c] + at);
    else vf_rows4(rgb, f->classifier.color, vi_shl(vi_load(q->entry + at), 2));
    if (f->paint.kind != VVI_PAINT_NONE || f->texture)
        paint_samples(rgb, p, &point, k, lane, m);
    if (f->light.shaded) {
        vf3 gradient = point; /* which clouds without shading do not need */
        if (f->light.unlit)
            ;
        else if (has_gradient(f))
            gradient = vf3_set(vf_load(q->found[3] + at), vf_load(q->found[4] + at), vf_load(q->found[5] + at));
        else if (f->classifier.kind == VVI_CLASSIFY_LABELS)
            gradient = part_label_gradient(f, point, vf_load(q->found[0] + at), m);
        else
            gradient = part_gradient(f, sampler, point, m);
        if (!f->light.unlit)
            gradient = cap_gradient(gradient, r, f, k, lane, m);
        shade(f, point, permuted(r->direction, lane), gradient, false, rgb);
    }
    VV_UNROLL
    for (int c = 0; c < 3; c++)
        vf_store(part[c] + at, rgb[c] * weight);
}

VV_INLINE void color_all(color_queue *q, const march_part *p, int sampler)
{
    float red[QUEUE_ROOM + VV_WIDTH], green[QUEUE_ROOM + VV_WIDTH], blue[QUEUE_ROOM + VV_WIDTH];
    float *const part[3] = {red, green, blue};
    for (int at = 0; at < q->n; at += VV_WIDTH)
        color_batch(part, q, p, sampler, at);
    VV_UNROLL
    for (int c = 0; c < 3; c++) /* lanes without a sample read what lies behind the last */
        vf_store(part[c] + q->n, vf_set1(0.0f));
    vf rgb[3] = {q->rgb[0], q->rgb[1], q->rgb[2]}; /* in registers, from push to push */
    int at = 0;
    for (int i = 0; i < q->n_pushes; i++) {
        const vm m = vm_from_bits(q->pushed[i]);
        VV_UNROLL
        for (int c = 0; c < 3; c++)
            rgb[c] = rgb[c] + vf_expand(part[c] + at, m);
        at += vm_count(m);
    }
    VV_UNROLL
    for (int c = 0; c < 3; c++)
        q->rgb[c] = rgb[c];
    q->n = q->n_pushes = 0;
}

/** Memory of packets before is no garbage: what lies behind the last that waits is computed as well, with numbers. */
VV_INLINE void queue_begin(color_queue *q)
{
    q->n = q->n_pushes = 0;
    q->rgb[0] = q->rgb[1] = q->rgb[2] = vf_set1(0.0f);
}

/** What waits of a table. */
VV_INLINE void queue_push(color_queue *q, vf k, vi entry, vf weight, vm m)
{
    vf_compress(q->k + q->n, k, m);
    vf_compress(q->weight + q->n, weight, m);
    vi_compress(q->entry + q->n, entry, m);
    vi_compress(q->lane + q->n, own_lanes(), m);
    q->pushed[q->n_pushes++] = vm_bits(m);
    q->n += vm_count(m);
}

/** Of any classification. */
VV_INLINE void queue_push_sight(color_queue *q, const vvi_march_volume *f, vf k, const sight *s, vf weight, vm m)
{
    const int n = q->n;
    if (has_colors(f)) {
        const vf each = vf_set1(1.0f) / vf_max(s->depth, vf_set1(1e-30f));
        VV_UNROLL
        for (int c = 0; c < 3; c++)
            vf_compress(q->found[c] + n, s->rgb[c] * each, m);
    }
    if (f->classifier.kind == VVI_CLASSIFY_LABELS)
        vf_compress(q->found[0] + n, s->label, m);
    if (has_gradient(f)) {
        vf_compress(q->found[3] + n, s->gradient.x, m);
        vf_compress(q->found[4] + n, s->gradient.y, m);
        vf_compress(q->found[5] + n, s->gradient.z, m);
    }
    queue_push(q, k, s->entry, weight, m);
}

#endif
