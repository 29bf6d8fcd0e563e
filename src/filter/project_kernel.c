#include "filter/project_kernel.h"
#include "filter/blocks.h"

typedef double eight __attribute__((vector_size(64)));
typedef int64_t eight_bits __attribute__((vector_size(64)));

/* Whether all numbers are there. */
VV_INLINE bool add(double sum[STEP], const double v[STEP])
{
    eight_bits gone = {0};
    uint64_t any = 0;
    VV_UNROLL
    for (int i = 0; i < STEP; i += 8) {
        eight s, x;
        memcpy(&x, v + i, sizeof x);
        memcpy(&s, sum + i, sizeof s);
        const eight_bits there = x == x;
        s += (eight)((eight_bits)x & there);
        gone |= ~there;
        memcpy(sum + i, &s, sizeof s);
    }
    VV_UNROLL
    for (int i = 0; i < 8; i++)
        any |= (uint64_t)gone[i];
    return !any;
}

static void count_missing(double *missing, const double v[STEP], int64_t n)
{
    for (int i = 0; i < STEP && i < n; i++)
        missing[i] += v[i] == v[i] ? 0 : 1;
}

/* Welford's; nothing is worked out on a condition alone, as vectors have no branches. */
VV_INLINE void add_square(double mean[STEP], double square[STEP], double count[STEP], const double v[STEP])
{
    for (int i = 0; i < STEP; i++) {
        const double away = v[i] - mean[i], more = count[i] + 1, next = mean[i] + away / more;
        const double grown = square[i] + away * (v[i] - next);
        mean[i] = v[i] == v[i] ? next : mean[i];
        square[i] = v[i] == v[i] ? grown : square[i];
        count[i] = v[i] == v[i] ? more : count[i];
    }
}

/* In the same order on every machine. */
VV_INLINE double halves_added(const double v[STEP])
{
    eight part[STEP / 8];
    double sum[8];
    memcpy(part, v, sizeof part);
    VV_UNROLL
    for (int half = STEP / 16; half > 0; half /= 2)
        VV_UNROLL
    for (int i = 0; i < half; i++)
        part[i] += part[half + i];
    memcpy(sum, part, sizeof sum);
    return ((sum[0] + sum[4]) + (sum[2] + sum[6])) + ((sum[1] + sum[5]) + (sum[3] + sum[7]));
}

enum { WHOLE_ROWS = 1 << 15 };

#define SAMPLE uint8_t
#define NAME(x) x##_u8
#define WHOLE uint32_t
#include "filter/project_body.h"
#undef WHOLE
#undef SAMPLE
#undef NAME

#define SAMPLE int8_t
#define NAME(x) x##_i8
#define WHOLE int32_t
#include "filter/project_body.h"
#undef WHOLE
#undef SAMPLE
#undef NAME

#define SAMPLE uint16_t
#define NAME(x) x##_u16
#define WHOLE uint32_t
#include "filter/project_body.h"
#undef WHOLE
#undef SAMPLE
#undef NAME

#define SAMPLE int16_t
#define NAME(x) x##_i16
#define WHOLE int32_t
#include "filter/project_body.h"
#undef WHOLE
#undef SAMPLE
#undef NAME

#define SAMPLE uint32_t
#define NAME(x) x##_u32
#include "filter/project_body.h"
#undef SAMPLE
#undef NAME

#define SAMPLE int32_t
#define NAME(x) x##_i32
#include "filter/project_body.h"
#undef SAMPLE
#undef NAME

#define SAMPLE uint64_t
#define NAME(x) x##_u64
#include "filter/project_body.h"
#undef SAMPLE
#undef NAME

#define SAMPLE int64_t
#define NAME(x) x##_i64
#include "filter/project_body.h"
#undef SAMPLE
#undef NAME

#define SAMPLE float
#define NAME(x) x##_f32
#include "filter/project_body.h"
#undef SAMPLE
#undef NAME

#define SAMPLE double
#define NAME(x) x##_f64
#include "filter/project_body.h"
#undef SAMPLE
#undef NAME

#define LOOPS(x)                                                                                                       \
    {                                                                                                                  \
        .extreme = {smallest_##x, largest_##x}, .sum = sum_##x, .square = square_##x,                                  \
        .extreme_of = {smallest_of_##x, largest_of_##x}, .sum_of = sum_of_##x, .square_of = square_of_##x              \
    }

const vvi_project_kernels VV_KERNEL_TABLE(vvi_project_kernels) = {
    .isa = VV_ISA_NAME,
    .needs = VV_ISA_NEEDS,
    .of =
        {
            [VV_TYPE_U8] = LOOPS(u8),
            [VV_TYPE_I8] = LOOPS(i8),
            [VV_TYPE_U16] = LOOPS(u16),
            [VV_TYPE_I16] = LOOPS(i16),
            [VV_TYPE_U32] = LOOPS(u32),
            [VV_TYPE_I32] = LOOPS(i32),
            [VV_TYPE_U64] = LOOPS(u64),
            [VV_TYPE_I64] = LOOPS(i64),
            [VV_TYPE_F32] = LOOPS(f32),
            [VV_TYPE_F64] = LOOPS(f64),
        },
};
