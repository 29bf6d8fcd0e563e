/** @file
 * How many samples of a field are no larger than a value, and the other way round: cumulative histograms as lines from
 * point to point.
 */
#ifndef VVI_FILTER_RANKS_H
#define VVI_FILTER_RANKS_H
#include "core/status.h"
#include <volvis/field.h>

/** Of the finite samples of a component, stored numbers. Of integers that span at most 65536 numbers there is a point
 * for each that a sample has; else for each end of 65536 equal bins. */
typedef struct vvi_ranks {
    size_t n;      /**< points; 0: no sample is finite */
    double *at;    /**< stored number, rising */
    double *up_to; /**< samples that are no larger, not falling */
} vvi_ranks;

/** Kept in the job's cache: *out is for vvi_ranks_release() with *held. */
vv_status vvi_ranks_of(vvi_ranks *out, void **held, const vv_field *field, int component, vv_job *job);
void vvi_ranks_release(void *held); /* NULL is fine */
/** y at x, in straight lines between points whose x do not fall; the ends' beyond them. */
double vvi_line_at(double x, const double *xs, const double *ys, size_t n);
#endif
