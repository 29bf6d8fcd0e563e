/** @file
 * Min-max cells that speak for their surroundings too: what a renderer needs that reads beyond a block.
 */
#ifndef VVI_RENDER_COMMON_MINMAX_SPREAD_H
#define VVI_RENDER_COMMON_MINMAX_SPREAD_H
#include "core/status.h"
#include "grid/minmax.h"

/** Each block's range becomes that of all blocks at most `reach` away on every axis. Free with vvi_minmax_free(). */
vv_status vvi_minmax_spread(vvi_minmax **out, const vvi_minmax *from, int reach, vv_job *job);

#endif
