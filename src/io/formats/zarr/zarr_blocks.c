/* Compressed blocks, each decoder stopped at the room that there is. */
#include "config.h"
#include "io/formats/zarr/zarr.h"
#include "io/inflate.h"
#include <limits.h>
#include <string.h>
#include <zlib.h>
#if VV_HAVE_BZIP2
#include <bzlib.h>
#endif
#if VV_HAVE_ZSTD
#include <zstd.h>
#include <zstd_errors.h>
#endif
#if VV_HAVE_LZ4
#include <lz4.h>
#endif
#if VV_HAVE_LZMA
#include <lzma.h>
#endif
#if VV_HAVE_BLOSC
#include <blosc.h>
#endif

#define LZMA_MEMORY ((uint64_t)256 << 20)

static const char too_long[] = "its compressed data holds more bytes than a chunk has";
static const char cut_short[] = "its compressed data is cut short";
static const char damaged[] = "its compressed data is damaged";

typedef struct span {
    const uint8_t *in;
    size_t n_in;
    uint8_t *out;
    size_t room, n;
} span;

static unsigned piece(size_t n)
{
    return n < UINT_MAX ? (unsigned)n : UINT_MAX;
}

/* gzip or zlib, as their first bytes say; gzip members may follow each other. What is not one whole block within the
 * room is walked through by zlib, which knows what is wrong with it. */
static const char *unpack_gzip(span *s)
{
    z_stream z = {0};
    int code = Z_OK;
    const vvi_inflate_wrapper wrapper = s->n_in > 0 && s->in[0] == 0x1f ? VVI_INFLATE_GZIP : VVI_INFLATE_ZLIB;
    if (vvi_inflate_block(s->out, s->room, &s->n, s->in, s->n_in, wrapper))
        return NULL;
    if (inflateInit2(&z, 15 + 32) != Z_OK)
        return "there is not enough memory to decompress it";
    size_t left_in = s->n_in, left_out = s->room;
    do {
        const unsigned in = piece(left_in), out = piece(left_out);
        z.next_in = (Bytef *)s->in + (s->n_in - left_in);
        z.avail_in = in;
        z.next_out = s->out + (s->room - left_out);
        z.avail_out = out;
        code = inflate(&z, Z_NO_FLUSH);
        left_in -= in - z.avail_in;
        left_out -= out - z.avail_out;
        const bool more = code == Z_STREAM_END && left_in > 18 && s->in[s->n_in - left_in] == 0x1f;
        if (more)
            code = inflateReset(&z) == Z_OK ? Z_OK : Z_MEM_ERROR;
        else if (code == Z_OK && left_in == 0)
            break;
    } while (code == Z_OK);
    inflateEnd(&z);
    s->n = s->room - left_out;
    if (code == Z_STREAM_END)
        return NULL;
    if (code == Z_BUF_ERROR && left_out == 0)
        return too_long;
    return code == Z_OK || code == Z_BUF_ERROR ? cut_short : damaged;
}

static const char *unpack_zstd(span *s)
{
#if VV_HAVE_ZSTD
    const size_t n = ZSTD_decompress(s->out, s->room, s->in, s->n_in);
    if (ZSTD_isError(n))
        return ZSTD_getErrorCode(n) == ZSTD_error_dstSize_tooSmall ? too_long : damaged;
    s->n = n;
    return NULL;
#else
    return damaged;
#endif
}

static const char *unpack_bzip2(span *s)
{
#if VV_HAVE_BZIP2
    unsigned n = piece(s->room);
    const int code = BZ2_bzBuffToBuffDecompress((char *)s->out, &n, (char *)s->in, piece(s->n_in), 0, 0);
    s->n = n;
    return code == BZ_OK ? NULL : code == BZ_OUTBUFF_FULL ? too_long : code == BZ_UNEXPECTED_EOF ? cut_short : damaged;
#else
    return damaged;
#endif
}

/* Four bytes say how long the data is; then one block. */
static const char *unpack_lz4(span *s)
{
#if VV_HAVE_LZ4
    if (s->n_in < 4)
        return cut_short;
    const uint8_t *in = s->in;
    const size_t said = (size_t)in[0] | (size_t)in[1] << 8 | (size_t)in[2] << 16 | (size_t)in[3] << 24;
    if (said > s->room)
        return too_long;
    if (said > LZ4_MAX_INPUT_SIZE || s->n_in - 4 > INT_MAX)
        return damaged;
    const int n = LZ4_decompress_safe((const char *)in + 4, (char *)s->out, (int)(s->n_in - 4), (int)said);
    s->n = n > 0 ? (size_t)n : 0;
    return n >= 0 && (size_t)n == said ? NULL : damaged;
#else
    return damaged;
#endif
}

static const char *unpack_lzma(span *s)
{
#if VV_HAVE_LZMA
    lzma_stream z = LZMA_STREAM_INIT;
    if (lzma_auto_decoder(&z, LZMA_MEMORY, 0) != LZMA_OK)
        return "there is not enough memory to decompress it";
    z.next_in = s->in;
    z.avail_in = s->n_in;
    z.next_out = s->out;
    z.avail_out = s->room;
    const lzma_ret code = lzma_code(&z, LZMA_FINISH);
    s->n = s->room - z.avail_out;
    lzma_end(&z);
    if (code == LZMA_STREAM_END)
        return NULL;
    return code == LZMA_OK && z.avail_out == 0         ? too_long
           : code == LZMA_OK || code == LZMA_BUF_ERROR ? cut_short
                                                       : damaged;
#else
    return damaged;
#endif
}

static const char *unpack_blosc(span *s)
{
#if VV_HAVE_BLOSC
    size_t n;
    if (blosc_cbuffer_validate(s->in, s->n_in, &n) < 0)
        return damaged;
    if (n > s->room)
        return too_long;
    if (n > 0 && blosc_decompress_ctx(s->in, s->out, s->room, 1) != (int)n)
        return "its Blosc data is damaged, or compressed in a way that this Blosc library does not have";
    s->n = n;
    return NULL;
#else
    return damaged;
#endif
}

/* NOLINTNEXTLINE(readability-non-const-parameter): what is unpacked goes there */
const char *vvi_zarr_unpack(vvi_zarr_code code, const uint8_t *in, size_t n_in, uint8_t *out, size_t room,
                            size_t *n_out)
{
    span s = {in, n_in, out, room, 0};
    const char *wrong = damaged;
    switch (code) {
    case VVI_ZARR_GZIP:
        wrong = unpack_gzip(&s);
        break;
    case VVI_ZARR_ZSTD:
        wrong = unpack_zstd(&s);
        break;
    case VVI_ZARR_BZIP2:
        wrong = unpack_bzip2(&s);
        break;
    case VVI_ZARR_LZ4:
        wrong = unpack_lz4(&s);
        break;
    case VVI_ZARR_LZMA:
        wrong = unpack_lzma(&s);
        break;
    case VVI_ZARR_BLOSC:
        wrong = unpack_blosc(&s);
        break;
    default:
        break;
    }
    *n_out = s.n;
    return wrong;
}
