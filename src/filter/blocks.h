/** @file
 * Rows in blocks of a constant length, whose loops become vectors. For kernels only.
 */
#ifndef VVI_FILTER_BLOCKS_H
#define VVI_FILTER_BLOCKS_H
#include "core/simd.h"

enum { STEP = 64 }; /* numbers of a block */

/** STEP numbers of `each` bytes, of which n are there; the others are 0. */
VV_INLINE void take(void *block, const void *from, int64_t n, size_t each)
{
    if (n >= STEP) {
        memcpy(block, from, STEP * each);
    } else {
        memset(block, 0, STEP * each);
        memcpy(block, from, (size_t)n * each);
    }
}

/** As many of them as there are. */
VV_INLINE void give(void *to, const void *block, int64_t n, size_t each)
{
    if (n >= STEP)
        memcpy(to, block, STEP * each);
    else
        memcpy(to, block, (size_t)n * each);
}

#endif
