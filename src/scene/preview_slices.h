/** @file
 * Three slices through the middle of a volume, as colours for a screen.
 */
#ifndef VVI_SCENE_PREVIEW_SLICES_H
#define VVI_SCENE_PREVIEW_SLICES_H
#include "grid/slice_axes.h"
#include <volvis/file.h>

/** One slice; row 0 is the top. */
typedef struct vvi_preview_slice {
    int64_t n[2];   /**< samples across and down; of very many every k-th is taken */
    double step[2]; /**< world lengths between them */
    float *rgb;     /**< n[0] * n[1] * 3, as a screen has them, 0..1 */
    bool nearest;   /**< labels: never interpolated */
} vvi_preview_slice;

/**
 * Axial, coronal and sagittal as a radiologist looks at them (from the feet, the front and the left) where the space is
 * anatomical, else xy, xz and yz; of flat data the one that there is. Scalars are grey from the 1st to the 99.8th
 * percentile of what is seen, or over their channel's window; channels add up in their colours; labels have theirs.
 *
 * Reads three slabs, or all samples of what is small or mapped; field: all samples, where they
 * are there already, else NULL. pixels: the longer side of the picture that all of them are for. Finish the slices with
 * vvi_preview_slices_finish(), also after a failure.
 */
vv_status vvi_preview_slices_read(vvi_preview_slice out[VVI_SLICE_WAYS], int *n_out, vv_file *file,
                                  const vv_field *field, int64_t frame, int pixels, vv_job *job);
void vvi_preview_slices_finish(vvi_preview_slice slices[VVI_SLICE_WAYS]);
#endif
