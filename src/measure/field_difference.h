/** @file
 * How two fields differ, sample by sample.
 */
#ifndef VVI_MEASURE_FIELD_DIFFERENCE_H
#define VVI_MEASURE_FIELD_DIFFERENCE_H
#include <volvis/field.h>

typedef struct vvi_field_difference {
    double max_difference; /**< of values; INFINITY where one is a number and the other none */
    double rms;
    double psnr; /**< dB against the range of the first; INFINITY when nothing differs; NAN where it has no meaning: the
                  * first is the same everywhere, or somewhere only one of the two is a finite number */
    uint64_t n_different, n_samples;
} vvi_field_difference;

/** Fields of equal dims and components. The same numbers for any thread count. */
vv_status vvi_field_compare(vvi_field_difference *out, const vv_field *a, const vv_field *b, vv_job *job);
/** Largest difference of the places of the grid's corners, in world units. */
double vvi_placement_difference(const vv_grid *a, const vv_grid *b);
#endif
