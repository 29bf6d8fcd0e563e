/** @file
 * Where rays meet the triangles of a mesh: a tree of boxes around them, made once and kept in the runtime's cache.
 */
#ifndef VVI_RENDER_MESH_TREE_H
#define VVI_RENDER_MESH_TREE_H
#include "core/cache.h"
#include <volvis/mesh.h>

/** Whether this build can make trees: with Embree, of which version; "" without it. */
bool vvi_mesh_tree_exists(void);
const char *vvi_mesh_tree_version(void);

/** The tree of a mesh, pinned: vvi_cache_release(). Errors: VV_E_UNSUPPORTED (a build without Embree), VV_E_MEMORY,
 * VV_E_LIMIT, VV_E_CANCELLED. */
vv_status vvi_mesh_tree_get(vvi_cached **out, const vv_mesh *mesh, vv_job *job);

/** The box of its positions, grown by a millionth of their reach: a flat mesh has one that rays pass through, too. */
void vvi_mesh_tree_box(double lo_out[3], double hi_out[3], const vvi_cached *cached);

/** A ray among the positions of a mesh, which its origin is not added to. Distances are in lengths of `direction`. */
typedef struct vvi_mesh_ray {
    float origin[3], direction[3], near, far;
} vvi_mesh_ray;

/** Where it meets a triangle: at the sum of its corners times 1 - u - v, u and v. */
typedef struct vvi_mesh_hit {
    float distance, u, v;
    uint32_t triangle;
} vvi_mesh_hit;

/** Asked of each hit that may be the nearest, in no order: whether it counts. */
typedef bool vvi_mesh_take_fn(void *user, const vvi_mesh_hit *hit);

/**
 * The nearest hit that counts; false: there is none. A ray through an edge meets at least one of its triangles.
 *
 * cached   of vvi_mesh_tree_get()
 * take     NULL: all count
 * Threads  any
 * Source   Wald, Woop, Benthin, Johnson and Ernst 2014 (Embree)
 */
bool vvi_mesh_tree_hit(vvi_mesh_hit *out, const vvi_cached *cached, const vvi_mesh_ray *ray, vvi_mesh_take_fn *take,
                       void *user);
#endif
