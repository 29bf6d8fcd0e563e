/* Which triangles lie beyond a length of another surface: against planes, spheres and distances of samples. */
#include "grid/mesh.h"
#include "measure/far_triangles.h"
#include "meshes.h"
#include "shapes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

static vvi_beyond look(uint32_t *of, vv_mesh_tree *a, vv_mesh_tree *b, double distance, size_t step)
{
    vvi_beyond beyond = {.of = of, .step = step};
    assert_int_equal(vvi_mesh_beyond(&beyond, a, b, distance, NULL), VV_OK);
    return beyond;
}

static vv_mesh_tree *tree_of(vv_mesh *mesh)
{
    vv_mesh_tree *tree;
    assert_int_equal(vv_mesh_tree_new(&tree, mesh, NULL, NULL), VV_OK);
    vv_mesh_release(mesh);
    return tree;
}

static vv_mesh_tree *moved(vv_mesh *mesh, double z)
{
    vv_affine up = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .origin = {0, 0, z}};
    vv_mesh_tree *tree;
    assert_int_equal(vv_mesh_tree_new(&tree, mesh, &up, NULL), VV_OK);
    vv_mesh_release(mesh);
    return tree;
}

static void squares_of_other_triangles_are_as_far_apart_as_they_are(void **state)
{
    (void)state;
    static const size_t sides[][2] = {{1, 1}, {7, 23}, {23, 7}, {1, 31}, {31, 1}};
    uint32_t of[2 * 31 * 31];
    for (size_t i = 0; i < sizeof sides / sizeof *sides; i++) {
        vv_mesh_tree *a = tree_of(test_mesh_square(5, sides[i][0])), *b = moved(test_mesh_square(5, sides[i][1]), 0.25);
        const size_t n = vv_mesh_get_info(a->mesh)->n_triangles;
        assert_int_equal(look(of, a, b, 0.2501, 1).n, 0);
        const vvi_beyond beyond = look(of, a, b, 0.2499, 1);
        assert_int_equal(beyond.n, n);
        assert_true(fabs(beyond.largest - 0.25) < 1e-6);
        for (size_t t = 0; t < n; t++)
            assert_true(of[t] < vv_mesh_get_info(b->mesh)->n_triangles);
        assert_int_equal(look(of, a, b, 0.2499, 3).n, (n + 2) / 3);
        vv_mesh_tree_release(a);
        vv_mesh_tree_release(b);
    }
}

/* The middle of each triangle, and others in it, are the truth for a lower bound; the Hausdorff distance for an upper.
 */
static void what_is_not_beyond_has_no_place_that_is(void **state)
{
    (void)state;
    vv_mesh_tree *fine = tree_of(test_mesh_sphere((vv_vec3){0}, 10, 4)),
                 *coarse = tree_of(test_mesh_sphere((vv_vec3){0}, 10, 2));
    uint32_t *of = malloc(vv_mesh_get_info(fine->mesh)->n_triangles * sizeof *of);
    vv_mesh_distances d;
    assert_non_null(of);
    assert_int_equal(vv_mesh_distance(&d, fine, coarse, NULL, NULL), VV_OK);
    for (int way = 0; way < 2; way++) {
        vv_mesh_tree *a = way ? coarse : fine, *b = way ? fine : coarse;
        const vv_figure max = way ? d.b_to_a.max : d.a_to_b.max;
        const vv_mesh_info *m = vv_mesh_get_info(a->mesh);
        assert_int_equal(look(of, a, b, 1.002 * (max.value + max.error), 1).n, 0);
        assert_true(look(of, a, b, 0.998 * max.value, 1).n > 0);
        const double distance = 0.7 * max.value;
        const vvi_beyond beyond = look(of, a, b, distance, 1);
        size_t n_seen = 0;
        assert_true(beyond.largest >= distance && beyond.largest <= max.value + max.error);
        for (size_t t = 0; t < m->n_triangles; t++) {
            bool seen = false;
            for (int i = 0; i <= 20; i++)
                for (int j = 0; i + j <= 20; j++) {
                    vv_vec3 p = {0};
                    const double weight[3] = {i / 20.0, j / 20.0, (20 - i - j) / 20.0};
                    for (int k = 0; k < 3; k++) {
                        const vv_vec3 c = test_mesh_vertex(a->mesh, m->triangles[3 * t + (size_t)k]);
                        p = (vv_vec3){p.x + weight[k] * c.x, p.y + weight[k] * c.y, p.z + weight[k] * c.z};
                    }
                    vv_mesh_foot foot;
                    vv_mesh_tree_nearest(&foot, b, p);
                    seen |= foot.distance > distance;
                }
            n_seen += seen;
            if (seen)
                assert_int_not_equal(of[t], VVI_NOT_BEYOND);
        }
        assert_true(n_seen > 0 && n_seen < m->n_triangles && beyond.n < n_seen + m->n_triangles / 20 + 2);
    }
    free(of);
    vv_mesh_tree_release(fine);
    vv_mesh_tree_release(coarse);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(squares_of_other_triangles_are_as_far_apart_as_they_are),
        cmocka_unit_test(what_is_not_beyond_has_no_place_that_is),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
