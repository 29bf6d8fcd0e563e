/** @file
 * Amounts of voxels, as people type them.
 */
#ifndef VVI_SEGMENT_VOXELS_H
#define VVI_SEGMENT_VOXELS_H
#include "core/status.h"
#include <volvis/field.h>

/** "100", "100vox", "2.5mm3", "2.5mm^3", in voxels of the grid; NULL and "" are 0. `place` begins the error. */
vv_status vvi_voxels_parse(double *out, const char *text, const vv_grid *grid, const char *place);
#endif
