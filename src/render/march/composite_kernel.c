/* The kernels of light through clouds, for one instruction set: instances of the loop of composite.h. Their table is
 * that of kernels.c. */
#include "render/march/composite.h"

/* The value at the front of a step is the one at the back of the step before, or where there was none, a sample. Out of
 * line: where rays come to something. */
static __attribute__((noinline)) void find_front(march_part *p, const vf *from, vm fresh)
{
    const vvi_march_volume *f = p->f;
    const vf3 at = packet_point(&p->r, (*from - p->first) * p->scale);
    const vf value = f->sampler.cubic ? cubic_value(&f->sampler.lattice, &at, fresh)
                                      : any_value(&f->sampler.lattice, false, &at, fresh);
    row_place row;
    find_row(&row, &f->classifier, value);
    p->known = vf_select(fresh, value, p->known);
    select_row(&p->known_row, fresh, &row);
}

/* Means from there to the value at the back, which the next step begins with. */
VV_INLINE vm integrate(sight *out, march_part *p, const part_span *span, vf value, vm m)
{
    const vvi_march_volume *f = p->f;
    const vm fresh = vm_andnot(m, vf_eq(p->known_at, span->from));
    if (vm_any(fresh))
        find_front(p, &span->from, fresh);
    const vm real = vm_and(m, vm_and(is_number(value), is_number(p->known)));
    row_place back;
    find_row(&back, &f->classifier, value);
    mean_between(out, f, &p->known_row, &back, (p->known + value) * vf_set1(0.5f), (span->to - span->from) * p->scale,
                 real);
    p->known = vf_select(m, value, p->known);
    p->known_at = vf_select(m, span->to, p->known_at);
    select_row(&p->known_row, m, &back);
    return real;
}

/* What is left of it where opacity goes by the gradient. */
VV_INLINE void fade(sight *s, vf left)
{
    s->depth = s->depth * left;
    for (int c = 0; c < 3; c++)
        s->rgb[c] = s->rgb[c] * left;
}

/* What a value is seen as before its gradient is asked for, and which lanes of m it may be seen in. Kinds differ too
 * little to be kernels of their own: all lanes are of one. */
VV_INLINE vm classify_value(sight *out, march_part *p, const part_span *span, vf value, vm m)
{
    const vvi_march_volume *f = p->f;
    const vf share = (span->to - span->from) * p->scale, zero = vf_set1(0.0f); /* of one of its own steps */
    vm real = vm_and(m, is_number(value));
    out->entry = vi_set1(0);
    out->depth = out->rgb[0] = out->rgb[1] = out->rgb[2] = zero;
    out->label = value;
    if (f->classifier.kind == VVI_CLASSIFY_PLANE)
        return out->may_be = vm_and(real, may_be_in_plane(f, value, real));
    if (f->classifier.kind == VVI_CLASSIFY_INTEGRATED)
        real = integrate(out, p, span, value, m);
    else
        look_up(out, f, value, share, real);
    out->depth = vf_select(real, out->depth, zero);
    return out->may_be = vm_and(real, vf_lt(zero, out->depth));
}

/* What its gradient, at p, makes of that, where it has a say. */
VV_INLINE void classify_gradient(sight *s, const vvi_march_volume *f, int sampler, vf3 p, vf value, vf share, vm m)
{
    s->gradient = has_labels(f, sampler) ? part_label_gradient(f, p, value, m) : part_gradient(f, sampler, p, m);
    if (f->classifier.kind == VVI_CLASSIFY_PLANE)
        in_plane(s, f, value, share);
    if (f->classifier.modulate_power > 0)
        fade(s, modulation(f, s->gradient));
    s->depth = vf_select(m, s->depth, vf_set1(0.0f));
}

/* Of samples that wait, at most one a lane from `at` on. */
VV_INLINE void steep_batch(steep_queue *q, const march_part *p, int sampler, int at)
{
    const vvi_march_volume *f = p->f;
    const packet *r = &p->r;
    const vm m = vm_first_n((uint64_t)(q->n - at));
    const vi lane = vi_load(q->lane + at);
    const vf share = vf_load(q->share + at);
    const vf k = vf_fma(share, vf_permute(r->phase, lane), vf_load(q->from + at));
    const vf3 point = vf3_set(vf_fma(k, vf_permute(r->delta.x, lane), vf_permute(r->start.x, lane)),
                              vf_fma(k, vf_permute(r->delta.y, lane), vf_permute(r->start.y, lane)),
                              vf_fma(k, vf_permute(r->delta.z, lane), vf_permute(r->start.z, lane)));
    sight s = {.depth = vf_load(q->depth + at)};
    for (int c = 0; c < 3; c++)
        s.rgb[c] = vf_load(q->rgb[c] + at);
    classify_gradient(&s, f, sampler, point, vf_load(q->value + at), share, m);
    vf_store(q->depth + at, s.depth);
    for (int c = 0; c < 3; c++)
        vf_store(q->rgb[c] + at, s.rgb[c]);
    vf_store(q->gradient[0] + at, s.gradient.x);
    vf_store(q->gradient[1] + at, s.gradient.y);
    vf_store(q->gradient[2] + at, s.gradient.z);
}

