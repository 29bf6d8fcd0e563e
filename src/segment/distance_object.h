/** @file
 * Of what distances are measured: the parameters of `distance`, and the voxels that they choose.
 */
#ifndef VVI_SEGMENT_DISTANCE_OBJECT_H
#define VVI_SEGMENT_DISTANCE_OBJECT_H
#include "segment/value_range.h"
#include <stdatomic.h>
#include <volvis/sys/registry.h>

typedef struct vvi_distance_params {
    vv_object object;
    vv_numbers *of;
    char *range;
    int side;
} vvi_distance_params;

enum { VVI_DISTANCE_OUTSIDE, VVI_DISTANCE_INSIDE, VVI_DISTANCE_BOTH };

typedef struct vvi_distance_object {
    vv_brick brick; /* the samples that are looked at */
    vvi_key_range *range;
    size_t n_ranges;
    bool other;      /* what is in none of the ranges */
    bool complement; /* what is not of the object is asked for */
    vvi_key_range all;
    _Atomic uint64_t n_inside;
} vvi_distance_object;

/** Whether values say what the object is. */
bool vvi_distance_given(const vvi_distance_params *params);
/** All but the brick, of samples like these. range is for vvi_free(). */
vv_status vvi_distance_choose(vvi_distance_object *object, const vvi_distance_params *params, const vv_field_info *info,
                              vv_job *job);
/** vvi_set_row() of its brick. */
void vvi_distance_set_row(uint8_t *out, size_t row, void *object);
/** What was found of n_voxels in all. */
void vvi_distance_tell(const vvi_distance_object *object, int side, uint64_t n_voxels, vv_job *job);

/** Where memory does not hold the distances: src/segment/distance_passes.c. */
extern const vv_passes vvi_distance_passes;
/** The result's info. */
vv_status vvi_distance_plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params);
#endif
