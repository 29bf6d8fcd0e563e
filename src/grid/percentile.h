/** @file
 * Percentiles. Of n numbers in rising order, counted from 0, percentile p lies at place p / 100 (n - 1), in a straight
 * line between the two beside it: numpy's "linear". The median is percentile 50. All that VolVis tells is this.
 */
#ifndef VVI_GRID_PERCENTILE_H
#define VVI_GRID_PERCENTILE_H
#include "grid/selection.h"
#include <volvis/run.h>

/** `part` of the way from the number of rank `low` to that of rank `high`; ranks begin at 0. */
typedef struct vvi_quantile {
    uint64_t low, high;
    double part;
} vvi_quantile;

/** Where it lies among `count` numbers, which is not 0. */
vvi_quantile vvi_quantile_at(double percent, uint64_t count);
/** Between the numbers of its two ranks. */
double vvi_quantile_between(const vvi_quantile *q, double low, double high);

/** The two ranks of each of n percentiles among `count` numbers: what a selection is asked for. */
void vvi_quantile_ranks(uint64_t *ranks, const double *percents, int n, uint64_t count);
/** When they are found: the i-th percentile, as a stored number. */
double vvi_selection_percentile(const vvi_selection *s, int i, double percent, uint64_t count);

/** A series of one field, which outlives it. */
vv_field_series vvi_field_alone(const vv_field *field);

/** Values (scale applied), exact, of the finite samples; NaN where none is finite. Each field of the series is opened
 * once a pass (1 of 8 and 16 bits, 2 of 32, 4 of 64). Damaged fields are refused. At most VVI_RANKS_MOST / 2. */
vv_status vvi_percentiles(double *values, const double *percents, int n, const vv_field_series *series, int component,
                          vv_job *job);
/** The same of one field, kept in the job's cache for a pair of percents. */
vv_status vvi_field_percentiles(double values[2], const double percents[2], const vv_field *field, int component,
                                vv_job *job);
#endif
