/** @file
 * Ranges of samples as people type them.
 */
#ifndef VVI_FILTER_CROP_H
#define VVI_FILTER_CROP_H
#include "core/status.h"
#include <volvis/field.h>

/** FIRST:END along an axis as in `crop`: samples [*lo, *end). text NULL or "": all. */
vv_status vvi_crop_range(int64_t *lo, int64_t *end, const char *text, const vv_grid *grid, int axis);
#endif
