/** @file
 * How the samples of one axis are made of those of another: for each new sample a run of old ones and their weights.
 */
#ifndef VVI_FILTER_RESAMPLE_WEIGHTS_H
#define VVI_FILTER_RESAMPLE_WEIGHTS_H
#include "core/status.h"
#include <volvis/runtime.h>

typedef enum vvi_resample_kernel {
    VVI_RESAMPLE_LINEAR,
    VVI_RESAMPLE_NEAREST,
    VVI_RESAMPLE_CUBIC,  /**< Keys (1981) */
    VVI_RESAMPLE_LANCZOS /**< of three lobes to each side */
} vvi_resample_kernel;

typedef struct vvi_resample_axis {
    int64_t n;      /**< new samples */
    int most;       /**< weights of each */
    int64_t *first; /**< of its run of old samples */
    int *count;     /**< 0: it lies outside (vvi_resample_axis_cut) */
    double *w;      /**< most for each; their sum is 1 */
} vvi_resample_axis;

/**
 * New sample i lies at old index start + i * step. Where a step is longer than 1 the kernel is widened by it, so that
 * every old sample counts and nothing aliases. Beyond the ends the run is cut and its weights are made to sum to 1
 * again; the wide kernels (cubic, Lanczos) see the samples mirrored there in place and value, so that what rises evenly
 * rises on.
 */
vv_status vvi_resample_axis_make(vvi_resample_axis *out, vvi_resample_kernel kernel, int64_t n_old, int64_t n,
                                 double start, double step, vv_job *job);
/** New samples more than half a sample beyond the old ones have none: their count is 0. */
void vvi_resample_axis_cut(vvi_resample_axis *axis, int64_t n_old, double start, double step);
void vvi_resample_axis_free(vvi_resample_axis *axis); /* a zeroed one is fine */

/** The same for one place, with a kernel `width` old samples wide: the weights of the run from *first on, how many
 * there are. w has room for `most` of them, as vvi_resample_most() says. */
int vvi_resample_weigh(double *w, int64_t *first, int most, vvi_resample_kernel kernel, int64_t n_old, double at,
                       double width);
int vvi_resample_most(vvi_resample_kernel kernel, double width, int64_t n_old);
/** Whether an old index lies in the extent of the samples, half a sample beyond the outermost. */
bool vvi_resample_inside(double at, int64_t n_old);
#endif
