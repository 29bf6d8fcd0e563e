/** @file
 * Samples as numbers that are not rounded, smoothed by the filter `gaussian`.
 */
#ifndef VVI_FILTER_SMOOTHED_SAMPLES_H
#define VVI_FILTER_SMOOTHED_SAMPLES_H
#include "core/job.h"
#include "grid/field.h"

/** One box of a field as stored numbers in floats (of samples of more than 16 bits: doubles), smoothed. sigma: of a
 * length, in the world; 0: not at all. Errors as of gaussian. */
vv_status vvi_smoothed(vv_field **out, const vv_field *in, const vv_box *box, double sigma, vv_job *job);
/** Whether gaussian takes such a sigma, said by `name`. */
vv_status vvi_smoothed_check(const vv_grid *grid, double sigma, const char *name);
#endif
