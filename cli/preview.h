/** @file
 * Slices side by side in their proportions, as one small picture.
 */
#ifndef CLI_PREVIEW_H
#define CLI_PREVIEW_H
#include "slices.h"
#include <volvis/image.h>

/** Pixels as a screen has them, three floats each, 0..1; row 0 is the top. */
typedef struct cli_thumbnail {
    int width, height;
    float *rgb; /**< free() it */
} cli_thumbnail;

/**
 * The slices at one scale, as large as fits, on black.
 *
 * exact   the picture has that size; else it is as small as its slices
 * aspect  height of a pixel by its width: 1 but in letters
 */
vv_status cli_thumbnail_make(cli_thumbnail *out, const cli_slice *slices, int n, int width, int height, bool exact,
                             double aspect);
/** For vv_image_write(). */
vv_status cli_thumbnail_image(vv_image **out, const cli_thumbnail *thumbnail, vv_job *job);
#endif
