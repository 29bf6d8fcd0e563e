/** @file
 * A mesh as paths need it: welded, with its neighbours, and with the ends of the path among its vertices.
 */
#ifndef VVI_MEASURE_PATH_MESH_H
#define VVI_MEASURE_PATH_MESH_H
#include "core/status.h"
#include <volvis/mesh.h>

#define VVI_NONE UINT32_MAX

/** Edge 3 t + k goes from corner k of triangle t to corner k + 1. */
typedef struct vvi_path_mesh {
    size_t n_vertices, n_triangles;
    vv_vec3 *place;     /**< of vertices, from `origin` */
    vv_vec3 origin;     /**< in the world */
    uint32_t *triangle; /**< 3 vertices each, all different */
    double *length;     /**< of edges */
    uint32_t *twin;     /**< of edges: the same one in the only other triangle that has it; VVI_NONE: there is none */
    size_t *first;      /**< corners around vertex v: from first[v] to first[v + 1] of */
    uint32_t *corner;   /**< , numbers 3 t + k */
    bool *turning;      /**< vertices that a shortest path may turn at: at a border, or with more than a full angle */
    uint32_t from, to;  /**< vertices */
} vvi_path_mesh;

/** Errors as vv_mesh_geodesic(). */
vv_status vvi_path_mesh_init(vvi_path_mesh *out, const vv_mesh_info *mesh, const vv_affine *to_world, vv_vec3 from,
                             vv_vec3 to, vv_job *job);
void vvi_path_mesh_finish(vvi_path_mesh *mesh); /* zeroed ones are fine */

static inline uint32_t vvi_edge_start(const vvi_path_mesh *m, uint32_t edge)
{
    return m->triangle[edge];
}
/** The next edge of the same triangle. */
static inline uint32_t vvi_edge_next(uint32_t edge)
{
    return edge % 3 == 2 ? edge - 2 : edge + 1;
}
static inline uint32_t vvi_edge_end(const vvi_path_mesh *m, uint32_t edge)
{
    return m->triangle[vvi_edge_next(edge)];
}
/** The corner that the edge does not touch. */
static inline uint32_t vvi_edge_apex(const vvi_path_mesh *m, uint32_t edge)
{
    return m->triangle[vvi_edge_next(vvi_edge_next(edge))];
}
#endif
