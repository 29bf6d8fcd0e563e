/** @file
 * One cell of Marching Cubes: what of it lies inside, bounded by triangles and by parts of its faces. In the cell's own
 * coordinates, 0 to 1. Corners, edges and faces are numbered as in surface/cases.h. depth: of each corner, how far it
 * is inside; where a bit of `pattern` is set it is not negative, and beside such a corner along an edge it is negative
 * where the bit is not set.
 */
#ifndef VVI_MEASURE_CELL_H
#define VVI_MEASURE_CELL_H
#include "measure/triangle_chain.h"
#include "surface/cases.h"

typedef struct vvi_cell {
    vv_vec3 point[12 + VVI_CASE_INTERIOR]; /**< of each edge that is crossed, and inside */
    unsigned points;                       /**< bit: that point is there */
    int n;                                 /**< triangles, three points each, counter-clockwise as seen from outside */
    const uint8_t *triangle;
} vvi_cell;

void vvi_cell_triangles(vvi_cell *out, const double depth[8], unsigned pattern);
/** The part of a face that is inside, turned out of the cell, to the chain as `part`. */
void vvi_cell_face(vvi_chain *chain, vvi_chain_part part, const double depth[8], unsigned pattern, int face);
/** How much of a face is inside, 0 to 1. */
double vvi_cell_face_area(const double depth[8], unsigned pattern, int face);
#endif
