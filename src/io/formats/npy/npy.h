/** @file
 * NumPy's .npy: an array by itself (npy.c), or one of several in a .npz (npz.c, npz_write.c).
 */
#ifndef VVI_IO_NPY_H
#define VVI_IO_NPY_H
#include "core/text.h"
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
/** Adds the header of an array to an empty text, filled up so that the samples begin at a multiple of 64 bytes where
 * the header itself begins `before` bytes after one. */
vv_status vvi_npy_add_header(vvi_text *t, const vv_field_info *info, size_t n_frames, bool big_endian, size_t before);
/** The row's, of npz_write.c. */
extern const char *const vvi_npz_encodings[];
vv_status vvi_npz_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames, const vv_write_options *options,
                        vv_job *job);
#endif
