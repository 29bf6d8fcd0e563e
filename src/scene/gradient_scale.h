/** @file
 * How steep a volume is.
 */
#ifndef VVI_SCENE_GRADIENT_SCALE_H
#define VVI_SCENE_GRADIENT_SCALE_H
#include "core/status.h"
#include <volvis/sys/scene.h>

/**
 * The length that 99 of 100 gradients do not pass, of those that are more than a hundredth of the longest: so flat
 * background does not count. Central differences at up to about 300000 samples of an even grid; NaN left out. Measured
 * once for a field in one place.
 *
 * Units    values per world length; 0 where nothing changes
 * Errors   VV_E_MEMORY, VV_E_CANCELLED
 * Threads  any; same result always
 */
vv_status vvi_gradient_scale(double *out, const vv_actor *actor, vv_job *job);

#endif
