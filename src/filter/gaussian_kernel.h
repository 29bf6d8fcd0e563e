/** @file
 * Gaussian smoothing of rows of floats (f32) and doubles (f64): the same numbers from every build.
 *
 * A sample becomes c + sum of w[r] ((a[-r] - c) + (a[+r] - c)): the ordinary weighted mean, written so that a constant
 * comes out exactly whatever the rounding of the weights.
 */
#ifndef VVI_FILTER_GAUSSIAN_KERNEL_H
#define VVI_FILTER_GAUSSIAN_KERNEL_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <volvis/field.h>

/** Numbers behind the end of every row of numbers that may be read, or written where it is a result. */
#define VVI_GAUSSIAN_GUARD 64

/** Half of a symmetric kernel whose weights sum to 1. */
typedef struct vvi_gaussian_weights {
    int64_t radius; /**< 0: the identity */
    double *w;      /**< radius + 1 of them, w[0] in the middle */
} vvi_gaussian_weights;

/** n numbers of the result from 2 radius + 1 rows, the row itself in the middle. */
typedef void vvi_gaussian_sum(void *out, const void *const *rows, const vvi_gaussian_weights *weights, int64_t n);
/** Packed samples as numbers; what is behind their end is 0. */
typedef void vvi_gaussian_load(void *out, const char *in, vv_type type, int64_t n);
/** What is not finite becomes 0; mask: 1 for what is, else 0. Whether all are, and what is behind their end. */
typedef bool vvi_gaussian_finite(void *row, void *mask, int64_t n);
/** row[i] /= mask[i]. */
typedef void vvi_gaussian_divide(void *row, const void *mask, int64_t n);
/** Floats as packed samples of up to 16 bits or floats: to the nearest, ties to even, within the type's range. */
typedef void vvi_gaussian_store(char *out, const float *row, vv_type type, int64_t n);

typedef struct vvi_gaussian_kernels {
    const char *isa;
    uint32_t needs;           /**< VVI_CPU_* */
    vvi_gaussian_sum *sum[2]; /**< of floats, of doubles */
    vvi_gaussian_load *load[2];
    vvi_gaussian_finite *finite[2];
    vvi_gaussian_divide *divide[2];
    vvi_gaussian_store *store;
} vvi_gaussian_kernels;

/** The best that these VVI_CPU_* bits allow. */
const vvi_gaussian_kernels *vvi_gaussian_kernels_for(uint32_t cpu);
/** All that this build has, the best first; NULL past the end. */
const vvi_gaussian_kernels *vvi_gaussian_kernels_nth(size_t index);
#endif
