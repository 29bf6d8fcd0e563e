/** @file
 * Planes of doubles, one number a pixel: what image comparison works on.
 */
#ifndef VVI_IMAGE_IMAGE_PLANES_H
#define VVI_IMAGE_IMAGE_PLANES_H
#include "core/status.h"
#include <volvis/image.h>

typedef struct vvi_plane {
    int32_t width, height;
    double *v;
} vvi_plane;

/** An odd kernel: w[0 .. 2 * radius], the middle at w[radius]. */
typedef struct vvi_kernel {
    int radius;
    double w[64];
} vvi_kernel;

/** Of no content yet. */
vv_status vvi_plane_new(vvi_plane *out, int32_t width, int32_t height, vv_job *job);
void vvi_plane_free(vvi_plane *plane); /* a zeroed one is fine */
/** out = in smoothed by x along rows and y along columns; beyond the border lies the border. out may be in. */
vv_status vvi_plane_filter(vvi_plane *out, const vvi_plane *in, const vvi_kernel *x, const vvi_kernel *y, vv_job *job);

/** The image's 8-bit sRGB codes over black, 3 a pixel; for vvi_free(). */
vv_status vvi_image_codes(uint8_t **out, const vv_image *image, vv_job *job);
/** Mean structural similarity of luma. */
vv_status vvi_image_ssim(double *out, const uint8_t *a, const uint8_t *b, int32_t width, int32_t height, vv_job *job);
/** Mean FLIP error at 67 pixels a degree. */
vv_status vvi_image_flip(double *out, const uint8_t *a, const uint8_t *b, int32_t width, int32_t height, vv_job *job);
#endif
