/** @file
 * The search for shortest paths, in all of a mesh or in a part of it.
 */
#ifndef VVI_MEASURE_PATH_SEARCH_H
#define VVI_MEASURE_PATH_SEARCH_H
#include "measure/path_mesh.h"

/** A place on a path: on the edge between two vertices, or a vertex, twice. */
typedef struct vvi_path_place {
    vv_vec3 at;
    uint32_t vertex[2];
} vvi_path_place;

/** A path from m->from to m->to; zeroed ones are empty. */
typedef struct vvi_path {
    vvi_path_place *places;
    size_t n, room;
    double length;
    double least; /**< no path is shorter */
} vvi_path;

vv_status vvi_path_add(vvi_path *path, vv_vec3 at, uint32_t a, uint32_t b, vv_job *job);
void vvi_path_finish(vvi_path *path);
/** Sets the length to that of its places; turns them round. */
void vvi_path_complete(vvi_path *path);

/** The shortest path along edges. Errors: VV_E_ARGUMENT (there is none). */
vv_status vvi_path_along_edges(vvi_path *out, const vvi_path_mesh *mesh, vv_job *job);
/** Makes *path, which is one, the shortest of those through triangles whose vertices are `allowed` (NULL: all), or
 * leaves it when nothing better was found. Sets its `least` for the allowed part; it is its length, but for rounding,
 * when max_windows were enough. */
vv_status vvi_path_shorten(vvi_path *path, const vvi_path_mesh *mesh, const bool *allowed, uint64_t max_windows,
                           vv_job *job);
#endif
