#include "filter/sample_keys.h"

#include <string.h>

/* Bits of a number of `bytes`, to keys and back: each of these is its own way back. */
static uint64_t turn(uint64_t bits, vv_type type)
{
    switch (type) {
    case VV_TYPE_I8:
        return bits ^ 0x80;
    case VV_TYPE_U16:
        return bits ^ 0x8000;
    case VV_TYPE_U32:
        return bits ^ 0x80000000;
    case VV_TYPE_U64:
        return bits ^ 0x8000000000000000;
    case VV_TYPE_F32: /* negative numbers grow the other way */
        return bits >> 31 & 1 ? bits ^ 0x7fffffff : bits;
    case VV_TYPE_F64:
        return bits >> 63 ? bits ^ 0x7fffffffffffffff : bits;
    default:
        return bits;
    }
}

#define TURN_EACH(ctype, vtype, to, from)                                                                              \
    for (int64_t i = 0; i < n; i++) {                                                                                  \
        ctype bits;                                                                                                    \
        memcpy(&bits, (const char *)in + i * (from), sizeof bits);                                                     \
        bits = (ctype)turn(bits, vtype);                                                                               \
        memcpy((char *)out + i * (to), &bits, sizeof bits);                                                            \
    }

/* The type is a constant in each of these loops, so that only its own turn is left in it; those of packed samples
 * become vectors. */
#define TURN_ALL(ctype, vtype)                                                                                         \
    case vtype:                                                                                                        \
        if (in_step == sizeof(ctype) && out_step == sizeof(ctype))                                                     \
            TURN_EACH(ctype, vtype, (int64_t)sizeof(ctype), (int64_t)sizeof(ctype))                                    \
        else                                                                                                           \
            TURN_EACH(ctype, vtype, out_step, in_step)                                                                 \
        break

static inline void turn_all(void *out, int64_t out_step, const void *in, int64_t in_step, vv_type type, int64_t n)
{
    switch (type) {
        TURN_ALL(uint8_t, VV_TYPE_U8);
        TURN_ALL(uint8_t, VV_TYPE_I8);
        TURN_ALL(uint16_t, VV_TYPE_U16);
        TURN_ALL(uint16_t, VV_TYPE_I16);
        TURN_ALL(uint32_t, VV_TYPE_U32);
        TURN_ALL(uint32_t, VV_TYPE_I32);
        TURN_ALL(uint64_t, VV_TYPE_U64);
        TURN_ALL(uint64_t, VV_TYPE_I64);
        TURN_ALL(uint32_t, VV_TYPE_F32);
        TURN_ALL(uint64_t, VV_TYPE_F64);
    }
}

void vvi_keys_of_samples(void *keys, const void *samples, int64_t step, vv_type type, int64_t n)
{
    const int64_t bytes = (int64_t)vv_type_bytes(type);
    turn_all(keys, bytes, samples, step, type, n);
}

void vvi_samples_of_keys(void *samples, int64_t step, const void *keys, vv_type type, int64_t n)
{
    const int64_t bytes = (int64_t)vv_type_bytes(type);
    turn_all(samples, step, keys, bytes, type, n);
}

bool vvi_keys_bounds(int64_t *lo, int64_t *hi, vv_type type)
{
    if (type == VV_TYPE_F32) {
        *hi = 0x7f800000;
        *lo = -*hi - 1;
    } else if (type == VV_TYPE_F64) {
        *hi = 0x7ff0000000000000;
        *lo = -*hi - 1;
    }
    return vv_type_is_float(type);
}

int64_t vvi_key_at(const void *keys, int64_t index, vv_type type)
{
    switch (vv_type_bytes(type)) {
    case 1:
        return ((const uint8_t *)keys)[index];
    case 2:
        return ((const int16_t *)keys)[index];
    case 4:
        return ((const int32_t *)keys)[index];
    default:
        return ((const int64_t *)keys)[index];
    }
}

void vvi_sample_of_key(void *sample, int64_t key, vv_type type)
{
    const uint8_t byte = (uint8_t)key;
    const int16_t two = (int16_t)key;
    const int32_t four = (int32_t)key;
    const void *const keys[4] = {&byte, &two, &four, &key};
    const size_t bytes = vv_type_bytes(type);
    vvi_samples_of_keys(sample, 8, keys[bytes == 8 ? 3 : bytes / 2], type, 1);
}
