/** @file
 * How the samples of one axis are made of those of another: for each new sample a run of old ones and their weights.
 */
#ifndef VVI_FILTER_RESAMPLE_WEIGHTS_H
#define VVI_FILTER_RESAMPLE_WEIGHTS_H
#include "core/status.h"
#include <volvis/runtime.h>

typedef enum vvi_resample_kernel { VVI_RESAMPLE_LINEAR, VVI_RESAMPLE_NEAREST, VVI_RESAMPLE_CUBIC } vvi_resample_kernel;

typedef struct vvi_resample_axis {
    int64_t n;      /**< new samples */
    int most;       /**< weights of each */
    int64_t *first; /**< of its run of old samples */
    int *count;
    double *w; /**< most for each; their sum is 1 */
} vvi_resample_axis;

/**
 * New sample i lies at old index start + i * step. Where step is above 1 the kernel is widened by it, so that every old
 * sample counts and nothing aliases. Beyond the ends the run is cut and its weights are made to sum to 1 again.
 */
vv_status vvi_resample_axis_make(vvi_resample_axis *out, vvi_resample_kernel kernel, int64_t n_old, int64_t n,
                                 double start, double step, vv_job *job);
void vvi_resample_axis_free(vvi_resample_axis *axis); /* a zeroed one is fine */
#endif
