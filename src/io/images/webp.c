/* WebP: the row of the table. */
#include "io/images/webp.h"

#include "registry.h"

#include <string.h>
#include <webp/encode.h>

static int probe(const uint8_t *head, size_t n, const char *path)
{
    (void)path;
    return n >= 12 && memcmp(head, "RIFF", 4) == 0 && memcmp(head + 8, "WEBP", 4) == 0 ? 2 : 0;
}

static const char *const suffixes[] = {".webp", NULL};
static const int bits[] = {8, 0};

const vv_image_format vvi_image_format_webp = {
    .api = VV_IMAGE_FORMAT_API,
    .name = "webp",
    .doc = "WebP with transparency and text; sRGB, lossless unless a quality is given",
    .suffixes = suffixes,
    .probe = probe,
    .write = vvi_webp_write,
    .read = vvi_webp_read,
    .read_straight = vvi_webp_read_straight,
    .read_text = vvi_webp_read_text,
    .bits = bits,
    .lossy = true,
    .side_most = WEBP_MAX_DIMENSION,
};
