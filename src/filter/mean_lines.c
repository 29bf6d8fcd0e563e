#include "filter/mean_lines.h"
#include "grid/field.h"

#include <string.h>

#define Z_BYTES 4096 /* of a row, of all planes at once: they stay in the second-level cache */

vvi_mean_number vvi_mean_number_for(vv_type type, int64_t samples)
{
    if (vv_type_is_float(type) || vv_type_bytes(type) == 8)
        return VVI_MEAN_F64;
    return vv_type_bytes(type) <= 2 && samples <= 32767 ? VVI_MEAN_I32 : VVI_MEAN_I64;
}

size_t vvi_mean_number_bytes(vvi_mean_number number)
{
    return number == VVI_MEAN_I32 ? sizeof(int32_t) : sizeof(int64_t);
}

#define EACH(number, ctype, bytes)                                                                                     \
    for (int64_t i = 0; i < n; i++) {                                                                                  \
        ctype v;                                                                                                       \
        memcpy(&v, in + i * (bytes), sizeof v);                                                                        \
        to[i] = (number)v;                                                                                             \
    }
/* Packed samples become vectors. */
#define LOAD(number, ctype)                                                                                            \
    {                                                                                                                  \
        if (step == sizeof(ctype))                                                                                     \
            EACH(number, ctype, (int64_t)sizeof(ctype))                                                                \
        else                                                                                                           \
            EACH(number, ctype, step)                                                                                  \
        break;                                                                                                         \
    }

static void load_i32(int32_t *to, const char *in, int64_t step, vv_type type, int64_t n)
{
    switch (type) {
    case VV_TYPE_U8:
        LOAD(int32_t, uint8_t)
    case VV_TYPE_I8:
        LOAD(int32_t, int8_t)
    case VV_TYPE_U16:
        LOAD(int32_t, uint16_t)
    default:
        LOAD(int32_t, int16_t)
    }
}

static void load_i64(int64_t *to, const char *in, int64_t step, vv_type type, int64_t n)
{
    switch (type) {
    case VV_TYPE_U8:
        LOAD(int64_t, uint8_t)
    case VV_TYPE_I8:
        LOAD(int64_t, int8_t)
    case VV_TYPE_U16:
        LOAD(int64_t, uint16_t)
    case VV_TYPE_I16:
        LOAD(int64_t, int16_t)
    case VV_TYPE_U32:
        LOAD(int64_t, uint32_t)
    default:
        LOAD(int64_t, int32_t)
    }
}

static void load_f64(double *to, const char *in, int64_t step, vv_type type, int64_t n)
{
    switch (type) {
    case VV_TYPE_U64:
        LOAD(double, uint64_t)
    case VV_TYPE_I64:
        LOAD(double, int64_t)
    case VV_TYPE_F32:
        LOAD(double, float)
    default:
        LOAD(double, double)
    }
}

void vvi_mean_load(void *out, vvi_mean_number number, const char *in, int64_t step, vv_type type, int64_t n)
{
    if (number == VVI_MEAN_I32)
        load_i32(out, in, step, type, n);
    else if (number == VVI_MEAN_I64)
        load_i64(out, in, step, type, n);
    else
        load_f64(out, in, step, type, n);
}

/* Rows of numbers, bytes from one to the next. */
typedef struct rows {
    int64_t n, step, count; /* numbers of a row, from row to row, how many rows */
} rows;

/* Runs along one axis of `width` numbers, `step` bytes from one to the next, from the highest binary digit of width to
 * the lowest: from `in` to `out`, once for each of so many rows. */
