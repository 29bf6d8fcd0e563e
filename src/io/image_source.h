/** @file
 * Images out of other files than their own.
 */
#ifndef VVI_IO_IMAGE_SOURCE_H
#define VVI_IO_IMAGE_SOURCE_H
#include "core/status.h"
#include "io/source.h"
#include <volvis/image.h>

/** vv_image_read() of a source that is open, in this process; it stays open. text_out may be NULL. VV_E_FORMAT: of no
 * known format, or damaged; VV_E_UNSUPPORTED. */
vv_status vvi_image_read_source(vv_image **out, vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job);
#endif
