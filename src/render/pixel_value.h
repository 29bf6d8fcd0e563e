/** @file
 * What is seen where a pixel's depth is: volume, value, gradient, normal. From the depth alone, for the layers and the
 * picking of renderers that tell no more (those that do: VV_CAN_LAYERS); and what the data are at a place.
 */
#ifndef VVI_RENDER_PIXEL_VALUE_H
#define VVI_RENDER_PIXEL_VALUE_H
#include "grid/probe.h"
#include <volvis/sys/scene.h>

/** One visible volume, ready to be asked. */
typedef struct vvi_sight_volume {
    const vv_actor *actor;
    vvi_probe probe;
    vv_affine world_to_index;
    double lo[3], hi[3]; /**< where it has values, index space */
    double voxel;        /**< world */
    bool layer;          /**< shows one value of each ray, over what is behind it or before */
} vvi_sight_volume;

typedef struct vvi_sight {
    const vv_scene *scene;
    vvi_sight_volume *volumes;
    size_t n_volumes;
} vvi_sight;

/** Of a scene that outlives it. On failure there is nothing to close. */
vv_status vvi_sight_open(vvi_sight *out, const vv_scene *scene, vv_job *job);
void vvi_sight_close(vvi_sight *sight);

typedef struct vvi_seen {
    const vv_actor *actor; /**< NULL: no volume is there */
    uint32_t id;           /**< 1 + its number among the scene's; 0: none */
    vv_vec3 world, index;
    double value;
    vv_label_id label; /**< 0 where that is none, or does not fit */
    vv_vec3 gradient;  /**< value by world length */
    vv_vec3 normal;    /**< against the gradient, or of the face by which the ray enters; towards the eye; or 0 */
} vvi_seen;

/** At `depth` along the ray through (x, y), in pixels of the scene. Of several volumes the uppermost layer that hides
 * half of what is below it there, else the one with the largest extinction. */
void vvi_sight_at(vvi_seen *out, const vvi_sight *sight, double x, double y, double depth);

/** The same of the volume that a renderer says it is. */
void vvi_sight_of(vvi_seen *out, const vvi_sight *sight, uint32_t id, double x, double y, double depth);

/** The layers normal, id and value, where the image has them, from its depth; all threads. Normals that the renderer
 * drew stay; of a renderer that writes all of them nothing is filled. */
vv_status vvi_layers_fill(vv_image *image, const vv_scene *scene, vv_job *job);
#endif
