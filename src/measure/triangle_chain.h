/** @file
 * A closed polyhedron as a chain of oriented triangles, cut by planes one after the other. What a plane opens is closed
 * again by triangles from one point of the plane to the cut edges: some cancel others, but their sum is the cap, of any
 * shape. Volumes and caps are sums over the chain, so nothing ever has to be convex or in one piece.
 */
#ifndef VVI_MEASURE_TRIANGLE_CHAIN_H
#define VVI_MEASURE_TRIANGLE_CHAIN_H
#include "core/vec.h"

typedef enum vvi_chain_part {
    VVI_CHAIN_SURFACE, /**< of the object */
    VVI_CHAIN_BORDER,  /**< where the volume ends */
    VVI_CHAIN_WALL,    /**< to the next cell */
    VVI_CHAIN_CUT      /**< made by a plane */
} vvi_chain_part;

typedef struct vvi_chain_triangle {
    vv_vec3 p[3];
    vvi_chain_part part;
    vv_vec3 outwards; /**< of cuts: away from what is kept */
} vvi_chain_triangle;

/** Room for a cell, cut as often as a region can. */
enum { VVI_CHAIN_ROOM = 4096 };

typedef struct vvi_chain {
    int n;
    bool full; /**< there was no room for all */
    vvi_chain_triangle triangle[VVI_CHAIN_ROOM];
} vvi_chain;

void vvi_chain_add(vvi_chain *chain, vvi_chain_part part, vv_vec3 a, vv_vec3 b, vv_vec3 c);
/** Keeps what lies at plane.normal . p >= plane.offset. other: room for it. The result is in *chain. */
void vvi_chain_cut(vvi_chain *chain, vvi_chain *other, const vv_plane *plane);
#endif
