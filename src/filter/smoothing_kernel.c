#include "filter/smoothing_kernel.h"
#include "core/simd_math.h"

enum {
    VECTORS = 4, /* that are worked on at once: none waits for another */
    BLOCK = VECTORS * VV_WIDTH,
    STEP = VVI_SMOOTHING_STEP
};

#define REAL float
#define NAME(x) x##_f32
#include "filter/bilateral_body.h"
#include "filter/diffuse_body.h"

#define REAL double
#define NAME(x) x##_f64
#include "filter/bilateral_body.h"
#include "filter/diffuse_body.h"

const vvi_smoothing_kernels VV_KERNEL_TABLE(vvi_smoothing_kernels) = {
    .isa = VV_ISA_NAME,
    .needs = VV_ISA_NEEDS,
    .bilateral = {bilateral_f32, bilateral_f64},
    .flux = {flux_f32, flux_f64},
    .spread = {spread_f32, spread_f64},
};
