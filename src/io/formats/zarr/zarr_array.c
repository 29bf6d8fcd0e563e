/* What the metadata of arrays has in common: sizes, types, fill values. */
#include "core/memory.h"
#include "grid/field.h"
#include "io/formats/zarr/zarr.h"
#include "io/sample_writer.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What can be counted without overflow; what is too much is said by the limits of the job, of all formats alike. */
#define AXIS_MOST (UINT64_C(1) << 31)
#define ELEMENTS_MOST (UINT64_C(1) << 60)

vv_status vvi_zarr_sizes(int64_t *out, int *n_out, const json_t *list, const char *key, const char *name)
{
    const size_t n = json_array_size(list);
    if (!json_is_array(list))
        return vv_fail_at(VV_E_FORMAT, name, NULL, "has no '%s' that is a list of sizes", key);
    if (n == 0)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "holds one number and no axes");
    if (n > VVI_ZARR_AXES)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "has %zu axes; at most %d can be read", n, VVI_ZARR_AXES);
    for (size_t i = 0; i < n; i++)
        if (!vvi_json_whole(&out[i], json_array_get(list, i)) || out[i] < 1 || (uint64_t)out[i] > AXIS_MOST)
            return vv_fail_at(VV_E_FORMAT, name, NULL, "entry %zu of '%s' is not a whole number from 1 to %llu", i + 1,
                              key, (unsigned long long)AXIS_MOST);
    *n_out = (int)n;
    return VV_OK;
}

/* Sizes that belong together, and products that fit. */
vv_status vvi_zarr_check_array(vvi_zarr_array *a, const char *name)
{
    uint64_t samples = 1;
    a->chunk_bytes = a->type.bytes;
    for (int i = 0; i < a->n_axes; i++) {
        if (samples > ELEMENTS_MOST / (uint64_t)a->shape[i])
            return vv_fail_at(VV_E_FORMAT, name, NULL, "asks for more than %llu samples; its metadata is wrong",
                              (unsigned long long)ELEMENTS_MOST);
        samples *= (uint64_t)a->shape[i];
        if (a->chunk_bytes > ELEMENTS_MOST / (uint64_t)a->chunk[i])
            return vv_fail_at(VV_E_FORMAT, name, NULL, "has chunks of more than %llu bytes; its metadata is wrong",
                              (unsigned long long)ELEMENTS_MOST);
        a->chunk_bytes *= (uint64_t)a->chunk[i];
        if (a->sharded && a->shard[i] % a->chunk[i] != 0)
            return vv_fail_at(VV_E_FORMAT, name, NULL,
                              "has shards of %lld and chunks of %lld along axis %d; chunks must fill shards evenly",
                              (long long)a->shard[i], (long long)a->chunk[i], i + 1);
    }
    return VV_OK;
}

/* As xarray does it where the format has no names. */
static void name_axes(vvi_zarr_array *a, const json_t *names)
{
    if (json_array_size(names) != (size_t)a->n_axes)
        return;
    for (int i = 0; i < a->n_axes; i++)
        if (!a->axis_name[i][0])
            vvi_json_copy_text(a->axis_name[i], sizeof a->axis_name[i],
                               json_string_value(json_array_get(names, (size_t)i)));
}

vv_status vvi_zarr_array_of(vvi_zarr_array *out, const vvi_zarr_node *node, const vvi_zarr_tree *tree)
{
    char name[VVI_ZARR_PATH + 512];
    snprintf(name, sizeof name, "%.500s%s%s", vvi_source_name(tree->folder), *node->path ? "/" : "", node->path);
    vv_status st =
        node->version == 2 ? vvi_zarr_array_v2(out, node->meta, name) : vvi_zarr_array_v3(out, node->meta, name);
    if (st == VV_OK)
        name_axes(out, json_object_get(node->attributes, "_ARRAY_DIMENSIONS"));
    return st;
}

/* Types ---------------------------------------------------------------------------------------------------------- */

bool vvi_zarr_type_v2(vvi_zarr_type *out, const char *text)
{
    static const struct {
        const char *name;
        vv_type type;
        bool half;
        size_t bytes;
    } types[] = {
        {"b1", VV_TYPE_U8, false, 1},  {"u1", VV_TYPE_U8, false, 1},  {"i1", VV_TYPE_I8, false, 1},
        {"u2", VV_TYPE_U16, false, 2}, {"i2", VV_TYPE_I16, false, 2}, {"u4", VV_TYPE_U32, false, 4},
        {"i4", VV_TYPE_I32, false, 4}, {"u8", VV_TYPE_U64, false, 8}, {"i8", VV_TYPE_I64, false, 8},
        {"f2", VV_TYPE_F32, true, 2},  {"f4", VV_TYPE_F32, false, 4}, {"f8", VV_TYPE_F64, false, 8},
    };
    const char order = text && *text && strchr("<>|=", *text) ? *text++ : '=';
    for (size_t i = 0; text && i < sizeof types / sizeof *types; i++)
        if (strcmp(text, types[i].name) == 0) {
            const bool says = (order == '<' || order == '>') && types[i].bytes > 1;
            *out =
                (vvi_zarr_type){types[i].type, types[i].half, says && vvi_order_swapped(order == '>'), types[i].bytes};
            return true;
        }
    return false;
}

