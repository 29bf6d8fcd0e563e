#include "filter/real_samples.h"
#include "grid/field.h"

#include <string.h>

bool vvi_reals_wide(vv_type type)
{
    return type != VV_TYPE_F32 && vv_type_bytes(type) > 2;
}

#define CONVERT(vtype, ctype, real)                                                                                    \
    case vtype:                                                                                                        \
        for (int64_t i = 0; i < n; i++) {                                                                              \
            ctype v;                                                                                                   \
            memcpy(&v, in + i * step, sizeof v);                                                                       \
            out[i] = (real)v;                                                                                          \
        }                                                                                                              \
        break

#define CONVERT_ALL(real)                                                                                              \
    switch (type) {                                                                                                    \
        CONVERT(VV_TYPE_U8, uint8_t, real);                                                                            \
        CONVERT(VV_TYPE_I8, int8_t, real);                                                                             \
        CONVERT(VV_TYPE_U16, uint16_t, real);                                                                          \
        CONVERT(VV_TYPE_I16, int16_t, real);                                                                           \
        CONVERT(VV_TYPE_U32, uint32_t, real);                                                                          \
        CONVERT(VV_TYPE_I32, int32_t, real);                                                                           \
        CONVERT(VV_TYPE_U64, uint64_t, real);                                                                          \
        CONVERT(VV_TYPE_I64, int64_t, real);                                                                           \
        CONVERT(VV_TYPE_F32, float, real);                                                                             \
        CONVERT(VV_TYPE_F64, double, real);                                                                            \
    }

static void to_f32(float *out, const char *in, int64_t step, vv_type type, int64_t n)
{
    CONVERT_ALL(float)
}

static void to_f64(double *out, const char *in, int64_t step, vv_type type, int64_t n)
{
    CONVERT_ALL(double)
}

void vvi_reals_of_samples(void *reals, bool wide, const void *samples, int64_t step, vv_type type, int64_t n)
{
    if (wide)
        to_f64(reals, samples, step, type, n);
    else
        to_f32(reals, samples, step, type, n);
}

#define RUN 256

void vvi_samples_of_reals(void *samples, int64_t step, vv_type type, const void *reals, bool wide, int64_t n)
{
    const size_t each = vv_type_bytes(type);
    double row[RUN];
    uint64_t packed[RUN];
    for (int64_t at = 0; at < n; at += RUN) {
        const int64_t now = n - at < RUN ? n - at : RUN;
        char *out = (char *)samples + at * step;
        for (int64_t i = 0; i < now; i++)
            row[i] = wide ? ((const double *)reals)[at + i] : (double)((const float *)reals)[at + i];
        vvi_samples_from_f64((size_t)step == each ? (void *)out : packed, row, type, (size_t)now);
        for (int64_t i = 0; (size_t)step != each && i < now; i++)
            memcpy(out + i * step, (const char *)packed + (size_t)i * each, each);
    }
}

static int64_t clamp(int64_t v, int64_t lo, int64_t n)
{
    return v < lo ? lo : v >= lo + n ? lo + n - 1 : v;
}

void vvi_reals_of_box(void *reals, bool wide, const vv_brick *b, const vv_box *box, const int64_t margin[3],
                      int64_t component)
{
    const size_t each = vvi_reals_bytes(wide);
    const int64_t *lo = b->box.lo, *n = b->box.n;
    const int64_t x = box->lo[0] - margin[0], row_n = box->n[0] + 2 * margin[0];
    const int64_t first = clamp(x, lo[0], n[0]), last = clamp(x + row_n - 1, lo[0], n[0]);
    const char *data = (const char *)b->data + component * (int64_t)vv_type_bytes(b->type);
    char *row = reals;
    for (int64_t k = -margin[2]; k < box->n[2] + margin[2]; k++)
        for (int64_t j = -margin[1]; j < box->n[1] + margin[1]; j++, row += (size_t)row_n * each) {
            const int64_t y = clamp(box->lo[1] + j, lo[1], n[1]) - lo[1],
                          z = clamp(box->lo[2] + k, lo[2], n[2]) - lo[2];
            char *inside = row + (size_t)(first - x) * each;
            vvi_reals_of_samples(inside, wide,
                                 data + (first - lo[0]) * b->stride[0] + y * b->stride[1] + z * b->stride[2],
                                 b->stride[0], b->type, last - first + 1);
            for (int64_t i = 0; i < first - x; i++)
                memcpy(row + (size_t)i * each, inside, each);
            for (int64_t i = last - x + 1; i < row_n; i++)
                memcpy(row + (size_t)i * each, inside + (size_t)(last - first) * each, each);
        }
}
