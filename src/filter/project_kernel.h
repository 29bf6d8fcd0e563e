/** @file
 * What rows of samples of any type come to: their extremes, sums and squares. NaN do not count. The same bytes from
 * every build.
 */
#ifndef VVI_FILTER_PROJECT_KERNEL_H
#define VVI_FILTER_PROJECT_KERNEL_H
#include <stddef.h>
#include <stdint.h>
#include <volvis/field.h>

/** What has come so far: its sum, and how many were missing; or its mean, the sum of squares of what is away from it,
 * and how many there were. */
typedef struct vvi_project_sums {
    double *sum, *square, *count;
} vvi_project_sums;

/** Rows of n packed samples of a type, with any alignment. */
typedef void vvi_project_extreme(void *extreme, const char *row, int64_t n);
typedef void vvi_project_add(const vvi_project_sums *sums, const char *row, int64_t n);
/** Several of them, `step` bytes apart. */
typedef void vvi_project_add_rows(const vvi_project_sums *sums, const char *row, int64_t rows, int64_t step, int64_t n);

/** For one type. The first three go sample by sample through a row of states, the others along the row into one. */
typedef struct vvi_project_loops {
    vvi_project_extreme *extreme[2]; /**< smallest, largest; NaN of floats: none yet */
    vvi_project_add_rows *sum;
    vvi_project_add *square;             /**< Welford 1962 */
    vvi_project_extreme *extreme_of[2];  /**< the extreme is there before */
    vvi_project_add *sum_of, *square_of; /**< set what is there */
} vvi_project_loops;

typedef struct vvi_project_kernels {
    const char *isa;
    uint32_t needs; /**< VVI_CPU_* */
    vvi_project_loops of[VV_TYPE_COUNT];
} vvi_project_kernels;

/** The best that these VVI_CPU_* bits allow. */
const vvi_project_kernels *vvi_project_kernels_for(uint32_t cpu);
/** All that this build has, the best first; NULL past the end. */
const vvi_project_kernels *vvi_project_kernels_nth(size_t index);
#endif
