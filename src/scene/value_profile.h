/** @file
 * What happens at each value of a volume: how often it is there and how steep the data are.
 */
#ifndef VVI_SCENE_VALUE_PROFILE_H
#define VVI_SCENE_VALUE_PROFILE_H
#include "core/status.h"
#include <volvis/sys/scene.h>

enum { VVI_PROFILE_BINS = 256 };

/** By equal bins of values; bin b has its middle at lo + (b + 0.5) width. */
typedef struct vvi_value_profile {
    int n;
    double lo, width;
    double count[VVI_PROFILE_BINS]; /**< of all samples but the largest thousandth, where it is far out */
    double seen[VVI_PROFILE_BINS];  /**< of samples whose gradients were looked at */
    double slope[VVI_PROFILE_BINS]; /**< sum of |gradient| over these, in values per world length */
} vvi_value_profile;

/** Bins and counts of a histogram, the rest 0. Bins are whole numbers of the histogram's. */
void vvi_profile_counts(vvi_value_profile *out, const vv_statistics *statistics);
/** With gradients at up to about 300000 samples of an even grid; kept in the job's cache. Errors as those of
 * vvi_walk_samples(). */
vv_status vvi_profile_get(vvi_value_profile *out, const vv_actor *actor, vv_job *job);
#endif
