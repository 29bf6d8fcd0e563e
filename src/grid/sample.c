/* Stored samples to doubles and back, and byte order. */
#include "grid/field.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define TO_F64(ctype)                                                                                                  \
    for (size_t i = 0; i < n; i++) {                                                                                   \
        ctype v;                                                                                                       \
        memcpy(&v, (const char *)in + i * sizeof v, sizeof v); /* mapped data has any alignment */                     \
        out[i] = (double)v;                                                                                            \
    }                                                                                                                  \
    break

void vvi_samples_to_f64(double *out, const void *in, vv_type type, size_t n)
{
    switch (type) {
    case VV_TYPE_U8:
        TO_F64(uint8_t);
    case VV_TYPE_I8:
        TO_F64(int8_t);
    case VV_TYPE_U16:
        TO_F64(uint16_t);
    case VV_TYPE_I16:
        TO_F64(int16_t);
    case VV_TYPE_U32:
        TO_F64(uint32_t);
    case VV_TYPE_I32:
        TO_F64(int32_t);
    case VV_TYPE_U64:
        TO_F64(uint64_t);
    case VV_TYPE_I64:
        TO_F64(int64_t);
    case VV_TYPE_F32:
        TO_F64(float);
    case VV_TYPE_F64:
        memmove(out, in, n * sizeof *out);
        break;
    }
}

/* To nearest, ties to even, without a call into libm: above 2^51 the last bit of a double is worth 1. */
static inline double round_to_even(double v)
{
    const double magic = 0x1.8p52;
    return v > -0x1p51 && v < 0x1p51 ? (v + magic) - magic : nearbyint(v);
}

/* The comparison is written so that NaN takes the last branch; `hi` of 64-bit types is one above their range. */
#define FROM_F64(ctype, lo, hi)                                                                                        \
    for (size_t i = 0; i < n; i++) {                                                                                   \
        const double r = round_to_even(in[i]);                                                                         \
        const ctype v = r >= (double)(hi) ? (hi) : r > (double)(lo) ? (ctype)r : r <= (double)(lo) ? (lo) : 0;         \
        memcpy((char *)out + i * sizeof v, &v, sizeof v);                                                              \
    }                                                                                                                  \
    break

/* What is finite stays so. That is rare to fail, and the loop has no branch: the compiler makes vectors of it. */
static void to_f32(char *out, const double *in, size_t n)
{
    int64_t beyond = 0;
    for (size_t i = 0; i < n; i++) {
        const float v = (float)in[i];
        memcpy(out + i * sizeof v, &v, sizeof v);
        beyond += fabs(in[i]) > FLT_MAX ? 1 : 0;
    }
    for (size_t i = 0; i < n && beyond > 0; i++) {
        const float most = copysignf(FLT_MAX, (float)in[i]);
        if (fabs(in[i]) > FLT_MAX && isfinite(in[i]))
            memcpy(out + i * sizeof most, &most, sizeof most);
    }
}

void vvi_samples_from_f64(void *out, const double *in, vv_type type, size_t n)
{
    switch (type) {
    case VV_TYPE_U8:
        FROM_F64(uint8_t, 0, UINT8_MAX);
    case VV_TYPE_I8:
        FROM_F64(int8_t, INT8_MIN, INT8_MAX);
    case VV_TYPE_U16:
        FROM_F64(uint16_t, 0, UINT16_MAX);
    case VV_TYPE_I16:
        FROM_F64(int16_t, INT16_MIN, INT16_MAX);
    case VV_TYPE_U32:
        FROM_F64(uint32_t, 0, UINT32_MAX);
    case VV_TYPE_I32:
        FROM_F64(int32_t, INT32_MIN, INT32_MAX);
    case VV_TYPE_U64:
        FROM_F64(uint64_t, 0, UINT64_MAX);
    case VV_TYPE_I64:
        FROM_F64(int64_t, INT64_MIN, INT64_MAX);
    case VV_TYPE_F32:
        to_f32(out, in, n);
        break;
    case VV_TYPE_F64:
        memmove(out, in, n * sizeof *in);
        break;
    }
}

void vvi_swap_bytes(void *data, size_t element_bytes, size_t n)
{
    char *p = data;
    if (element_bytes == 2) {
        for (size_t i = 0; i < n; i++) {
            uint16_t v;
            memcpy(&v, p + 2 * i, 2);
            v = __builtin_bswap16(v);
            memcpy(p + 2 * i, &v, 2);
        }
    } else if (element_bytes == 4) {
        for (size_t i = 0; i < n; i++) {
            uint32_t v;
            memcpy(&v, p + 4 * i, 4);
            v = __builtin_bswap32(v);
            memcpy(p + 4 * i, &v, 4);
        }
    } else if (element_bytes == 8) {
        for (size_t i = 0; i < n; i++) {
            uint64_t v;
            memcpy(&v, p + 8 * i, 8);
            v = __builtin_bswap64(v);
            memcpy(p + 8 * i, &v, 8);
        }
    }
}
