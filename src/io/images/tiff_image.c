/* TIFF pictures: the row of the table, and how they are told from volumes. */
#include "io/images/tiff_image.h"

#include "registry.h"

#include <string.h>

int vvi_tiff_image_probe(const uint8_t *head, size_t n, const char *path)
{
    static const uint8_t starts[4][4] = {{'I', 'I', 42, 0}, {'M', 'M', 0, 42}, {'I', 'I', 43, 0}, {'M', 'M', 0, 43}};
    (void)path;
    for (size_t i = 0; i < 4 && n >= 8; i++) {
        const size_t at = i < 2 ? 8 : 16; /* offsets of BigTIFF are longer */
        if (memcmp(head, starts[i], 4) == 0)
            return n >= at + VVI_TIFF_IMAGE_MARK_BYTES &&
                           memcmp(head + at, VVI_TIFF_IMAGE_MARK, VVI_TIFF_IMAGE_MARK_BYTES) == 0
                       ? 2
                       : 1;
    }
    return 0;
}

static const char *const suffixes[] = {".tif", ".tiff", NULL};
static const int bits[] = {8, 16, 32, 0};

const vv_image_format vvi_image_format_tiff = {
    .api = VV_IMAGE_FORMAT_API,
    .name = "tiff",
    .doc = "TIFF with 8 or 16 bits per channel (sRGB) or 32-bit floats (linear, premultiplied), transparency and text",
    .suffixes = suffixes,
    .probe = vvi_tiff_image_probe,
    .write = vvi_tiff_image_write,
    .read = vvi_tiff_image_read,
    .read_straight = vvi_tiff_image_read_straight,
    .read_text = vvi_tiff_image_read_text,
    .bits = bits,
    .paper = true,
};
