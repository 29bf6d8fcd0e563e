/** @file
 * Texts of images that the import program reads: docs/decisions/0009-import-program.md.
 */
#ifndef VVI_IO_IMPORT_IMAGE_H
#define VVI_IO_IMPORT_IMAGE_H
#include <volvis/image.h>

/** As vv_image_read_text(), by the import program. */
vv_status vvi_import_image_text(vv_text **out, size_t *n_out, const char *path, vv_job *job);
#endif
