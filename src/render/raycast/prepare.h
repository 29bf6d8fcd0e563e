/** @file
 * The steps of preparing a frame of the ray caster, one subject a file.
 */
#ifndef VVI_RENDER_RAYCAST_PREPARE_H
#define VVI_RENDER_RAYCAST_PREPARE_H
#include "render/common/transfer_integral.h"
#include "render/raycast/raycast.h"

/** Samples, place and light of one volume, which a frame is worked out for. */
vv_status vvi_raycast_open_volume(vvi_raycast_volume *v, const vv_scene *scene, double step, vv_job *job);

/** Colour and opacity by value: the table as well, for vvi_raycast_find_blocks(). */
vv_status vvi_raycast_classify(vvi_raycast_volume *v, vvi_transfer_table *table, const vv_scene *scene, vv_job *job);
/** Where colours come from, if not from the classification. */
vv_status vvi_raycast_find_paint(vvi_raycast_volume *v, vv_job *job);
/** Order, threshold and lengths of the modes that show one value of each ray. */
void vvi_raycast_find_projection(vvi_raycast_volume *v, const vvi_raycast_params *p);
/** Between which stored values it is solid. */
void vvi_raycast_find_solid(vvi_raycast_volume *v, const vvi_raycast_params *params);

/** Blocks to jump; table NULL: a solid. Clears v->visible where all of them are. */
vv_status vvi_raycast_find_blocks(vvi_raycast_volume *v, const vvi_transfer_table *table, vv_job *job);
/** Where rays meet boxes that may show something (PARC), likewise. */
vv_status vvi_raycast_bound_rays(vvi_raycast_volume *v, const vv_scene *scene, const vvi_transfer_table *table,
                                 vv_job *job);

#endif
