#include "filter/calc_table.h"
#include "core/memory.h"
#include "grid/field.h"

#include <math.h>
#include <string.h>

enum { OTHER_NAMES = 64, WORTH = 4 }; /* WORTH: times as many samples as values */

struct vvi_calc_table {
    size_t in_bytes, out_bytes;
    char *out; /* by the bits of a sample */
};

static bool is_possible(const vvi_expression *e, const vv_field_info *info, int64_t n_samples)
{
    const size_t bytes = vv_type_bytes(info->type);
    for (size_t name = 1; name < OTHER_NAMES; name++)
        if (vvi_expression_uses(e, name))
            return false;
    return vvi_expression_uses(e, 0) && bytes <= 2 && n_samples >= WORTH * (int64_t)((size_t)1 << 8 * bytes);
}

static bool is_in_range(const double *values, size_t n, vv_type type)
{
    const double lo = vvi_type_min(type), hi = vvi_type_max(type);
    bool inside = true;
    for (size_t i = 0; i < n; i++)
        inside &= !(nearbyint(values[i]) < lo || nearbyint(values[i]) > hi);
    return vv_type_is_float(type) || inside;
}

/* False: a value is beyond the type. */
static bool fill(vvi_calc_table *t, vvi_expression_rows *rows, const vv_field_info *info, vv_type type)
{
    const size_t n = (size_t)1 << 8 * t->in_bytes, step = n < VVI_EXPRESSION_ROW ? n : VVI_EXPRESSION_ROW;
    double *row = vvi_expression_row(rows, 0);
    for (size_t first = 0; first < n; first += step) {
        uint8_t bytes[VVI_EXPRESSION_ROW];
        uint16_t words[VVI_EXPRESSION_ROW];
        for (size_t i = 0; i < step; i++)
            bytes[i] = (uint8_t)(first + i), words[i] = (uint16_t)(first + i);
        vvi_samples_to_f64(row, t->in_bytes == 1 ? (const void *)bytes : words, info->type, step);
        if (info->value_scale != 1 || info->value_offset != 0)
            for (size_t i = 0; i < step; i++)
                row[i] = row[i] * info->value_scale + info->value_offset;
        const double *values = vvi_expression_run(rows, step);
        if (!is_in_range(values, step, type))
            return false;
        vvi_samples_from_f64(t->out + first * t->out_bytes, values, type, step);
    }
    return true;
}

vv_status vvi_calc_table_new(vvi_calc_table **out, const vvi_expression *expression, const vv_field_info *info,
                             vv_type type, int64_t n_samples, vv_job *job)
{
    vvi_expression_rows *rows = NULL;
    *out = NULL;
    if (!is_possible(expression, info, n_samples))
        return VV_OK;
    const size_t in_bytes = vv_type_bytes(info->type), out_bytes = vv_type_bytes(type);
    const size_t bytes = sizeof(vvi_calc_table) + (out_bytes << 8 * in_bytes);
    vvi_calc_table *t = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    if (!t)
        return vv_fail_memory(bytes);
    *t = (vvi_calc_table){in_bytes, out_bytes, (char *)(t + 1)};
    const vv_status st = vvi_expression_rows_new(&rows, expression, job);
    if (st == VV_OK && fill(t, rows, info, type))
        *out = t;
    else
        vvi_free(t);
    vvi_expression_rows_free(rows);
    return st;
}

void vvi_calc_table_free(vvi_calc_table *table)
{
    vvi_free(table);
}

#define LOOK_UP(in_type, out_type)                                                                                     \
    for (size_t i = 0; i < n; i++) {                                                                                   \
        in_type v;                                                                                                     \
        memcpy(&v, (const char *)in + i * sizeof v, sizeof v);                                                         \
        memcpy((char *)out + i * sizeof(out_type), table->out + v * sizeof(out_type), sizeof(out_type));               \
    }                                                                                                                  \
    break

void vvi_calc_table_row(void *out, const vvi_calc_table *table, const void *in, size_t n)
{
    switch (16 * table->in_bytes + table->out_bytes) {
    case 0x11:
        LOOK_UP(uint8_t, uint8_t);
    case 0x12:
        LOOK_UP(uint8_t, uint16_t);
    case 0x14:
        LOOK_UP(uint8_t, uint32_t);
    case 0x18:
        LOOK_UP(uint8_t, uint64_t);
    case 0x21:
        LOOK_UP(uint16_t, uint8_t);
    case 0x22:
        LOOK_UP(uint16_t, uint16_t);
    case 0x24:
        LOOK_UP(uint16_t, uint32_t);
    case 0x28:
        LOOK_UP(uint16_t, uint64_t);
    }
}
