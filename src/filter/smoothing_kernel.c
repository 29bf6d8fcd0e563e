#include "filter/smoothing_kernel.h"
#include "core/simd_math.h"

enum {
    VECTORS = 4, /* that are worked on at once: none waits for another */
    BLOCK = VECTORS * VV_WIDTH,
    STEP = VVI_SMOOTHING_STEP
};

/* Rows from `in` on, `apart` numbers from one to the next. */
static void sum_shifted(float *out, const float *in, int64_t apart, int64_t n_rows, int64_t n)
{
    for (int64_t at = 0; at < n; at += STEP) {
        float sum[STEP];
        memcpy(sum, in + at, sizeof sum);
        for (int64_t r = 1; r < n_rows; r++)
            for (int i = 0; i < STEP; i++)
                sum[i] += in[r * apart + at + i];
        memcpy(out + at, sum, sizeof sum);
    }
}

#define REAL float
#define NAME(x) x##_f32
#include "filter/bilateral_body.h"
#include "filter/diffuse_body.h"
#include "filter/nonlocal_body.h"
#undef REAL
#undef NAME

#define REAL double
#define NAME(x) x##_f64
#include "filter/bilateral_body.h"
#include "filter/diffuse_body.h"
#include "filter/nonlocal_body.h"
#undef REAL
#undef NAME

const vvi_smoothing_kernels VV_KERNEL_TABLE(vvi_smoothing_kernels) = {
    .isa = VV_ISA_NAME,
    .needs = VV_ISA_NEEDS,
    .bilateral = {bilateral_f32, bilateral_f64},
    .flux = {flux_f32, flux_f64},
    .spread = {spread_f32, spread_f64},
    .nonlocal = {nonlocal_f32, nonlocal_f64},
};
