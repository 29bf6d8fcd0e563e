/** @file
 * Gaussian smoothing of whole slices and planes, in float and in double from one source (gaussian_body.h).
 *
 * A sample becomes c + sum of w[r] ((a[-r] - c) + (a[+r] - c)): the ordinary weighted mean, written so that a constant
 * comes out exactly whatever the rounding of the weights. Beyond the border lies the border's sample.
 */
#ifndef VVI_FILTER_GAUSSIAN_LINES_H
#define VVI_FILTER_GAUSSIAN_LINES_H
#include "grid/field.h"

/** Half of a symmetric kernel whose weights sum to 1. */
typedef struct vvi_gaussian_weights {
    int64_t radius; /**< 0: the identity */
    double *w;      /**< radius + 1 of them, w[0] in the middle */
} vvi_gaussian_weights;

/** What is read from a brick. */
typedef enum vvi_gaussian_source {
    VVI_GAUSSIAN_SAMPLES, /**< the samples; 0 for those that are not finite */
    VVI_GAUSSIAN_MASK     /**< 1 for finite samples, 0 for others */
} vvi_gaussian_source;

/** Room that slice() needs, in numbers. */
size_t vvi_gaussian_slice_room(int64_t nx, int64_t ny, int components, const vvi_gaussian_weights *x);

/** Smooth one slice (a brick of n[2] = 1) along x and y into out[ny][nx * components]. *odd becomes true when a sample
 * is not finite. */
vv_status vvi_gaussian_slice_f32(float *out, bool *odd, float *room, const vv_brick *brick, vvi_gaussian_source source,
                                 const vvi_gaussian_weights *x, const vvi_gaussian_weights *y, vv_job *job);
vv_status vvi_gaussian_slice_f64(double *out, bool *odd, double *room, const vv_brick *brick,
                                 vvi_gaussian_source source, const vvi_gaussian_weights *x,
                                 const vvi_gaussian_weights *y, vv_job *job);
/** One row of n numbers of the result along a stack of rows: row k of `n_rows`, `stride` numbers apart. */
void vvi_gaussian_row_f32(float *out, const float *rows, int64_t k, int64_t n_rows, int64_t stride, int64_t n,
                          const vvi_gaussian_weights *weights);
void vvi_gaussian_row_f64(double *out, const double *rows, int64_t k, int64_t n_rows, int64_t stride, int64_t n,
                          const vvi_gaussian_weights *weights);
#endif
