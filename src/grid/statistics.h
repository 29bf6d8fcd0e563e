/** @file
 * How vv_field_statistics() is split: samples to counts or moments (parallel, in items), and those to the numbers that
 * people see (serial, exact). Everything here is in stored numbers; scale and offset come last.
 */
#ifndef VVI_GRID_STATISTICS_H
#define VVI_GRID_STATISTICS_H
#include "grid/field.h"

/** Of one stored 8- or 16-bit pattern each. */
#define VVI_COUNTS_MOST 65536

/** Counts of samples by bit pattern; counts has 256 or 65536 entries, zero before. */
vv_status vvi_count_patterns(uint64_t *counts, const vv_field *field, int component, vv_job *job);
/** The stored number of a bit pattern. */
int32_t vvi_pattern_value(uint32_t pattern, vv_type type);

/** Of any number of samples; parts are joined in a fixed order. */
typedef struct vvi_moments {
    uint64_t count, nan_count, infinite_count;
    double min, max;      /**< of finite samples */
    long double mean, m2; /**< m2: sum of squared differences from the mean */
} vvi_moments;

void vvi_moments_init(vvi_moments *m);
void vvi_moments_add(vvi_moments *m, const double *values, size_t n);
void vvi_moments_join(vvi_moments *m, const vvi_moments *other);
vv_status vvi_field_moments(vvi_moments *out, const vv_field *field, int component, vv_job *job);

/** Equal bins. Value v is in bin floor((v - lo) / width), the last one closed above; values outside are in the end
 * bins. */
typedef struct vvi_bins {
    double lo, hi;
    int n;
} vvi_bins;

/** At most 1024: whole numbers share bins evenly, as many a bin as needed; reals over [min, max]. */
vvi_bins vvi_bins_for(double min, double max, bool whole_numbers);
vv_status vvi_count_bins(uint64_t *histogram, const vvi_bins *bins, const vv_field *field, int component, vv_job *job);
#endif
