#include "grid/field.h"
#include "io/formats/nifti/nifti.h"
#include <math.h>
#include <string.h>

/* Where each number of the header lies: one table for both directions and both versions. */
typedef enum where { I16, I32, I64, U8, F32, F64 } where;

typedef struct slot {
    where type1;
    int at1;
    where type2;
    int at2;
} slot;

static const slot slots[] = {
    {I16, 70, I16, 12},   /* datatype */
    {I16, 72, I16, 14},   /* bitpix */
    {F32, 108, I64, 168}, /* vox_offset */
    {F32, 112, F64, 176}, /* scl_slope */
    {F32, 116, F64, 184}, /* scl_inter */
    {F32, 124, F64, 192}, /* cal_max */
    {F32, 128, F64, 200}, /* cal_min */
    {F32, 136, F64, 216}, /* toffset */
    {U8, 123, I32, 500},  /* xyzt_units */
    {I16, 68, I32, 504},  /* intent_code */
    {I16, 252, I32, 344}, /* qform_code */
    {I16, 254, I32, 348}, /* sform_code */
    {U8, 39, U8, 524},    /* dim_info */
    {I16, 74, I64, 224},  /* slice_start */
    {I16, 120, I64, 232}, /* slice_end */
    {F32, 132, F64, 208}, /* slice_duration */
    {U8, 122, I32, 496},  /* slice_code */
    {F32, 56, F64, 80},   /* intent_p1 p2 p3 */
    {F32, 256, F64, 352}, /* quatern_b c d, qoffset_x y z, srow_x y z: 18 in a row */
};
enum {
    S_DATATYPE,
    S_BITPIX,
    S_OFFSET,
    S_SLOPE,
    S_INTERCEPT,
    S_MAX,
    S_MIN,
    S_TOFFSET,
    S_UNITS,
    S_INTENT,
    S_QFORM,
    S_SFORM,
    S_DIM_INFO,
    S_SLICE_START,
    S_SLICE_END,
    S_SLICE_DURATION,
    S_SLICE_CODE,
    S_INTENT_P,
    S_AFFINE
};

static size_t bytes_of(where type)
{
    static const size_t bytes[] = {2, 4, 8, 1, 4, 8};
    return bytes[type];
}

static double get(const uint8_t *at, where type, bool swapped)
{
    union {
        uint8_t b[8];
        int16_t i16;
        int32_t i32;
        int64_t i64;
        float f32;
        double f64;
    } u;
    const size_t n = bytes_of(type);
    for (size_t i = 0; i < n; i++)
        u.b[i] = at[swapped ? n - 1 - i : i];
    switch (type) {
    case I16:
        return u.i16;
    case I32:
        return u.i32;
    case I64:
        return (double)u.i64;
    case U8:
        return u.b[0];
    case F32:
        return u.f32;
    case F64:
        return u.f64;
    }
    return 0;
}

static void put(uint8_t *at, where type, double value, bool swapped)
{
    union {
        uint8_t b[8];
        int16_t i16;
        int32_t i32;
        int64_t i64;
        float f32;
        double f64;
    } u = {{0}};
    const size_t n = bytes_of(type);
    switch (type) {
    case I16:
        u.i16 = (int16_t)value;
        break;
    case I32:
        u.i32 = (int32_t)value;
        break;
    case I64:
        u.i64 = (int64_t)value;
        break;
    case U8:
        u.b[0] = (uint8_t)value;
        break;
    case F32:
        u.f32 = (float)value;
        break;
    case F64:
        u.f64 = value;
        break;
    }
    for (size_t i = 0; i < n; i++)
        at[i] = u.b[swapped ? n - 1 - i : i];
}

static double get_slot(const vvi_nifti *h, const uint8_t *bytes, int s, int index)
{
    const where type = h->version == 1 ? slots[s].type1 : slots[s].type2;
    const int at = h->version == 1 ? slots[s].at1 : slots[s].at2;
    return get(bytes + at + (size_t)index * bytes_of(type), type, h->swapped);
}

static void put_slot(const vvi_nifti *h, uint8_t *bytes, int s, int index, double value)
{
    const where type = h->version == 1 ? slots[s].type1 : slots[s].type2;
    const int at = h->version == 1 ? slots[s].at1 : slots[s].at2;
    put(bytes + at + (size_t)index * bytes_of(type), type, value, h->swapped);
}

int vvi_nifti_version(const uint8_t *head, size_t n, bool *swapped, bool *pair)
{
    static const uint8_t line_ends[] = {'\r', '\n', 0x1a, '\n'};
    *swapped = false;
    *pair = false;
    if (n < 8)
        return 0;
    for (int swap = 0; swap < 2; swap++) {
        const double size = get(head, I32, swap);
        *swapped = swap;
        if (size == VVI_NIFTI1_BYTES && n >= VVI_NIFTI1_BYTES) {
            *pair = memcmp(head + 344, "ni1", 4) == 0;
            if (*pair || memcmp(head + 344, "n+1", 4) == 0)
                return 1;
        }
        if (size == VVI_NIFTI2_BYTES && (memcmp(head + 4, "ni2", 4) == 0 || memcmp(head + 4, "n+2", 4) == 0)) {
            /* changed line ends are how a text transfer ruins a file */
            *pair = head[5] == 'i';
            return n >= 12 && memcmp(head + 8, line_ends, 4) == 0 ? 2 : 0;
        }
    }
    return 0;
}

static void copy_text(char *out, const uint8_t *from, size_t n)
{
    memcpy(out, from, n);
    out[n] = 0;
}

