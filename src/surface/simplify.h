/** @file
 * Fewer triangles for nearly the same surface.
 */
#ifndef VVI_SURFACE_SIMPLIFY_H
#define VVI_SURFACE_SIMPLIFY_H
#include "core/status.h"
#include <volvis/mesh.h>

typedef struct vvi_simplify_options {
    uint64_t triangles;   /**< the budget; 0: none, the error alone decides */
    double error;         /**< how far the surface may move, in the mesh's unit; 0: as far as the budget asks for */
    bool fix_border;      /**< vertices at open edges stay */
    const uint8_t *still; /**< of each vertex: not 0: the triangles around it stay as they are; NULL: of none */
    const uint8_t *keep;  /**< of each triangle: not 0: it is there as it was, whatever else is; NULL: of none */
    bool uncounted;       /**< an attempt: pieces are not counted, and no progress is told */
    uint32_t *corners;    /**< room for three of each triangle, set: those of the new triangles, by the mesh's numbers;
                             NULL    is fine */
} vvi_simplify_options;

typedef struct vvi_simplify_result {
    size_t n_triangles;
    double error;         /**< estimate of how far the surface has moved, in the mesh's unit */
    size_t n_pieces;      /**< that the mesh had: what triangles join by the vertices that they share */
    size_t n_dropped;     /**< of those: of which nothing is left */
    size_t n_pieces_left; /**< that the new mesh has: where necks are cut more come of one */
    size_t n_crowded;     /**< edges of more than two triangles that are left */
    bool over_budget;     /**< no more could go within the error, or without changing how the surface hangs together */
} vvi_simplify_result;

/** Whether this build can simplify: it has meshoptimizer. */
bool vvi_can_simplify(void);

/**
 * A mesh of fewer triangles: edges collapse, the cheapest by quadric error first, until budget or error is reached.
 *
 * Vertices that stay are not moved and keep value and colour; normals, where there were any, are made anew. Parts stay
 * parts, each with its share of the budget by triangles; where they share vertices those stay. Vertices at the same
 * place are one to the surface, but a seam between them (two colours, say) is kept as a seam.
 *
 * Around triangles that stay as they are all open edges of their part stay too.
 *
 * First, edges that are nothing but rounding collapse, with the triangles of no area beside them: vvi_weld_edges().
 * What is closed stays closed. A thin handle or neck may close, and where surfaces would then share an edge or a vertex
 * they are cut apart, vvi_cut_apart(): vertices are copied there, and each edge has two triangles where it had before.
 * Edges with which that fails are counted. With an error no piece vanishes: what would is simplified again to a quarter
 * of the error, a sixteenth, ..., and at last stays as it is, be it triangles of no area; with a budget alone small
 * pieces go. Sheets may pass through one another: nobody looks for that.
 *
 * Error    the greatest quadric error of a collapse, as a length: an average over the planes around it, not a bound;
 *          vv_mesh_distance() between the two meshes measures how far it really is
 * Errors   VV_E_ARGUMENT (neither budget nor error, or one that is negative or no number), VV_E_UNSUPPORTED (no
 *          meshoptimizer in this build), VV_E_MEMORY, VV_E_LIMIT, VV_E_CANCELLED (only between parts)
 * Owns     *out is the caller's; result_out may be NULL
 * Threads  any; runs on this one alone; the same bytes each time
 * Source   Garland & Heckbert 1997, as in meshoptimizer by A. Kapoulkine
 */
vv_status vvi_mesh_simplify(vv_mesh **out, vvi_simplify_result *result_out, const vv_mesh *mesh,
                            const vvi_simplify_options *options, vv_job *job);
/** Sets the counts of pieces. corners: three of each triangle of the new mesh, by the mesh's numbers. Errors:
 * VV_E_MEMORY, VV_E_CANCELLED. */
vv_status vvi_simplify_count_pieces(vvi_simplify_result *out, const vv_mesh_info *mesh, const vv_mesh_info *made,
                                    const uint32_t *corners, vv_job *job);
#endif
