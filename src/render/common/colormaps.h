/** @file
 * Perceptually uniform colour maps, and the colour space they live in.
 */
#ifndef VVI_RENDER_COLORMAPS_H
#define VVI_RENDER_COLORMAPS_H
#include <volvis/render.h>

/** Oklab (Ottosson 2020) to linear sRGB, clipped to [0, 1]. */
void vvi_oklab_to_linear(double rgb_out[3], const double lab[3]);

/** Number of a colour map by name, -1 when there is none. */
int vvi_colormap_find(const char *name);
/** VV_E_NOT_FOUND: the property `where` names a colour map that there is not. */
vv_status vvi_colormap_fail(const char *where, const char *typed);
/** Name and one line about map `index`; NULL past the last. */
const vv_preset *vvi_colormap_row(size_t index);
/** Linear colour of map `index` at 0..1 (clamped). */
void vvi_colormap_at(double rgb_out[3], int index, double at);

#endif
