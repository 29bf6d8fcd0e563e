/** @file
 * What the two halves of the OpenEXR format share: the C library of OpenEXR on memory instead of files.
 */
#ifndef VVI_IO_EXR_H
#define VVI_IO_EXR_H
#include "core/status.h"
#include <openexr.h>
#include <volvis/sys/registry.h>

/** A file in memory: the library goes back and forth in it, which sources and sinks cannot. */
typedef struct vvi_exr_file {
    uint8_t *data;
    size_t n, room;
    vv_job *job;
    vv_status status; /**< of our own memory, whose text is already the thread's error; else VV_OK */
    size_t refused;   /**< bytes that the library could not have; else 0 */
    char text[256];   /**< the library's words for its first failure */
} vvi_exr_file;

/** Reading, writing, memory and errors by `file`, which is freed by vvi_exr_file_finish(). */
exr_context_initializer_t vvi_exr_initializer(vvi_exr_file *file);
void vvi_exr_file_finish(vvi_exr_file *file);

/** What a channel is: numbers of the picture's colours or of one of its layers. */
typedef struct vvi_exr_channel {
    const char *name;
    int layer;     /**< number of the layer; -1: colours */
    size_t number; /**< which of a pixel's */
} vvi_exr_channel;
/** NULL ends it. */
extern const vvi_exr_channel vvi_exr_channels[];

vv_status vvi_exr_write(vv_sink *sink, const vv_image *image, const vv_image_options *options, vv_job *job);
vv_status vvi_exr_read(vv_image **out, vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job);
vv_status vvi_exr_read_text(vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job);
#endif
