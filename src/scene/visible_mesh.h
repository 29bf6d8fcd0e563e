/** @file
 * The part of a mesh that is seen: what a camera that nobody placed looks at.
 */
#ifndef VVI_SCENE_VISIBLE_MESH_H
#define VVI_SCENE_VISIBLE_MESH_H
#include "core/status.h"
#include <volvis/sys/scene.h>

/** So many directions are looked along for what lies farthest out: where nothing but the ways to these is known, a
 * ball's silhouette is 1.5 % larger at most. */
enum { VVI_SHAPE_POINTS = 386 };

/**
 * The vertices of triangles, in the World, that lie farthest out along each of the directions to a cube's surface of
 * 9 x 9 x 9 points; cut planes are not looked at. Without triangles all of them are its place's origin. Kept in the
 * cache. Errors: VV_E_MEMORY, VV_E_CANCELLED.
 */
vv_status vvi_visible_mesh_points(vv_vec3 out[VVI_SHAPE_POINTS], const vv_mesh_actor *shape, vv_job *job);
#endif
