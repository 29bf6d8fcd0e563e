/** @file
 * What `components` is told, and what its two ways share: all samples at once, and slab by slab.
 */
#ifndef VVI_SEGMENT_COMPONENTS_H
#define VVI_SEGMENT_COMPONENTS_H
#include "segment/part_sizes.h"
#include "segment/runs.h"
#include <volvis/sys/registry.h>

typedef struct vvi_components_params {
    vv_object object;
    char *range;
    bool merge;
    int connectivity;
    char *min_size;
    int64_t keep;
} vvi_components_params;

/** The runs of a brick; info is that of the whole field. */
vv_status vvi_components_runs(vvi_runs *out, const vv_brick *brick, const vv_field_info *info,
                              const vvi_components_params *params, vv_job *job);
/** The least size that is kept, in samples, and how many parts. */
vv_status vvi_components_kept(double *least, uint32_t *most, const vv_field_info *info,
                              const vvi_components_params *params);
/** "5 of 605 parts, the largest of 120, 7 and 7 voxels". */
void vvi_components_tell(const vvi_part_sizes *sizes, vv_job *job);

/** Where memory does not hold the labels: src/segment/components_passes.c. */
extern const vv_passes vvi_components_passes;
#endif
