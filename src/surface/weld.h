/** @file
 * Tiny edges of triangles go.
 */
#ifndef VVI_SURFACE_WELD_H
#define VVI_SURFACE_WELD_H
#include "core/status.h"
#include <volvis/runtime.h>

typedef struct vvi_weld {
    uint32_t *indices;      /**< in and out: three a triangle; those that stay keep their order */
    size_t n_indices;       /**< in and out */
    const float *positions; /**< three a vertex */
    size_t n_vertices;
    bool fix_border; /**< vertices at open edges stay */
} vvi_weld;

/** How long an edge may be that is nothing but rounding: 1/10000 of the root mean square of all edges, or two steps of
 * a float where the coordinates are large. */
double vvi_tiny_edge(const vvi_weld *mesh);
/** Collapses edges shorter than `length` onto one of their vertices, the others in the order of the triangles, so that
 * the triangles of (nearly) no area beside them go. Only where the surface then hangs together as before: the two
 * vertices have no neighbours in common but those of the edge's own triangles (link condition, Dey et al. 1999).
 * Closed pieces that have tiny edges alone go as a whole. On this thread. Errors: VV_E_MEMORY, VV_E_CANCELLED. */
vv_status vvi_weld_edges(vvi_weld *mesh, double length, vv_job *job);
#endif
