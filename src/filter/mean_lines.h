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
/** Numbers with a margin of radius[] on each side, dims[] with it, packed, with VVI_MEAN_GUARD bytes behind them;
 * `room` is as large. The sum of the box of (i, j, k) is then at (i, j, k) of what is returned, which is one of the
 * two. */
void *vvi_mean_sums(void *block, void *room, vvi_mean_number number, const int64_t dims[3], const int64_t radius[3],
                    const vvi_mean_kernels *kernels);
/** n of them from at on, as doubles. */
void vvi_mean_give(double *out, const void *sums, vvi_mean_number number, int64_t at, int64_t n);
/** Means as samples, `step` bytes from one to the next: to the nearest, ties to even. They lie between samples of the
 * type. */
void vvi_mean_store(char *out, int64_t step, const double *means, vv_type type, int64_t n);
#endif
