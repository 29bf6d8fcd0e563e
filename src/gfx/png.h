/** @file
 * An image inside a document.
 */
#ifndef VVI_GFX_PNG_H
#define VVI_GFX_PNG_H
#include "core/status.h"
#include "core/text.h"
#include <volvis/image.h>

/** Adds the image as a PNG file, 8 bits a channel, in base 64. */
vv_status vvi_gfx_png_base64(vvi_text *out, const vv_image *image, vv_job *job);
#endif
