/** @file
 * Bytes of one array of VTK's XML files, plain or in base64.
 */
#ifndef VVI_IO_VTK_STREAM_H
#define VVI_IO_VTK_STREAM_H
#include "io/formats/vtk/vtk_xml.h"

typedef struct vvi_vtk_stream {
    const char *name; /* of the file; in errors */
    const vvi_vtk_array *array;
    vv_source *source;
} vvi_vtk_stream;

/** Bytes [from, from + n) of what begins at byte `begin` of the file; fewer where the array or the file ends. */
vv_status vvi_vtk_stream_read(const vvi_vtk_stream *stream, uint64_t begin, uint64_t from, void *out, size_t n,
                              size_t *n_got);
/** Characters or bytes of the file that n bytes take. */
uint64_t vvi_vtk_stream_length(const vvi_vtk_array *array, uint64_t n);
#endif
