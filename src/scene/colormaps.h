/** @file
 * Perceptually uniform colour maps: curves in Oklab (core/oklab.h).
 */
#ifndef VVI_SCENE_COLORMAPS_H
#define VVI_SCENE_COLORMAPS_H
#include <volvis/render.h>

/** Number of a colour map by name, -1 when there is none. */
int vvi_colormap_find(const char *name);
/** VV_E_NOT_FOUND: the property `where` names a colour map that there is not. */
vv_status vvi_colormap_fail(const char *where, const char *typed);
/** Name and one line about map `index`; NULL past the last. */
const vv_preset *vvi_colormap_row(size_t index);
/** Linear colour of map `index` at 0..1 (clamped). */
void vvi_colormap_at(double rgb_out[3], int index, double at);

#endif
