/** @file
 * Sums of boxes of samples, in whole numbers or doubles, from one source (mean_body.h).
 *
 * Runs of 2 m or 2 m + 1 numbers are made of two runs of m: nothing is subtracted, so a large number leaves no trace
 * where it is not in the box.
 */
#ifndef VVI_FILTER_MEAN_LINES_H
#define VVI_FILTER_MEAN_LINES_H
#include <stdint.h>
#include <volvis/field.h>

/** Numbers of one kind. Blocks are packed; `room` is as large as the block. */
typedef struct vvi_mean_lines {
    size_t bytes;
    /** n samples, `step` bytes from one to the next, as numbers. */
    void (*load)(void *out, const char *in, int64_t step, vv_type type, int64_t n);
    /** Numbers with a margin of radius[] on each side, dims[] with it: the sum of the box of (i, j, k) is then at
     * (i, j, k) of what is returned, which is one of the two. */
    void *(*sum)(void *block, void *room, const int64_t dims[3], const int64_t radius[3]);
    /** As doubles. */
    void (*give)(double *out, const void *in, int64_t n);
} vvi_mean_lines;

/** int32_t: samples of up to 16 bits, boxes of up to 32767. int64_t: of up to 32 bits. double: all. */
extern const vvi_mean_lines vvi_mean_lines_i32, vvi_mean_lines_i64, vvi_mean_lines_f64;
#endif
