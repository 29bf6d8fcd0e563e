#include "filter/calc_kernel.h"
#include "core/simd.h"

#include <float.h>

#define LOAD(name, ctype)                                                                                              \
    static void name(double *restrict out, const char *restrict in, size_t n)                                          \
    {                                                                                                                  \
        for (size_t i = 0; i < n; i++) {                                                                               \
            ctype v;                                                                                                   \
            memcpy(&v, in + i * sizeof v, sizeof v);                                                                   \
            out[i] = (double)v;                                                                                        \
        }                                                                                                              \
    }
LOAD(load_u8, uint8_t)
LOAD(load_i8, int8_t)
LOAD(load_u16, uint16_t)
LOAD(load_i16, int16_t)
LOAD(load_u32, uint32_t)
LOAD(load_i32, int32_t)
LOAD(load_u64, uint64_t)
LOAD(load_i64, int64_t)
LOAD(load_f32, float)
LOAD(load_f64, double)

static bool store_f32(char *restrict out, const double *restrict in, size_t n)
{
    int64_t beyond = 0;
    for (size_t i = 0; i < n; i++) {
        const float v = (float)in[i];
        memcpy(out + i * sizeof v, &v, sizeof v);
        beyond += fabs(in[i]) > (double)FLT_MAX ? 1 : 0;
    }
    return beyond == 0;
}

const vvi_calc_kernels VV_KERNEL_TABLE(vvi_calc_kernels) = {
    .isa = VV_ISA_NAME,
    .needs = VV_ISA_NEEDS,
    .load =
        {
            [VV_TYPE_U8] = load_u8,
            [VV_TYPE_I8] = load_i8,
            [VV_TYPE_U16] = load_u16,
            [VV_TYPE_I16] = load_i16,
            [VV_TYPE_U32] = load_u32,
            [VV_TYPE_I32] = load_i32,
            [VV_TYPE_U64] = load_u64,
            [VV_TYPE_I64] = load_i64,
            [VV_TYPE_F32] = load_f32,
            [VV_TYPE_F64] = load_f64,
        },
    .store_f32 = store_f32,
};
