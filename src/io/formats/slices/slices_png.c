/* A PNG file in memory to samples as they are stored: grey, colours or colours with alpha, of 8 or 16 bits. */
#include "io/formats/tiff/tiff.h"
#include "io/images/png.h"
#include "io/sample_writer.h"
#include <stdio.h>
#include <string.h>

typedef struct decoding {
    png_structp png;
    png_infop info;
    const uint8_t *coded;
    size_t n, at;
    uint8_t *out;
    size_t n_out, row_bytes;
    const vvi_tiff_page *page;
    bool fits;
} decoding;

static void feed(png_structp png, png_bytep out, size_t n)
{
    decoding *d = png_get_io_ptr(png);
    if (n > d->n - d->at)
        png_error(png, "it ends too early");
    memcpy(out, d->coded + d->at, n);
    d->at += n;
}

static void read_head(void *user)
{
    decoding *d = user;
    png_read_info(d->png, d->info);
    const int type = png_get_color_type(d->png, d->info);
    if (type == PNG_COLOR_TYPE_PALETTE)
        png_set_palette_to_rgb(d->png);
    else
        png_set_packing(d->png); /* fewer than 8 bits: the numbers as they are */
    if (type == PNG_COLOR_TYPE_GRAY_ALPHA || type == PNG_COLOR_TYPE_PALETTE)
        png_set_strip_alpha(d->png);
    if (!vvi_order_swapped(false) && png_get_bit_depth(d->png, d->info) == 16)
        png_set_swap(d->png);
    const int passes = png_set_interlace_handling(d->png);
    png_read_update_info(d->png, d->info);
    d->row_bytes = png_get_rowbytes(d->png, d->info);
    d->fits = png_get_image_width(d->png, d->info) == d->page->width &&
              png_get_image_height(d->png, d->info) == d->page->height && d->row_bytes * d->page->height == d->n_out;
    for (int p = 0; p < passes && d->fits; p++)
        for (uint32_t y = 0; y < d->page->height; y++)
            png_read_row(d->png, d->out + y * d->row_bytes, NULL);
}

bool vvi_slices_decode_png(void *out, size_t n_out, const vvi_tiff_page *page, const uint8_t *coded, size_t n,
                           char *why, size_t n_why)
{
    vvi_png_error error = {0};
    decoding d = {.coded = coded, .n = n, .out = out, .n_out = n_out, .page = page};
    d.png = vvi_png_begin_read(&error);
    d.info = d.png ? png_create_info_struct(d.png) : NULL;
    bool good = false;
    if (d.info) {
        png_set_read_fn(d.png, &d, feed);
        png_set_chunk_malloc_max(d.png, VVI_PNG_TEXT_MOST);
        png_set_user_limits(d.png, page->width, page->height);
        good = vvi_png_guard(d.png, read_head, &d) && d.fits;
        if (!good)
            snprintf(why, n_why, "%.60s", error.text[0] ? error.text : "its header changes");
    }
    png_destroy_read_struct(&d.png, &d.info, NULL);
    return good;
}
