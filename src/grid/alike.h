/** @file
 * Whether samples of two fields lie in the same places, so that one may mark or colour the other.
 */
#ifndef VVI_GRID_ALIKE_H
#define VVI_GRID_ALIKE_H
#include "core/status.h"
#include <volvis/field.h>

/** How far apart, in voxels, two samples may lie that are meant to be in one place: what headers lose that keep four
 * digits or 32 bits. Half a voxel is another convention, and no rounding. */
#define VVI_GRID_SLACK 0.05

/**
 * VV_OK: each sample of `other` lies where that of `grid` with the same numbers does.
 *
 * A grid without spacing (unit "voxels") says nothing about places, and equal dims are enough. Where only one of the
 * two is anatomical their origins and directions cannot be compared, and spacings are. Units of length are converted.
 *
 * name    what `other` is, in the sentence: "mask"
 * Errors  VV_E_ARGUMENT
 */
vv_status vvi_grid_alike(const vv_grid *grid, const vv_grid *other, const char *name);
#endif