static void run(char *out, const char *in, const rows *r, int64_t step, int64_t width, bool along, vvi_mean_join *join,
                int64_t bytes)
{
    const char *from = in;
    int64_t done = 1;
    int digit = 0;
    while (width >> (digit + 1))
        digit++;
    for (digit--; digit >= 0; digit--) {
        const int64_t odd = width >> digit & 1, next = 2 * done + odd;
        const int64_t n = along ? r->n - (next - 1) * (step / bytes) : r->n;
        const int64_t count = along ? r->count : r->count - (next - 1);
        for (int64_t k = 0; k < count; k++) {
            const char *a = from + k * r->step;
            join(out + k * r->step, a, a + done * step, odd ? in + k * r->step + 2 * done * step : NULL, n);
        }
        from = out;
        done = next;
    }
}

static void swap(char **a, char **b)
{
    char *const other = *a;
    *a = *b;
    *b = other;
}

/* Along x and y plane by plane, along z a part of all rows at a time: what is worked on stays in the caches. */
void *vvi_mean_sums(void *block, void *room, vvi_mean_number number, const int64_t dims[3], const int64_t radius[3],
                    const vvi_mean_kernels *kernels)
{
    const int64_t bytes = (int64_t)vvi_mean_number_bytes(number), plane = dims[0] * dims[1], piece = Z_BYTES / bytes;
    char *in = block, *out = room;
    for (int a = 0; a < 2; a++) {
        if (radius[a] == 0)
            continue;
        for (int64_t k = 0; k < dims[2]; k++) {
            const rows one = {.n = plane, .step = 0, .count = 1};
            run(out + k * plane * bytes, in + k * plane * bytes, &one, (a ? dims[0] : 1) * bytes, 2 * radius[a] + 1,
                true, kernels->join[number], bytes);
        }
        swap(&in, &out);
    }
    for (int64_t at = 0; at < plane && radius[2] > 0; at += piece) {
        const rows all = {.n = plane - at < piece ? plane - at : piece, .step = plane * bytes, .count = dims[2]};
        run(out + at * bytes, in + at * bytes, &all, plane * bytes, 2 * radius[2] + 1, false, kernels->join[number],
            bytes);
    }
    if (radius[2] > 0)
        swap(&in, &out);
    return in;
}

void vvi_mean_give(double *out, const void *sums, vvi_mean_number number, int64_t at, int64_t n)
{
    if (number == VVI_MEAN_F64)
        memcpy(out, (const double *)sums + at, (size_t)n * sizeof *out);
    else if (number == VVI_MEAN_I32)
        for (int64_t i = 0; i < n; i++)
            out[i] = (double)((const int32_t *)sums)[at + i];
    else
        for (int64_t i = 0; i < n; i++)
            out[i] = (double)((const int64_t *)sums)[at + i];
}

/* Above 2^51 the last bit of a double is worth 1. */
#define STORE(ctype, wide, magic)                                                                                      \
    for (int64_t i = 0; i < n; i++) {                                                                                  \
        const ctype v = (ctype)(wide)((means[i] + (magic)) - (magic));                                                 \
        memcpy(out + i * step, &v, sizeof v);                                                                          \
    }                                                                                                                  \
    break

void vvi_mean_store(char *out, int64_t step, const double *means, vv_type type, int64_t n)
{
    const double to_whole = 0x1.8p52;
    switch (type) {
    case VV_TYPE_U8:
        STORE(uint8_t, int32_t, to_whole);
    case VV_TYPE_I8:
        STORE(int8_t, int32_t, to_whole);
    case VV_TYPE_U16:
        STORE(uint16_t, int32_t, to_whole);
    case VV_TYPE_I16:
        STORE(int16_t, int32_t, to_whole);
    case VV_TYPE_U32:
        STORE(uint32_t, int64_t, to_whole);
    case VV_TYPE_I32:
        STORE(int32_t, int32_t, to_whole);
    case VV_TYPE_F32:
        STORE(float, double, 0);
    case VV_TYPE_U64:
    case VV_TYPE_I64:
    case VV_TYPE_F64:
        for (int64_t i = 0; i < n; i++)
            vvi_samples_from_f64(out + i * step, means + i, type, 1);
    }
}
