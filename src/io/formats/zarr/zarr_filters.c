/* Filters: what makes bytes easier to compress, undone; and the checksum CRC-32C (Castagnoli). */
#include "grid/field.h"
#include "io/formats/zarr/zarr.h"
#include <math.h>
#include <string.h>

uint32_t vvi_crc32c(const uint8_t *data, size_t n)
{
    /* remainders of half bytes by the reversed polynomial 82f63b78 */
    static const uint32_t step[16] = {0x00000000, 0x105ec76f, 0x20bd8ede, 0x30e349b1, 0x417b1dbc, 0x5125dad3,
                                      0x61c69362, 0x7198540d, 0x82f63b78, 0x92a8fc17, 0xa24bb5a6, 0xb21572c9,
                                      0xc38d26c4, 0xd3d3e1ab, 0xe330a81a, 0xf36e6f75};
    uint32_t crc = ~UINT32_C(0);
    for (size_t i = 0; i < n; i++) {
        crc = crc >> 4 ^ step[(crc ^ data[i]) & 15];
        crc = crc >> 4 ^ step[(crc ^ data[i] >> 4) & 15];
    }
    return ~crc;
}

/* The first bytes of all elements lie together, then the second ones; a rest that fills no element lies as it is. */
static void unshuffle(const uint8_t *in, size_t n_in, uint8_t *out, size_t element)
{
    const size_t n = n_in / element;
    for (size_t b = 0; b < element; b++)
        for (size_t i = 0; i < n; i++)
            out[i * element + b] = in[b * n + i];
    memcpy(out + n * element, in + n * element, n_in - n * element);
}

static bool is_real(const vvi_zarr_type *type)
{
    return vv_type_is_float(type->type);
}

/* An integer by its bytes, with its sign. */
static int64_t load_whole(const uint8_t *in, const vvi_zarr_type *type)
{
    uint8_t raw[8] = {0};
    int64_t value;
    memcpy(raw, in, type->bytes);
    if (type->swap)
        vvi_swap_bytes(raw, type->bytes, 1);
    memcpy(&value, raw, sizeof value); /* little-endian machines */
    const unsigned unused = 64 - 8 * (unsigned)type->bytes;
    const bool has_sign = type->type == VV_TYPE_I8 || type->type == VV_TYPE_I16 || type->type == VV_TYPE_I32;
    return has_sign ? (int64_t)((uint64_t)value << unused) >> unused : value;
}

static double load_real(const uint8_t *in, const vvi_zarr_type *type)
{
    uint8_t raw[8];
    double value;
    memcpy(raw, in, type->bytes);
    if (type->swap)
        vvi_swap_bytes(raw, type->bytes, 1);
    vvi_samples_to_f64(&value, raw, type->type, 1);
    return value;
}

static void store(uint8_t *out, const void *value, const vvi_zarr_type *type)
{
    memcpy(out, value, type->bytes);
    if (type->swap)
        vvi_swap_bytes(out, type->bytes, 1);
}

static void store_real(uint8_t *out, double value, const vvi_zarr_type *type)
{
    uint64_t raw;
    const double whole = is_real(type) ? value : trunc(value); /* as NumPy casts */
    vvi_samples_from_f64(&raw, &whole, type->type, 1);
    store(out, &raw, type);
}

/* Sums of what is stored: integers wrap, floats round as their type does. */
static void undo_delta(const vvi_zarr_codec *c, const uint8_t *in, size_t n, uint8_t *out)
{
    uint64_t sum = 0;
    double real = 0;
    for (size_t i = 0; i < n; i++, in += c->stored.bytes, out += c->plain.bytes) {
        if (is_real(&c->plain)) {
            real += load_real(in, &c->stored);
            if (c->plain.type == VV_TYPE_F32)
                real = (double)(float)real;
            store_real(out, real, &c->plain);
        } else {
            sum += is_real(&c->stored) ? (uint64_t)(int64_t)fmin(fmax(load_real(in, &c->stored), -0x1p62), 0x1p62)
                                       : (uint64_t)load_whole(in, &c->stored);
            store(out, &sum, &c->plain);
        }
    }
}

static void undo_fixed(const vvi_zarr_codec *c, const uint8_t *in, size_t n, uint8_t *out)
{
    for (size_t i = 0; i < n; i++, in += c->stored.bytes, out += c->plain.bytes)
        store_real(out, load_real(in, &c->stored) / c->scale + c->offset, &c->plain);
}

void vvi_zarr_unfilter(const vvi_zarr_codec *c, const uint8_t *in, size_t n_in, uint8_t *out)
{
    if (c->code == VVI_ZARR_SHUFFLE)
        unshuffle(in, n_in, out, c->element_bytes);
    else if (c->code == VVI_ZARR_DELTA)
        undo_delta(c, in, n_in / c->stored.bytes, out);
    else
        undo_fixed(c, in, n_in / c->stored.bytes, out);
}
