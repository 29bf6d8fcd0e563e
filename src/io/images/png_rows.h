/** @file
 * Pixels to filtered, deflated PNG rows: strips of an image, each by itself, so that they can be made in parallel.
 */
#ifndef VVI_IO_PNG_ROWS_H
#define VVI_IO_PNG_ROWS_H
#include "core/status.h"
#include "io/images/image_srgb.h"

/** How pixels become bytes. */
typedef struct vvi_png_rows {
    const vv_image *image;
    int channels; /**< 3: opaque; 4: with alpha, not premultiplied */
    int bits;     /**< 8 or 16 */
    const vvi_srgb_table *table;
} vvi_png_rows;

/** One strip of a zlib stream: raw deflate that ends on a byte, and the checksum of what it holds. */
typedef struct vvi_png_strip {
    uint8_t *data;
    size_t n_bytes, n_raw;
    uint32_t adler;
} vvi_png_strip;

size_t vvi_png_row_bytes(const vvi_png_rows *rows);
/** Rows [y0, y1); `last` ends the deflate stream. data is for vvi_free(). */
vv_status vvi_png_strip_make(vvi_png_strip *out, const vvi_png_rows *rows, int32_t y0, int32_t y1, bool last,
                             vv_job *job);
#endif
