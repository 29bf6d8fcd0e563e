/** @file
 * Smooth closed surfaces around the labels of a segmentation, which share their borders.
 *
 * Each label has an indicator, 1 where it is and 0 elsewhere, smoothed by the difference of two
 * Gaussians that does not shrink what is curved, as one alone would. The surface of label i is where
 * its indicator less the largest of all others' is 0: where two labels meet, both have the same surface, turned over,
 * and nothing is left between them. What lies outside the volume belongs to no label, so that surfaces close half a
 * voxel beyond the outermost samples.
 */
#ifndef VVI_SURFACE_LABELS_H
#define VVI_SURFACE_LABELS_H
#include "core/status.h"
#include <volvis/field.h>
#include <volvis/mesh.h>
#include <volvis/sys/registry.h>

typedef struct vvi_labels_options {
    const vv_label_id *labels; /**< n_labels of them, in the order of the parts; NULL: all but the background */
    const vv_mesh_part *parts; /**< their names ("": "label 7") and colours; NULL: none */
    size_t n_labels;
    vv_label_id background; /**< the label that is none */
    double smoothing; /**< standard deviation, in voxels of each axis, 0 to 8; 0: a surface of steps. 1 is usual */
    bool no_normals;
    /** Name and colour of a label, in the place of `parts`, or NULL. False: without `labels`, it is left out. */
    vv_label_look *look;
    void *look_user;
} vvi_labels_options;

/**
 * A mesh with a part for each label.
 *
 * Errors   VV_E_ARGUMENT (smoothing, component), VV_E_NOT_FOUND (a label that is not there), VV_E_UNSUPPORTED (samples
 *          that are no integers), VV_E_LIMIT (more than 65535 labels), VV_E_MEMORY, VV_E_READ, VV_E_CANCELLED
 * Owns     *out is the caller's
 * Memory   2 bytes a voxel, 16 for each voxel near a border, and 2 for each in the box of one label at a time
 * Threads  same bytes for any thread count
 */
vv_status vvi_label_surfaces(vv_mesh **out, const vv_field *field, int component, const vvi_labels_options *options,
                             vv_job *job);
#endif
