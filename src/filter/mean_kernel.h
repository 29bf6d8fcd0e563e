/** @file
 * Sums of two or three rows of numbers: what means of boxes are made of.
 */
#ifndef VVI_FILTER_MEAN_KERNEL_H
#define VVI_FILTER_MEAN_KERNEL_H
#include <stddef.h>
#include <stdint.h>

/** Bytes behind the end of rows that may be read, and are not looked at. */
#define VVI_MEAN_GUARD 512

/** out[i] = a[i] + b[i], and + c[i] where there is a c, of n numbers. `out` may be a, if the others lie behind it. */
typedef void vvi_mean_join(void *out, const void *a, const void *b, const void *c, int64_t n);

typedef enum vvi_mean_number { VVI_MEAN_I32, VVI_MEAN_I64, VVI_MEAN_F64, VVI_MEAN_NUMBERS } vvi_mean_number;

typedef struct vvi_mean_kernels {
    const char *isa;
    uint32_t needs; /**< VVI_CPU_* */
    vvi_mean_join *join[VVI_MEAN_NUMBERS];
} vvi_mean_kernels;

/** The best that these VVI_CPU_* bits allow. */
const vvi_mean_kernels *vvi_mean_kernels_for(uint32_t cpu);
/** All that this build has, the best first; NULL past the end. */
const vvi_mean_kernels *vvi_mean_kernels_nth(size_t index);
#endif
