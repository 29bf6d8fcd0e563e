/** @file
 * Inner loops of filters that smooth and keep edges, of rows of floats (f32) and doubles (f64).
 *
 * Differences of values are taken in that type, weights in floats: what an exponential is worth to seven digits.
 */
#ifndef VVI_FILTER_SMOOTHING_KERNEL_H
#define VVI_FILTER_SMOOTHING_KERNEL_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Numbers behind the end of every row that may be read, or written where it is a result. */
#define VVI_SMOOTHING_GUARD 64

/** Weights below 2^-100 are none. */
#define VVI_SMOOTHING_LEAST 100.0f

/** The samples that a bilateral mean looks at, from each sample. */
typedef struct vvi_bilateral_taps {
    int64_t n;
    int64_t *offset; /**< numbers */
    float *weight;   /**< of the place, as the logarithm to base 2: at most 0 */
} vvi_bilateral_taps;

/**
 * out[i] is the mean of the numbers at row[i + offset], weighed by their place and by 2 to the power of minus the
 * square of (their difference from row[i]) / width. What is not finite has no weight, and stays.
 */
typedef void vvi_bilateral_row(void *out, const void *row, const vvi_bilateral_taps *taps, double width, int64_t n);

/** Rows of diffusion are as long as a multiple of this, and begin at one. */
#define VVI_SMOOTHING_STEP 16

/**
 * out[i] is what flows from a[i] to b[i], their difference d times 2 to the power of -(d * inverse)^2, or (rational)
 * times 1 / (1 + (d * inverse)^2): nothing where one of them is not finite.
 */
typedef void vvi_diffuse_flux(void *out, const void *a, const void *b, double inverse, bool rational, int64_t n);
/** out[i] is row[i] and rate[a] of what comes in and does not go out again along each axis: flux has the fluxes from
 * below and to above along x, along y, along z. */
typedef void vvi_diffuse_spread(void *out, const void *row, const void *const flux[6], const double rate[3], int64_t n);

/** Samples that a patch has to each side at most. */
#define VVI_NONLOCAL_PATCH_MOST 16

/** A tile on its way: differences are times `inverse`, so that a patch's distance is the sum of their squares. */
typedef struct vvi_nonlocal_tile {
    const void *numbers; /**< with a margin of the search and the patch */
    int64_t stride[2];   /**< numbers from a row, a slice to the next */
    int64_t first;       /**< index of the first that has a result */
    int64_t n[3];        /**< results */
    int64_t row_n;       /**< of a row of results, a multiple of VVI_SMOOTHING_STEP */
    int64_t patch[3];    /**< samples to each side */
    double inverse;
    float expected;        /**< square that stands for one with a sample that is not finite */
    float less;            /**< that a distance is less before it counts */
    float *sums, *weights; /**< of each result: weighed differences, times inverse, and their weights */
    float *room;           /**< vvi_nonlocal_room() */
} vvi_nonlocal_tile;

static inline size_t vvi_nonlocal_room(const int64_t n[3], int64_t row_n, const int64_t patch[3])
{
    const int64_t rows = n[1] + 2 * patch[1] + (2 * patch[2] + 1) * n[1];
    return (size_t)(row_n + 2 * patch[0] + 2 * VVI_SMOOTHING_STEP + rows * row_n);
}

/** Every result's sums grow by the sample that lies at an offset from it, weighed by 2 to the power of minus the
 * distance between their patches. */
typedef void vvi_nonlocal_add(const vvi_nonlocal_tile *tile, int64_t offset);

typedef struct vvi_smoothing_kernels {
    const char *isa;
    uint32_t needs;                  /**< VVI_CPU_* */
    vvi_bilateral_row *bilateral[2]; /**< of floats, of doubles */
    vvi_diffuse_flux *flux[2];
    vvi_diffuse_spread *spread[2];
    vvi_nonlocal_add *nonlocal[2];
} vvi_smoothing_kernels;

/** The best that these VVI_CPU_* bits allow. */
const vvi_smoothing_kernels *vvi_smoothing_kernels_for(uint32_t cpu);
/** All that this build has, the best first; NULL past the end. */
const vvi_smoothing_kernels *vvi_smoothing_kernels_nth(size_t index);
#endif
