/** @file
 * Parts by their size.
 */
#ifndef VVI_SEGMENT_PART_SIZES_H
#define VVI_SEGMENT_PART_SIZES_H
#include "segment/runs.h"

#define VVI_PARTS_TOLD 5

typedef struct vvi_part_sizes {
    uint32_t n_parts, n_kept;
    uint32_t *rank;                   /**< by part: 1 is the largest, of equal ones the first; 0: left out */
    uint64_t largest[VVI_PARTS_TOLD]; /**< samples of those that are kept */
} vvi_part_sizes;

/** Keeps parts of at least `least` samples, and of them the `most` largest. Owns: vvi_part_sizes_finish(). */
vv_status vvi_part_sizes_find(vvi_part_sizes *out, const vvi_runs *runs, double least, uint32_t most, vv_job *job);
/** The same of parts that have these sizes. `out` is zeroed, or has a rank of the caller's own with room for n. */
vv_status vvi_part_sizes_rank(vvi_part_sizes *out, const uint64_t *size, uint32_t n, double least, uint32_t most,
                              vv_job *job);
void vvi_part_sizes_finish(vvi_part_sizes *sizes); /* zeroed is fine */
#endif
