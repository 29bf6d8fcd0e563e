/** @file
 * The reduced surface for navigation: Marching Cubes whose vertices take one of four places on an edge, kept as a few
 * bits a cell and made into triangles when they are drawn.
 *
 * A place is number q = min(3, floor(4 t)) of (2 q + 1) / 8 of the edge, so that all coordinates are eighths of a cell.
 * A cell that the surface passes is a record of 12 bits for where it is in its brick of 16^3 cells, 8 for which of its
 * corners are inside, and 2 for each edge that is crossed: 28 on the mean. Neighbours read the same q of the same two
 * samples, and corners inside are always apart on faces with two meanings: the surface has no cracks.
 *
 * Where that is still too much, every second, fourth, ... sample is taken, each the mean of those around it.
 */
#ifndef VVI_SURFACE_REDUCED_H
#define VVI_SURFACE_REDUCED_H
#include "core/status.h"
#include <volvis/mesh.h>

enum { VVI_REDUCED_SHIFT = 4, VVI_REDUCED_SIDE = 1 << VVI_REDUCED_SHIFT };

/** What becomes of samples that are left out. */
typedef enum vvi_reduced_filter {
    VVI_REDUCED_SMOOTH,    /**< weights 1 2 1 along each axis */
    VVI_REDUCED_KEEP_HIGH, /**< the largest of two, along each axis: nothing inside the surface is lost, and it grows by
                              half a step on the mean */
    VVI_REDUCED_KEEP_LOW   /**< the smallest: no gap is lost, and it shrinks */
} vvi_reduced_filter;

typedef struct vvi_reduced_options {
    double value; /**< of the surface, in the field's values */
    int component;
    int step;             /**< 1, 2, 4, ... 256 samples; 0: the least that the budgets allow */
    size_t max_triangles; /**< 0: no limit; not looked at if step is given */
    size_t max_bytes;     /**< of the records; 0: no limit; not looked at if step is given */
    vvi_reduced_filter filter;
    bool keep; /**< the samples that were taken, too */
} vvi_reduced_options;

/** The records of one brick, in the order of their places, beginning at a byte. */
typedef struct vvi_reduced_brick {
    int32_t at[3]; /**< in the grid of bricks */
    uint32_t n_cells, n_triangles;
    size_t first_byte, first_triangle;
} vvi_reduced_brick;

/** Immutable. Bricks by z, y, x. */
typedef struct vvi_reduced {
    vv_grid grid;    /**< of the samples that were taken */
    int32_t step[3]; /**< of the field's samples to one of these: thin axes keep more of theirs */
    int32_t n[3];    /**< bricks */
    size_t n_bricks, n_cells, n_triangles, n_bytes;
    vvi_reduced_brick *bricks;
    uint8_t *records; /**< n_bytes */
    vv_field
        *samples; /**< what was taken, less the value and rising as values do; NULL: not asked for, or the field's */
} vvi_reduced;

/** Places in eighths of a cell from the brick's corner, counter-clockwise as seen from outside (if the grid is not
 * mirrored), and the normal that follows from them: twice the area, in square eighths. */
typedef struct vvi_reduced_triangle {
    uint8_t corner[3][3];
    int16_t normal[3];
} vvi_reduced_triangle;

/**
 * The reduced surface of one value.
 *
 * Errors   VV_E_ARGUMENT, VV_E_UNSUPPORTED (labels), VV_E_LIMIT, VV_E_MEMORY, VV_E_READ, VV_E_CANCELLED
 * Owns     *out is the caller's: vvi_reduced_free()
 * Threads  same bytes for any thread count
 * Cost     one pass over the samples; a float for each of those that are taken unless step is 1
 */
vv_status vvi_reduced_make(vvi_reduced **out, const vv_field *field, const vvi_reduced_options *options, vv_job *job);
void vvi_reduced_free(void *reduced); /* NULL is fine */
/** What it holds in memory. */
size_t vvi_reduced_bytes(const vvi_reduced *reduced);

/** The n_triangles triangles of a brick. Any thread. */
void vvi_reduced_expand(vvi_reduced_triangle *out, const vvi_reduced *reduced, size_t brick);
/** All of it with shared vertices; normals are the mean of those of the triangles around, by area. Errors: VV_E_LIMIT,
 * VV_E_MEMORY, VV_E_CANCELLED. Same bytes for any thread count. */
vv_status vvi_reduced_mesh(vv_mesh **out, const vvi_reduced *reduced, vv_job *job);
#endif
