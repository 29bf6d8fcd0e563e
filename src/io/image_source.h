/** @file
 * Images out of other files than their own.
 */
#ifndef VVI_IO_IMAGE_SOURCE_H
#define VVI_IO_IMAGE_SOURCE_H
#include "core/status.h"
#include "io/source.h"
#include <volvis/image.h>

/** The image of a source that is open, in this process; it stays open. vv_image.rgba is not multiplied by alpha:
 * colours are as the file has them, also where alpha is 0, if its format keeps them there. VV_E_FORMAT: of no known
 * format, or damaged; VV_E_UNSUPPORTED. */
vv_status vvi_image_read_straight(vv_image **out, vv_source *source, vv_job *job);
#endif
