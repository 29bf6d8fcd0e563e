/** @file
 * The greatest of several rows of keys (filter/sample_keys.h), sample by sample: what all of morphology is made of.
 */
#ifndef VVI_FILTER_DILATE_KERNEL_H
#define VVI_FILTER_DILATE_KERNEL_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Bytes behind the end of rows that may be read, and of what is prepared may be written, and are not looked at. */
#define VVI_DILATE_GUARD 256

/** out[i] is the greatest of rows[r][i], for n keys. `out` may be one of the rows, if the others do not lie before it.
 */
typedef void vvi_dilate_most(void *out, const void *const *rows, int n_rows, int64_t n);
/** Every bit of n keys is turned round if `turn` is -1, not if it is 0; keys below lo or above hi become the least that
 * there is, and the result is true if there are any. */
typedef bool vvi_dilate_prepare(void *keys, int64_t n, int turn, int64_t lo, int64_t hi);

typedef struct vvi_dilate_kernels {
    const char *isa;
    uint32_t needs;           /**< VVI_CPU_* */
    vvi_dilate_most *most[4]; /**< keys of 1, 2, 4 and 8 bytes */
    vvi_dilate_prepare *prepare[4];
} vvi_dilate_kernels;

/** The best that these VVI_CPU_* bits allow. */
const vvi_dilate_kernels *vvi_dilate_kernels_for(uint32_t cpu);
/** All that this build has, the best first; NULL past the end. */
const vvi_dilate_kernels *vvi_dilate_kernels_nth(size_t index);
#endif
