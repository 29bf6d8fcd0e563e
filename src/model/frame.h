/** @file
 * Where a volume stands.
 */
#ifndef VVI_MODEL_FRAME_H
#define VVI_MODEL_FRAME_H
#include <volvis/model.h>

/** The map of a placement: its matrix when that is set, else scale, then rotation about x, y, z, then position. */
vv_affine vvi_frame_matrix(const vv_frame *frame);
#endif
