/** @file
 * Which components the channel operation picks.
 */
#ifndef VVI_FILTER_CHANNEL_H
#define VVI_FILTER_CHANNEL_H
#include "core/status.h"
#include <volvis/sys/registry.h>

#define VVI_CHANNELS_MOST 64 /* picked at once */

/** Numbers of the components that parameters of `channel` pick from so many, in their order. */
vv_status vvi_channel_picks(int picks_out[VVI_CHANNELS_MOST], int *n_out, const vv_object *params, int components);
#endif
