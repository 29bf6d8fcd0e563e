/** @file
 * What Marching Cubes does in a cell: for each pattern of corners inside the surface, and for each decision on the
 * faces where that pattern has two meanings, the triangles. The table is made by make_cases.c when VolVis is built.
 *
 * Corner c = x + 2 y + 4 z. Edges run up their axis: 0 to 3 along x at (y, z) = (0,0) (1,0) (0,1) (1,1); 4 to 7 along y
 * at (x, z); 8 to 11 along z at (x, y). Faces: x = 0, x = 1, y = 0, y = 1, z = 0, z = 1.
 */
#ifndef VVI_SURFACE_CASES_H
#define VVI_SURFACE_CASES_H
#include <stdint.h>

enum {
    VVI_CASES = 656,         /* patterns with their decisions */
    VVI_CASE_TRIANGLES = 12, /* of one case, at most */
    VVI_CASE_INTERIOR = 1,   /* vertices inside the cell, at most */
    VVI_CASE_LOOPS = 4,      /* pieces of surface, at most */
    VVI_CASE_AMBIGUOUS = 255
};

typedef struct vvi_case {
    uint16_t edges; /**< bit e: edge e is crossed */
    uint8_t n_triangles, n_interior, n_loops;
    /** Three vertices each, counter-clockwise as seen from outside: an edge, or 12 + i for interior vertex i. */
    uint8_t triangle[3 * VVI_CASE_TRIANGLES];
    uint8_t loop[VVI_CASE_TRIANGLES];   /**< which piece of surface a triangle belongs to */
    uint8_t faces[VVI_CASE_LOOPS];      /**< bit f: that piece meets face f */
    uint16_t around[VVI_CASE_INTERIOR]; /**< the edges whose crossings interior vertex i is the mean of */
} vvi_case;

/** A pattern's cases begin at vvi_case_first[pattern], in the order of its decisions: bit i of the decision is the i-th
 * of the faces in vvi_case_ambiguous[pattern], lowest first, and is 1 where the corners inside are joined on that face.
 */
/** A case as the inner loop wants it: up to five triangles are written at once. The numbers of the vertices come from
 * eight counters: those of the edges along x, in their order, then along y at z and at z + 1, along z at y and at y
 * + 1. */
typedef struct vvi_case_quick {
    uint8_t triangle[16]; /**< three edges each, the first five triangles */
    uint8_t ahead[16];    /**< of each edge: what its vertex lies after its counter */
    uint8_t step[8];      /**< how far the counters move on */
    uint8_t n_triangles, n_interior;
    uint8_t padding[6];
} vvi_case_quick;

extern const vvi_case vvi_cases[VVI_CASES];
extern const vvi_case_quick vvi_cases_quick[VVI_CASES];
extern const uint16_t vvi_case_first[256];
extern const uint8_t vvi_case_ambiguous[256];
/** Triangles of a pattern; VVI_CASE_AMBIGUOUS where it has several cases or an interior vertex. */
extern const uint8_t vvi_case_triangles[256];
/** The corners of a face in cyclic order, clockwise from outside. */
extern const uint8_t vvi_face_corners[6][4];
#endif
