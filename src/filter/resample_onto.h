/** @file
 * Samples of one volume at the places of another's, however the two lie.
 */
#ifndef VVI_FILTER_RESAMPLE_ONTO_H
#define VVI_FILTER_RESAMPLE_ONTO_H
#include "filter/resample_weights.h"
#include "grid/field.h"

/** Where a sample of `onto` lies among those of `grid`: old index = map(new index). VV_E_ARGUMENT where nobody knows
 * how the two lie. */
vv_status vvi_onto_map(vv_affine *map, const vv_grid *grid, const vv_grid *onto);
/** Whether each axis of so many new samples runs along that of the same number, forwards or backwards. */
bool vvi_onto_is_straight(const vv_affine *map, const int64_t dims[3]);
/** One box of the result, whose info it is, by any map. fill: the bytes of a number outside. */
vv_status vvi_onto_run_box(vv_field **out, const vv_field *in, const vv_field_info *info, const vv_affine *map,
                           vvi_resample_kernel kernel, const char fill[8], const vv_box *box, vv_job *job);
#endif
