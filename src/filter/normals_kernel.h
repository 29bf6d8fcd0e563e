/** @file
 * Random numbers of a normal distribution for many samples at once: the same to the bit from every build and on every
 * machine, which those of a C library's logarithm and cosine are not (docs/decisions/0025-normal-numbers.md).
 */
#ifndef VVI_FILTER_NORMALS_KERNEL_H
#define VVI_FILTER_NORMALS_KERNEL_H
#include <stddef.h>
#include <stdint.h>

/** What random numbers are mixed from: a whole number of turns of the golden ratio for each draw. */
#define VVI_NORMALS_STEP 0x9e3779b97f4a7c15u

/** Two independent numbers for each of n samples, from `first` on (Box & Muller 1958), from the sample's first two
 * draws. `seed`: mixed already. Both arrays end VVI_NORMALS_GUARD numbers after n. */
typedef void vvi_normals_make(double *a, double *b, uint64_t seed, uint64_t first, int64_t n);
#define VVI_NORMALS_GUARD 8

typedef struct vvi_normals_kernels {
    const char *isa;
    uint32_t needs; /**< VVI_CPU_* */
    vvi_normals_make *make;
} vvi_normals_kernels;

/** The best that these VVI_CPU_* bits allow. */
const vvi_normals_kernels *vvi_normals_kernels_for(uint32_t cpu);
/** All that this build has, the best first; NULL past the end. */
const vvi_normals_kernels *vvi_normals_kernels_nth(size_t index);
#endif
