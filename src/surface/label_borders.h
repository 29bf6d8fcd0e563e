/** @file
 * The smoothed indicators of labels, near their borders; elsewhere one is 1 and all others are 0.
 */
#ifndef VVI_SURFACE_LABEL_BORDERS_H
#define VVI_SURFACE_LABEL_BORDERS_H
#include "surface/label_map.h"

enum { VVI_LABEL_ONE = 32767, VVI_LABELS_KEPT = 3 };

/** The labels with the largest indicators at a voxel, the largest first; VVI_LABEL_ONE is 1. */
typedef struct vvi_label_voxel {
    int32_t x;
    uint16_t label[VVI_LABELS_KEPT], weight[VVI_LABELS_KEPT];
} vvi_label_voxel;

/** Voxels of one slice by y, x. */
typedef struct vvi_label_slice {
    vvi_label_voxel *voxels;
    uint32_t *first; /**< by row, and the end */
    size_t n, room;
} vvi_label_slice;

typedef struct vvi_label_borders {
    int radius; /**< voxels that the smoothing reaches: its Gaussians are cut off at 2.5 standard deviations */
    vvi_label_slice *slices;
    int64_t n_slices;
} vvi_label_borders;

/** Errors: VV_E_MEMORY, VV_E_CANCELLED. Owns: vvi_label_borders_finish(); zeroed on failure. `deviation`: 0 to 8. */
vv_status vvi_label_borders_init(vvi_label_borders *out, const vvi_label_map *map, double deviation);
void vvi_label_borders_finish(vvi_label_borders *borders); /* zeroed is fine */
#endif
