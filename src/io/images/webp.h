/** @file
 * What the two halves of the WebP format share.
 */
#ifndef VVI_IO_WEBP_H
#define VVI_IO_WEBP_H
#include "core/status.h"
#include <volvis/sys/registry.h>

vv_status vvi_webp_write(vv_sink *sink, const vv_image *image, const vv_image_options *options, vv_job *job);
vv_status vvi_webp_read(vv_image **out, vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job);
vv_status vvi_webp_read_straight(vv_image **out, vv_source *source, vv_job *job);
vv_status vvi_webp_read_text(vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job);
#endif
