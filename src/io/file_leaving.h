/** @file
 * Values of a file that stand for none: those that somebody names, and padding that its header declares.
 */
#ifndef VVI_IO_FILE_LEAVING_H
#define VVI_IO_FILE_LEAVING_H
#include "io/notes.h"

typedef struct vvi_leaving {
    vv_field_info rest; /**< what is read: NaN in place of the values, integers as floats that hold them */
    size_t n;
    double value[];
} vvi_leaving;

/** Yours to free(); the notes tell the values. VV_E_ARGUMENT of labels and colours, which are no amounts. */
vv_status vvi_leaving_new(vvi_leaving **out, const vv_field_info *info, const double *values, size_t n,
                          const char *name, vv_notes *notes);
/** The stored numbers, from out[0] to out[1], that a reader noted as padding (PixelPaddingValue of DICOM); false: none.
 */
bool vvi_notes_padding(double out[2], const vv_notes *notes);
#endif
