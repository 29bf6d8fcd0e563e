/** @file
 * The part of a volume that is seen: what a camera that nobody placed looks at.
 */
#ifndef VVI_SCENE_VISIBLE_VOLUME_H
#define VVI_SCENE_VISIBLE_VOLUME_H
#include "core/status.h"
#include <volvis/sys/scene.h>

/** So many directions are looked along for what lies farthest out. */
enum { VVI_VISIBLE_POINTS = 98 };

/**
 * Points, in samples of the actor's grid, that lie farthest out of what its classification, or the renderer's solid,
 * shows: by blocks of 4 or 8 voxels and how opaque they can be. Pieces that are apart and together make up less than a
 * tenth of what is seen (specks of noise, a scanner's table) are left out where they would make the box around it
 * longer by more than a tenth. Where everything is seen, nothing is, or a projection shows each ray's values, they are
 * corners of the box of all samples. Kept in the cache.
 *
 * Errors  those of reading samples; VV_E_CANCELLED. Where there is no memory to look, it is the box.
 */
vv_status vvi_visible_points(vv_vec3 out[VVI_VISIBLE_POINTS], const vv_scene *scene, const vv_actor *actor,
                             vv_job *job);
#endif
