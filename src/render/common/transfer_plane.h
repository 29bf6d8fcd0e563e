/** @file
 * Two-dimensional transfer functions: colour and opacity by value and length of the gradient (Kniss 2002).
 */
#ifndef VVI_RENDER_TRANSFER_PLANE_H
#define VVI_RENDER_TRANSFER_PLANE_H
#include "scene/transfer.h"

enum { VVI_PLANE_SIDE = 256 };

/** Extinction times r, g, b, 1 at a value and a length of the gradient (value per world length), straight from the
 * regions: theirs are added. */
void vvi_transfer_plane_evaluate(double rgbk_out[4], const vv_classification *classes, double value, double gradient);

/** The same at VVI_PLANE_SIDE values times as many lengths, for bilinear look-up: columns from `lo` to `hi`, beyond
 * which nothing is seen, rows from 0 to `top`, beyond which all is as at the top. */
typedef struct vvi_transfer_plane {
    float *rgbk;               /**< rows of columns of 4 */
    float any[VVI_PLANE_SIDE]; /**< by column: 1 where it or the next shows something at any gradient */
    double lo, hi, top;
} vvi_transfer_plane;

/** columns_out: a table that has no colours, but tells in `running` which columns show something at any gradient; for
 * skipping. Errors: VV_E_MEMORY. Finish both. */
vv_status vvi_transfer_plane_init(vvi_transfer_plane *out, vvi_transfer_table *columns_out,
                                  const vv_classification *classes, vv_job *job);
void vvi_transfer_plane_finish(vvi_transfer_plane *plane); /* zeroed is fine */

#endif
