/** @file
 * glTF 2.0 (Khronos, ISO/IEC 12113): JSON that describes buffers of numbers, in text with a file or base64 beside it
 * (.gltf), or in one binary file (.glb). Lengths there are metres, and y is up.
 */
#ifndef VVI_IO_GLTF_H
#define VVI_IO_GLTF_H
#include "io/meshes/mesh_builder.h"
#include <jansson.h>

enum { VVI_GLB_MAGIC = 0x46546c67, VVI_GLB_JSON = 0x4e4f534a, VVI_GLB_BIN = 0x004e4942 };

/** A place in metres, y up, of one in VolVis' axes: x, z, -y; and back. */
extern const vv_affine vvi_gltf_to_volvis;

/** An open file. */
typedef struct vvi_gltf {
    const char *file; /**< stands in errors */
    json_t *root;
    vv_source *source;
    uint8_t **buffer; /**< bytes of each buffer, NULL while nobody asked */
    uint64_t *n_bytes;
    size_t n_buffers;
    uint64_t json_bytes;
    uint64_t bin, n_bin; /**< of a .glb's own buffer: where it lies, how many bytes */
    vv_job *job;
} vvi_gltf;

/** JSON and where the buffers are. Errors as of vv_mesh_read(). Finish it in any case. */
vv_status vvi_gltf_open(vvi_gltf *out, vv_source *source, vv_job *job);
void vvi_gltf_finish(vvi_gltf *gltf);
/** Names what is wrong: VV_E_FORMAT. */
vv_status vvi_gltf_fail(const vvi_gltf *gltf, const char *format, ...) VV_PRINTF(2, 3);
/** An index at a key that is below the size of a list; false where there is no key. */
vv_status vvi_gltf_index(const vvi_gltf *gltf, const json_t *object, const char *key, size_t n, size_t *out,
                         bool *there);

/** n finite numbers at a key; false: they are not. */
bool vvi_gltf_numbers_at(double *out, size_t n, const json_t *object, const char *key);

/** Numbers of an accessor. */
typedef struct vvi_gltf_numbers {
    double *v; /**< n times `components`; yours to vvi_free() */
    size_t n;
    int components;
} vvi_gltf_numbers;

/** How many numbers an accessor has; it is checked, and its buffer is there afterwards. */
vv_status vvi_gltf_count_accessor(size_t *out, vvi_gltf *gltf, size_t index, int least, int most);
/** How many bytes the JSON and the buffers have that somebody asked for. */
uint64_t vvi_gltf_count_bytes(const vvi_gltf *gltf);
/** Normalized integers become 0 .. 1 or -1 .. 1; sparse ones are filled in. The whole is checked against its buffer
 * before memory is taken. */
vv_status vvi_gltf_read_accessor(vvi_gltf_numbers *out, vvi_gltf *gltf, size_t index, int least, int most);

/** The bytes of a buffer view, or of base64, that an object ("images") has. `owned`: vvi_free(). */
typedef struct vvi_gltf_bytes {
    const uint8_t *at;
    size_t n;
    uint8_t *owned;
} vvi_gltf_bytes;
vv_status vvi_gltf_read_bytes(vvi_gltf_bytes *out, vvi_gltf *gltf, const json_t *object);
/** The name of a file: %20 is a blank. False: it is none, or of another machine. */
bool vvi_gltf_decode_uri(char out[1024], const char *uri);

vv_status vvi_gltf_write(vv_sink *sink, const vv_mesh *mesh, const vv_mesh_write_options *options, vv_job *job);
vv_status vvi_glb_write(vv_sink *sink, const vv_mesh *mesh, const vv_mesh_write_options *options, vv_job *job);
#endif
