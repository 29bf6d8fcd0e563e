/** @file
 * What is true of a mesh, worked out the slow way.
 */
#ifndef TEST_MESHES_H
#define TEST_MESHES_H
#include <volvis/mesh.h>

/** Edges that do not have exactly one triangle on each side, with opposite directions; as directed edges. */
size_t test_mesh_bad_edges(const vv_mesh *mesh);
/** Vertices - edges + triangles; for closed meshes whose vertices are all used. */
int64_t test_mesh_euler(const vv_mesh *mesh);
double test_mesh_area(const vv_mesh *mesh);
/** By the divergence theorem; positive when triangles face outwards. */
double test_mesh_volume(const vv_mesh *mesh);
/** Place of a vertex in the world. */
vv_vec3 test_mesh_vertex(const vv_mesh *mesh, size_t vertex);

/** A strip of n triangles (t, t + 1, t + 2) between n + 2 vertices at random places, in millimetres; parts: three of
 * them, where there are three triangles. FAR: a million off. TEXTURES: two images, coordinates of vertices, with PARTS,
 * of which the last has none; CORNERS: of corners. No triangles: no vertices. */
vv_mesh *test_mesh_strip(size_t n, unsigned with);
enum {
    TEST_MESH_NORMALS = 1,
    TEST_MESH_VALUES = 2,
    TEST_MESH_COLORS = 4,
    TEST_MESH_PARTS = 8,
    TEST_MESH_FAR = 16,
    TEST_MESH_TEXTURES = 32,
    TEST_MESH_CORNERS = 64
};
#endif
