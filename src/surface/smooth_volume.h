/** @file
 * The volume of each closed piece of a mesh, kept while it is smoothed.
 */
#ifndef VVI_SURFACE_SMOOTH_VOLUME_H
#define VVI_SURFACE_SMOOTH_VOLUME_H
#include "core/status.h"
#include <volvis/mesh.h>

typedef struct vvi_smooth_piece {
    double origin[3]; /**< one of its vertices */
    double volume;    /**< at the beginning; negative: it faces inwards */
    double area;
    double a[4];  /**< volume where vertices are moved by d along their normals: a[0] + a[1] d + a[2] d^2 + a[3] d^3 */
    double shift; /**< the d that gives it the volume of the beginning */
    bool open;    /**< has no volume: an edge is open, or it is flat */
    bool done, mended;
} vvi_smooth_piece;

typedef struct vvi_smooth_pieces {
    vvi_smooth_piece *all;
    size_t n;
    uint32_t *of; /**< by vertex: its piece */
} vvi_smooth_pieces;

/** The pieces of a mesh, place[v] standing for vertex v, with volume and area; none is open yet but those without area.
 * Owns: vvi_smooth_pieces_finish(), also on errors. On this thread. Errors: VV_E_MEMORY, VV_E_CANCELLED. */
vv_status vvi_smooth_pieces_find(vvi_smooth_pieces *p, const vv_mesh_info *mesh, const uint32_t *place, vv_job *job);
void vvi_smooth_pieces_finish(vvi_smooth_pieces *p);
/** Moves the vertices of all pieces that are not done along their normals so that the volumes are what they were. Those
 * that have it, or have none, are done; the others have changed too much for that.
 * positions, from the origin of the piece, and normals (scratch): three for each vertex. */
void vvi_smooth_pieces_mend(vvi_smooth_pieces *p, double *positions, double *normals, const vv_mesh_info *mesh,
                            const uint32_t *place);
#endif
