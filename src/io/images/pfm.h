/** @file
 * PFM: three or one 32-bit floats a pixel, nothing else. Also the file that a layer becomes beside an image.
 */
#ifndef VVI_IO_PFM_H
#define VVI_IO_PFM_H
#include <volvis/sys/registry.h>

/** One layer of an image, by number; whole numbers become floats, which are exact to 2^24. */
vv_status vvi_pfm_write_layer(vv_sink *sink, const vv_image *image, size_t index, vv_job *job);
#endif
