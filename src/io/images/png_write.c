/* Writing PNG. Headers and text go through libpng; the pixels are deflated in parallel strips, each ended on a byte
 * boundary, which together are one valid stream (as pigz does it). Bytes do not depend on the number of threads. */
#include "io/images/png.h"

#include "core/job.h"
#include "core/memory.h"
#include "image/image_layer.h"
#include "io/images/png_rows.h"
#include "io/sink.h"

#include <math.h>
#include <string.h>

#define COMPRESS_TEXT_FROM 1024
#define KEY_MOST 79

typedef struct writer {
    vv_sink *sink;
    const vv_image_options *options;
    const vv_image_rows *rows;
    vvi_codes codes;
    vvi_png_part part;
    int32_t y; /* of the next row */
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
    return fine ? VV_OK
                : vv_fail(VV_E_ARGUMENT,
                          "the text key '%.90s' cannot be used in a PNG; it needs 1 to %d plain characters", key,
                          KEY_MOST);
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

typedef struct strips_writing {
    writer *w;
    const vvi_png_strips *strips;
} strips_writing;

static void write_strips(void *user)
{
    static const png_byte idat[5] = "IDAT";
    const strips_writing *writing = user;
    const writer *w = writing->w;
    const vvi_png_strips *s = writing->strips;
    for (size_t i = 0; i < s->n; i++) {
        const size_t head = w->part.first && i == 0 ? sizeof s->head : 0;
        const size_t tail = w->part.last && i + 1 == s->n ? sizeof s->tail : 0;
        png_write_chunk_start(w->png, idat, (png_uint_32)(head + s->strip[i].n_bytes + tail));
        png_write_chunk_data(w->png, s->head, head);
        png_write_chunk_data(w->png, s->strip[i].data, s->strip[i].n_bytes);
        png_write_chunk_data(w->png, s->tail, tail);
        png_write_chunk_end(w->png);
    }
}

static void write_end(void *user)
{
    static const png_byte iend[5] = "IEND";
    png_write_chunk(((const writer *)user)->png, iend, NULL, 0);
}

static void write_head(void *user)
{
    writer *w = user;
    png_set_write_fn(w->png, w, write_bytes, flush_nothing);
    png_set_IHDR(w->png, w->info, (png_uint_32)w->rows->width, (png_uint_32)w->rows->height, w->codes.bits,
                 w->codes.channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(w->png, w->info, PNG_sRGB_INTENT_PERCEPTUAL);
    if (w->options->dpi > 0) {
        const png_uint_32 per_metre = (png_uint_32)lround(w->options->dpi / 0.0254);
        png_set_pHYs(w->png, w->info, per_metre, per_metre, PNG_RESOLUTION_METER);
    }
    if (w->text)
        png_set_text(w->png, w->info, w->text, (int)w->options->n_text);
    png_write_info(w->png, w->info);
}

/* What libpng does; it leaves by a jump where it fails. */
static vv_status with_libpng(writer *w, void (*what)(void *user), void *user)
{
    if (vvi_png_guard(w->png, what, user))
        return VV_OK;
    return w->error.status != VV_OK ? w->error.status
                                    : vv_fail_at(VV_E_WRITE, vvi_sink_name(w->sink), NULL, "libpng: %s", w->error.text);
}

static vv_status write_part(writer *w)
{
    vvi_png_strips strips = {0};
    vv_status st = w->rows->next(w->rows->user, &w->codes.image, w->job);
    if (st != VV_OK)
        return st;
    w->part.first = w->y == 0;
    w->y += w->codes.image->height;
    w->part.last = w->y == w->rows->height;
    if ((st = vvi_png_strips_make(&strips, &w->codes, &w->part, w->job)) == VV_OK)
        st = with_libpng(w, write_strips, &(strips_writing){w, &strips});
    vvi_png_strips_free(&strips);
    return st;
}

static vv_status write_file(writer *w)
{
    w->png = vvi_png_begin_write(&w->error);
    w->info = w->png ? png_create_info_struct(w->png) : NULL;
    vv_status st = w->info ? with_libpng(w, write_head, w) : vv_fail_memory(4096);
    while (st == VV_OK && w->y < w->rows->height)
        st = write_part(w);
    if (st == VV_OK)
        st = with_libpng(w, write_end, w);
    if (st == VV_OK && w->error.refused)
        st = vv_fail_memory(w->error.refused);
    png_destroy_write_struct(&w->png, &w->info);
    return st;
}

/* apart: colours of the rows are not multiplied by alpha. */
static vv_status write_rows(vv_sink *sink, const vv_image_rows *rows, const vv_image_options *options, bool apart,
                            vv_job *job)
{
    vvi_srgb_table table;
    writer w = {.sink = sink, .options = options, .rows = rows, .job = job};
    const vv_image sizes = {.width = rows->width, .height = rows->height};
    vvi_srgb_table_init(&table);
    w.codes = (vvi_codes){
        .image = &sizes,
        .channels = options->alpha && rows->transparent ? 4 : 3,
        .apart = apart,
        .bits = options->bits,
        .table = &table,
    };
    const size_t row = vvi_codes_row_bytes(&w.codes);
    w.part.above = vvi_alloc_zeroed(job, row, VVI_MEM_SCRATCH);
    vv_status st = w.part.above ? prepare_text(&w) : vv_fail_memory(row);
    if (st == VV_OK)
        st = write_file(&w);
    vvi_free(w.part.above);
    vvi_free(w.text);
    return st;
}

vv_status vvi_png_write_rows(vv_sink *sink, const vv_image_rows *rows, const vv_image_options *options, vv_job *job)
{
    return write_rows(sink, rows, options, false, job);
}

static vv_status all_rows(void *user, const vv_image **out, vv_job *job)
{
    (void)job;
    *out = user;
    return VV_OK;
}

static vv_status write_image(vv_sink *sink, const vv_image *image, const vv_image_options *options, bool apart,
                             vv_job *job)
{
    const vv_image_rows rows = {
        .width = image->width,
        .height = image->height,
        .transparent = options->alpha && vvi_image_transparent(image),
        .next = all_rows,
        .user = (void *)image,
    };
    return write_rows(sink, &rows, options, apart, job);
}

vv_status vvi_png_write(vv_sink *sink, const vv_image *image, const vv_image_options *options, vv_job *job)
{
    return write_image(sink, image, options, false, job);
}

vv_status vvi_png_write_straight(vv_sink *sink, const vv_image *image, vv_job *job)
{
    vv_image_options options;
    vv_image_options_init(&options, sizeof options);
    options.bits = 8;
    return write_image(sink, image, &options, true, job);
}
