/** @file
 * Samples of any type as numbers, and numbers as floats. The same bytes from every build.
 */
#ifndef VVI_FILTER_CALC_KERNEL_H
#define VVI_FILTER_CALC_KERNEL_H
#include <stddef.h>
#include <stdint.h>
#include <volvis/field.h>

typedef struct vvi_calc_kernels {
    const char *isa;
    uint32_t needs; /**< VVI_CPU_* */
    /** As vvi_samples_to_f64(), of n packed samples with any alignment. */
    void (*load[VV_TYPE_COUNT])(double *restrict out, const char *restrict in, size_t n);
    /** Rounded to floats. False: some are beyond them, of which the finite ones are not what they should be. */
    bool (*store_f32)(char *restrict out, const double *restrict in, size_t n);
} vvi_calc_kernels;

/** The best that these VVI_CPU_* bits allow. */
const vvi_calc_kernels *vvi_calc_kernels_for(uint32_t cpu);
/** All that this build has, the best first; NULL past the end. */
const vvi_calc_kernels *vvi_calc_kernels_nth(size_t index);
#endif
