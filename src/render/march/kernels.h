/** @file
 * The ray caster's inner loops, built once per instruction set. A kernel fills one tile of the image; everything it
 * needs that does not depend on the pixel is in vvi_ray_setup.
 */
#ifndef VVI_RENDER_MARCH_KERNELS_H
#define VVI_RENDER_MARCH_KERNELS_H
#include "gfx/lamp.h"
#include "grid/lattice.h"
#include "render/march/parc.h"
#include "render/march/skip.h"
#include <math.h>
#include <volvis/sys/scene.h>

enum { VVI_RAY_PLANES = 32, VVI_RAY_LAMPS = 16 };

/** No opacity is as large. */
enum { VVI_ENTRY_SPLIT = 2 };

typedef struct vvi_ray_setup {
    /* the view */
    vv_lens lens;
    int32_t width, height; /**< of the scene: what the lens spans */
    /* the rays of one pass: pixel (X, Y) of the image looks through (X * stride + pixel_x, Y * stride + pixel_y) */
    double pixel_x, pixel_y, stride;
    int32_t row; /**< pixels from one row of the image to the next */
    bool jitter; /**< samples lie at a place in their steps that differs from ray to ray; same seed, same places */
    uint64_t jitter_seed;
    /* the volume */
    vvi_lattice lattice;
    double world_to_index[3][4];
    float index_to_world[3][4];
    float gradient_to_world[3][3]; /**< inverse transpose of the linear part, times voxel / range of stored values */
    double lo[3], hi[3];           /**< its domain in index space */
    bool nearest;                  /**< the value of the nearest sample, not interpolated */
    size_t n_planes;
    double planes[VVI_RAY_PLANES][4]; /**< kept side n . p >= c: n, c; world space */
    double step;                      /**< world length between samples */
    float steps;                      /**< about how many the longest ray has */
    /* space skipping */
    const uint8_t *reach;     /**< of each block (skip.h); NULL: none */
    const float *block_bound; /**< most that a block can add to a projection: its largest stored value, or smallest */
    int32_t blocks[3];
    int shift;
    const vvi_parc *parc; /**< where rays meet boxes in which something is visible; NULL: not known */
    /* classification: entry = trunc(stored * scale + shift_entry), clamped to [0, last_place]. An entry that is split
     * has entries of its own, evenly spaced over the places from it to the next */
    const float *alpha; /**< opacity of one step, by entry; split: the first of its own + VVI_ENTRY_SPLIT */
    const float *color; /**< r, g, b, optical depth of one step, by entry; split: how many, -, -, -alpha */
    float entry_scale, entry_shift;
    float last_place; /**< a hair below the number of entries that are not of others */
    float opaque;     /**< a ray ends when less transmittance than this is left */
    /* projections: one value of each ray, in stored numbers */
    float sign;        /**< of extrema: 1 the largest, -1 the smallest */
    float threshold;   /**< of local maxima */
    float stored_zero; /**< the stored number that means 0 */
    bool over_longest; /**< the sum over the longest ray's length, not over the ray's own */
    float longest;     /**< steps from corner to corner */
    /* surface: solid where stored value is in [solid_lo, solid_hi] */
    float solid_lo, solid_hi;
    float solid_unit; /**< 1 / range of the stored values: products of differences stay in the range of floats */
    float surface_color[3];
    const struct vvi_texture *texture; /**< on colours, before light (texture.h); NULL: none */
    /* light */
    bool shaded, two_sided;
    bool cell_gradient; /**< gradients are those of cells, not central differences */
    bool capped;        /**< what lies on the face of a cut plane is lit as that face */
    float cap_depth;    /**< to this many steps behind it: a voxel, whatever the step, but at least one */
    vvi_gloss gloss;
    float flat_gradient; /**< a gradient shorter than this, in ranges a voxel, has no direction */
    size_t n_lamps;
    vvi_lamp lamps[VVI_RAY_LAMPS];
    /* out */
    float *rgba, *depth; /**< rows of `row` pixels; depth may be NULL */
} vvi_ray_setup;

/** Where in its steps the samples of a ray lie, 0 to 1: spread evenly over neighbouring pixels (Jimenez 2014), and over
 * the passes of a picture by the golden ratio. */
static inline float vvi_ray_phase(int32_t x, int32_t y, uint64_t seed)
{
    const double a = 0.06711056 * x + 0.00583715 * y, b = 52.9829189 * (a - floor(a));
    const double c = b + 0.6180339887498949 * (double)(seed & 0xffff);
    return (float)(c - floor(c));
}

typedef void vvi_ray_kernel(const vvi_ray_setup *frame, const vv_tile *tile, vv_render_counts *counts);

struct vvi_blend_setup;
typedef void vvi_blend_kernel(const struct vvi_blend_setup *frame, const vv_tile *tile, vv_render_counts *counts);

/** What a kernel of one volume makes of the values along a ray. */
enum {
    VVI_RAY_COMPOSITE,
    VVI_RAY_COMPOSITE_SHADED,
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
    /** By what they do, and by sample type (VVI_SAMPLE_WIDE for wide lattices). */
    vvi_ray_kernel *of[VVI_RAY_KERNELS][VVI_SAMPLE_KERNELS];
    vvi_ray_kernel *surface_cubic; /**< the lattice has coefficients (cubic_spline.h) */
    vvi_blend_kernel *blend;       /**< any number of volumes, classified in any way (blend_kernel.h) */
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
