/** @file
 * Diffusion along structures: coherence-enhancing diffusion (Weickert 1999).
 */
#ifndef VVI_FILTER_COHERENCE_H
#define VVI_FILTER_COHERENCE_H
#include "core/job.h"
#include "grid/field.h"

typedef struct vvi_coherence {
    int64_t iterations;
    double sigma, rho; /**< lengths: of the smoothing before slopes are taken, and of their products */
    double alpha;      /**< what flows across structures */
    double edge;       /**< stored numbers over the smallest spacing */
    double step;       /**< squares of the smallest spacing: at most 0.5 / vvi_coherence_rate() */
} vvi_coherence;

/** What the greatest diffusion takes from a sample in a unit of time, at most, over 4. */
double vvi_coherence_rate(const vv_grid *grid);
/** Whether memory is there for it; else VV_E_LIMIT. */
vv_status vvi_coherence_plan(const vv_field_info *info, vv_job *job);
/** Bytes that it holds beside what it is given and makes. */
uint64_t vvi_coherence_memory(const vv_field_info *info);
/**
 * One component of all samples of a field, diffused, in a volume of the same samples at `out`.
 *
 * In each step the structure tensor is that of slopes of the smoothed values, smoothed again. Along the direction of
 * its least eigenvalue flows alpha + (1 - alpha) exp(-edge^4 / k), where k is the sum of the squares of the differences
 * of eigenvalues; across it flows alpha. In a plane these are the two of the plane. Fluxes are differences between
 * neighbours, and across of their means; their sum is nothing. Missing samples take no part.
 */
vv_status vvi_coherence_run(void *out, const vv_field *in, int component, const vvi_coherence *c, vv_job *job);
#endif
