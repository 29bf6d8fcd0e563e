/** @file
 * What rays meet where they end: the volume's value and gradient at the place that the depth tells. For kernels only.
 *
 * Out of line and after the loop, for those that ask (vvi_sink.hits): nothing of it costs anything elsewhere.
 */
#ifndef VVI_RENDER_MARCH_HITS_H
#define VVI_RENDER_MARCH_HITS_H
#include "render/march/color.h"

/* Steps within which a place is on the face by which its ray enters. */
#define ON_FACE 1e-4f

/** No lane has met anything yet. */
VV_INLINE void hits_begin(vvi_sink *out, size_t at)
{
    if (out->hits)
        vi_store(out->hits->volume + at, vi_set1(-1));
}

VV_INLINE void store_lanes(float *to, vf v, vm m)
{
    vf_store(to, vf_select(m, v, vf_load(to)));
}

/* Against the gradient, on the viewer's side; 0 where there is none. */
VV_INLINE vf3 facing_normal(const vvi_march_volume *f, vf3 gradient, vf3 direction)
{
    const vf length2 = vf3_dot(gradient, gradient), least = vf_set1(f->light.flat_gradient * f->light.flat_gradient);
    const vm steep = vf_lt(vf_set1(1e36f), length2); /* as in shade() */
    gradient = vf3_select(steep, vf3_scale(gradient, vf_set1(0x1p-64f)), gradient);
    return seen_side(vf3_unit(gradient), vf3_scale(direction, vf_set1(-1.0f)), vf_lt(least, length2));
}

/** Of lanes m, whose hits lie k steps from where they enter the volume, at p. */
static __attribute__((noinline)) void find_hits(vvi_sink *out, const packet *r, const vvi_march_volume *f, size_t at,
                                                const vf *k, const vf3 *p, vm m)
{
    vvi_hits *h = out->hits;
    const bool labels = f->classifier.kind == VVI_CLASSIFY_LABELS && !f->sampler.cubic;
    const int sampler = f->sampler.cubic ? VVI_RAY_CUBIC : VVI_SAMPLE_ANY;
    if (!vm_any(m))
        return;
    const vf value = labels ? winning_label(&f->sampler.lattice, VVI_SAMPLE_ANY, *p, m) : part_value(f, sampler, *p, m);
    const vf3 gradient = labels ? part_label_gradient(f, *p, value, m) : part_gradient(f, sampler, *p, m);
    vf3 normal = facing_normal(f, gradient, r->direction);
    const vm face = vm_and(m, vf_le(*k, vf_set1(ON_FACE)));
    if (vm_any(face)) { /* into the volume, so away from the viewer */
        float n[3][VV_WIDTH];
        uint32_t by_cut;
        find_entries(n, &by_cut, r, f, vm_bits(face));
        const vf3 out_of = vf3_scale(vf3_set(vf_load(n[0]), vf_load(n[1]), vf_load(n[2])), vf_set1(-1.0f));
        normal = vf3_select(face, out_of, normal);
    }
    const vi number = vi_set1(f->number);
    vi_store(h->volume + at, vi_select(m, number, vi_load(h->volume + at)));
    store_lanes(h->value + at, value, m);
    store_lanes(h->gradient[0] + at, gradient.x, m);
    store_lanes(h->gradient[1] + at, gradient.y, m);
    store_lanes(h->gradient[2] + at, gradient.z, m);
    store_lanes(h->normal[0] + at, normal.x, m);
    store_lanes(h->normal[1] + at, normal.y, m);
    store_lanes(h->normal[2] + at, normal.z, m);
}

/** Of a volume alone, whose depths are k steps; negative: nowhere. */
VV_INLINE void store_hits(vvi_sink *out, const packet *r, const vvi_march_volume *f, size_t at, vf k)
{
    if (!out->hits)
        return;
    const vf3 p = packet_point(r, k);
    hits_begin(out, at);
    find_hits(out, r, f, at, &k, &p, vf_le(vf_set1(0.0f), k));
}

#endif
