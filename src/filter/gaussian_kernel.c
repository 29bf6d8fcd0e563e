#include "filter/gaussian_kernel.h"
#include "filter/blocks.h"

enum {
    VECTOR_BYTES = VV_WIDTH > 4 ? 4 * VV_WIDTH : 16, /* two doubles at least */
    VECTORS = 4,                                     /* that are worked on at once: none waits for another */
};

#define REAL float
#define WHOLE int32_t
#define NAME(x) x##_f32
#include "filter/gaussian_body.h"
#undef REAL
#undef WHOLE
#undef NAME

#define REAL double
#define WHOLE int64_t
#define NAME(x) x##_f64
#include "filter/gaussian_body.h"
#undef REAL
#undef WHOLE
#undef NAME

/* Above 2^22 the last bit of a float is worth 1. */
#define STORE(ctype, lo, hi)                                                                                           \
    for (int64_t at = 0; at < n; at += STEP) {                                                                         \
        const float magic = 0x1.8p23f;                                                                                 \
        ctype v[STEP];                                                                                                 \
        for (int i = 0; i < STEP; i++) {                                                                               \
            const int32_t whole = (int32_t)((row[at + i] + magic) - magic);                                            \
            v[i] = (ctype)(whole < (lo) ? (lo) : whole > (hi) ? (hi) : whole);                                         \
        }                                                                                                              \
        give(out + at * (int64_t)sizeof *v, v, n - at, sizeof *v);                                                     \
    }                                                                                                                  \
    break

static void store(char *out, const float *row, vv_type type, int64_t n)
{
    switch (type) {
    case VV_TYPE_U8:
        STORE(uint8_t, 0, UINT8_MAX);
    case VV_TYPE_I8:
        STORE(int8_t, INT8_MIN, INT8_MAX);
    case VV_TYPE_U16:
        STORE(uint16_t, 0, UINT16_MAX);
    case VV_TYPE_I16:
        STORE(int16_t, INT16_MIN, INT16_MAX);
    default:
        memcpy(out, row, (size_t)n * sizeof *row);
    }
}

const vvi_gaussian_kernels VV_KERNEL_TABLE(vvi_gaussian_kernels) = {
    .isa = VV_ISA_NAME,
    .needs = VV_ISA_NEEDS,
    .sum = {sum_f32, sum_f64},
    .load = {load_f32, load_f64},
    .finite = {finite_f32, finite_f64},
    .divide = {divide_f32, divide_f64},
    .store = store,
};
