#include "grid/label_id.h"
#include "grid/field.h"
#include <math.h>
#include <string.h>

static vv_label_id rounded(double v)
{
    v = round(v);
    return v > -0x1p62 && v < 0x1p62 ? (vv_label_id)v : 0;
}

vv_label_id vvi_label_of(const void *sample, vv_type type)
{
    vv_label_id id;
    double v;
    if (type == VV_TYPE_I64 || type == VV_TYPE_U64) {
        memcpy(&id, sample, sizeof id);
        return id;
    }
    vvi_samples_to_f64(&v, sample, type, 1);
    return rounded(v);
}

void vvi_label_read(vv_label_id *out, const vv_brick *b, int component, const vv_field_info *info, int64_t j, int64_t k)
{
    const char *at =
        (const char *)b->data + (size_t)component * vv_type_bytes(b->type) + j * b->stride[1] + k * b->stride[2];
    const bool plain = !info || (info->value_scale == 1 && info->value_offset == 0);
#define READ(ctype)                                                                                                    \
    for (int64_t i = 0; i < b->box.n[0]; i++) {                                                                        \
        ctype v;                                                                                                       \
        memcpy(&v, at + i * b->stride[0], sizeof v);                                                                   \
        out[i] = (vv_label_id)v;                                                                                       \
    }                                                                                                                  \
    break
    switch (plain ? b->type : VV_TYPE_F64) {
    case VV_TYPE_U8:
        READ(uint8_t);
    case VV_TYPE_I8:
        READ(int8_t);
    case VV_TYPE_U16:
        READ(uint16_t);
    case VV_TYPE_I16:
        READ(int16_t);
    case VV_TYPE_U32:
        READ(uint32_t);
    case VV_TYPE_I32:
        READ(int32_t);
    case VV_TYPE_U64:
        READ(uint64_t);
    case VV_TYPE_I64:
        READ(int64_t);
    default:
        for (int64_t i = 0; i < b->box.n[0]; i++) {
            double v;
            vvi_samples_to_f64(&v, at + i * b->stride[0], b->type, 1);
            out[i] = rounded(info ? v * info->value_scale + info->value_offset : v);
        }
    }
#undef READ
}
