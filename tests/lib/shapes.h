/** @file
 * Meshes whose measures are known from a formula.
 */
#ifndef TEST_SHAPES_H
#define TEST_SHAPES_H
#include <volvis/mesh.h>

/** A copy of these arrays: three floats a vertex, three vertices a triangle. Unit "mm". */
vv_mesh *test_mesh_new(const float *positions, size_t n_vertices, const uint32_t *triangles, size_t n_triangles);
/** The box [0, x] x [0, y] x [0, z] of 12 triangles facing outwards, moved by `origin`. */
vv_mesh *test_mesh_box(double x, double y, double z, vv_vec3 origin);
/** A sphere of vertices on it: an icosahedron whose triangles are split in 4 that many times. */
vv_mesh *test_mesh_sphere(vv_vec3 center, double radius, int splits);
/** The flat square [0, size]^2 at z = 0 of 2 n^2 triangles, n at least 1, facing up. */
vv_mesh *test_mesh_square(double size, uint32_t n);
/** By Marching Cubes of their distances, without normals if so wanted, in voxels; centers off the samples. */
vv_mesh *test_mesh_marched_sphere(double radius, bool normals);
vv_mesh *test_mesh_marched_torus(double major, double minor);
/** The same triangles, each with vertices of its own. */
vv_mesh *test_mesh_unshared(const vv_mesh *mesh);
/** The same mesh less its last triangles. */
vv_mesh *test_mesh_less(const vv_mesh *mesh, size_t n_triangles);
#endif
