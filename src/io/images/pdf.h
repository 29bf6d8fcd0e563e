/** @file
 * PDF: one page with one picture (docs/decisions/0019-pdf.md). It is written; of what is read there are its texts.
 */
#ifndef VVI_IO_PDF_H
#define VVI_IO_PDF_H
#include "core/status.h"
#include <volvis/sys/registry.h>

vv_status vvi_pdf_write(vv_sink *sink, const vv_image *image, const vv_image_options *options, vv_job *job);
/** Of files that VolVis made: of the packet that stands first. */
vv_status vvi_pdf_read_text(vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job);
#endif
