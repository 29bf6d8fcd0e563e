/** @file
 * Rectilinear grids: samples at uneven places along each axis. Fields are regular, so such data are resampled: the
 * function that linear interpolation between them gives, on a regular grid over the same box, fine enough for the
 * smallest gap unless that were far too many samples.
 */
#ifndef VVI_IO_RECTILINEAR_H
#define VVI_IO_RECTILINEAR_H
#include "core/status.h"
#include <volvis/field.h>
#include <volvis/sys/registry.h>

#define VVI_AXIS_GROWTH 4    /* samples of an axis, at most, for each that there is */
#define VVI_SAMPLES_GROWTH 8 /* of the whole grid */

typedef struct vvi_axes {
    int64_t n[3];    /* samples that there are */
    double *at[3];   /* where */
    bool even[3];    /* to a thousandth of a step */
    double gap[3];   /* the smallest; 0 for one sample */
    int64_t dims[3]; /* of the regular grid */
    double step[3];  /* of it; its sign is that of the coordinates */
} vvi_axes;

/** Copies the coordinates. VV_E_FORMAT unless they are finite and rise or fall all along each axis. */
vv_status vvi_axes_new(vvi_axes **out, const double *const at[3], const int64_t n[3], const char *name, vv_job *job);
void vvi_axes_free(vvi_axes *axes); /* NULL is fine */
bool vvi_axes_even(const vvi_axes *axes);
/** Places of the centres between n points; of one point the point. Returns how many. */
int64_t vvi_axes_centres(double *at, int64_t n);
/** Dims and steps of the regular grid, and the type that holds its samples: the file's own when nothing is resampled
 * or it is a float or a colour, else a float. */
void vvi_axes_place(vv_field_info *info, const vvi_axes *axes);
/** Says what is done to uneven data and how coarse it is. */
vv_status vvi_axes_warn(vv_notes *notes, const vvi_axes *axes);
/** The stored samples that a box of the regular grid needs. */
vv_box vvi_axes_needs(const vvi_axes *axes, const vv_box *region);
/** A box of the regular grid (NULL: all) from stored samples that begin at needs->lo. */
vv_status vvi_axes_sample(vv_field **out, const vv_field_info *info, const vvi_axes *axes, const vv_box *region,
                          const vv_field *stored, const vv_box *needs, vv_job *job);
#endif
