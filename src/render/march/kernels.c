/* The ray-casting kernels of one instruction set: the bodies of extremum.h, average.h, local_maximum.h and surface.h
 * for each sample type, and those of composite_kernel.c. */
#include "render/march/kernels.h"
#include "render/march/average.h"
#include "render/march/extremum.h"
#include "render/march/eye.h"
#include "render/march/local_maximum.h"
#include "render/march/surface_cubic.h"

typedef void packet_fn(vvi_sink *out, const vvi_march_volume *f, const packet *r, size_t at, vv_render_counts *counts);

VV_INLINE void each_packet(vvi_sink *out, const vvi_march_volume *f, const vvi_rays *rays, vv_render_counts *counts,
                           packet_fn *fn)
{
    for (size_t at = 0; at < rays->n; at += VV_WIDTH) {
        packet r;
        packet_begin(&r, f, rays, at);
        fn(out, f, &r, at, counts);
    }
}

/* name, what one packet does */
#define KERNEL(name, call)                                                                                             \
    static void name##_packet(vvi_sink *out, const vvi_march_volume *f, const packet *r, size_t at,                    \
                              vv_render_counts *counts)                                                                \
    {                                                                                                                  \
        call;                                                                                                          \
    }                                                                                                                  \
    static void name(vvi_sink *out, const vvi_march_volume *f, const vvi_rays *rays, vv_render_counts *counts)         \
    {                                                                                                                  \
        each_packet(out, f, rays, counts, name##_packet);                                                              \
    }

/* Whether samples are the nearest is asked at run time: it is always the same answer, and half the program to build. */
#define KERNELS_OF_TYPE(t, type)                                                                                       \
    extern vvi_ray_kernel VV_KERNEL_TABLE(vvi_composite_##t), VV_KERNEL_TABLE(vvi_composite_lit_##t),                  \
        VV_KERNEL_TABLE(vvi_composite_classified_##t);                                                                 \
    KERNEL(extremum_##t, extremum_packet(out, f, r, at, type, f->sampler.nearest, counts))                             \
    KERNEL(average_##t, average_packet(out, f, r, at, type, f->sampler.nearest, counts))                               \
    KERNEL(local_##t, local_packet(out, f, r, at, type, f->sampler.nearest, counts))                                   \
    KERNEL(surface_##t, surface_packet(out, f, r, at, type, f->sampler.nearest, counts))

KERNELS_OF_TYPE(u8, VVI_SAMPLE_U8)
KERNELS_OF_TYPE(u16, VVI_SAMPLE_U16)
KERNELS_OF_TYPE(i16, VVI_SAMPLE_I16)
KERNELS_OF_TYPE(f32, VVI_SAMPLE_F32)
KERNELS_OF_TYPE(any, VVI_SAMPLE_ANY)

KERNEL(spline, surface_cubic_packet(out, f, r, at, counts))

VV_INLINE void sample_points(float *restrict value, float *const gradient[3], const vvi_lattice *g, int type,
                             bool nearest, const float *x, const float *y, const float *z, size_t n)
{
    for (size_t i = 0; i < n; i += VV_WIDTH) {
        /* the tail is a mask of the same loop, not a second loop to get wrong */
        const size_t here = n - i < VV_WIDTH ? n - i : VV_WIDTH;
        const vm m = vm_first_n(n - i);
        float in[3][VV_WIDTH] = {{0}}, out[4][VV_WIDTH];
        memcpy(in[0], x + i, here * sizeof *x);
        memcpy(in[1], y + i, here * sizeof *y);
        memcpy(in[2], z + i, here * sizeof *z);
        const vf3 p = clamp_to_grid(g, vf3_set(vf_load(in[0]), vf_load(in[1]), vf_load(in[2])));
        vf_store(out[3], sample_value(g, type, nearest, p, m));
        memcpy(value + i, out[3], here * sizeof *value);
        if (!gradient)
            continue;
        const cell_at c = find_gradient_cell(g, nearest, p);
        const vf3 d = sample_gradient(g, type, &c, m);
        vf_store(out[0], d.x);
        vf_store(out[1], d.y);
        vf_store(out[2], d.z);
        for (int a = 0; a < 3; a++)
            memcpy(gradient[a] + i, out[a], here * sizeof *value);
    }
}

static void sample(float *restrict value, float *const gradient[3], const vvi_lattice *g, bool nearest, const float *x,
                   const float *y, const float *z, size_t n)
{
    switch (vvi_lattice_kernel(g)) {
    case VVI_SAMPLE_U8:
        sample_points(value, gradient, g, VVI_SAMPLE_U8, nearest, x, y, z, n);
        break;
    case VVI_SAMPLE_U16:
        sample_points(value, gradient, g, VVI_SAMPLE_U16, nearest, x, y, z, n);
        break;
    case VVI_SAMPLE_I16:
        sample_points(value, gradient, g, VVI_SAMPLE_I16, nearest, x, y, z, n);
        break;
    case VVI_SAMPLE_F32:
        sample_points(value, gradient, g, VVI_SAMPLE_F32, nearest, x, y, z, n);
        break;
    default:
        sample_points(value, gradient, g, VVI_SAMPLE_ANY, nearest, x, y, z, n);
        break;
    }
}

VV_INLINE void map_points(float *restrict out, const float *x, size_t n, vf (*fn)(vf))
{
    for (size_t i = 0; i < n; i += VV_WIDTH) {
        const size_t here = n - i < VV_WIDTH ? n - i : VV_WIDTH;
        float lanes[VV_WIDTH] = {0};
        memcpy(lanes, x + i, here * sizeof *x);
        vf_store(lanes, fn(vf_load(lanes)));
        memcpy(out + i, lanes, here * sizeof *out);
    }
}

static void exp2_points(float *restrict out, const float *x, size_t n)
{
    map_points(out, x, n, vf_exp2);
}

static void log2_points(float *restrict out, const float *x, size_t n)
{
    map_points(out, x, n, vf_log2);
}

static void rsqrt_points(float *restrict out, const float *x, size_t n)
{
    map_points(out, x, n, vf_rsqrt);
}

static void eye(vvi_rays *out, const vvi_eye *e, const vv_tile *tile)
{
    eye_rays(out, e, tile);
}

#define BY_TYPE(name)                                                                                                  \
    {                                                                                                                  \
        name##_u8, name##_u16, name##_i16, name##_f32, name##_any                                                      \
    }

#define BY_TYPE_OF(name)                                                                                               \
    {                                                                                                                  \
        VV_KERNEL_TABLE(name##_u8), VV_KERNEL_TABLE(name##_u16), VV_KERNEL_TABLE(name##_i16),                          \
            VV_KERNEL_TABLE(name##_f32), VV_KERNEL_TABLE(name##_any)                                                   \
    }

extern vvi_blend_kernel VV_KERNEL_TABLE(vvi_blend_rays);      /* composite_kernel.c */
extern vvi_range_mean_kernel VV_KERNEL_TABLE(vvi_range_mean); /* range_kernel.c */
extern vvi_range_fold_kernel VV_KERNEL_TABLE(vvi_range_fold);
extern vvi_ray_kernel VV_KERNEL_TABLE(vvi_composite_classified_cubic);
extern const vvi_ray_kernels VV_KERNEL_TABLE(vvi_ray_kernels);
const vvi_ray_kernels VV_KERNEL_TABLE(vvi_ray_kernels) = {
    .needs = VV_ISA_NEEDS,
    .isa = VV_ISA_NAME,
    .width = VV_WIDTH,
    .of = {[VVI_RAY_COMPOSITE] = BY_TYPE_OF(vvi_composite),
           [VVI_RAY_COMPOSITE_LIT] = BY_TYPE_OF(vvi_composite_lit),
           [VVI_RAY_COMPOSITE_CLASSIFIED] = BY_TYPE_OF(vvi_composite_classified),
           [VVI_RAY_EXTREMUM] = BY_TYPE(extremum),
           [VVI_RAY_AVERAGE] = BY_TYPE(average),
           [VVI_RAY_LOCAL_MAXIMUM] = BY_TYPE(local),
           [VVI_RAY_SURFACE] = BY_TYPE(surface)},
    .eye = eye,
    .blend = VV_KERNEL_TABLE(vvi_blend_rays),
    .surface_cubic = spline,
    .range_mean = VV_KERNEL_TABLE(vvi_range_mean),
    .range_fold = VV_KERNEL_TABLE(vvi_range_fold),
    .composite_cubic = VV_KERNEL_TABLE(vvi_composite_classified_cubic),
    .texture = VV_KERNEL_TABLE(vvi_texture_apply),
    .sample = sample,
    .exp2 = exp2_points,
    .log2 = log2_points,
    .rsqrt = rsqrt_points,
};
