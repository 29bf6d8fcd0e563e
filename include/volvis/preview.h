/** @file
 * Small pictures of data files, without a World: slices side by side.
 */
#ifndef VOLVIS_PREVIEW_H
#define VOLVIS_PREVIEW_H
#include <volvis/file.h>
#include <volvis/image.h>
VV_BEGIN_DECLS

#define VV_PREVIEW_SIDE_MOST 16384

/** Options of vv_preview_new(). Fill with vv_preview_options_init(), then change what you need. */
typedef struct vv_preview_options {
    size_t size;           /**< set by init */
    int64_t frame;         /**< time step; default 0 */
    const vv_field *field; /**< all of its samples, where they are at hand; default NULL: they are read */
    int width, height;     /**< pixels, at most; default 1024 x 512 */
    bool exact;            /**< the picture has that size; default: it is as small as its slices */
    double aspect;         /**< height of a pixel by its width; default 1; in letters it is another */
    int detail; /**< samples that are looked at along the longer side, about; default 0: as many as it has pixels */
} vv_preview_options;

VV_API void vv_preview_options_init(vv_preview_options *options, size_t size);

/**
 * Three slices through the middle: axial, coronal and sagittal as a radiologist looks at them (from the feet, the front
 * and the left) where the space is anatomical, else xy, xz and yz; of flat data the one that there is. All of them at
 * one scale, on black. Scalars are grey from the 1st to the 99.8th percentile of what is seen, or over their channel's
 * window, and blue and red where zero is their middle; channels add up in their colours; labels have theirs. Only these
 * slices are read where the format allows that, or all samples of what is small.
 *
 * options  NULL: the defaults
 * Errors   VV_E_ARGUMENT (sizes), VV_E_READ, VV_E_FORMAT, VV_E_MEMORY, VV_E_CANCELLED
 * Owns     *out is new and yours
 */
VV_API vv_status vv_preview_new(vv_image **out, vv_file *file, const vv_preview_options *options, vv_job *job);

VV_END_DECLS
#endif
