/** @file
 * Many rays per pixel: what pixel_rays.c and noise.c share.
 */
#ifndef VVI_RENDER_PIXEL_RAYS_H
#define VVI_RENDER_PIXEL_RAYS_H
#include "render/picture.h"

enum { VVI_BLOCK = 4 }; /**< pixels along the side of what gets more rays or does not; divides VVI_TILE */

typedef struct vvi_samples {
    const vv_image *image;
    vv_image *shifted; /**< the picture of one pass, a column and a row larger than the image */
    double x, y;       /**< how far: a pixel's centre lies at (x, y) between the rays of four shifted ones */
    float *mean;       /**< rgba of each pixel, before the background; the image's own where nobody looks at that */
    float *half;       /**< the same of odd passes alone, to tell the error by; NULL: nobody asks */
    uint8_t *active;   /**< by block, n_across x n_down: gets more rays */
    int32_t n_across, n_down;
    int64_t n_active;
} vvi_samples;

/** Where pass 0, 1, 2, ... lies, each in [0, 1): to the left of the centres, and above. */
void vvi_sample_shift(double *x_out, double *y_out, int64_t pass);
/** Blocks that are known well enough get no more rays; those that were are for good. */
vv_status vvi_noise_check(vvi_picture *picture, vvi_samples *samples);
#endif