/* Fill values ---------------------------------------------------------------------------------------------------- */

static void put_real(uint64_t *out, double value, const vvi_zarr_type *type)
{
    if (type->type == VV_TYPE_F32) {
        const float f = (float)value;
        memcpy(out, &f, sizeof f);
    } else if (type->type == VV_TYPE_F64) {
        memcpy(out, &value, sizeof value);
    } else {
        vvi_samples_from_f64(out, &value, type->type, 1);
    }
}

/* Integers to 64 bits exactly; those of 64 bits keep their low bits. */
static bool put_whole(uint64_t *out, int64_t value, const vvi_zarr_type *type)
{
    if (vv_type_is_float(type->type)) {
        put_real(out, (double)value, type);
        return true;
    }
    if (type->bytes == 8) {
        memcpy(out, &value, sizeof value);
        return type->type == VV_TYPE_I64 || value >= 0;
    }
    put_real(out, (double)value, type);
    return (double)value >= vvi_type_min(type->type) && (double)value <= vvi_type_max(type->type);
}

/* The element's own bytes, as they lie in a file. */
static void put_raw(uint64_t *out, const uint8_t *bytes, bool swap, const vvi_zarr_type *type)
{
    uint8_t raw[8] = {0};
    memcpy(raw, bytes, type->bytes);
    if (swap)
        vvi_swap_bytes(raw, type->bytes, 1);
    if (type->half) {
        uint16_t half;
        memcpy(&half, raw, sizeof half);
        put_real(out, vvi_half_to_float(half), type);
    } else {
        memcpy(out, raw, type->bytes);
    }
}

/* "0x7fc00000": the bits of a number, most significant first. */
static bool put_hex(uint64_t *out, const char *text, const vvi_zarr_type *type)
{
    uint8_t bytes[8];
    if (strncmp(text, "0x", 2) != 0 || strlen(text + 2) != 2 * type->bytes ||
        strspn(text + 2, "0123456789abcdefABCDEF") != 2 * type->bytes)
        return false;
    for (size_t i = 0; i < type->bytes; i++) {
        const char digits[3] = {text[2 + 2 * i], text[3 + 2 * i], 0};
        bytes[i] = (uint8_t)strtoul(digits, NULL, 16);
    }
    put_raw(out, bytes, vvi_order_swapped(true), type);
    return true;
}

static int base64_digit(char c)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *at = c ? strchr(digits, c) : NULL;
    return at ? (int)(at - digits) : -1;
}

/* Base64 of the element's bytes as they lie in the file. */
static bool put_base64(uint64_t *out, const char *text, const vvi_zarr_type *type)
{
    uint8_t bytes[12];
    size_t n = 0;
    unsigned bits = 0, value = 0;
    if (strlen(text) != (type->bytes + 2) / 3 * 4)
        return false;
    for (; *text && *text != '='; text++) {
        const int digit = base64_digit(*text);
        if (digit < 0)
            return false;
        value = value << 6 | (unsigned)digit;
        bits += 6;
        if (bits >= 8) {
            bits -= 8;
            bytes[n++] = (uint8_t)(value >> bits);
        }
    }
    if (n != type->bytes)
        return false;
    put_raw(out, bytes, type->swap, type);
    return true;
}

static bool put_text(uint64_t *out, const char *text, const vvi_zarr_type *type)
{
    static const struct {
        const char *name;
        double value;
    } words[] = {
        {"NaN", (double)NAN}, {"Infinity", (double)INFINITY}, {"-Infinity", -(double)INFINITY}, {"", (double)NAN}};
    for (size_t i = 0; vv_type_is_float(type->type) && i < sizeof words / sizeof *words; i++)
        if (strcmp(text, words[i].name) == 0) {
            put_real(out, words[i].value, type);
            return true;
        }
    return put_hex(out, text, type) || put_base64(out, text, type);
}

vv_status vvi_zarr_fill(uint64_t *out, const json_t *value, const vvi_zarr_type *type, const char *name)
{
    bool known = false;
    *out = 0;
    if (!value || json_is_null(value)) {
        known = true;
    } else if (json_is_boolean(value)) {
        known = put_whole(out, json_is_true(value), type);
    } else if (json_is_integer(value)) {
        known = put_whole(out, json_integer_value(value), type);
    } else if (json_is_real(value)) {
        const double real = json_real_value(value);
        put_real(out, real, type);
        known = vv_type_is_float(type->type) ||
                (real == floor(real) && real <= vvi_type_max(type->type) && real >= vvi_type_min(type->type));
    } else if (json_is_string(value)) {
        known = put_text(out, json_string_value(value), type);
    }
    return known ? VV_OK
                 : vv_fail_at(VV_E_FORMAT, name, NULL, "its 'fill_value' is not a value of type %s",
                              vv_type_name(type->type));
}
