/** @file
 * NumPy's .npy: an array by itself (npy.c), or one of several in a .npz (npz.c).
 */
#ifndef VVI_IO_NPY_H
#define VVI_IO_NPY_H
#include "io/layout.h"
#include "io/notes.h"

typedef struct vvi_npy {
    char order; /* '<' '>' '|' '=' */
    char letter;
    int bytes; /* of an element */
    bool fortran;
    int n_shape;
    int64_t shape[5];
    uint64_t offset; /* of the samples in the array's file */
    vvi_layout layout;
} vvi_npy;

/** The header of an array, from where the source stands. */
vv_status vvi_npy_parse(vvi_npy *out, vv_source *source, vv_job *job);
/** What its axes are: as the letters say, NULL: as its shape suggests. Ways that come into question are noted as parts;
 * NULL: they are not. */
vv_status vvi_npy_place(vv_field_info *info, vvi_npy *p, const char *axes, const char *name, vv_notes *notes);
#endif
