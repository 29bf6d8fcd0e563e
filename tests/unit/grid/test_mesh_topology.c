#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include "grid/mesh.h"
#include "jobs.h"
#include "meshes.h"
#include <cmocka.h>
#include <math.h>
#include <string.h>

/* The unit cube, turned outwards, and a vertex that nobody uses. */
static const float corners[9][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1},
                                    {1, 0, 1}, {0, 1, 1}, {1, 1, 1}, {5, 5, 5}};
static const uint32_t faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};

/* The first n_faces of the cube, and `extra` more as given. */
static vv_mesh *cube(size_t n_vertices, size_t n_faces, const uint32_t *extra, size_t n_extra)
{
    vv_mesh *mesh;
    vvi_mesh_arrays a;
    const vv_mesh_info info = {.n_vertices = n_vertices, .n_triangles = n_faces + n_extra, .origin = {1e7, -1e7, 3}};
    assert_int_equal(vvi_mesh_new(&mesh, &a, &info, 0, NULL), VV_OK);
    memcpy(a.positions, corners, n_vertices * sizeof *corners);
    memcpy(a.triangles, faces, n_faces * sizeof *faces);
    if (n_extra)
        memcpy(a.triangles + 3 * n_faces, extra, n_extra * 3 * sizeof *extra);
    return mesh;
}

static void expect(vv_mesh *mesh, const vv_mesh_topology *want)
{
    vv_mesh_topology got;
    assert_int_equal(vv_mesh_count_topology(&got, mesh, NULL), VV_OK);
    assert_int_equal(got.n_edges, want->n_edges);
    assert_int_equal(got.n_open_edges, want->n_open_edges);
    assert_int_equal(got.n_crowded_edges, want->n_crowded_edges);
    assert_int_equal(got.n_turned_edges, want->n_turned_edges);
    assert_int_equal(got.n_degenerate, want->n_degenerate);
    assert_int_equal(got.n_unused, want->n_unused);
    assert_int_equal(got.n_pieces, want->n_pieces);
    vv_mesh_release(mesh);
}

static void a_closed_cube_has_no_bad_edges(void **state)
{
    (void)state;
    expect(cube(8, 12, NULL, 0), &(vv_mesh_topology){.n_edges = 18, .n_pieces = 1});
}

static void a_missing_triangle_leaves_three_open_edges(void **state)
{
    (void)state;
    expect(cube(8, 11, NULL, 0), &(vv_mesh_topology){.n_edges = 18, .n_open_edges = 3, .n_pieces = 1});
}

static void a_turned_triangle_has_three_turned_edges(void **state)
{
    (void)state;
    const uint32_t turned[3] = {3, 5, 7};
    expect(cube(8, 11, turned, 1), &(vv_mesh_topology){.n_edges = 18, .n_turned_edges = 3, .n_pieces = 1});
}

static void a_third_triangle_at_an_edge_crowds_it(void **state)
{
    (void)state;
    const uint32_t fin[3] = {0, 1, 8};
    expect(cube(9, 12, fin, 1),
           &(vv_mesh_topology){.n_edges = 20, .n_open_edges = 2, .n_crowded_edges = 1, .n_pieces = 1});
}

static void degenerate_triangles_and_unused_vertices_are_counted(void **state)
{
    (void)state;
    const uint32_t flat[6] = {0, 0, 1, 7, 7, 7};
    expect(cube(9, 12, flat, 2), &(vv_mesh_topology){.n_edges = 18, .n_degenerate = 2, .n_unused = 1, .n_pieces = 1});
}

static void nothing_has_no_pieces(void **state)
{
    (void)state;
    expect(cube(0, 0, NULL, 0), &(vv_mesh_topology){0});
}

static void a_vertex_with_many_edges_is_counted(void **state)
{
    (void)state;
    enum { N = 1009 };
    vv_mesh *mesh;
    vvi_mesh_arrays a;
    const vv_mesh_info info = {.n_vertices = N + 1, .n_triangles = N};
    assert_int_equal(vvi_mesh_new(&mesh, &a, &info, 0, NULL), VV_OK);
    for (size_t i = 0; i <= N; i++) {
        a.positions[3 * i] = i ? cosf((float)i) : 0;
        a.positions[3 * i + 1] = i ? sinf((float)i) : 0;
        a.positions[3 * i + 2] = 0;
    }
    for (uint32_t i = 0; i < N; i++) {
        a.triangles[3 * i] = 0;
        a.triangles[3 * i + 1] = 1 + i;
        a.triangles[3 * i + 2] = 1 + (i + 1) % N;
    }
    expect(mesh, &(vv_mesh_topology){.n_edges = 2 * N, .n_open_edges = N, .n_pieces = 1});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_closed_cube_has_no_bad_edges),
        cmocka_unit_test(a_missing_triangle_leaves_three_open_edges),
        cmocka_unit_test(a_turned_triangle_has_three_turned_edges),
        cmocka_unit_test(a_third_triangle_at_an_edge_crowds_it),
        cmocka_unit_test(degenerate_triangles_and_unused_vertices_are_counted),
        cmocka_unit_test(nothing_has_no_pieces),
        cmocka_unit_test(a_vertex_with_many_edges_is_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
