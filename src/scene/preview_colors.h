/** @file
 * From a sample to its colour on a screen: grey, channels, labels, the data's own colours.
 */
#ifndef VVI_SCENE_PREVIEW_COLORS_H
#define VVI_SCENE_PREVIEW_COLORS_H
#include <volvis/file.h>

typedef struct vvi_preview_colors vvi_preview_colors;

vv_status vvi_preview_colors_new(vvi_preview_colors **out, const vv_file *file);
void vvi_preview_colors_free(vvi_preview_colors *colors); /* NULL is fine */
/** Takes a sample into account for windows that nobody gave. */
void vvi_preview_colors_look(vvi_preview_colors *colors, const char *sample);
/** After the last one. Errors: VV_E_MEMORY. */
vv_status vvi_preview_colors_settle(vvi_preview_colors *colors, vv_job *job);
/** Red, green and blue, sRGB encoded, 0..1. */
void vvi_preview_color(float rgb_out[3], const vvi_preview_colors *colors, const char *sample);
bool vvi_preview_colors_nearest(const vvi_preview_colors *colors);
#endif
