/* One slice as PNG: numbers as they are, without a colour space, since samples are no light. */
#include "core/memory.h"
#include "io/formats/slices/slices_write.h"
#include "io/images/png.h"
#include "io/sample_writer.h"

typedef struct encoding {
    png_structp png;
    png_infop info;
    vv_sink *sink;
    const uint8_t *samples;
    const vv_field_info *about;
    vvi_png_error error;
} encoding;

static void write_bytes(png_structp png, png_bytep data, size_t n)
{
    encoding *e = png_get_io_ptr(png);
    if ((e->error.status = vvi_sink_write(e->sink, data, n)) != VV_OK)
        png_error(png, "write");
}

static void flush_nothing(png_structp png)
{
    (void)png;
}

static void write_all(void *user)
{
    encoding *e = user;
    const vv_field_info *about = e->about;
    const size_t row = (size_t)about->grid.dims[0] * (size_t)about->components * vv_type_bytes(about->type);
    const bool wide = about->type == VV_TYPE_U16;
    png_set_write_fn(e->png, e, write_bytes, flush_nothing);
    png_set_user_limits(e->png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    png_set_IHDR(e->png, e->info, (png_uint_32)about->grid.dims[0], (png_uint_32)about->grid.dims[1], wide ? 16 : 8,
                 about->components == 4   ? PNG_COLOR_TYPE_RGB_ALPHA
                 : about->components == 3 ? PNG_COLOR_TYPE_RGB
                                          : PNG_COLOR_TYPE_GRAY,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(e->png, e->info);
    if (wide && vvi_order_swapped(true))
        png_set_swap(e->png);
    for (int64_t y = 0; y < about->grid.dims[1]; y++)
        png_write_row(e->png, e->samples + (size_t)y * row);
    png_write_end(e->png, e->info);
}

vv_status vvi_slices_encode_png(uint8_t **out, size_t *n_out, const uint8_t *samples, const vv_field_info *info,
                                const char *name, vv_job *job)
{
    encoding e = {.samples = samples, .about = info};
    *out = NULL;
    *n_out = 0;
    vv_status st = vvi_sink_open_memory(&e.sink, name, job);
    if (st != VV_OK)
        return st;
    e.png = vvi_png_begin_write(&e.error);
    e.info = e.png ? png_create_info_struct(e.png) : NULL;
    if (!e.info)
        st = vv_fail_memory(4096);
    else if (!vvi_png_guard(e.png, write_all, &e))
        st = e.error.status != VV_OK ? e.error.status : vv_fail_at(VV_E_WRITE, name, NULL, "libpng: %s", e.error.text);
    png_destroy_write_struct(&e.png, &e.info);
    if (st == VV_OK)
        return vvi_sink_take(out, n_out, e.sink);
    vvi_sink_abandon(e.sink);
    return st;
}
