/** @file
 * The three ways in which slices lie, and which way they are looked at: anatomical ones as a radiologist does, from the
 * feet, the front and the left, so that the patient's right is on the picture's left; others as their axes run.
 */
#ifndef VVI_GRID_SLICE_AXES_H
#define VVI_GRID_SLICE_AXES_H
#include <volvis/field.h>

enum { VVI_SLICE_WAYS = 3 }; /* axial, coronal, sagittal; across z, y, x */

/** World axes by number; +1 or -1 is the sign along right and up. */
typedef struct vvi_slice_axes {
    int normal, right, right_sign, up, up_sign;
} vvi_slice_axes;

/** VVI_SLICE_WAYS rows. */
const vvi_slice_axes *vvi_slice_axes_of(vv_space space);

/** The index axis that runs most along each world axis, each once, and the sign with which it does: the inverse of
 * vvi_grid_main_axes(). */
void vvi_grid_index_axes(int index_axis_out[3], int sign_out[3], const vv_grid *grid);

#endif
