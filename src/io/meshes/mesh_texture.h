/** @file
 * Images that mesh files name or hold, read into a mesh and written beside it.
 */
#ifndef VVI_IO_MESH_TEXTURE_H
#define VVI_IO_MESH_TEXTURE_H
#include "io/meshes/mesh_builder.h"

/** What the alpha of an image means. */
typedef enum vvi_texture_alpha {
    VVI_TEXTURE_OPAQUE, /**< nothing */
    VVI_TEXTURE_MASK,   /**< below `cutoff` nothing is there, else all */
    VVI_TEXTURE_BLEND   /**< opacity */
} vvi_texture_alpha;

/** How an image is to be used. */
typedef struct vvi_texture_use {
    int wrap[2]; /**< vv_texture_wrap */
    vvi_texture_alpha alpha;
    double cutoff;
} vvi_texture_use;

/** One more texture of the mesh, by the content of a source, which stays open. *texture_out: as in vv_mesh_part; 0 and
 * a warning where it is no image that can be read. Errors: VV_E_MEMORY, VV_E_LIMIT, VV_E_CANCELLED, VV_E_READ. */
vv_status vvi_mesh_texture_read(size_t *texture_out, vvi_mesh_builder *b, vv_source *source, const char *name,
                                const vvi_texture_use *use, vv_notes *notes);
/** The same of a file beside the mesh's. One that is not there, or may not be read, is a warning. Where it is named by
 * the place that it had on another machine, the name alone is looked for. */
vv_status vvi_mesh_texture_find(size_t *texture_out, vvi_mesh_builder *b, const char *name, const vvi_texture_use *use,
                                vv_notes *notes);

/** The bytes of a PNG file of a texture; vv_image_bytes_free(). */
vv_status vvi_mesh_texture_encode(uint8_t **out, size_t *n_out, const vv_mesh_texture *texture, vv_job *job);
/** Such a file beside `sink`, which is called after its file and the number of the texture. */
vv_status vvi_mesh_texture_write(vv_sink *sink, const vv_mesh_info *mesh, size_t index, vv_job *job);
/** Warns where images go on beyond their borders as a format cannot say, which repeats them; clamp: it can say that. */
void vvi_mesh_texture_warn(const vv_sink *sink, const vv_mesh_info *mesh, bool clamp, const char *format,
                           const vv_job *job);
/** That name; yours to free(). */
char *vvi_mesh_texture_name(const vv_sink *sink, size_t index);
#endif
