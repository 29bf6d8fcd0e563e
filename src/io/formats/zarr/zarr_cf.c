/* What the attributes of an array say of its numbers by the CF conventions, as xarray and netCDF-C write them; and how
 * chunks of such numbers become chunks of values. */
#include "core/memory.h"
#include "grid/field.h"
#include "io/formats/zarr/zarr.h"
#include "io/scan.h"
#include <math.h>
#include <string.h>

/* Version 3 has floats as base64 of 8 bytes there, and both have words: NaN. */
static bool number_of(double *out, const json_t *value)
{
    const vvi_zarr_type f64 = {.type = VV_TYPE_F64, .bytes = 8};
    uint64_t bits;
    const char *end, *text = json_string_value(value);
    if (text && vvi_scan_real(out, text, &end) && !*end)
        return true;
    if (!value || json_is_null(value) || json_is_boolean(value) || vvi_zarr_fill(&bits, value, &f64, "") != VV_OK)
        return false;
    memcpy(out, &bits, sizeof *out);
    return true;
}

/* The fill of xarray's arrays of version 2 is their _FillValue. 0 is the fill of whoever asked for none: it counts only
 * where numbers are packed. */
static const json_t *value_of(const vvi_zarr_node *node, const char *name)
{
    const json_t *value = json_object_get(node->attributes, name), *fill = json_object_get(node->meta, "fill_value");
    double number;
    if (value || node->version != 2 || strcmp(name, "_FillValue") != 0 ||
        !json_object_get(node->attributes, "_ARRAY_DIMENSIONS") || !number_of(&number, fill))
        return value;
    const bool packed =
        json_object_get(node->attributes, "scale_factor") || json_object_get(node->attributes, "add_offset");
    return number != 0 || packed ? fill : NULL;
}

static int numbers_of(double *out, int most, const void *user, const char *name)
{
    const json_t *value = value_of(user, name);
    int n = 0;
    if (!json_is_array(value))
        return number_of(out, value);
    while (n < most && number_of(&out[n], json_array_get(value, (size_t)n)))
        n++;
    return n;
}

static bool is_float(const void *user, const char *name)
{
    const json_t *value = value_of(user, name);
    if (!json_is_array(value))
        return json_is_real(value);
    return json_is_real(json_array_get(value, 0)) || json_is_real(json_array_get(value, 1));
}

static bool text_of(char *out, size_t room, const void *user, const char *name)
{
    const vvi_zarr_node *node = user;
    const json_t *value = json_object_get(node->attributes, name);
    vvi_json_copy_text(out, room,
                       json_is_true(value)    ? "true"
                       : json_is_false(value) ? "false"
                                              : json_string_value(value));
    return out[0] != 0;
}

vv_status vvi_zarr_take_cf(vv_field_info *info, vvi_zarr_array *array, const vvi_zarr_node *node, vv_notes *notes)
{
    const vvi_cf_attributes of = {.user = node, .numbers = numbers_of, .is_float = is_float, .text = text_of};
    const char *unit = vvi_json_text(node->attributes, "units");
    const bool scaled = info->value_scale != 1 || info->value_offset != 0; /* as we wrote it */
    vvi_cf_gaps *gaps = &array->gaps;
    if (unit && !info->value_unit[0])
        vvi_unit_name(info->value_unit, unit, strlen(unit));
    if (scaled)
        return VV_OK;
    vvi_cf_take_gaps(gaps, array->type.type, info->meaning != VV_MEANING_SCALAR, &of);
    array->type.type = info->type = gaps->stored;
    if (!gaps->any || gaps->scale == 0)
        vvi_cf_packing(&info->value_scale, &info->value_offset, &of);
    if (gaps->any)
        info->type = gaps->type;
    return vvi_cf_note_gaps(gaps, notes);
}

/* Values ---------------------------------------------------------------------------------------------------------- */

#define BLOCK 1024

static void to_doubles(double *out, const uint8_t *in, const vvi_zarr_type *type, size_t n)
{
    if (!type->half) {
        vvi_samples_to_f64(out, in, type->type, n);
        return;
    }
    for (size_t i = 0; i < n; i++) {
        uint16_t half;
        memcpy(&half, in + i * sizeof half, sizeof half);
        out[i] = (double)vvi_half_to_float(half);
    }
}

static void to_values(uint8_t *out, const uint8_t *in, const vvi_zarr_type *type, const vvi_cf_gaps *gaps, size_t n)
{
    double block[BLOCK];
    const size_t bytes = vv_type_bytes(gaps->type);
    for (size_t at = 0; at < n; at += BLOCK) {
        const size_t m = n - at < BLOCK ? n - at : BLOCK;
        to_doubles(block, in + at * type->bytes, type, m);
        vvi_samples_from_f64(out + at * bytes, block, gaps->type, m);
        vvi_cf_mark_gaps(gaps, out + at * bytes, m);
    }
}

vv_status vvi_zarr_values(vvi_zarr_bytes *chunk, const vvi_zarr_array *array, vv_job *job)
{
    const size_t n = chunk->n / array->type.bytes, n_bytes = n * vv_type_bytes(array->gaps.type);
    uint8_t *values = vvi_alloc(job, n_bytes ? n_bytes : 1, VVI_MEM_SCRATCH);
    if (!values)
        return vv_fail_memory(n_bytes);
    to_values(values, chunk->data, &array->type, &array->gaps, n);
    vvi_free(chunk->data);
    *chunk = (vvi_zarr_bytes){values, n_bytes};
    return VV_OK;
}

uint64_t vvi_zarr_fill_value(const vvi_zarr_array *array)
{
    const vvi_zarr_type type = {.type = array->type.type, .bytes = vv_type_bytes(array->type.type)};
    uint64_t fill = 0;
    if (!array->gaps.any)
        return array->fill;
    to_values((uint8_t *)&fill, (const uint8_t *)&array->fill, &type, &array->gaps, 1);
    return fill;
}
