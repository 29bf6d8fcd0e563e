/** @file
 * Meshes along the rays of a batch: opaque ones end rays, translucent ones are met one after the other.
 */
#ifndef VVI_RENDER_RAYCAST_MESH_RAYS_H
#define VVI_RENDER_RAYCAST_MESH_RAYS_H
#include "core/cache.h"
#include "gfx/lamp.h"
#include "gfx/mesh_look.h"
#include "render/common/light_volume.h"
#include "render/common/mesh_caps.h"
#include "render/march/rays.h"

/** One mesh of a frame. */
typedef struct vvi_ray_mesh {
    const vv_mesh_actor *actor;
    uint32_t id; /**< as the id layer has it */
    vvi_cached *tree;
    vv_mesh_info shown;
    vvi_gfx_surface surface; /**< of `shown` */
    vv_affine to_mesh;       /**< from the world to its positions, without their origin */
    vv_affine to_world;      /**< and back */
    double lo[3], hi[3];     /**< of them */
    bool translucent;
    vvi_gloss gloss;
} vvi_ray_mesh;

typedef struct vvi_ray_meshes {
    const vv_scene *scene;
    vvi_mesh_caps caps;
    vvi_ray_mesh *mesh; /**< those of the scene, and their caps */
    size_t n;
    bool translucent; /**< some of them is */
    vvi_gfx_decode decode;
    vvi_gfx_view view;             /**< of the scene's lens */
    const vvi_light_volume *light; /**< NULL: all light arrives everywhere */
} vvi_ray_meshes;

/** What of meshes lies on the rays of a batch. Rays that meet none have depth INFINITY there. */
typedef struct vvi_mesh_sink {
    vvi_sink sink; /**< through: 1 less the opacity */
    uint32_t id[VVI_RAY_BATCH];
    float normal[3][VVI_RAY_BATCH]; /**< world, length 1, on the ray's side; 0: not known */
} vvi_mesh_sink;

/** Errors: those of vvi_mesh_tree_get(). Then close it too; zeroed is fine. */
vv_status vvi_ray_meshes_open(vvi_ray_meshes *out, const vv_scene *scene, vv_job *job);
void vvi_ray_meshes_close(vvi_ray_meshes *meshes);

/** The nearest opaque triangle between near and far of each ray; what is there already is kept where it is nearer. */
void vvi_ray_meshes_opaque(vvi_mesh_sink *inout, const vvi_ray_meshes *meshes, const vvi_rays *rays);
/** The nearest translucent one. How many rays have one. */
size_t vvi_ray_meshes_translucent(vvi_mesh_sink *out, const vvi_ray_meshes *meshes, const vvi_rays *rays);
#endif
