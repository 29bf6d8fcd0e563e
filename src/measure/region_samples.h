/** @file
 * Regions of any shape on a grid: which samples of a row are inside, and what geometry says of them.
 */
#ifndef VVI_MEASURE_REGION_SAMPLES_H
#define VVI_MEASURE_REGION_SAMPLES_H
#include "core/status.h"
#include <volvis/measure.h>

/** A region, ready to be asked about the samples of a grid. It borrows the outline. */
typedef struct vvi_region_samples {
    vv_region_shape of;
    vv_affine local; /**< from sample indices to coordinates of the region */
    vv_box box;      /**< samples that may be inside; n 0: none */
    bool beyond;     /**< it is partly outside the grid */
    double nudge;    /**< of its coordinates: a hair, so that rounding puts no sample on the wrong side of a border */
    double lo[2], hi[2]; /**< of a polygon: where its outline lies */
} vvi_region_samples;

/** Errors: VV_E_ARGUMENT (no extent, numbers that are not finite, a frame or a grid that is flat). */
vv_status vvi_region_samples_init(vvi_region_samples *out, const vv_grid *grid, const vv_region_shape *region);
/** Clears the bits of row (j, k) whose samples are outside. */
void vvi_region_samples_keep_row(uint64_t *bits, size_t words, const vvi_region_samples *shape, int64_t j, int64_t k);
/** How many samples are inside. */
uint64_t vvi_region_samples_count(const vvi_region_samples *shape);
#endif
