/** @file
 * What the CF conventions, https://cfconventions.org, say of numbers: which of them stand for no value, how the others
 * are packed, and whether they have a sign. netCDF has these attributes, and so have the arrays that xarray writes.
 */
#ifndef VVI_IO_CF_H
#define VVI_IO_CF_H
#include "io/notes.h"

#define VVI_CF_NONE 8

/** The attributes of a variable, however its format keeps them. */
typedef struct vvi_cf_attributes {
    const void *user;
    /** At most so many numbers; how many there are. */
    int (*numbers)(double *out, int most, const void *user, const char *name);
    bool (*is_float)(const void *user, const char *name);
    bool (*text)(char *out, size_t room, const void *user, const char *name);
} vvi_cf_attributes;

/** Stored numbers that stand for no value, and what the others stand for. */
typedef struct vvi_cf_gaps {
    bool any;
    bool turned;          /* the sign is not that of the file's type */
    vv_type stored;       /* with the sign that is meant, as are all the numbers here */
    vv_type type;         /* of the values, a float */
    double scale, offset; /* of integers, which are unpacked; scale 0: they are left to the info */
    int n;                /* how many numbers stand for none */
    double none[VVI_CF_NONE];
    double lo, hi; /* and so do those outside */
} vvi_cf_gaps;

/** Scale and offset of packed numbers; what is not there is left alone. */
void vvi_cf_packing(double *scale, double *offset, const vvi_cf_attributes *of);
/** Numbers equal to _FillValue or missing_value and those outside the valid range; and the sign that _Unsigned gives,
 * with or without any of them. labels: integers that are names or colours; they stay integers. */
void vvi_cf_take_gaps(vvi_cf_gaps *out, vv_type in_file, bool labels, const vvi_cf_attributes *of);
/** Says which stored numbers they are where integers are read as floats because of them. */
vv_status vvi_cf_note_gaps(const vvi_cf_gaps *gaps, vv_notes *notes);
/** n stored numbers, converted from the file's type to that of the gaps, to values; NaN for none. */
void vvi_cf_mark_gaps(const vvi_cf_gaps *gaps, void *numbers, size_t n);
#endif
