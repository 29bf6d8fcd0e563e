/** @file
 * A primitive among the samples of a grid.
 */
#ifndef VVI_MODELING_PLACE_H
#define VVI_MODELING_PLACE_H
#include "modeling/primitives.h"
#include "modeling/profile.h"

enum { VVI_PLACED_BRICK = 16 }; /**< samples along a side that are looked at together */

typedef struct vvi_placed {
    const vvi_primitive *primitive;
    vvi_lengths lengths;
    vv_affine to_own; /**< from indices of samples to coordinates of the primitive; lengths are those of the world */
    const vvi_profile *profile;
} vvi_placed;

/** Densities of a box of samples no larger than a brick, packed. False when the whole box is 0 or 1 and was filled by
 * one look. */
bool vvi_placed_densities(float *out, const vvi_placed *placed, const vv_box *box);
#endif
