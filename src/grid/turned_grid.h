/** @file
 * Grids whose axes run along the same lines of the world, in another order or direction.
 */
#ifndef VVI_GRID_TURNED_GRID_H
#define VVI_GRID_TURNED_GRID_H
#include "grid/same_grid.h"

/** How axes of two grids go together. */
typedef enum vvi_axes {
    VVI_AXES_SAME,
    VVI_AXES_TURNED, /**< along the same lines, in another order or direction */
    VVI_AXES_OTHER   /**< each is nearest to another direction of the world, and not along the same lines */
} vvi_axes;

/** turn_out: which samples of b those of a go with, by their axes alone: b as it would be with a's axes begins at its
 * own corner. */
vvi_axes vvi_axes_compare(vvi_grid_fit *turn_out, const vv_grid *a, const vv_grid *b);
/** "-x+z+y", as `reorient` calls that order. */
void vvi_turn_print(char out[8], const vvi_grid_fit *turn);
/** The grid in that order, its samples where they were. */
vv_grid vvi_grid_turned(const vv_grid *grid, const vvi_grid_fit *turn);
#endif
