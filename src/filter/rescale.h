/** @file
 * One window for several fields that are rescaled one after the other: the time steps of a file.
 */
#ifndef VVI_FILTER_RESCALE_H
#define VVI_FILTER_RESCALE_H
#include "grid/percentile.h"
#include <volvis/property.h>

/** Whether the samples decide what the window is: `from` is not given. params: of the operation rescale. */
bool vvi_rescale_looks(const vv_object *params);
/** From now on the window is that of all samples of the fields, whichever is rescaled. */
vv_status vvi_rescale_settle(vv_object *params, const vvi_field_series *fields, vv_job *job);
#endif
