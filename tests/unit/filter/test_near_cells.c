/* Cells near triangles: whatever is within the distance is in them, and what is far away is not. */
#include "fail_alloc.h"
#include "filter/near_cells.h"
#include "measure/triangle.h"
#include "shapes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

static vv_vec3 corner_at(const vv_mesh_info *m, size_t triangle, size_t k)
{
    const float *p = m->positions + 3 * (size_t)m->triangles[3 * triangle + k];
    return vvi_vec((double)p[0], (double)p[1], (double)p[2]);
}

static vvi_triangle triangle_at(const vv_mesh_info *m, size_t t)
{
    return (vvi_triangle){corner_at(m, t, 0), corner_at(m, t, 1), corner_at(m, t, 2)};
}

static void what_is_within_the_distance_is_touched(void **state)
{
    (void)state;
    vv_mesh *sphere = test_mesh_sphere((vv_vec3){3, -20, 400}, 10, 3);
    const vv_mesh_info *m = vv_mesh_get_info(sphere);
    for (double distance = 0.01; distance < 30; distance *= 4) {
        vvi_near_cells cells;
        size_t n_near = 0, n_touched = 0;
        assert_int_equal(vvi_near_cells_init(&cells, m, distance, NULL), VV_OK);
        vvi_near_cells_mark(&cells, m->positions, m->triangles + 3 * (size_t)77);
        const vvi_triangle marked = triangle_at(m, 77);
        for (size_t t = 0; t < m->n_triangles; t++) {
            vv_vec3 on[2];
            const vvi_triangle other = triangle_at(m, t);
            const double apart = sqrt(vvi_triangles_square(&on[0], &on[1], &marked, &other));
            const bool touched = vvi_near_cells_touch(&cells, m->positions, m->triangles + 3 * t);
            assert_true(touched || apart > distance);
            /* no farther than the diagonals of the boxes of both triangles, of what is around them and of a cell */
            assert_true(!touched || apart < 2 * sqrt(3) * (distance + fmax(distance, 20. / 128) + 3));
            n_near += apart <= distance;
            n_touched += touched;
        }
        assert_true(n_near >= 1 && n_touched >= n_near);
        assert_true(distance > 1 || n_touched < m->n_triangles / 4);
        vvi_near_cells_clear(&cells);
        for (size_t t = 0; t < m->n_triangles; t++)
            assert_false(vvi_near_cells_touch(&cells, m->positions, m->triangles + 3 * t));
        vvi_near_cells_finish(&cells);
    }
    vv_mesh_release(sphere);
}

/* A plane has no height: one cell is enough of it. */
static void a_plane_is_no_trouble(void **state)
{
    (void)state;
    vv_mesh *square = test_mesh_square(5, 4);
    const vv_mesh_info *m = vv_mesh_get_info(square);
    vvi_near_cells cells;
    assert_int_equal(vvi_near_cells_init(&cells, m, 0.1, NULL), VV_OK);
    assert_int_equal(cells.n[0] * cells.n[1] * cells.n[2], cells.n[0] * cells.n[1]);
    vvi_near_cells_mark(&cells, m->positions, m->triangles);
    assert_true(vvi_near_cells_touch(&cells, m->positions, m->triangles));
    assert_false(vvi_near_cells_touch(&cells, m->positions, m->triangles + 3 * (m->n_triangles - 1)));
    vvi_near_cells_finish(&cells);
    vv_mesh_release(square);
}

static vv_status make(void *user)
{
    vvi_near_cells cells = {0};
    const vv_status st = vvi_near_cells_init(&cells, vv_mesh_get_info(user), 1, NULL);
    vvi_near_cells_finish(&cells);
    return st;
}

static void short_memory_is_an_error(void **state)
{
    (void)state;
    vv_mesh *sphere = test_mesh_sphere((vv_vec3){0}, 10, 2);
    assert_int_equal(test_fail_each_alloc(make, sphere), 1);
    vv_mesh_release(sphere);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_within_the_distance_is_touched),
        cmocka_unit_test(a_plane_is_no_trouble),
        cmocka_unit_test(short_memory_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
