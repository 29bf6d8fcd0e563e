/** @file
 * Where a volume stands.
 */
#ifndef VVI_MODEL_PLACEMENT_H
#define VVI_MODEL_PLACEMENT_H
#include <volvis/model.h>

/** The map of a placement: its matrix when that is set, else scale, then rotation about x, y, z, then position. */
vv_affine vvi_placement_matrix(const vv_placement *frame);
#endif
