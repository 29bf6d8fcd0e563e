/** @file
 * How bright an X-ray of a volume becomes, before anybody has looked at one.
 */
#ifndef VVI_SCENE_XRAY_EXPOSURE_H
#define VVI_SCENE_XRAY_EXPOSURE_H
#include "core/status.h"
#include <volvis/sys/scene.h>

/**
 * The largest mean of the data values along lines through the grid, of a few hundred lines along each axis, or many
 * more where these pass beside what is bright. With over_longest, their sums over the length of the volume's diagonal
 * instead of over their own. Samples that are no number count as nothing.
 *
 * *out     data units; 0 for a field of no numbers
 */
vv_status vvi_exposure(double *out, const vv_actor *actor, bool over_longest, vv_job *job);

#endif
