/** @file
 * What the two halves of the PNG format share.
 */
#ifndef VVI_IO_PNG_H
#define VVI_IO_PNG_H
#include "core/status.h"
#include <png.h>
#include <volvis/sys/registry.h>

/** libpng leaves a failing call by longjmp; this keeps what it said. `status` is VV_OK until something failed. */
typedef struct vvi_png_error {
    vv_status status; /**< of our own reading or writing, or of its memory; its text is already the thread's error */
    char text[160];   /**< libpng's words, when status is VV_OK */
    size_t refused; /**< bytes of memory that it did not get, last; it calls files damaged then, or leaves texts out */
} vvi_png_error;

/** NULL: no memory. */
png_structp vvi_png_begin_write(vvi_png_error *error);
png_structp vvi_png_begin_read(vvi_png_error *error);
/** Runs step(user) and comes back also when libpng jumps: false. */
bool vvi_png_guard(png_structp png, void (*step)(void *user), void *user);

/** Of one text and of all chunks that hold text. */
#define VVI_PNG_TEXT_MOST ((size_t)16 << 20)

vv_status vvi_png_write_rows(vv_sink *sink, const vv_image_rows *rows, const vv_image_options *options, vv_job *job);
vv_status vvi_png_write(vv_sink *sink, const vv_image *image, const vv_image_options *options, vv_job *job);
vv_status vvi_png_read(vv_image **out, vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job);
/** Colours that are not multiplied by alpha: those of alpha 0 too. */
vv_status vvi_png_write_straight(vv_sink *sink, const vv_image *image, vv_job *job);
vv_status vvi_png_read_straight(vv_image **out, vv_source *source, vv_job *job);
vv_status vvi_png_read_text(vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job);
#endif
