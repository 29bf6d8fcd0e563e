/** @file
 * Decorations: what a view wants drawn over its picture (views.<view>.decorations), whatever renderer made it.
 */
#ifndef VVI_RENDER_DECORATE_H
#define VVI_RENDER_DECORATE_H
#include "gfx/gfx.h"
#include <volvis/sys/scene.h>

/** Whether the scene's view wants any. */
bool vvi_decorate_wanted(const vv_scene *scene);
/** Errors of the properties, before any work: placeholders that there are not. */
vv_status vvi_decorate_check(const vv_scene *scene);
/** Draws them on a picture that has no background yet: what stands in the World is hidden by what is nearer by the
 * picture's depth. Layers stay what they are. Without a font: a warning, and no letters. */
vv_status vvi_decorate(vv_image *image, const vv_scene *scene, vv_job *job);
/** The same in a figure that is being drawn; `image` tells what is covered. */
vv_status vvi_decorate_figure(vvi_gfx *gfx, const vv_image *image, const vv_scene *scene, vv_job *job);
/** The picture with depths that hide decorations: a copy of its own, or of all that is seen where no depth is one.
 * view_out->depth: vvi_free(). */
vv_status vvi_decorate_view(vv_image *view_out, const vv_image *image, const vv_scene *scene, vv_job *job);
#endif
