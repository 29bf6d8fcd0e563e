/** @file
 * Whether samples of two fields lie in the same places, so that one may mark or colour the other.
 */
#ifndef VVI_GRID_SAME_GRID_H
#define VVI_GRID_SAME_GRID_H
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

/** `other` with its lengths in the unit of `grid`, where both units are known. */
vv_grid vvi_grid_in_unit_of(const vv_grid *grid, const vv_grid *other);

/** Where the samples of one grid are among those of another: sample i along axis a of the grid is sample
 * first[a] + sign[a] i along axis[a] of the other. */
typedef struct vvi_grid_fit {
    int axis[3], sign[3];
    int64_t first[3];
} vvi_grid_fit;

/** True: each sample of `grid` lies where one of `other` does, or would if that went on. The same slack; both must say
 * where they lie, in the same space. */
bool vvi_grid_fits(vvi_grid_fit *out, const vv_grid *grid, const vv_grid *other);
/** The samples of `grid` that `other` has; n is 0 along an axis where it has none. */
vv_box vvi_grid_covered(const vv_grid *grid, const vv_grid *other, const vvi_grid_fit *fit);
/** The samples of `field` in the order of `grid`, of whose samples those that the field lacks are 0. Made slab by slab,
 * when they are asked for; retains the field. */
vv_status vvi_field_fitted(vv_field **out, const vv_field *field, const vv_grid *grid, const vvi_grid_fit *fit,
                           vv_job *job);
#endif
