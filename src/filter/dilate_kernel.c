#include "filter/dilate_kernel.h"
#include "core/simd.h"

#define KEY uint8_t
#define LEAST 0
#define NAME(x) x##_8
#include "filter/dilate_body.h"

#define KEY int16_t
#define LEAST INT16_MIN
#define NAME(x) x##_16
#include "filter/dilate_body.h"

#define KEY int32_t
#define LEAST INT32_MIN
#define NAME(x) x##_32
#include "filter/dilate_body.h"

#define KEY int64_t
#define LEAST INT64_MIN
#define NAME(x) x##_64
#include "filter/dilate_body.h"

const vvi_dilate_kernels VV_KERNEL_TABLE(vvi_dilate_kernels) = {
    .isa = VV_ISA_NAME,
    .needs = VV_ISA_NEEDS,
    .most = {most_8, most_16, most_32, most_64},
    .prepare = {prepare_8, prepare_16, prepare_32, prepare_64},
};
