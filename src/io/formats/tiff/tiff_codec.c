/* Decoding of one chunk by libtiff, which is given a small file of that chunk alone: no state is shared, so chunks are
 * decoded on any number of threads, and what a damaged chunk makes libtiff do stays within its size. */
#include "config.h"
#include "io/formats/tiff/tiff.h"
#include "io/inflate.h"
#include "io/sample_writer.h"
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#if VV_HAVE_TIFF
#include <tiffio.h>

vv_status vvi_tiff_codec_check(const vvi_tiff_page *p, const char *name)
{
    if (p->compression == VVI_TIFF_PLAIN || p->compression == VVI_TIFF_PNG)
        return VV_OK;
    if (p->compression == VVI_TIFF_OLD_JPEG)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                          "is compressed with the JPEG of TIFF 6.0, which was never well defined; save it again");
    if (TIFFIsCODECConfigured(p->compression))
        return VV_OK;
    return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                      "is compressed in a way (%d) that this libtiff does not know; save it as deflate or LZW",
                      p->compression);
}

/* Deflate without libtiff, faster ---------------------------------------------------------------------------- */

#define ADD_LEFT(T)                                                                                                    \
    do {                                                                                                               \
        T *at = (T *)(void *)row, sum = 0;                                                                             \
        for (size_t i = 0; i < n && samples == 1; i++) /* in a register: four times as fast as through memory */       \
            at[i] = sum = (T)(sum + at[i]);                                                                            \
        for (size_t i = samples; i < n && samples > 1; i++)                                                            \
            at[i] = (T)(at[i] + at[i - samples]);                                                                      \
    } while (0)

/* Predictor 2: every number is kept as its difference from the one to its left. */
static void add_left(uint8_t *row, size_t n, size_t samples, size_t bytes)
{
    if (bytes == 1)
        ADD_LEFT(uint8_t);
    else if (bytes == 2)
        ADD_LEFT(uint16_t);
    else if (bytes == 4)
        ADD_LEFT(uint32_t);
    else
        ADD_LEFT(uint64_t);
}

/* False where it is not a whole block of numbers of whole bytes: libtiff then says what is wrong, or can do it. */
static bool decode_deflate(uint8_t *out, size_t n_out, const vvi_tiff_page *p, uint32_t rows, const uint8_t *coded,
                           size_t n)
{
    const size_t bytes = p->bits / 8u, samples = vvi_tiff_chunk_samples(p), row = (size_t)vvi_tiff_chunk_row_bytes(p);
    const bool whole_bytes = p->bits == 8 || p->bits == 16 || p->bits == 32 || p->bits == 64;
    size_t made;
    if ((p->compression != VVI_TIFF_DEFLATE && p->compression != VVI_TIFF_OLD_DEFLATE) || !whole_bytes ||
        p->fill_order == 2 || p->predictor > 2 || row * rows != n_out)
        return false;
    if (!vvi_inflate_block(out, n_out, &made, coded, n, VVI_INFLATE_ZLIB) || made != n_out)
        return false;
    if (bytes > 1 && vvi_order_swapped(p->big_endian))
        vvi_swap_bytes(out, bytes, n_out / bytes);
    for (size_t y = 0; y < rows && p->predictor == 2; y++)
        add_left(out + y * row, row / bytes, samples, bytes);
    return true;
}

/* libtiff stops at the last number and does not look at the checksum behind it. */
static bool sum_is_wrong(const vvi_tiff_page *p, const uint8_t *coded, size_t n)
{
    return (p->compression == VVI_TIFF_DEFLATE || p->compression == VVI_TIFF_OLD_DEFLATE) && p->fill_order != 2 &&
           !vvi_inflate_is_whole(coded, n);
}

/* The small file: its head, then the coded bytes, as if they lay in one piece. */
typedef struct chunk_file {
    uint8_t head[512];
    size_t n_head;
    const uint8_t *part[2]; /* JPEG tables and coded bytes after the head */
    size_t n_part[2];
    uint64_t at;
    bool big_endian;
    char *why;
    size_t n_why;
} chunk_file;

static void put(chunk_file *f, uint64_t v, int bytes)
{
    for (int i = 0; i < bytes; i++)
        f->head[f->n_head++] = (uint8_t)(v >> 8 * (f->big_endian ? bytes - 1 - i : i));
}

static void put_entry(chunk_file *f, int tag, int type, uint32_t n, uint64_t value)
{
    put(f, (uint64_t)tag, 2);
    put(f, (uint64_t)type, 2);
    put(f, n, 4);
    if (type == 3 && n == 1) {
        put(f, value, 2);
        put(f, 0, 2);
    } else {
        put(f, value, 4);
    }
}

#define HEAD_BYTES 256u /* bits and formats of samples are said once a pixel: kept apart in a table after the head */

static void make_head(chunk_file *f, const vvi_tiff_page *p, uint32_t rows)
{
    const uint32_t samples = vvi_tiff_chunk_samples(p), tables = HEAD_BYTES;
    const bool color = p->planar == 1 && p->photometric != VVI_TIFF_PALETTE;
    put(f, p->big_endian ? 0x4d4d : 0x4949, 2);
    put(f, 42, 2);
    put(f, 8, 4);
    put(f, f->n_part[0] ? 13 : 12, 2);
    put_entry(f, 256, 4, 1, p->chunk_width);
    put_entry(f, 257, 4, 1, rows);
    put_entry(f, 258, 3, 1, p->bits); /* one number stands for all samples, as libtiff reads it */
    put_entry(f, 259, 3, 1, p->compression);
    put_entry(f, 262, 3, 1, color ? p->photometric : VVI_TIFF_BLACK_IS_ZERO);
    put_entry(f, 266, 3, 1, p->fill_order);
    put_entry(f, 273, 4, 1, tables + f->n_part[0]);
    put_entry(f, 277, 3, 1, samples);
    put_entry(f, 278, 4, 1, rows);
    put_entry(f, 279, 4, 1, f->n_part[1]);
    put_entry(f, 317, 3, 1, p->predictor);
    put_entry(f, 339, 3, 1, p->format);
    if (f->n_part[0])
        put_entry(f, 347, 7, (uint32_t)f->n_part[0], tables);
    memset(f->head + f->n_head, 0, HEAD_BYTES - f->n_head);
    f->n_head = HEAD_BYTES;
}

