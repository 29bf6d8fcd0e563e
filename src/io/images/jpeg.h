/** @file
 * What the two halves of the JPEG format share.
 */
#ifndef VVI_IO_JPEG_H
#define VVI_IO_JPEG_H
#include "core/status.h"
#include <setjmp.h>
#include <stddef.h>
#include <stdio.h>
#include <volvis/sys/registry.h>

#include <jpeglib.h>

/** libjpeg leaves a failing call by what error_exit does; this jumps, and keeps what it said. `base` stands first. */
typedef struct vvi_jpeg_error {
    struct jpeg_error_mgr base;
    jmp_buf jump;
    vv_status status; /**< of our own reading or writing, whose text is already the thread's error; else VV_OK */
    char text[JMSG_LENGTH_MAX];
} vvi_jpeg_error;

/** Functions that jump; damage that libjpeg would only warn of fails too. */
struct jpeg_error_mgr *vvi_jpeg_error_init(vvi_jpeg_error *error);
/** Runs step(user) and comes back also when libjpeg jumps: false. */
bool vvi_jpeg_guard(vvi_jpeg_error *error, void (*step)(void *user), void *user);
/** From within a callback of libjpeg: leave with a status of our own. */
_Noreturn void vvi_jpeg_leave(j_common_ptr jpeg, vv_status st);

/** Text is kept in comments, "KEY=VALUE" in one, or the rest of a long value in more that begin with "KEY+=". */
#define VVI_JPEG_KEY_MOST 79
/** Of all texts. */
#define VVI_JPEG_TEXT_MOST ((size_t)16 << 20)

/** Whether the n bytes can be a key: letters, digits and the punctuation of names. */
bool vvi_jpeg_is_key(const char *key, size_t n);

vv_status vvi_jpeg_write(vv_sink *sink, const vv_image *image, const vv_image_options *options, vv_job *job);
vv_status vvi_jpeg_read(vv_image **out, vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job);
vv_status vvi_jpeg_read_text(vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job);
#endif
