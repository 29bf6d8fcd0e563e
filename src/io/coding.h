/** @file
 * Stream codings behind one face each way: gzip, bzip2, zstd, zlib (deflate in the thinner of its two wrappers).
 */
#ifndef VVI_IO_CODING_H
#define VVI_IO_CODING_H
#include "io/source.h"

/** What is left of the input and of the output of one step. */
typedef struct vvi_coding_step {
    const uint8_t *in;
    size_t n_in;
    uint8_t *out;
    size_t n_out;
} vvi_coding_step;

/** "gzip", "bzip2", "zstd", "zlib", "raw". */
const char *vvi_coding_name(vvi_coding coding);
/** The coding whose magic a file begins with; VVI_CODING_NONE when it is none of them. */
vvi_coding vvi_coding_of(const uint8_t *head, size_t n);
/** VV_E_UNSUPPORTED when this build has no such library. */
vv_status vvi_coding_available(vvi_coding coding);

/** Whether a decoder of it can be copied where it stands. */
bool vvi_coding_copies(vvi_coding coding);

typedef struct vvi_decoder vvi_decoder;
vv_status vvi_decoder_new(vvi_decoder **out, vvi_coding coding, vv_job *job);
/** Advances the step. *member_end: the coded stream ended; what follows, if anything, is another or does not matter.
 * NULL, or what is wrong with the data. */
const char *vvi_decoder_run(vvi_decoder *decoder, vvi_coding_step *step, bool *member_end);
/** A second one that stands where the first does and goes on by itself. *out NULL with VV_OK: vvi_coding_copies() says
 * that this is not to be had. */
vv_status vvi_decoder_copy(vvi_decoder **out, vvi_decoder *decoder, vv_job *job);
/** Ready for another stream. False: no memory. */
bool vvi_decoder_reset(vvi_decoder *decoder);
void vvi_decoder_free(vvi_decoder *decoder); /* NULL is fine */

typedef struct vvi_encoder vvi_encoder;
/** level 0: the default. */
vv_status vvi_encoder_new(vvi_encoder **out, vvi_coding coding, int level, vv_job *job);
/** Advances the step; with `finish` the stream is ended: *done when nothing is left inside. False: failed. */
bool vvi_encoder_run(vvi_encoder *encoder, vvi_coding_step *step, bool finish, bool *done);
void vvi_encoder_free(vvi_encoder *encoder); /* NULL is fine */
#endif
