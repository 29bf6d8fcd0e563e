#include "gfx/png.h"
#include "core/memory.h"
#include "image/image_srgb.h"
#include <png.h>

static void base64(vvi_text *out, const uint8_t *data, size_t n)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < n; i += 3) {
        const uint32_t word = (uint32_t)data[i] << 16 | (uint32_t)(i + 1 < n ? data[i + 1] : 0) << 8 |
                              (uint32_t)(i + 2 < n ? data[i + 2] : 0);
        const char four[4] = {digits[word >> 18], digits[word >> 12 & 63], i + 1 < n ? digits[word >> 6 & 63] : '=',
                              i + 2 < n ? digits[word & 63] : '='};
        vvi_text_add_n(out, four, 4);
    }
}

static vv_status write_pixels(vvi_text *out, const vv_image *image, const uint8_t *pixels, vv_job *job)
{
    png_image png = {.version = PNG_IMAGE_VERSION,
                     .width = (png_uint_32)image->width,
                     .height = (png_uint_32)image->height,
                     .format = PNG_FORMAT_RGBA};
    png_alloc_size_t n = PNG_IMAGE_PNG_SIZE_MAX(png);
    uint8_t *file = vvi_alloc(job, n, VVI_MEM_SCRATCH);
    if (!file)
        return vv_fail_memory(n);
    const bool fine = png_image_write_to_memory(&png, file, &n, 0, pixels, 0, NULL);
    if (fine)
        base64(out, file, n);
    vvi_free(file);
    return fine ? VV_OK : vv_fail(VV_E_INTERNAL, "a picture inside a figure cannot be written: %s", png.message);
}

vv_status vvi_gfx_png_base64(vvi_text *out, const vv_image *image, vv_job *job)
{
    const size_t n = (size_t)image->width * (size_t)image->height;
    vvi_srgb_table table;
    uint8_t *pixels = vvi_alloc(job, 4 * n, VVI_MEM_SCRATCH);
    if (!pixels)
        return vv_fail_memory(4 * n);
    vvi_srgb_table_init(&table);
    for (size_t i = 0; i < n; i++)
        vvi_srgb_pixel(pixels + 4 * i, &table, image->rgba + 4 * i);
    const vv_status st = write_pixels(out, image, pixels, job);
    vvi_free(pixels);
    return st;
}
