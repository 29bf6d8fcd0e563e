/** @file
 * What a picture depends on, as one number.
 */
#ifndef VVI_RENDER_PICTURE_DEPENDS_H
#define VVI_RENDER_PICTURE_DEPENDS_H
#include "render/picture.h"

/** Of what pictures gather, and in which order rays are cast: goes up when bytes of the same scene change. */
enum { VVI_PICTURE_VERSION = 1 };

/** A hash of all that decides the bytes of its light: the part of the World that its view shows, its data, the renderer
 * and the version of the program; not what only people read, what is drawn over it, nor threads. lasting: data count by
 * their samples, so that it means the same in every process, which costs reading them once; else by identity. Fails
 * where samples cannot be read. */
vv_status vvi_picture_depends(uint64_t *out, const vv_picture *picture, bool lasting, vv_job *job);
#endif
