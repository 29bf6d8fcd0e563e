/** @file
 * What the CPU can do, and which kernels a runtime uses.
 */
#ifndef VVI_CORE_CPU_H
#define VVI_CORE_CPU_H
#include <volvis/runtime.h>

enum {
    VVI_CPU_AVX2 = 1,   /**< AVX2, FMA, F16C, BMI2, and an OS that saves the registers */
    VVI_CPU_AVX512 = 2, /**< AVX-512 F, BW, DQ, VL as well */
    VVI_CPU_NEON = 4
};
/** Bits of this machine, lowered by VOLVIS_CPU. */
uint32_t vvi_cpu_detect(void);
/** Bits that a job's kernels may use (its runtime's choice; VOLVIS_CPU and the machine for NULL). */
uint32_t vvi_job_cpu(const vv_job *job);
#endif
