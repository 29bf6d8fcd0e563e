/** @file
 * Differences between neighbours of a row of numbers, of which NaN are missing.
 */
#ifndef VVI_FILTER_SLOPES_KERNEL_H
#define VVI_FILTER_SLOPES_KERNEL_H
#include <stddef.h>
#include <stdint.h>

/** Numbers behind the end of a row's neighbours that may be read, and are not looked at. */
#define VVI_SLOPES_GUARD 16

typedef struct vvi_slopes {
    int64_t step[3];     /**< numbers from one to the next along each index axis */
    double lone[3];      /**< what a difference of nothing counts: 0 along axes of one sample, else NaN */
    double world[3][3];  /**< by index axis: the world gradient of an index that goes up by one */
    double second[3][3]; /**< what second differences count */
} vvi_slopes;

/** n results from the numbers at `row` on, each of whose neighbours is there, or NaN. */
typedef void vvi_slopes_row(double *out, const double *row, const vvi_slopes *slopes, int64_t n);

typedef struct vvi_slopes_kernels {
    const char *isa;
    uint32_t needs;            /**< VVI_CPU_* */
    vvi_slopes_row *length;    /**< of the gradient */
    vvi_slopes_row *vector;    /**< x, y, z of it */
    vvi_slopes_row *laplacian; /**< the sum of second derivatives */
} vvi_slopes_kernels;

/** The best that these VVI_CPU_* bits allow. */
const vvi_slopes_kernels *vvi_slopes_kernels_for(uint32_t cpu);
/** All that this build has, the best first; NULL past the end. */
const vvi_slopes_kernels *vvi_slopes_kernels_nth(size_t index);
#endif
