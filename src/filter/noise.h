/** @file
 * How noisy a field is: what filters that are not told how much to smooth go by.
 */
#ifndef VVI_FILTER_NOISE_H
#define VVI_FILTER_NOISE_H
#include "core/status.h"
#include <volvis/field.h>

/**
 * Standard deviation of the noise of one component, in stored numbers; kept in the job's cache, and logged.
 *
 * It is the median size of the differences of samples from the mean of their two neighbours along each axis, as of
 * Gaussian white noise: edges are too few to change it. Places without any difference do not count (backgrounds that
 * were cut out), nor do missing ones. Of larger fields it looks at a million samples in evenly placed slices.
 *
 * Source   pseudo-residuals: Gasser, Sroka & Jennen-Steinmetz 1986; their median: Coupe et al. 2010
 */
vv_status vvi_noise(double *out, const vv_field *field, int component, vv_job *job);
#endif
