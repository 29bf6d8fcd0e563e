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

/* What a value is seen as, in a volume whose samples are taken in one way. Kinds differ too little to be kernels of
 * their own: all lanes are of one. */
VV_INLINE void classify(sight *out, march_part *p, const part_span *span, vf middle, vf value, vm m, int sampler)
{
    const vvi_march_volume *f = p->f;
    const int kind = f->classifier.kind;
    const bool labels = has_labels(f, sampler);
    const vf share = (span->to - span->from) * p->scale, zero = vf_set1(0.0f); /* of one of its own steps */
    const vf3 point = packet_point(&p->r, middle);
    vm real = vm_and(m, is_number(value)), steep = vm_none();
    out->entry = vi_set1(0);
    out->rgb[0] = out->rgb[1] = out->rgb[2] = zero;
    if (kind == VVI_CLASSIFY_PLANE) {
        real = steep = vm_and(real, may_be_in_plane(f, value, real));
    } else if (kind == VVI_CLASSIFY_INTEGRATED) {
        real = integrate(out, p, span, value, m);
    } else {
        out->label = value;
        look_up(out, f, value, share, real);
    }
    if (f->classifier.modulate_power > 0 && kind != VVI_CLASSIFY_PLANE)
        steep = vm_and(real, vf_lt(zero, out->depth));
    if (vm_any(steep)) {
        out->gradient = labels ? part_label_gradient(f, point, value, steep) : part_gradient(f, sampler, point, steep);
        if (kind == VVI_CLASSIFY_PLANE)
            in_plane(out, f, value, share);
        if (f->classifier.modulate_power > 0)
            fade(out, modulation(f, out->gradient));
    } else if (kind == VVI_CLASSIFY_PLANE) {
        out->depth = zero;
    }
    out->depth = vf_select(real, out->depth, zero);
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
    extern vvi_ray_kernel VV_KERNEL_TABLE(vvi_composite_classified_##t);                                               \
    void VV_KERNEL_TABLE(vvi_composite_classified_##t)(vvi_sink * out, const vvi_march_volume *f,                      \
                                                       const vvi_rays *rays, vv_render_counts *counts)                 \
    {                                                                                                                  \
        composite_rays(out, f, rays, counts, HOW_ONE, sampler, &(sampler_row){NULL, classify_##t, color_##t});         \
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
