/** @file
 * What a picture has gathered, as a file: a header of fixed size, the arrays of its stage as they lie in memory, their
 * CRC-32. Which arrays there are, and how large, follows from the scene and the stage alone.
 */
#ifndef VVI_RENDER_CHECKPOINT_H
#define VVI_RENDER_CHECKPOINT_H
#include "io/source.h"
#include "render/picture.h"

enum { VVI_CHECKPOINT_HEADER = 128 };

/** *out: what is in the file, for a picture of that scene which depends on `depends`; vvi_gathered_finish(). On failure
 * it is empty. */
vv_status vvi_checkpoint_read(vvi_gathered *out, vv_source *source, const vv_scene *scene, uint64_t depends,
                              vv_job *job);
/** The header's and the arrays' checksums made right, for tests that change a file of n bytes. */
void vvi_checkpoint_sign(uint8_t *file, size_t n);
#endif
