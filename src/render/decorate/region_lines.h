/** @file
 * Regions of measurements as lines: where a plane cuts their surface, and their edges in space.
 */
#ifndef VVI_RENDER_REGION_LINES_H
#define VVI_RENDER_REGION_LINES_H
#include "core/status.h"
#include <volvis/measure.h>

/** What becomes of a line of the World. Anything but VV_OK ends the others. */
typedef vv_status vvi_region_line(void *user, vv_vec3 from, vv_vec3 to);

/** The border of the region's part in a plane. The plane's normal has length 1. */
vv_status vvi_region_cut(const vv_region_shape *region, const vv_plane *plane, vvi_region_line *line, void *user);
/** Its edges; of an ellipsoid its three ellipses. */
vv_status vvi_region_edges(const vv_region_shape *region, vvi_region_line *line, void *user);
#endif