static tmsize_t file_read(thandle_t user, void *out, tmsize_t n)
{
    chunk_file *f = user;
    const uint8_t *parts[3] = {f->head, f->part[0], f->part[1]};
    const size_t sizes[3] = {f->n_head, f->n_part[0], f->n_part[1]};
    tmsize_t done = 0;
    uint64_t start = 0;
    for (int i = 0; i < 3; start += sizes[i++]) {
        if (done >= n || f->at < start || f->at - start >= sizes[i])
            continue;
        const size_t from = (size_t)(f->at - start), left = sizes[i] - from;
        const size_t m = left < (size_t)(n - done) ? left : (size_t)(n - done);
        memcpy((uint8_t *)out + done, parts[i] + from, m);
        done += (tmsize_t)m;
        f->at += m;
    }
    return done;
}

static tmsize_t file_write(thandle_t user, void *data, tmsize_t n)
{
    (void)user, (void)data, (void)n;
    return 0;
}

static toff_t file_size(thandle_t user)
{
    const chunk_file *f = user;
    return f->n_head + f->n_part[0] + f->n_part[1];
}

static toff_t file_seek(thandle_t user, toff_t to, int whence)
{
    chunk_file *f = user;
    f->at = whence == SEEK_SET ? to : whence == SEEK_CUR ? f->at + to : file_size(user) + to;
    return f->at;
}

static int file_close(thandle_t user)
{
    (void)user;
    return 0;
}

#if TIFFLIB_VERSION >= 20221213
static int on_error(TIFF *tiff, void *user, const char *module, const char *format, va_list args)
{
    chunk_file *f = user;
    (void)tiff, (void)module;
    if (!f->why[0])
        vsnprintf(f->why, f->n_why, format, args);
    return 1;
}

static int on_warning(TIFF *tiff, void *user, const char *module, const char *format, va_list args)
{
    (void)tiff, (void)user, (void)module, (void)format, (void)args;
    return 1;
}

static TIFF *open_chunk(chunk_file *f, size_t most)
{
    TIFFOpenOptions *options = TIFFOpenOptionsAlloc();
    if (!options)
        return NULL;
    TIFFOpenOptionsSetMaxSingleMemAlloc(options, (tmsize_t)most);
    TIFFOpenOptionsSetErrorHandlerExtR(options, on_error, f);
    TIFFOpenOptionsSetWarningHandlerExtR(options, on_warning, f);
    TIFF *tiff = TIFFClientOpenExt("chunk", "rm", f, file_read, file_write, file_seek, file_close, file_size, NULL,
                                   NULL, options);
    TIFFOpenOptionsFree(options);
    return tiff;
}
#else
static TIFF *open_chunk(chunk_file *f, size_t most)
{
    (void)most;
    TIFFSetErrorHandler(NULL);
    TIFFSetWarningHandler(NULL);
    return TIFFClientOpen("chunk", "rm", f, file_read, file_write, file_seek, file_close, file_size, NULL, NULL);
}
#endif

bool vvi_tiff_decode(void *out, size_t n_out, const vvi_tiff_page *p, uint32_t rows, const uint8_t *coded, size_t n,
                     const uint8_t *tables, size_t n_tables, char *why, size_t n_why)
{
    chunk_file f = {
        .part = {tables, coded}, .n_part = {n_tables, n}, .big_endian = p->big_endian, .why = why, .n_why = n_why};
    why[0] = 0;
    if (decode_deflate(out, n_out, p, rows, coded, n))
        return true;
    if (n == 0 || n > UINT32_MAX - n_tables - HEAD_BYTES)
        return false;
    make_head(&f, p, rows);
    TIFF *tiff = open_chunk(&f, n_out + n + n_tables + ((size_t)4 << 20));
    if (!tiff)
        return false;
    if (p->photometric == VVI_TIFF_YCBCR && p->compression == VVI_TIFF_JPEG)
        TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
    const bool there = TIFFStripSize(tiff) == (tmsize_t)n_out &&
                       TIFFReadEncodedStrip(tiff, 0, out, (tmsize_t)n_out) == (tmsize_t)n_out;
    const bool good = there && !sum_is_wrong(p, coded, n);
    TIFFClose(tiff);
    if (!good && !why[0])
        snprintf(why, n_why,
                 there ? "a strip or tile is damaged: its data do not get to the checksum that they should have"
                       : "a strip or tile has fewer bytes than it should");
    return good;
}

#else

vv_status vvi_tiff_codec_check(const vvi_tiff_page *p, const char *name)
{
    if (p->compression == VVI_TIFF_PLAIN || p->compression == VVI_TIFF_PNG)
        return VV_OK;
    return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                      "is compressed, and this build of VolVis has no libtiff; save it without compression");
}

bool vvi_tiff_decode(void *out, size_t n_out, const vvi_tiff_page *p, uint32_t rows, const uint8_t *coded, size_t n,
                     const uint8_t *tables, size_t n_tables, char *why, size_t n_why)
{
    (void)out, (void)n_out, (void)p, (void)rows, (void)coded, (void)n, (void)tables, (void)n_tables;
    snprintf(why, n_why, "this build has no libtiff");
    return false;
}
#endif
