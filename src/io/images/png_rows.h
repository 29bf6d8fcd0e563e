/** @file
 * Pixels to filtered, deflated PNG rows: strips of an image, each by itself, so that they can be made in parallel, and
 * which together are one zlib stream. PDF has the same.
 */
#ifndef VVI_IO_PNG_ROWS_H
#define VVI_IO_PNG_ROWS_H
#include "core/status.h"
#include "io/images/image_codes.h"

/** One strip of a zlib stream: raw deflate that ends on a byte, and the checksum of what it holds. */
typedef struct vvi_png_strip {
    uint8_t *data;
    size_t n_bytes, n_raw;
    uint32_t adler;
} vvi_png_strip;

/** A whole image: the stream is head, all strips, tail. */
typedef struct vvi_png_strips {
    vvi_png_strip *strip;
    size_t n;
    int32_t rows; /**< of each but the last */
    uint8_t head[2], tail[4];
    size_t n_bytes; /**< of the stream */
} vvi_png_strips;

/** Which part of a picture an image is. The stream is all parts in order: the first one's head, the strips of all, the
 * last one's tail. */
typedef struct vvi_png_part {
    bool first, last;
    uint8_t *above; /**< codes of the row above the first one, zeros where there is none; becomes the last row's */
    uint32_t adler; /**< of the parts before; becomes that with this one */
} vvi_png_part;

/** part: NULL: it is all of it. Free with vvi_png_strips_free(), also when it fails. */
vv_status vvi_png_strips_make(vvi_png_strips *out, const vvi_codes *codes, vvi_png_part *part, vv_job *job);
void vvi_png_strips_free(vvi_png_strips *strips);
#endif
