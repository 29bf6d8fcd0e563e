/** @file
 * Surfaces that touch themselves are cut apart there.
 */
#ifndef VVI_SURFACE_SELF_CONTACTS_H
#define VVI_SURFACE_SELF_CONTACTS_H
#include "core/status.h"
#include <volvis/runtime.h>

typedef struct vvi_cut {
    uint32_t *indices;      /**< in and out: three a triangle; those that stay keep their order */
    size_t n_indices;       /**< in and out */
    const float *positions; /**< three a vertex */
    size_t n_vertices;
    uint32_t *copied;           /**< out: of each vertex from n_vertices on, the one whose copy it is; vvi_free() */
    size_t n_copies, n_crowded; /**< out: edges that more than two triangles still share */
} vvi_cut;

/** Two triangles back to back go. Where more than two share an edge, those between which the solid lies stay together,
 * and each vertex gets a copy for each fan of triangles around it: edges of two triangles, vertices of one fan (Gueziec
 * et al. 2001). Nothing moves, and what is closed stays closed. On this thread. Errors: VV_E_MEMORY, VV_E_CANCELLED;
 * copied is NULL then. */
vv_status vvi_cut_apart(vvi_cut *mesh, vv_job *job);
#endif
