/** @file
 * Pieces of meshes, and meshes as sets of triangles, worked out the slow way.
 */
#ifndef TEST_MESH_PIECES_H
#define TEST_MESH_PIECES_H
#include <volvis/mesh.h>

/** A triangle as its corners' places and normals (0 without), beginning with the corner that sorts first. */
typedef struct test_triangle {
    float corner[3][6];
} test_triangle;

/** For each vertex the lowest vertex of its piece; free(). */
uint32_t *test_mesh_pieces(const vv_mesh *mesh, size_t *n_pieces_out);
/** The triangles of the piece with this lowest vertex (UINT32_MAX: of all), sorted; free(). */
test_triangle *test_mesh_triangles(const vv_mesh *mesh, const uint32_t *pieces, uint32_t piece, size_t *n_out);
/** The vertex nearest to a place. */
uint32_t test_mesh_nearest(const vv_mesh *mesh, vv_vec3 place);
#endif
