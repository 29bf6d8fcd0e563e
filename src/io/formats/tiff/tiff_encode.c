/* Compression of strips: zlib, Zstandard and the LZW of TIFF 6.0 (section 13), with horizontal differences
 * (section 14). */
#include "config.h"
#include "core/memory.h"
#include "io/formats/tiff/tiff.h"
#include "io/formats/tiff/tiff_write.h"
#include "io/sample_writer.h"
#include <string.h>
#include <zlib.h>
#if VV_HAVE_ZSTD
#include <zstd.h>
#endif

/* Differences to the pixel on the left, from the right end on -------------------------------------------------------
 */

static void subtract_u8(uint8_t *row, size_t n, size_t samples)
{
    for (size_t i = n; i-- > samples;)
        row[i] = (uint8_t)(row[i] - row[i - samples]);
}

static void subtract_u16(uint8_t *row, size_t n, size_t samples, bool swap)
{
    uint16_t *v = (uint16_t *)(void *)row;
    if (swap)
        vvi_swap_bytes(row, 2, n);
    for (size_t i = n; i-- > samples;)
        v[i] = (uint16_t)(v[i] - v[i - samples]);
    if (swap)
        vvi_swap_bytes(row, 2, n);
}

static void subtract(uint8_t *rows, size_t n, const vvi_tiff_writing *w)
{
    const size_t bytes = vv_type_bytes(w->info->type), samples = (size_t)w->samples;
    for (size_t at = 0; at < n; at += w->row_bytes)
        if (bytes == 1)
            subtract_u8(rows + at, w->row_bytes, samples);
        else
            subtract_u16(rows + at, w->row_bytes / 2, samples, vvi_order_swapped(w->big_endian));
}

/* LZW ---------------------------------------------------------------------------------------------------------------
 */

#define LZW_CLEAR 256
#define LZW_END 257
#define LZW_FIRST 258
#define LZW_LAST 4094 /* a clear comes before the code that 12 bits could not count any more */
#define LZW_SLOTS 16384

typedef struct lzw {
    uint8_t *out;
    size_t n;
    uint64_t bits;
    int n_bits, width;
    uint32_t next;
    uint32_t key[LZW_SLOTS]; /* prefix << 8 | byte, plus 1; 0: free */
    uint16_t code[LZW_SLOTS];
} lzw;

static void put_code(lzw *z, uint32_t code)
{
    z->bits = z->bits << z->width | code;
    z->n_bits += z->width;
    while (z->n_bits >= 8) {
        z->n_bits -= 8;
        z->out[z->n++] = (uint8_t)(z->bits >> z->n_bits);
    }
}

static void clear(lzw *z)
{
    put_code(z, LZW_CLEAR);
    memset(z->key, 0, sizeof z->key);
    z->width = 9;
    z->next = LZW_FIRST;
}

/* A code more is known: codes get wider one early, as readers of TIFF expect. */
static void grow(lzw *z)
{
    z->next++;
    if (z->next == LZW_LAST)
        clear(z);
    else if (z->next >= 1u << z->width)
        z->width++;
}

static uint32_t find(const lzw *z, uint32_t key)
{
    uint32_t at = key * 2654435761u >> 18;
    while (z->key[at] && z->key[at] != key + 1)
        at = (at + 1) % LZW_SLOTS;
    return at;
}

/* NOLINTNEXTLINE(readability-non-const-parameter): the codes are written there */
static size_t encode_lzw(lzw *z, uint8_t *out, const uint8_t *in, size_t n)
{
    *z = (lzw){.out = out, .width = 9};
    clear(z);
    uint32_t prefix = in[0];
    for (size_t i = 1; i < n; i++) {
        const uint32_t key = prefix << 8 | in[i], at = find(z, key);
        if (z->key[at]) {
            prefix = z->code[at];
            continue;
        }
        put_code(z, prefix);
        z->key[at] = key + 1;
        z->code[at] = (uint16_t)z->next;
        grow(z);
        prefix = in[i];
    }
    put_code(z, prefix);
    grow(z);
    put_code(z, LZW_END);
    if (z->n_bits > 0)
        z->out[z->n++] = (uint8_t)(z->bits << (8 - z->n_bits));
    return z->n;
}

/* -------------------------------------------------------------------------------------------------------------------
 */

size_t vvi_tiff_encode_bound(int compression, size_t n)
{
#if VV_HAVE_ZSTD
    if (compression == VVI_TIFF_ZSTD)
        return ZSTD_compressBound(n);
#endif
    return compression == VVI_TIFF_LZW ? 2 * n + 64 : compressBound((uLong)n);
}

static vv_status encode_deflate(uint8_t *out, size_t room, size_t *n_out, const uint8_t *rows, size_t n, int level)
{
    uLongf got = (uLongf)room;
    if (compress2(out, &got, rows, (uLong)n, level > 0 ? level : Z_DEFAULT_COMPRESSION) != Z_OK)
        return vv_fail_memory(room);
    *n_out = (size_t)got;
    return VV_OK;
}

vv_status vvi_tiff_encode(uint8_t *out, size_t room, size_t *n_out, uint8_t *rows, size_t n, const vvi_tiff_writing *w)
{
    if (w->predictor == 2)
        subtract(rows, n, w);
    if (w->compression == VVI_TIFF_DEFLATE)
        return encode_deflate(out, room, n_out, rows, n, w->options->level);
#if VV_HAVE_ZSTD
    if (w->compression == VVI_TIFF_ZSTD) {
        *n_out = ZSTD_compress(out, room, rows, n, w->options->level > 0 ? w->options->level * 2 : 3);
        return ZSTD_isError(*n_out) ? vv_fail_memory(room) : VV_OK;
    }
#endif
    lzw *z = vvi_alloc(w->job, sizeof *z, VVI_MEM_SCRATCH);
    if (!z)
        return vv_fail_memory(sizeof *z);
    *n_out = encode_lzw(z, out, rows, n);
    vvi_free(z);
    return VV_OK;
}
