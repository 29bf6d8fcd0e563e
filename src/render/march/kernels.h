/** @file
 * Loops along rays, built once per instruction set. A kernel follows the rays of one batch through what a frame has
 * prepared, and says what light comes along them.
 */
#ifndef VVI_RENDER_MARCH_KERNELS_H
#define VVI_RENDER_MARCH_KERNELS_H
#include "render/common/texture.h"
#include "render/march/rays.h"
#include "render/march/volume.h"
#include <volvis/sys/scene.h>

/** Follows the rays of a batch through one volume. */
typedef void vvi_ray_kernel(vvi_sink *out, const vvi_march_volume *volume, const vvi_rays *rays,
                            vv_render_counts *counts);

/** The same through several, of which each is classified in its own way. */
typedef void vvi_blend_kernel(vvi_sink *out, const vvi_blend_setup *blend, const vvi_rays *rays,
                              vv_render_counts *counts);

/** What a kernel of one volume makes of the values along a ray. */
enum {
    VVI_RAY_COMPOSITE,            /**< colours and opacities of a table, and no more */
    VVI_RAY_COMPOSITE_LIT,        /**< the same, then paint, texture and light */
    VVI_RAY_COMPOSITE_CLASSIFIED, /**< classified in any way, then these */
    VVI_RAY_EXTREMUM,
    VVI_RAY_AVERAGE,
    VVI_RAY_LOCAL_MAXIMUM,
    VVI_RAY_SURFACE,
    VVI_RAY_KERNELS
};

/** Points that bound a cubic spline between two samples, as weights of the four coefficients around: the spline at the
 * first, four inner points, and the spline at the second (cubic_range.c). */
enum { VVI_RANGE_INNER = 4 };
static const float vvi_range_weight[VVI_RANGE_INNER + 2][4] = {
    {1.0f / 6, 4.0f / 6, 1.0f / 6, 0},     {1.0f / 12, 8.0f / 12, 3.0f / 12, 0}, {1.0f / 24, 14.0f / 24, 9.0f / 24, 0},
    {0, 9.0f / 24, 14.0f / 24, 1.0f / 24}, {0, 3.0f / 12, 8.0f / 12, 1.0f / 12}, {0, 1.0f / 6, 4.0f / 6, 1.0f / 6},
};
/** One of these points of each of n places: a mean of four rows. */
typedef void vvi_range_mean_kernel(float *restrict to, const float *const from[4], const float weight[4], size_t n);
/** The least and the largest of the points of each cell along a row, and of those in lo and hi. Reads and writes up to
 * VVI_RANGE_BEYOND numbers beyond the ends. */
enum { VVI_RANGE_BEYOND = 16 };
typedef void vvi_range_fold_kernel(float *restrict lo, float *restrict hi, const float *restrict row, size_t cells);

typedef struct vvi_ray_kernels {
    uint32_t needs;
    const char *isa;
    int width; /**< lanes */
    /** By what they do, and by sample type (VVI_SAMPLE_ANY for what is fetched otherwise than from one array). */
    vvi_ray_kernel *of[VVI_RAY_KERNELS][VVI_SAMPLE_KERNELS];
    vvi_eye_kernel *eye;
    /** The lattice has coefficients (cubic_spline.h). */
    vvi_ray_kernel *surface_cubic, *composite_cubic;
    vvi_blend_kernel *blend; /**< any number of volumes, classified in any way */
    vvi_range_mean_kernel *range_mean;
    vvi_range_fold_kernel *range_fold;
    vvi_texture_kernel *texture; /**< for tests: the other kernels call it themselves */
    /** Values and index-space gradients (3 arrays; NULL: none) at n points in index space; for tests and probes. */
    void (*sample)(float *restrict value, float *const gradient[3], const vvi_lattice *lattice, bool nearest,
                   const float *x, const float *y, const float *z, size_t n);
    /** Elementary functions, for the kernel tests. */
    void (*exp2)(float *restrict out, const float *x, size_t n);
    void (*log2)(float *restrict out, const float *x, size_t n);
    void (*rsqrt)(float *restrict out, const float *x, size_t n);
} vvi_ray_kernels;

/** The best build for CPU bits (vvi_job_cpu), and the `index`-th of all that there are (NULL past the end): for tests.
 */
const vvi_ray_kernels *vvi_ray_kernels_for(uint32_t cpu);
const vvi_ray_kernels *vvi_ray_kernels_nth(size_t index);

#endif