/* Then their light, ray by ray in the order of samples; rays that end before do without the rest. */
VV_INLINE void steep_all(steep_queue *q, composite_state *s, int sampler)
{
    for (int at = 0; at < q->n; at += VV_WIDTH)
        steep_batch(q, s->part, sampler, at);
    int at = 0;
    for (int i = 0; i < q->n_pushes; i++) {
        const vm pushed = vm_from_bits(q->pushed[i]);
        sight found;
        steep_take(&found, q, s->part->f, at, pushed);
        add_sight(s, &found, vf_expand(q->from + at, pushed), vf_expand(q->share + at, pushed),
                  vm_and(pushed, vf_lt(vf_set1(s->opaque), s->transmittance)));
        at += vm_count(pushed);
    }
    q->n = q->n_pushes = 0;
}

/* All at once, of one volume among several. */
VV_INLINE void classify(sight *out, march_part *p, const part_span *span, vf middle, vf value, vm m, int sampler)
{
    const vm seen = classify_value(out, p, span, value, m);
    if (has_gradient(p->f) && vm_any(seen))
        classify_gradient(out, p->f, sampler, packet_point(&p->r, middle), value, (span->to - span->from) * p->scale,
                          seen);
}

static __attribute__((noinline)) void first(sight *out, march_part *p, const part_span *span, vf middle, vf value, vm m)
{
    (void)middle;
    classify_value(out, p, span, value, m);
}

/* Out of line, as all kinds of kernels call them, and the loops keep their registers. */
#define SAMPLER(t, sampler)                                                                                            \
    static __attribute__((noinline)) vf value_##t(const march_part *p, vf k, vm m)                                     \
    {                                                                                                                  \
        return classified_value(p, sampler, k, m);                                                                     \
    }                                                                                                                  \
    static __attribute__((noinline)) void classify_##t(sight *out, march_part *p, const part_span *span, vf middle,    \
                                                       vf value, vm m)                                                 \
    {                                                                                                                  \
        classify(out, p, span, middle, value, m, sampler);                                                             \
    }                                                                                                                  \
    static __attribute__((noinline)) void color_##t(color_queue *q, const march_part *p)                               \
    {                                                                                                                  \
        color_all(q, p, sampler);                                                                                      \
    }                                                                                                                  \
    static __attribute__((noinline)) void steep_##t(steep_queue *q, composite_state *s)                                \
    {                                                                                                                  \
        steep_all(q, s, sampler);                                                                                      \
    }                                                                                                                  \
    extern vvi_ray_kernel VV_KERNEL_TABLE(vvi_composite_classified_##t);                                               \
    void VV_KERNEL_TABLE(vvi_composite_classified_##t)(vvi_sink * out, const vvi_march_volume *f,                      \
                                                       const vvi_rays *rays, vv_render_counts *counts)                 \
    {                                                                                                                  \
        composite_rays(out, f, rays, counts, HOW_ONE, sampler, &(sampler_row){NULL, first, color_##t, steep_##t});     \
    }

#define KERNELS(t, sampler)                                                                                            \
    SAMPLER(t, sampler)                                                                                                \
    extern vvi_ray_kernel VV_KERNEL_TABLE(vvi_composite_##t), VV_KERNEL_TABLE(vvi_composite_lit_##t);                  \
    void VV_KERNEL_TABLE(vvi_composite_##t)(vvi_sink * out, const vvi_march_volume *f, const vvi_rays *rays,           \
                                            vv_render_counts *counts)                                                  \
    {                                                                                                                  \
        composite_rays(out, f, rays, counts, HOW_TABLE, sampler, NULL);                                                \
    }                                                                                                                  \
    void VV_KERNEL_TABLE(vvi_composite_lit_##t)(vvi_sink * out, const vvi_march_volume *f, const vvi_rays *rays,       \
                                                vv_render_counts *counts)                                              \
    {                                                                                                                  \
        composite_rays(out, f, rays, counts, HOW_LIT, sampler, &(sampler_row){.color = color_##t});                    \
    }

KERNELS(u8, VVI_SAMPLE_U8)
KERNELS(u16, VVI_SAMPLE_U16)
KERNELS(i16, VVI_SAMPLE_I16)
KERNELS(f32, VVI_SAMPLE_F32)
KERNELS(any, VVI_SAMPLE_ANY)
SAMPLER(cubic, VVI_RAY_CUBIC)

extern vvi_blend_kernel VV_KERNEL_TABLE(vvi_blend_rays);
void VV_KERNEL_TABLE(vvi_blend_rays)(vvi_sink *out, const vvi_blend_setup *f, const vvi_rays *rays,
                                     vv_render_counts *counts)
{
    static const sampler_row samplers[VVI_RAY_SAMPLERS] = {
        [VVI_SAMPLE_U8] = {value_u8, classify_u8, color_u8},
        [VVI_SAMPLE_U16] = {value_u16, classify_u16, color_u16},
        [VVI_SAMPLE_I16] = {value_i16, classify_i16, color_i16},
        [VVI_SAMPLE_F32] = {value_f32, classify_f32, color_f32},
        [VVI_SAMPLE_ANY] = {value_any, classify_any, color_any},
        [VVI_RAY_CUBIC] = {value_cubic, classify_cubic, color_cubic},
    };
    composite_blend(out, f, rays, counts, samplers);
}
