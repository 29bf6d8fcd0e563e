/** @file
 * Exact percentiles and ranks, however far out a few samples lie: samples are counted by the digits of an integer that
 * rises with them, 16 bits a pass from the highest on, so nothing depends on the range or on the number of threads.
 */
#ifndef VVI_GRID_PERCENTILE_H
#define VVI_GRID_PERCENTILE_H
#include "grid/field.h"

/** The most percentiles or ranks that are asked for at once. */
#define VVI_RANKS_MOST 8

/** Fields of equal type and scale whose samples are taken together: the time steps of a file, say. Each is opened once
 * a pass (1 of 8 and 16 bits, 2 of 32, 4 of 64) and released after it, so that only one needs to be in memory. */
typedef struct vvi_field_series {
    vv_status (*open)(vv_field **out, void *user, size_t index, vv_job *job);
    void *user;
    size_t n;
} vvi_field_series;

/** A series of one field, which outlives it. */
vvi_field_series vvi_field_alone(const vv_field *field);

/** Values (scale applied) that `percents` of the finite samples do not exceed, linear between neighbours in rank; NaN
 * where no sample is finite. Damaged fields are refused. At most VVI_RANKS_MOST / 2. */
vv_status vvi_percentiles(double *values, const double *percents, int n, const vvi_field_series *series, int component,
                          vv_job *job);
/** The same of one field, kept in the job's cache for a pair of percents. */
vv_status vvi_field_percentiles(double values[2], const double percents[2], const vv_field *field, int component,
                                vv_job *job);
/** Stored numbers by rank, 0 the least finite one; ranks are below the number of finite samples. */
vv_status vvi_select_ranks(double *stored, const uint64_t *ranks, int n, const vv_field *field, int component,
                           vv_job *job);
#endif
