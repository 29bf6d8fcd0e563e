/** @file
 * Samples for a reduced surface: those of the field where every one is taken and they can be read as they lie, else
 * floats, less the value of the surface.
 */
#ifndef VVI_SURFACE_SUBSAMPLE_H
#define VVI_SURFACE_SUBSAMPLE_H
#include "surface/marching_plan.h"
#include "surface/reduced.h"

typedef struct vvi_lattice_samples {
    const char *data;
    int64_t n[3], stride[3]; /**< samples; bytes */
    vvi_march_type type;
    char threshold[8]; /**< the least sample that is inside; inverted: that is not */
    bool inverted;
    float iso;
    int32_t step[3];
    double offset[3]; /**< of the first sample, in the field's index coordinates */
    float *made;      /**< NULL: data is the field's */
} vvi_lattice_samples;

/** All samples of an open plan. */
vv_status vvi_lattice_begin(vvi_lattice_samples *out, const vvi_march *m);
/** Every second one of *lattice, which is replaced; axes of 8 samples or fewer stay. False in *more_out: nothing was
 * left out. Errors: VV_E_MEMORY, VV_E_LIMIT, VV_E_CANCELLED; then *lattice is finished. */
vv_status vvi_lattice_halve(vvi_lattice_samples *lattice, bool *more_out, const vvi_march *m,
                            vvi_reduced_filter filter);
void vvi_lattice_finish(vvi_lattice_samples *lattice);
#endif
