/** @file
 * A whole file in memory, for libraries that go back and forth in it.
 */
#ifndef VVI_IO_IMAGE_BYTES_H
#define VVI_IO_IMAGE_BYTES_H
#include "io/source.h"

/** Everything that the source still has; for vvi_free(). */
vv_status vvi_image_bytes(uint8_t **out, size_t *n_out, vv_source *source, vv_job *job);
#endif
