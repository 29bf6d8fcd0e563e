/* The share of an error that is worth trying, and the patches of large meshes that tell it. */
#include "fail_alloc.h"
#include "filter/simplify_share.h"
#include "shapes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static vv_mesh_tree *tree_of(vv_mesh *mesh)
{
    vv_mesh_tree *tree;
    assert_int_equal(vv_mesh_tree_new(&tree, mesh, NULL, NULL), VV_OK);
    vv_mesh_release(mesh);
    return tree;
}

/* Each vertex of a patch lies on the sphere; each triangle is one of the sphere's, and comes once. */
static void patches_are_neighbours_out_of_the_mesh(void **state)
{
    (void)state;
    vv_mesh_tree *tree = tree_of(test_mesh_sphere((vv_vec3){1, 2, 3}, 10, 5));
    vv_mesh *patches;
    assert_int_equal(vvi_mesh_patches(&patches, tree, 4000, 8, NULL), VV_OK);
    const vv_mesh_info *m = vv_mesh_get_info(patches);
    assert_int_equal(m->n_triangles, 4000);
    assert_true(m->n_vertices > 2000 && m->n_vertices < 2600); /* alone, triangles would have 12000 */
    for (size_t t = 0; t < m->n_triangles; t++) {
        vv_vec3 middle = {0};
        for (size_t k = 0; k < 3; k++) {
            const float *p = m->positions + 3 * (size_t)m->triangles[3 * t + k];
            middle.x += (double)p[0] / 3 + m->origin.x / 3;
            middle.y += (double)p[1] / 3 + m->origin.y / 3;
            middle.z += (double)p[2] / 3 + m->origin.z / 3;
        }
        vv_mesh_foot foot;
        vv_mesh_tree_nearest(&foot, tree, middle);
        assert_true(foot.distance < 1e-5);
    }
    vv_mesh_release(patches);
    assert_int_equal(vvi_mesh_patches(&patches, tree, 1 << 30, 1, NULL), VV_OK);
    assert_int_equal(vv_mesh_get_info(patches)->n_triangles, 20480);
    assert_int_equal(vv_mesh_get_info(patches)->n_vertices, 10242);
    vv_mesh_release(patches);
    vv_mesh_tree_release(tree);
}

/* Facets of a sphere lie farther from it than the average over planes says: all of the error is too much. */
static void a_share_is_some_of_the_error(void **state)
{
    (void)state;
    if (!vvi_can_simplify())
        skip();
    for (int level = 5; level <= 7; level += 2) { /* 20480 triangles, and so many that patches have to do */
        double share = 0;
        const vvi_simplify_options o = {.error = 0.01};
        vv_mesh_tree *tree = tree_of(test_mesh_sphere((vv_vec3){0}, 10, level));
        assert_int_equal(vvi_simplify_find_share(&share, tree, &o, NULL), VV_OK);
        assert_true(share > 0.1 && share < 0.8);
        vv_mesh_tree_release(tree);
    }
}

static vv_status take_patches(void *user)
{
    vv_mesh *patches;
    const vv_status st = vvi_mesh_patches(&patches, user, 100, 4, NULL);
    vv_mesh_release(patches);
    return st;
}

static vv_status find_share(void *user)
{
    double share;
    const vvi_simplify_options o = {.error = 1};
    return vvi_simplify_find_share(&share, user, &o, NULL);
}

static void short_memory_is_an_error(void **state)
{
    (void)state;
    vv_mesh_tree *tree = tree_of(test_mesh_sphere((vv_vec3){0}, 10, 2));
    assert_true(test_fail_each_alloc(take_patches, tree) >= 2);
    if (vvi_can_simplify())
        assert_true(test_fail_each_alloc(find_share, tree) >= 10);
    vv_mesh_tree_release(tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(patches_are_neighbours_out_of_the_mesh),
        cmocka_unit_test(a_share_is_some_of_the_error),
        cmocka_unit_test(short_memory_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
