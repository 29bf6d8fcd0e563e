/** @file
 * Images at half the size, a quarter, and so on: pyramids of means, for looking up what a pixel covers.
 */
#ifndef VVI_IMAGE_LEVELS_H
#define VVI_IMAGE_LEVELS_H
#include "core/status.h"
#include <volvis/image.h>

enum { VVI_IMAGE_LEVELS = 32 };

/** One image of a pyramid: rows from the top, linear, premultiplied. */
typedef struct vvi_image_level {
    int32_t n[2], first; /**< columns and rows; the number of the first texel among those of all levels */
    const float *rgba;
} vvi_image_level;

typedef struct vvi_image_levels {
    int32_t n;
    vvi_image_level level[VVI_IMAGE_LEVELS];
    float *texels; /**< owned: all levels, one after the other */
} vvi_image_levels;

/**
 * Levels of an image: each half as wide and high as the one before, down to one texel; every texel the mean of the
 * part of the level before that it covers, so all levels have the image's mean.
 *
 * Errors   VV_E_LIMIT, VV_E_MEMORY, VV_E_CANCELLED; free it in any case
 */
vv_status vvi_image_levels_build(vvi_image_levels *out, const vv_image *image, vv_job *job);
void vvi_image_levels_free(vvi_image_levels *levels); /* zeroed is fine */
#endif
