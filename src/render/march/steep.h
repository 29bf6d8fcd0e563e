/** @file
 * Samples whose opacity goes by their gradient: they wait until there are some for every lane, whichever rays they are
 * of, as gradients cost several times what values do. For kernels only.
 */
#ifndef VVI_RENDER_MARCH_STEEP_H
#define VVI_RENDER_MARCH_STEEP_H
#include "render/march/color.h"

enum { STEEP_ROOM = QUEUE_ROOM + VV_WIDTH }; /* what is taken out is read a vector at a time */

typedef struct steep_queue {
    float from[STEEP_ROOM], share[STEEP_ROOM]; /* the step that each is of */
    float value[STEEP_ROOM], depth[STEEP_ROOM], rgb[3][STEEP_ROOM], gradient[3][STEEP_ROOM];
    int32_t entry[STEEP_ROOM], lane[STEEP_ROOM];
    uint32_t pushed[STEEP_ROOM]; /* the lanes of each push */
    int n, n_pushes;
} steep_queue;

/** What is known of it by value. */
VV_INLINE void steep_push(steep_queue *q, const vvi_march_volume *f, vf from, vf share, const sight *s, vm m)
{
    const int n = q->n;
    vf_compress(q->from + n, from, m);
    vf_compress(q->share + n, share, m);
    vf_compress(q->value + n, s->label, m);
    vi_compress(q->lane + n, own_lanes(), m);
    if (f->classifier.kind != VVI_CLASSIFY_PLANE) {
        vf_compress(q->depth + n, s->depth, m);
        vi_compress(q->entry + n, s->entry, m);
    }
    if (f->classifier.kind == VVI_CLASSIFY_INTEGRATED)
        for (int c = 0; c < 3; c++)
            vf_compress(q->rgb[c] + n, s->rgb[c], m);
    q->pushed[q->n_pushes++] = vm_bits(m);
    q->n = n + vm_count(m);
}

/** What is known of those of one push, from `at` on, by gradient too. */
VV_INLINE void steep_take(sight *out, const steep_queue *q, const vvi_march_volume *f, int at, vm m)
{
    out->depth = vf_expand(q->depth + at, m);
    out->entry = vi_bits(vf_expand((const float *)(const void *)(q->entry + at), m));
    out->label = vf_expand(q->value + at, m);
    for (int c = 0; c < 3; c++)
        out->rgb[c] = has_colors(f) ? vf_expand(q->rgb[c] + at, m) : vf_set1(0.0f);
    out->gradient = vf3_set(vf_set1(0.0f), vf_set1(0.0f), vf_set1(0.0f));
    if (f->light.shaded)
        out->gradient = vf3_set(vf_expand(q->gradient[0] + at, m), vf_expand(q->gradient[1] + at, m),
                                vf_expand(q->gradient[2] + at, m));
}

#endif
