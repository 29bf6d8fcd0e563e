/** @file
 * Medians of windows of at most three samples along each axis: rows at once, by comparisons that do not depend on the
 * values.
 */
#ifndef VVI_FILTER_MEDIAN_KERNEL_H
#define VVI_FILTER_MEDIAN_KERNEL_H
#include <stddef.h>
#include <stdint.h>

/** Samples behind the end of a row that may be read and are not looked at. */
#define VVI_MEDIAN_GUARD 256

/**
 * n keys (filter/sample_keys.h): out[i] is the median of the `width` keys from rows[r][i] on of all rows.
 *
 * n_rows  1, 3 or 9
 * width   1 or 3
 */
typedef void vvi_median_row(void *out, const void *const *rows, int n_rows, int width, int64_t n);

typedef struct vvi_median_kernels {
    const char *isa;
    uint32_t needs;              /**< VVI_CPU_* */
    vvi_median_row *of_bytes[4]; /**< keys of 1, 2, 4 and 8 bytes */
} vvi_median_kernels;

/** The best that these VVI_CPU_* bits allow. */
const vvi_median_kernels *vvi_median_kernels_for(uint32_t cpu);
/** All that this build has, the best first; NULL past the end. */
const vvi_median_kernels *vvi_median_kernels_nth(size_t index);
#endif
