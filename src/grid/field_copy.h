/** @file
 * Samples that are somewhere else, or are made when they are asked for, in memory.
 */
#ifndef VVI_GRID_FIELD_COPY_H
#define VVI_GRID_FIELD_COPY_H
#include <volvis/field.h>

/** The samples of a box as a field of their own, taken slice by slice. Errors: those of vv_field_brick(). */
vv_status vvi_field_copy_box(vv_field **out, const vv_field *field, const vv_box *box, vv_job *job);
#endif
