/* Sample types: sizes, ranges, names and the many spellings that files use. */
#include "grid/field.h"

#include <float.h>
#include <string.h>

typedef struct type_row {
    const char *name;
    size_t bytes;
    double min, max;
    const char *spellings; /* lower case, separated by '|' */
} type_row;

/* The ends of 64-bit types are the nearest doubles: 2^63 and 2^64 themselves lie one above the range. */
static const type_row types[VV_TYPE_COUNT] = {
    [VV_TYPE_U8] = {"u8", 1, 0, UINT8_MAX, "|u8|uint8|uint8_t|uchar|unsigned char|"},
    [VV_TYPE_I8] = {"i8", 1, INT8_MIN, INT8_MAX, "|i8|s8|int8|int8_t|signed char|char|"},
    [VV_TYPE_U16] = {"u16", 2, 0, UINT16_MAX, "|u16|uint16|uint16_t|ushort|unsigned short|unsigned short int|"},
    [VV_TYPE_I16] = {"i16", 2, INT16_MIN, INT16_MAX,
                     "|i16|s16|int16|int16_t|short|short int|signed short|signed short int|"},
    [VV_TYPE_U32] = {"u32", 4, 0, UINT32_MAX, "|u32|uint32|uint32_t|uint|unsigned int|"},
    [VV_TYPE_I32] = {"i32", 4, INT32_MIN, INT32_MAX, "|i32|s32|int32|int32_t|int|signed int|"},
    [VV_TYPE_U64] = {"u64", 8, 0, 18446744073709551615.0,
                     "|u64|uint64|uint64_t|ulonglong|unsigned long long|unsigned long long int|"},
    [VV_TYPE_I64] = {"i64", 8, -9223372036854775808.0, 9223372036854775807.0,
                     "|i64|s64|int64|int64_t|longlong|long long|long long int|signed long long|"
                     "signed long long int|"},
    [VV_TYPE_F32] = {"f32", 4, -FLT_MAX, FLT_MAX, "|f32|float|float32|single|"},
    [VV_TYPE_F64] = {"f64", 8, -DBL_MAX, DBL_MAX, "|f64|double|float64|"},
};

static bool known(vv_type type)
{
    return (unsigned)type < VV_TYPE_COUNT;
}

size_t vv_type_bytes(vv_type type)
{
    return known(type) ? types[type].bytes : 0;
}

const char *vv_type_name(vv_type type)
{
    return known(type) ? types[type].name : "unknown";
}

bool vv_type_is_float(vv_type type)
{
    return type == VV_TYPE_F32 || type == VV_TYPE_F64;
}

double vvi_type_min(vv_type type)
{
    return known(type) ? types[type].min : 0;
}

double vvi_type_max(vv_type type)
{
    return known(type) ? types[type].max : 0;
}

static bool is_space(char c)
{
    return c == ' ' || c == '\t';
}

/* "  Unsigned   Char " -> "|unsigned char|"; false when it is too long to be a type. */
static bool normalise(char *out, size_t room, const char *text)
{
    size_t n = 0;
    out[n++] = '|';
    for (; *text; text++) {
        if (is_space(*text) && (n == 1 || is_space(text[1]) || !text[1]))
            continue;
        if (n + 2 >= room || *text == '|')
            return false;
        const char c = is_space(*text) ? ' ' : *text;
        out[n++] = c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c;
    }
    out[n++] = '|';
    out[n] = 0;
    return n > 2;
}

bool vv_type_parse(vv_type *out, const char *text)
{
    char word[40];
    if (!text || !normalise(word, sizeof word, text))
        return false;
    for (int t = 0; t < VV_TYPE_COUNT; t++)
        if (strstr(types[t].spellings, word)) {
            *out = (vv_type)t;
            return true;
        }
    return false;
}
