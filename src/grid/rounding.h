/** @file
 * Values that became whole numbers: whether much of what told them apart is gone.
 */
#ifndef VVI_GRID_ROUNDING_H
#define VVI_GRID_ROUNDING_H
#include <volvis/field.h>

/** How many different values there are at least: bins of the histogram that are not empty. */
int vvi_values_apart(const vv_statistics *statistics);
/** Warns, once a job, where values from lo to hi, n_apart of them different, are n_left numbers of `type`: fewer than a
 * tenth. */
void vvi_tell_rounding(vv_job *job, double lo, double hi, int n_apart, double n_left, vv_type type);
#endif
