/** @file
 * How labels look: as their file says, else in the colours of pictures.
 */
#ifndef VVI_RUN_LABEL_LOOK_H
#define VVI_RUN_LABEL_LOOK_H
#include <volvis/sys/registry.h>

typedef struct vvi_file_labels {
    const vv_label *label; /**< n of them, of vv_file_labels() */
    size_t n;
} vvi_file_labels;

/** A vv_label_look; user: vvi_file_labels. */
bool vvi_label_look_of_file(vv_mesh_part *part, vv_label_id label, bool is_unsigned, void *user);
#endif
