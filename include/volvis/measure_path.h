/** @file
 * Shortest paths along surfaces.
 */
#ifndef VOLVIS_MEASURE_PATH_H
#define VOLVIS_MEASURE_PATH_H
#include <volvis/measure_mesh.h>
VV_BEGIN_DECLS

/** Options of vv_mesh_geodesic(). Fill with vv_mesh_path_options_init(), then change what you need. */
typedef struct vv_mesh_path_options {
    size_t size;          /**< set by init */
    vv_affine to_world;   /**< applied to every vertex first; default: identity */
    char unit[16];        /**< of lengths after that; default "": the mesh's */
    uint64_t max_windows; /**< effort: when so many are not enough the path may not be the shortest; default 0: 8
                             million, about 600 MB */
} vv_mesh_path_options;

/** A way along a surface. */
typedef struct vv_mesh_path {
    vv_figure length; /**< error: by how much a shorter one may be shorter; rounding when it is the shortest. That the
                           triangles are not the surface that they stand for is not in it */
    bool shortest;    /**< there is no shorter one */
    size_t n_points;  /**< at least 2: places on edges and corners, from the first to the last */
    vv_vec3 *points;  /**< in the world */
} vv_mesh_path;

VV_API void vv_mesh_path_options_init(vv_mesh_path_options *options, size_t size);

/**
 * The shortest path along the triangles between two places; both are moved to the nearest of the surface first.
 *
 * Exact: intervals of edges that see a source straight along the surface are carried from triangle to triangle; what
 * cannot be on a path to the goal that is shorter than the shortest known one is left out. That one comes from the
 * edges, and on large meshes from bands of triangles around it. So the cost grows with the places that are nearly as
 * short a way: about a second for 20 000 triangles of a sphere between its poles, far less for most pairs of places.
 *
 * Errors   VV_E_ARGUMENT (no triangles, a vertex that is not finite, no path between the places), VV_E_MEMORY,
 *          VV_E_CANCELLED
 * Owns     *out is for vv_mesh_path_finish(), also on errors
 * Threads  any; runs on this one; same bytes each time
 * Limits   where more than two triangles share an edge there is a way along it, but not across
 * Source   Mitchell, Mount & Papadimitriou 1987; Chen & Han 1990; filter and order: Xin & Wang 2009
 */
VV_API vv_status vv_mesh_geodesic(vv_mesh_path *out, const vv_mesh *mesh, vv_vec3 from, vv_vec3 to,
                                  const vv_mesh_path_options *options, vv_job *job);
VV_API void vv_mesh_path_finish(vv_mesh_path *path); /* zeroed ones are fine */

VV_END_DECLS
#endif