void vvi_nifti_unpack(vvi_nifti *h, const uint8_t *bytes)
{
    const bool one = h->version == 1;
    for (int i = 0; i < 8; i++) {
        h->dim[i] = one ? (int64_t)get(bytes + 40 + 2 * i, I16, h->swapped)
                        : (int64_t)fmax(-0x1p62, fmin(0x1p62, get(bytes + 16 + 8 * i, I64, h->swapped)));
        h->pixdim[i] = one ? get(bytes + 76 + 4 * i, F32, h->swapped) : get(bytes + 104 + 8 * i, F64, h->swapped);
    }
    h->datatype = (int)get_slot(h, bytes, S_DATATYPE, 0);
    h->bitpix = (int)get_slot(h, bytes, S_BITPIX, 0);
    h->vox_offset = get_slot(h, bytes, S_OFFSET, 0);
    h->slope = get_slot(h, bytes, S_SLOPE, 0);
    h->intercept = get_slot(h, bytes, S_INTERCEPT, 0);
    h->cal_max = get_slot(h, bytes, S_MAX, 0);
    h->cal_min = get_slot(h, bytes, S_MIN, 0);
    h->toffset = get_slot(h, bytes, S_TOFFSET, 0);
    h->xyzt_units = (int)get_slot(h, bytes, S_UNITS, 0);
    h->intent_code = (int)get_slot(h, bytes, S_INTENT, 0);
    h->qform_code = (int)get_slot(h, bytes, S_QFORM, 0);
    h->sform_code = (int)get_slot(h, bytes, S_SFORM, 0);
    h->dim_info = (int)get_slot(h, bytes, S_DIM_INFO, 0);
    h->slice_start = get_slot(h, bytes, S_SLICE_START, 0);
    h->slice_end = get_slot(h, bytes, S_SLICE_END, 0);
    h->slice_duration = get_slot(h, bytes, S_SLICE_DURATION, 0);
    h->slice_code = (int)get_slot(h, bytes, S_SLICE_CODE, 0);
    for (int i = 0; i < 3; i++) {
        h->intent_p[i] = get_slot(h, bytes, S_INTENT_P, i);
        h->quatern[i] = get_slot(h, bytes, S_AFFINE, i);
        h->qoffset[i] = get_slot(h, bytes, S_AFFINE, 3 + i);
        for (int j = 0; j < 4; j++)
            h->srow[i][j] = get_slot(h, bytes, S_AFFINE, 6 + 4 * i + j);
    }
    copy_text(h->description, bytes + (one ? 148 : 240), 80);
    copy_text(h->aux_file, bytes + (one ? 228 : 320), 24);
    copy_text(h->intent_name, bytes + (one ? 328 : 508), 16);
}

/* Readers take the first part of the quaternion, which is not stored, as the root of what the squares of the others
 * lack of 1. In a half turn they lack nothing; rounded to floats they might, and the root makes that large. So they are
 * made a little too long, by less than readers forgive: in floats, not in the doubles of the second version. */
static double quaternion_factor(const vvi_nifti *h)
{
    const double *q = h->quatern;
    return h->version == 1 && fabs(1 - (q[0] * q[0] + q[1] * q[1] + q[2] * q[2])) < 1e-8 ? 1 + 1e-7 : 1;
}

void vvi_nifti_pack(uint8_t *bytes, const vvi_nifti *h)
{
    const bool one = h->version == 1;
    memset(bytes, 0, one ? VVI_NIFTI1_BYTES : VVI_NIFTI2_BYTES);
    put(bytes, I32, one ? VVI_NIFTI1_BYTES : VVI_NIFTI2_BYTES, h->swapped);
    if (one) {
        memcpy(bytes + 344, h->pair ? "ni1" : "n+1", 4);
        bytes[38] = 'r'; /* "regular", from the format's ancestor; some readers look for it */
    } else {
        static const uint8_t magic[8] = {'n', '+', '2', 0, '\r', '\n', 0x1a, '\n'};
        memcpy(bytes + 4, magic, sizeof magic);
        if (h->pair)
            bytes[5] = 'i';
    }
    for (int i = 0; i < 8; i++) {
        put(one ? bytes + 40 + 2 * i : bytes + 16 + 8 * i, one ? I16 : I64, (double)h->dim[i], h->swapped);
        put(one ? bytes + 76 + 4 * i : bytes + 104 + 8 * i, one ? F32 : F64, h->pixdim[i], h->swapped);
    }
    const double numbers[] = {h->datatype,       h->bitpix,     h->vox_offset, h->slope,       h->intercept,
                              h->cal_max,        h->cal_min,    h->toffset,    h->xyzt_units,  h->intent_code,
                              h->qform_code,     h->sform_code, h->dim_info,   h->slice_start, h->slice_end,
                              h->slice_duration, h->slice_code};
    for (int s = 0; s < S_INTENT_P; s++)
        put_slot(h, bytes, s, 0, numbers[s]);
    for (int i = 0; i < 3; i++) {
        put_slot(h, bytes, S_INTENT_P, i, h->intent_p[i]);
        put_slot(h, bytes, S_AFFINE, i, h->quatern[i] * quaternion_factor(h));
        put_slot(h, bytes, S_AFFINE, 3 + i, h->qoffset[i]);
        for (int j = 0; j < 4; j++)
            put_slot(h, bytes, S_AFFINE, 6 + 4 * i + j, h->srow[i][j]);
    }
    memcpy(bytes + (one ? 148 : 240), h->description, 80);
    memcpy(bytes + (one ? 228 : 320), h->aux_file, 24);
    memcpy(bytes + (one ? 328 : 508), h->intent_name, 16);
}
