/** @file
 * Some triangles between the vertices of a mesh, on the way to a mesh of their own.
 */
#ifndef VVI_SURFACE_CHOSEN_TRIANGLES_H
#define VVI_SURFACE_CHOSEN_TRIANGLES_H
#include "core/status.h"
#include <volvis/mesh.h>

typedef struct vvi_chosen {
    const vv_mesh_info *mesh;
    uint32_t *triangles; /**< three a triangle: vertices of the mesh; its n_vertices + i: a copy of copied[i] */
    size_t n;            /**< triangles */
    uint32_t *copied;
    size_t n_copies;
    vv_mesh_part *parts; /**< as many as the mesh has; NULL where it has none */
} vvi_chosen;

/** The mesh's vertex, of one that may be a copy. */
static inline uint32_t vvi_chosen_original(const vvi_chosen *c, uint32_t vertex)
{
    return vertex < c->mesh->n_vertices ? vertex : c->copied[vertex - c->mesh->n_vertices];
}

/** With all that the mesh's vertices carry, in their old order, copies behind them; normals are made anew. Errors:
 * VV_E_MEMORY, VV_E_LIMIT, VV_E_CANCELLED. */
vv_status vvi_chosen_mesh(vv_mesh **out, const vvi_chosen *chosen, vv_job *job);
/** Places and triangles alone, in time that does not depend on the mesh's size. *vertex_out: of each vertex its number
 * before; vvi_free(). `number`: room for one of each vertex and copy, all UINT32_MAX, which they are again. */
vv_status vvi_chosen_places(vv_mesh **out, uint32_t **vertex_out, const vvi_chosen *chosen, uint32_t *number,
                            vv_job *job);
/** Triangles of a mesh that was made of this one's vertices, some of them more than once: `triangles`, set, has the
 * vertex of this mesh for each corner, and gets one's copy for each vertex of `made` but the first that is the same.
 * `number`: as above, for the mesh's vertices alone. */
vv_status vvi_chosen_tell_copies(vvi_chosen *chosen, const vv_mesh_info *made, uint32_t *number, vv_job *job);
#endif
