/** @file
 * The faces that meshes show where planes cut them: meshes themselves, drawn beside what they belong to by whoever
 * draws triangles.
 */
#ifndef VVI_RENDER_MESH_CAPS_H
#define VVI_RENDER_MESH_CAPS_H
#include "core/status.h"
#include <volvis/sys/scene.h>

typedef struct vvi_mesh_cap {
    vv_mesh_actor actor; /**< in the colours of parts, else in the volume's own; cut by all planes but its own */
    size_t owner;        /**< which of the scene's meshes */
    struct vvi_cached *section;
} vvi_mesh_cap;

typedef struct vvi_mesh_caps {
    vvi_mesh_cap *cap;
    size_t n;
} vvi_mesh_caps;

/** Of all meshes of a scene with shading.cap; that one is open where it is cut, and hollow there, is a warning. Errors:
 * VV_E_MEMORY, VV_E_LIMIT, VV_E_CANCELLED; then close it too. The scene lives longer. */
vv_status vvi_mesh_caps_open(vvi_mesh_caps *out, const vv_scene *scene, vv_job *job);
void vvi_mesh_caps_close(vvi_mesh_caps *caps); /* zeroed is fine */
#endif
