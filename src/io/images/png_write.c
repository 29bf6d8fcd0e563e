/* Writing PNG. Headers and text go through libpng; the pixels are deflated in parallel strips, each ended on a byte
 * boundary, which together are one valid stream (as pigz does it). Bytes do not depend on the number of threads. */
#include "io/images/png.h"

#include "core/job.h"
#include "core/memory.h"
#include "io/images/image_layer.h"
#include "io/images/png_rows.h"
#include "io/sink.h"

#include <string.h>
#include <zlib.h>

#define STRIP_BYTES ((size_t)256 << 10)
#define COMPRESS_TEXT_FROM 1024
#define KEY_MOST 79

typedef struct writer {
    vv_sink *sink;
    const vv_image_options *options;
    vvi_png_rows rows;
    int32_t strip_rows;
    size_t n_strips;
    vvi_png_strip *strips;
    vv_job *job;
    png_structp png;
    png_infop info;
    png_text *text;
    vvi_png_error error;
} writer;

static void write_bytes(png_structp png, png_bytep data, size_t n)
{
    writer *w = png_get_io_ptr(png);
    w->error.status = vvi_sink_write(w->sink, data, n);
    if (w->error.status != VV_OK)
        png_error(png, "write");
}

static void flush_nothing(png_structp png)
{
    (void)png;
}

static vv_status check_key(const char *key)
{
    const size_t n = strlen(key);
    bool fine = n >= 1 && n <= KEY_MOST && key[0] != ' ' && key[n - 1] != ' ' && !strstr(key, "  ");
    for (size_t i = 0; i < n; i++)
        fine = fine && key[i] >= 32 && key[i] < 127;
    return fine
               ? VV_OK
               : vv_fail(VV_E_ARGUMENT, "the text key '%.90s' cannot stand in a PNG; it needs 1 to %d plain characters",
                         key, KEY_MOST);
}

/* tEXt is Latin-1: plain ASCII goes there, everything else to iTXt, which is UTF-8. */
static bool is_plain(const char *value)
{
    for (const char *c = value; *c; c++)
        if ((*c < 32 && *c != '\n') || *c == 127)
            return false;
    return true;
}

static vv_status prepare_text(writer *w)
{
    const size_t n = w->options->n_text;
    if (n == 0)
        return VV_OK;
    w->text = vvi_alloc_zeroed(w->job, n * sizeof *w->text, VVI_MEM_SCRATCH);
    if (!w->text)
        return vv_fail_memory(n * sizeof *w->text);
    for (size_t i = 0; i < n; i++) {
        const vv_text *from = &w->options->text[i];
        const vv_status st = check_key(from->key);
        if (st != VV_OK)
            return st;
        const bool plain = is_plain(from->value), large = strlen(from->value) >= COMPRESS_TEXT_FROM;
        w->text[i].key = from->key;
        w->text[i].text = from->value;
        w->text[i].compression = plain ? (large ? PNG_TEXT_COMPRESSION_zTXt : PNG_TEXT_COMPRESSION_NONE)
                                       : (large ? PNG_ITXT_COMPRESSION_zTXt : PNG_ITXT_COMPRESSION_NONE);
    }
    return VV_OK;
}

static vv_status strip_item(void *scratch, void *user, size_t index)
{
    (void)scratch;
    writer *w = user;
    const int32_t height = w->rows.image->height, y0 = (int32_t)index * w->strip_rows;
    const int32_t y1 = height - y0 < w->strip_rows ? height : y0 + w->strip_rows;
    return vvi_png_strip_make(&w->strips[index], &w->rows, y0, y1, y1 == height, w->job);
}

static vv_status make_strips(writer *w)
{
    static const vvi_work work = {.stage = "write image", .item = strip_item};
    const size_t rows = STRIP_BYTES / vvi_png_row_bytes(&w->rows) + 1;
    w->strip_rows = rows < (size_t)w->rows.image->height ? (int32_t)rows : w->rows.image->height;
    w->n_strips = (size_t)((w->rows.image->height - 1) / w->strip_rows) + 1;
    w->strips = vvi_alloc_zeroed(w->job, w->n_strips * sizeof *w->strips, VVI_MEM_SCRATCH);
    if (!w->strips)
        return vv_fail_memory(w->n_strips * sizeof *w->strips);
    return vvi_parallel_for(w->job, &work, w, w->n_strips);
}

static void write_pixels(writer *w)
{
    static const uint8_t zlib_head[2] = {0x78, 0x01};
    static const png_byte idat[5] = "IDAT", iend[5] = "IEND";
    uLong adler = adler32_z(0, NULL, 0);
    size_t n = sizeof zlib_head + 4;
    for (size_t i = 0; i < w->n_strips; i++) {
        adler = i == 0 ? w->strips[i].adler : adler32_combine(adler, w->strips[i].adler, (z_off_t)w->strips[i].n_raw);
        n = sizeof zlib_head * (i == 0) + w->strips[i].n_bytes + 4 * (i + 1 == w->n_strips);
        png_write_chunk_start(w->png, idat, (png_uint_32)n);
        if (i == 0)
            png_write_chunk_data(w->png, zlib_head, sizeof zlib_head);
        png_write_chunk_data(w->png, w->strips[i].data, w->strips[i].n_bytes);
        if (i + 1 == w->n_strips) {
            const png_byte tail[4] = {(png_byte)(adler >> 24), (png_byte)(adler >> 16), (png_byte)(adler >> 8),
                                      (png_byte)adler};
            png_write_chunk_data(w->png, tail, sizeof tail);
        }
        png_write_chunk_end(w->png);
    }
    png_write_chunk(w->png, iend, NULL, 0);
}

static void write_all(void *user)
{
    writer *w = user;
    png_set_write_fn(w->png, w, write_bytes, flush_nothing);
    png_set_IHDR(w->png, w->info, (png_uint_32)w->rows.image->width, (png_uint_32)w->rows.image->height, w->rows.bits,
                 w->rows.channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(w->png, w->info, PNG_sRGB_INTENT_PERCEPTUAL);
    if (w->text)
        png_set_text(w->png, w->info, w->text, (int)w->options->n_text);
    png_write_info(w->png, w->info);
    write_pixels(w);
}

static vv_status write_file(writer *w)
{
    w->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &w->error, vvi_png_fail, vvi_png_warn);
    w->info = w->png ? png_create_info_struct(w->png) : NULL;
    vv_status st = VV_OK;
    if (!w->info)
        st = vv_fail_memory(4096);
    else if (!vvi_png_guard(w->png, write_all, w))
        st = w->error.status != VV_OK
                 ? w->error.status
                 : vv_fail_at(VV_E_WRITE, vvi_sink_name(w->sink), NULL, "libpng: %s", w->error.text);
    png_destroy_write_struct(&w->png, &w->info);
    return st;
}

vv_status vvi_png_write(vv_sink *sink, const vv_image *image, const vv_image_options *options, vv_job *job)
{
    vvi_srgb_table table;
    writer w = {.sink = sink, .options = options, .job = job};
    vvi_srgb_table_init(&table);
    w.rows = (vvi_png_rows){
        .image = image,
        .channels = options->alpha && vvi_image_transparent(image) ? 4 : 3,
        .bits = options->bits,
        .table = &table,
    };
    vv_status st;
    if ((st = prepare_text(&w)) == VV_OK && (st = make_strips(&w)) == VV_OK)
        st = write_file(&w);
    for (size_t i = 0; w.strips && i < w.n_strips; i++)
        vvi_free(w.strips[i].data);
    vvi_free(w.strips);
    vvi_free(w.text);
    return st;
}
