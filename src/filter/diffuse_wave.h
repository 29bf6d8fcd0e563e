/** @file
 * Steps of diffusion that follow each other through the slices as a wave: of every step two slices are held, so that
 * many steps take little memory, and each sample is read once.
 */
#ifndef VVI_FILTER_DIFFUSE_WAVE_H
#define VVI_FILTER_DIFFUSE_WAVE_H
#include "filter/smoothing_kernel.h"
#include "grid/field.h"

typedef struct vvi_diffuse_wave {
    const vv_field *in;
    const vvi_smoothing_kernels *kernels;
    double inverse[3]; /**< of the difference along each axis that is an edge */
    double rate[3];
    bool rational, wide;
    int64_t component, iterations; /**< iterations: 1 and more */
    vv_box box;                    /**< of the result */
    char *out;                     /**< its samples of this component, packed but for `step` */
    vv_type type;                  /**< of them */
    int64_t step;                  /**< bytes from one to the next */
    /** Called when slice k of the result is in `out`, which has room for one slice then. NULL: `out` has all. */
    vv_status (*take)(void *user, int64_t k);
    void *user;
    uint64_t before, all; /**< for the progress: slices of other waves that are done, and of all; 0: there are none */
    vv_job *job;
} vvi_diffuse_wave;

/** What it holds. */
double vvi_diffuse_wave_bytes(const vvi_diffuse_wave *wave);
/** The component of the box after the steps: the same numbers as of all samples at once. */
vv_status vvi_diffuse_wave_run(const vvi_diffuse_wave *wave);
#endif
