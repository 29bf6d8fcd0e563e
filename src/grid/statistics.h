/** @file
 * How vv_field_statistics() is split: samples to counts or moments (parallel, in items), and those to the numbers that
 * people see (serial, exact). Everything here is in stored numbers; scale and offset come last.
 */
#ifndef VVI_GRID_STATISTICS_H
#define VVI_GRID_STATISTICS_H
#include "grid/field.h"
#include "grid/value_pass.h"

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

/** Moments by passes: one part for each item of the pass, joined in their order. */
vv_status vvi_moments_begin(vvi_moments **parts_out, size_t n_items, vv_job *job);
vvi_pass vvi_moments_pass(vvi_moments *parts);
void vvi_moments_end(vvi_moments *out, vvi_moments *parts, size_t n_items);

/** Equal bins. Value v is in bin floor((v - lo) / width), the last one closed above. */
typedef struct vvi_bins {
    double lo, hi;
    int n;
} vvi_bins;

/** At most 1024: whole numbers share bins evenly, as many a bin as needed; reals over [min, max]. */
vvi_bins vvi_bins_for(double min, double max, bool whole_numbers);

/** The most bins that are counted. */
#define VVI_BINS_MOST 65536

/** Counts by bins, as a pass. Zeroed before vvi_bin_counts_begin(). */
typedef struct vvi_bin_counts {
    vvi_bins bins;
    double half_lo, per_half; /**< halves, as the range of huge doubles is no double */
    _Atomic uint64_t *total;  /**< of each bin, of what is below and above them, of what is not finite */
} vvi_bin_counts;

vv_status vvi_bin_counts_begin(vvi_bin_counts *counts, const vvi_bins *bins, vv_job *job);
vvi_pass vvi_bin_counts_pass(vvi_bin_counts *counts);
/** Bin b; behind the bins what is below, and then what is above them. */
uint64_t vvi_bin_counts_get(const vvi_bin_counts *counts, int b);
void vvi_bin_counts_end(vvi_bin_counts *counts);

/** vv_field_statistics() with exact percentiles of any type, for about twice the time; kept in the job's cache. */
vv_status vvi_field_statistics_exact(vv_statistics *out, const vv_field *field, int component, vv_job *job);
#endif
