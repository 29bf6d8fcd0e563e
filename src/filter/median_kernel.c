#include "filter/median_kernel.h"
#include "core/simd.h"

enum {
    BLOCK = 128,     /* keys at once */
    SLACK = 16,      /* keys of a block that are there and not worked on */
    STEP = BLOCK - 2 /* of which so many have both neighbours */
};

#define KEY uint8_t
#define NAME(x) x##_8
#include "filter/median_body.h"

#define KEY int16_t
#define NAME(x) x##_16
#include "filter/median_body.h"

#define KEY int32_t
#define NAME(x) x##_32
#include "filter/median_body.h"

#define KEY int64_t
#define NAME(x) x##_64
#include "filter/median_body.h"

const vvi_median_kernels VV_KERNEL_TABLE(vvi_median_kernels) = {
    .isa = VV_ISA_NAME,
    .needs = VV_ISA_NEEDS,
    .of_bytes = {row_8, row_16, row_32, row_64},
};
