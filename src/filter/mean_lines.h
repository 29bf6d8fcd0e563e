/** @file
 * Sums of boxes of samples, in whole numbers or doubles.
 *
 * Runs of 2 m or 2 m + 1 numbers are made of two runs of m: nothing is subtracted, so a large number leaves no trace
 * where it is not in the box.
 */
#ifndef VVI_FILTER_MEAN_LINES_H
#define VVI_FILTER_MEAN_LINES_H
#include "filter/mean_kernel.h"
#include <volvis/field.h>

/** Whole numbers of 32 bits hold boxes of up to 32767 samples of 16 bits; of 64 bits of any that are of up to 32 bits.
 */
vvi_mean_number vvi_mean_number_for(vv_type type, int64_t samples);
size_t vvi_mean_number_bytes(vvi_mean_number number);
/** n samples, `step` bytes from one to the next, as numbers. */
void vvi_mean_load(void *out, vvi_mean_number number, const char *in, int64_t step, vv_type type, int64_t n);
enum { VVI_MEAN_LEVELS = 24 };

/** Sums of boxes of slices that come one after the other. */
typedef struct vvi_mean_stack {
    vvi_mean_number number;
    const vvi_mean_kernels *kernels;
    int64_t radius[3];
    int64_t dims[2];                /**< of a slice, with a margin along x and y */
    int64_t plane, next;            /**< bytes of a slice; number of the one that comes */
    int levels;                     /**< of sums along z: of 1 slice, 2 or 3, ... */
    int64_t width[VVI_MEAN_LEVELS]; /**< slices of each */
    int64_t slots[VVI_MEAN_LEVELS]; /**< how many sums of each are kept */
    char *ring[VVI_MEAN_LEVELS], *block, *room, *sums;
} vvi_mean_stack;

/** dims: at most. Release it with vvi_mean_stack_finish(), also when it fails. */
vv_status vvi_mean_stack_init(vvi_mean_stack *stack, vvi_mean_number number, const int64_t dims[2],
                              const int64_t radius[3], const vvi_mean_kernels *kernels, vv_job *job);
void vvi_mean_stack_finish(vvi_mean_stack *stack);
/** Slices of so many numbers come from now on. */
void vvi_mean_stack_begin(vvi_mean_stack *stack, const int64_t dims[2]);
/** As if so many slices of ones had come; of doubles. */
void vvi_mean_stack_ones(vvi_mean_stack *stack, int64_t slices);
/** The slice that is in `block`, packed, is added, or the one before once more. The sums of boxes around slices that
 * are radius[2] before it: that of (i, j) at i + j dims[0]. NULL while there are too few. */
const void *vvi_mean_stack_add(vvi_mean_stack *stack, bool again);
/** n of them from at on, as doubles. */
void vvi_mean_give(double *out, const void *sums, vvi_mean_number number, int64_t at, int64_t n);
/** Means as samples, `step` bytes from one to the next: to the nearest, ties to even. They lie between samples of the
 * type. */
void vvi_mean_store(char *out, int64_t step, const double *means, vv_type type, int64_t n);
#endif
