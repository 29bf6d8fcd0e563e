/** @file
 * Rows of pixels as 8- and 16-bit codes of the sRGB curve, as files hold them.
 */
#ifndef VVI_IO_IMAGE_CODES_H
#define VVI_IO_IMAGE_CODES_H
#include "image/image_srgb.h"

/** How pixels become bytes. */
typedef struct vvi_codes {
    const vv_image *image;
    int channels;  /**< 3: colours; 4: with alpha; 1: alpha alone */
    bool straight; /**< 3: colours are not multiplied by alpha. 4 always are so */
    bool apart;    /**< the image's own colours are not multiplied by alpha */
    int bits;      /**< 8 or 16: two bytes, the high one first */
    const vvi_srgb_table *table;
} vvi_codes;

size_t vvi_codes_row_bytes(const vvi_codes *codes);
void vvi_codes_row(uint8_t *out, const vvi_codes *codes, int32_t y);
#endif
