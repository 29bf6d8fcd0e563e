/** @file
 * The pieces of a mesh: what triangles join by the vertices that they share. Sorted by size, the largest first, and
 * only those that are wanted.
 */
#ifndef VVI_SURFACE_PIECES_H
#define VVI_SURFACE_PIECES_H
#include "core/status.h"
#include <volvis/mesh.h>

typedef enum vvi_piece_size {
    VVI_PIECE_AREA,
    VVI_PIECE_VOLUME /**< that it encloses, a hollow's too; of a piece that is not closed, a number without meaning */
} vvi_piece_size;

typedef struct vvi_pieces_options {
    vvi_piece_size size;
    size_t most;  /**< that are kept; 0: all */
    double least; /**< size of those that are kept, in squares or cubes of the mesh's unit */
} vvi_pieces_options;

/** How large a piece is. */
typedef struct vvi_piece {
    uint32_t first_vertex; /**< of the mesh that was looked at */
    size_t n_triangles, n_vertices;
    double area, volume; /**< negative: it faces inwards, as hollows do */
} vvi_piece;

/** All pieces that have triangles, in the order of the options, which may leave some out. *out: vvi_free(). On this
 * thread. Errors: VV_E_MEMORY, VV_E_CANCELLED. */
vv_status vvi_find_pieces(vvi_piece **out, size_t *n_out, const vv_mesh *mesh, const vvi_pieces_options *options,
                          vv_job *job);

/**
 * The same as a mesh with a part for each piece. Vertices and triangles of a piece keep their order; vertices without
 * triangles go. A part is named "piece 1", ..., after the name that its first triangle's part had, whose colour it
 * has.
 *
 * Errors   VV_E_MEMORY, VV_E_CANCELLED, VV_E_ARGUMENT (a size that is not a number)
 * Owns     *out is the caller's
 */
vv_status vvi_mesh_pieces(vv_mesh **out, const vv_mesh *mesh, const vvi_pieces_options *options, vv_job *job);
#endif
