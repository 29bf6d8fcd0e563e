/** @file
 * Images that the import program reads: docs/decisions/0009-import-program.md.
 */
#ifndef VVI_IMPORT_IMAGE_H
#define VVI_IMPORT_IMAGE_H
#include <volvis/image.h>

/** Where in shared memory the pixels of an image and each of its layers begin, one after the other. */
typedef struct vvi_image_room {
    uint64_t rgba, layer[VV_LAYER_COUNT], end;
} vvi_image_room;

vvi_image_room vvi_image_room_of(int64_t width, int64_t height, unsigned layers);

/** As vv_image_read(), by the import program, and without texts. */
vv_status vvi_import_image(vv_image **out, const char *path, vv_job *job);
/** As vv_image_read_text(), by the import program. */
vv_status vvi_import_image_text(vv_text **out, size_t *n_out, const char *path, vv_job *job);
#endif
