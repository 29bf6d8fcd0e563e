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

typedef struct vvi_ray_kernels {
    uint32_t needs;
    const char *isa;
    int width; /**< lanes */
    /** By what they do, and by sample type (VVI_SAMPLE_ANY for what is fetched otherwise than from one array). */
    vvi_ray_kernel *of[VVI_RAY_KERNELS][VVI_SAMPLE_KERNELS];
    vvi_eye_kernel *eye;
    /** The lattice has coefficients (cubic_spline.h). */
    vvi_ray_kernel *surface_cubic, *composite_cubic;
    vvi_blend_kernel *blend;     /**< any number of volumes, classified in any way */
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
