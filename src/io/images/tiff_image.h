/** @file
 * What the two halves of TIFF pictures share. Stacks of samples are a format of volumes (io/formats/tiff/tiff.h), whose
 * directories, strips and codecs these are.
 */
#ifndef VVI_IO_TIFF_IMAGE_H
#define VVI_IO_TIFF_IMAGE_H
#include "core/status.h"
#include <volvis/sys/registry.h>

/** Right after the header, where no reader looks: a picture that VolVis made, by its first bytes, and no volume. */
#define VVI_TIFF_IMAGE_MARK "VolVis picture\0"
enum { VVI_TIFF_IMAGE_MARK_BYTES = 16 };

/** 0: no TIFF; 1: TIFF; 2: a picture that VolVis made. */
int vvi_tiff_image_probe(const uint8_t *head, size_t n, const char *path);
vv_status vvi_tiff_image_write(vv_sink *sink, const vv_image *image, const vv_image_options *options, vv_job *job);
/** The first page, of grey or colours. */
vv_status vvi_tiff_image_read(vv_image **out, vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job);
vv_status vvi_tiff_image_read_straight(vv_image **out, vv_source *source, vv_job *job);
vv_status vvi_tiff_image_read_text(vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job);
#endif
