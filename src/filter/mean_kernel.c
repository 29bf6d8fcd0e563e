#include "filter/mean_kernel.h"
#include "core/simd.h"

/* Inner loops have a constant number of turns: they become vectors. */
#define JOIN(name, number)                                                                                             \
    static void name(void *out, const void *a_in, const void *b_in, const void *c_in, int64_t n)                       \
    {                                                                                                                  \
        enum { BLOCK = VVI_MEAN_GUARD / sizeof(number) };                                                              \
        for (int64_t at = 0; at < n; at += BLOCK) {                                                                    \
            const number *a = (const number *)a_in + at, *b = (const number *)b_in + at;                               \
            number sum[BLOCK];                                                                                         \
            if (c_in) {                                                                                                \
                const number *c = (const number *)c_in + at;                                                           \
                for (int i = 0; i < BLOCK; i++)                                                                        \
                    sum[i] = a[i] + b[i] + c[i];                                                                       \
            } else {                                                                                                   \
                for (int i = 0; i < BLOCK; i++)                                                                        \
                    sum[i] = a[i] + b[i];                                                                              \
            }                                                                                                          \
            if (n - at < BLOCK)                                                                                        \
                memcpy((number *)out + at, sum, (size_t)(n - at) * sizeof *sum);                                       \
            else                                                                                                       \
                memcpy((number *)out + at, sum, sizeof sum);                                                           \
        }                                                                                                              \
    }

JOIN(join_i32, uint32_t) /* what is no sample may overflow */
JOIN(join_i64, uint64_t)
JOIN(join_f64, double)

const vvi_mean_kernels VV_KERNEL_TABLE(vvi_mean_kernels) = {
    .isa = VV_ISA_NAME,
    .needs = VV_ISA_NEEDS,
    .join = {join_i32, join_i64, join_f64},
};
