/** @file
 * The offsets of a structuring element, the nearest first.
 */
#ifndef VVI_FILTER_NEAR_OFFSETS_H
#define VVI_FILTER_NEAR_OFFSETS_H
#include "filter/element.h"

typedef struct vvi_near_offset {
    double away; /**< squared, in the world */
    int32_t i, j, k;
} vvi_near_offset;

typedef struct vvi_near_offsets {
    vvi_near_offset *offset;
    size_t n;
} vvi_near_offsets;

/** VV_E_ARGUMENT for elements of more than 4 million samples. */
vv_status vvi_near_offsets_init(vvi_near_offsets *out, const vvi_element *element, const vv_grid *grid,
                                const char *name, vv_job *job);
void vvi_near_offsets_finish(vvi_near_offsets *offsets); /* zeroed is fine */
#endif
