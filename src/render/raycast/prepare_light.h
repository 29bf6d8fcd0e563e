/** @file
 * How much light arrives where, for a frame with shadows or ambient occlusion.
 */
#ifndef VVI_RENDER_RAYCAST_PREPARE_LIGHT_H
#define VVI_RENDER_RAYCAST_PREPARE_LIGHT_H
#include "render/raycast/prepare.h"
#include "scene/resolve.h"

/** Cells around all that is drawn, along the axes of the first volume: a cell is a whole number of its voxels on each
 * axis, and there is one more cell than it needs at each end. */
typedef struct vvi_light_frame {
    const vvi_raycast_volume *first; /**< NULL: there are meshes alone */
    vv_affine to_world;              /**< from the first volume's indices; of meshes alone, from cells */
    double lo[3];                    /**< where the cells begin, in indices: the border of a voxel */
    int32_t side[3], n[3];           /**< voxels of a cell; cells */
} vvi_light_frame;

/** What the visible volumes take of the light, per world length: the mean of up to 4 samples on each axis of a cell, of
 * each no more than an optical depth of 3 a voxel. */
vv_status vvi_raycast_fill_extinction(float *out, const vvi_light_frame *frame, const vvi_raycast_state *state,
                                      vv_job *job);

/** Adds what meshes take: opaque triangles an optical depth of 6 in each cell that they pass through, translucent ones
 * that of their opacity. */
vv_status vvi_raycast_add_meshes(float *inout, const vvi_light_grid *grid, const vvi_ray_meshes *meshes, vv_job *job);

/** Works out the light of a frame whose volumes and meshes are ready, and tells them; nothing where nobody asked. */
vv_status vvi_raycast_find_light(vvi_raycast_state *state, const vv_scene *scene, vv_job *job);
/** About what it takes at most around one grid, told before its samples are read. */
uint64_t vvi_raycast_light_bytes(const vv_grid *grid, vvi_lighting lighting);
#endif
