/* One part of a mesh: its triangles, corner by corner, and all that belongs to their vertices. */
#include "fail_alloc.h"
#include "grid/mesh.h"
#include "meshes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

static void expect_same_vertex(const vv_mesh_info *p, size_t v, const vv_mesh_info *m, size_t w)
{
    assert_memory_equal(p->positions + 3 * v, m->positions + 3 * w, 3 * sizeof *m->positions);
    assert_int_equal(p->normals != NULL, m->normals != NULL);
    assert_int_equal(p->values != NULL, m->values != NULL);
    assert_int_equal(p->colors != NULL, m->colors != NULL);
    if (m->normals)
        assert_memory_equal(p->normals + 3 * v, m->normals + 3 * w, 3 * sizeof *m->normals);
    if (m->values)
        assert_memory_equal(p->values + v, m->values + w, sizeof *m->values);
    if (m->colors)
        assert_memory_equal(p->colors + 4 * v, m->colors + 4 * w, 4);
}

static const float *place_of(const vv_mesh_info *m, size_t corner)
{
    return m->coordinates + 2 * (size_t)(m->coordinate_of ? m->coordinate_of : m->triangles)[corner];
}

static void it_keeps_its_image_and_places_on_it(void **state)
{
    (void)state;
    for (unsigned corners = 0; corners <= TEST_MESH_CORNERS; corners += TEST_MESH_CORNERS) {
        vv_mesh *mesh = test_mesh_strip(50, TEST_MESH_PARTS | TEST_MESH_TEXTURES | corners), *part, *split;
        const vv_mesh_info *m = vv_mesh_get_info(mesh);
        for (size_t i = 0; i < m->n_parts; i++) {
            assert_int_equal(vvi_mesh_part(&part, mesh, i, NULL), VV_OK);
            const vv_mesh_info *p = vv_mesh_get_info(part);
            assert_true(p->textures == m->textures && p->parts[0].texture == m->parts[i].texture);
            for (size_t k = 0; k < 3 * p->n_triangles; k++)
                assert_memory_equal(place_of(p, k), place_of(m, 3 * m->parts[i].first_triangle + k), 8);
            vv_mesh_release(part);
        }
        assert_int_equal(vvi_mesh_split_corners(&split, mesh, NULL), VV_OK);
        const vv_mesh_info *s = vv_mesh_get_info(split);
        assert_true(!s->coordinate_of && s->n_coordinates == s->n_vertices && (corners != 0) == (split != mesh));
        for (size_t k = 0; k < 3 * m->n_triangles; k++) {
            assert_memory_equal(place_of(s, k), place_of(m, k), 8);
            expect_same_vertex(s, s->triangles[k], m, m->triangles[k]);
        }
        vv_mesh_release(split);
        vv_mesh_release(mesh);
    }
}

static void a_part_has_its_triangles_and_the_vertices_of_these(void **state)
{
    (void)state;
    for (unsigned with = 0; with < 8; with++) {
        vv_mesh *mesh = test_mesh_strip(50, with | TEST_MESH_PARTS | TEST_MESH_FAR), *part;
        const vv_mesh_info *m = vv_mesh_get_info(mesh);
        size_t n = 0;
        for (size_t i = 0; i < m->n_parts; i++) {
            assert_int_equal(vvi_mesh_part(&part, mesh, i, NULL), VV_OK);
            const vv_mesh_info *p = vv_mesh_get_info(part);
            assert_int_equal(p->n_triangles, m->parts[i].n_triangles);
            assert_int_equal(p->n_vertices, p->n_triangles + 2); /* of a strip */
            assert_true(p->n_parts == 1 && p->parts[0].first_triangle == 0);
            assert_string_equal(p->parts[0].name, m->parts[i].name);
            assert_string_equal(p->unit, "mm");
            assert_true(p->origin.x == m->origin.x && p->space == m->space);
            for (size_t k = 0; k < 3 * p->n_triangles; k++)
                expect_same_vertex(p, p->triangles[k], m, m->triangles[3 * m->parts[i].first_triangle + k]);
            n += p->n_triangles;
            vv_mesh_release(part);
        }
        assert_int_equal(n, 50);
        vv_mesh_release(mesh);
    }
}

static vv_status take(void *user)
{
    vv_mesh *part;
    const vv_status st = vvi_mesh_part(&part, user, 1, NULL);
    vv_mesh_release(part);
    return st;
}

static void short_memory_is_an_error(void **state)
{
    (void)state;
    vv_mesh *mesh = test_mesh_strip(50, 7 | TEST_MESH_PARTS);
    assert_true(test_fail_each_alloc(take, mesh) >= 5);
    vv_mesh_release(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_part_has_its_triangles_and_the_vertices_of_these),
        cmocka_unit_test(it_keeps_its_image_and_places_on_it),
        cmocka_unit_test(short_memory_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
