/** @file
 * Surfaces as a page draws them: one run of bytes each, which says all that is needed to make triangles of it.
 * All numbers are little-endian. All kinds begin with
 *
 *   0    "VVS1"
 *   4    kind, 16 bits: 1 records, 2 triangles, 3 boxes
 *   6    flags, 16 bits
 *   8    12 doubles: three axes and the origin of the affine map from the numbers of a place below to the space of the
 *        field or the mesh; of records and boxes each whole number is a
 *        sample
 *
 * Records (a reduced surface; reduced.h says what is in them)
 *
 *        flags: bit c of 0 to 7: the grid's corner c = x + 2 y + 4 z is inside; bit 8: where the samples end the solid
 *        ends, and shows a face there
 *   104  samples along x, y, z; bricks; cells; triangles; bytes of records: 32 bits each
 *   132  for each of the 256 patterns of corners, how many triangles it has: a byte each
 *   388  bytes of the next, 32 bits
 *   392  the patterns' triangles, one pattern after the other: three edges each, a byte an edge, as cases.h has them;
 *        zeros up to a multiple of 4 bytes
 *        bricks: where it is in the grid of bricks, 3 times 16 bits, cells, 16 bits, its first byte in the records, 32
 *        the records
 *
 * Triangles
 *
 *        flags: bit 0: vertices have colours
 *   104  vertices, triangles: 32 bits each
 *   112  triangles: three vertices each, 32 bits each, counter-clockwise as seen from outside
 *        colours: red, green, blue, alpha of each vertex, a byte each, sRGB; where the flag is set
 *        vertices: place, 3 times 16 bits, and normal, 2 times 16 bits, signed, octahedral (Meyer et al. 2010); -32768
 *        twice: none, as at the corners of sharp edges
 *
 * Boxes: blocks of samples that are solid, each with the first samples of the next ones
 *
 *   104  samples along x, y, z; samples from a box to the next; boxes along x, y, z; triangles of their outer faces: 32
 *        bits each
 *   136  a bit for each box, by x, y, z, the lowest bit first: whether it is solid
 */
#ifndef VVI_SURFACE_COMPACT_H
#define VVI_SURFACE_COMPACT_H
#include "surface/reduced.h"

typedef struct vvi_compact {
    uint8_t *bytes; /**< for vvi_free() */
    size_t n;
} vvi_compact;

enum {
    VVI_COMPACT_RECORDS = 1,
    VVI_COMPACT_TRIANGLES = 2,
    VVI_COMPACT_BOXES = 3,
    VVI_COMPACT_ENDS = 1 << 8,
    VVI_COMPACT_COLORS = 1
};

/** `corners`: the eight lower bits of the flags; ends: the ninth. VV_E_LIMIT: more than 2^16 bricks along an axis;
 * VV_E_MEMORY. */
vv_status vvi_compact_reduced(vvi_compact *out, const vvi_reduced *reduced, unsigned corners, bool ends, vv_job *job);
/** `colors`: sRGB and alpha of each vertex; NULL: they have none. Places are as exact as 2^-16 of the longest side of
 * the mesh. VV_E_MEMORY, VV_E_LIMIT. */
vv_status vvi_compact_mesh(vvi_compact *out, const vv_mesh_info *mesh, const uint8_t *colors, vv_job *job);
/** `solid`: of vvi_surface_boxes_solid(), `grid`: of its field; boxes of `least` and more are solid. The number of
 * triangles goes to *triangles_out. VV_E_MEMORY, VV_E_READ, VV_E_CANCELLED, VV_E_LIMIT. */
vv_status vvi_compact_boxes(vvi_compact *out, size_t *triangles_out, const vv_field *solid, const vv_grid *grid,
                            int least, vv_job *job);
/** That boxes take. */
size_t vvi_compact_boxes_bytes(const vv_field *solid);
/** That it takes, with colours or without. */
size_t vvi_compact_mesh_bytes(size_t n_vertices, size_t n_triangles, bool colors);
#endif
