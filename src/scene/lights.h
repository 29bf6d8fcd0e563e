/** @file
 * Lights of a World, brought to world space for one lens.
 */
#ifndef VVI_SCENE_LIGHTS_H
#define VVI_SCENE_LIGHTS_H
#include "core/status.h"
#include <volvis/sys/scene.h>

/** One light that no World has: what shines where none is given. */
typedef struct vvi_default_light {
    const char *id;
    vv_vec3 direction; /**< camera axes, of travel */
    double intensity;
} vvi_default_light;
/** By number; NULL past the end. */
const vvi_default_light *vvi_default_light_nth(size_t index);

/** Lamps (room for world->lights->n, at least vvi_lamps_room()) and the sum of all light that comes from everywhere.
 * Lights that are off are left out; a World that lists none gets the default key and fill. Errors: VV_E_ARGUMENT with
 * the light's path: a direction of no length, a falloff that divides by 0. */
vv_status vvi_resolve_lights(vv_lamp *lamps_out, size_t *n_out, float ambient_out[3], const vv_world *world,
                             const vv_lens *lens);
size_t vvi_lamps_room(const vv_world *world);

#endif
