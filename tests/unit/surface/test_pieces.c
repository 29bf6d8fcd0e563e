/* Pieces of meshes: against pieces found the slow way, and closed forms. */
#include "core/memory.h"
#include "fail_alloc.h"
#include "fields.h"
#include "grid/field.h"
#include "grid/mesh.h"
#include "mesh_pieces.h"
#include "meshes.h"
#include "surface/marching.h"
#include "surface/pieces.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Spheres of radius 8, 6 and 3, the first with a hollow of radius 5. */
static double spheres(vv_vec3 p)
{
    const double a = hypot(hypot(p.x - 10, p.y), p.z), b = hypot(hypot(p.x + 8, p.y + 2), p.z);
    const double c = hypot(hypot(p.x + 12, p.y - 12), p.z - 10);
    return fmax(fmax(fmin(8 - a, a - 5), 6 - b), 3 - c);
}

static vv_mesh *three_spheres(void)
{
    const test_form form = {.name = "spheres", .value = spheres};
    const vvi_marching_options o = {.value = 0};
    vv_field *f = test_field_cube(&form, 45, -22, 22, NULL);
    vv_mesh *mesh;
    assert_int_equal(vvi_marching_cubes(&mesh, f, &o, NULL), VV_OK);
    vv_field_release(f);
    return mesh;
}

static void assert_within(double found, double expected, double tolerance)
{
    if (!(fabs(found - expected) <= tolerance))
        fail_msg("%.6g is not within %g of %.6g", found, tolerance, expected);
}

static void spheres_are_told_apart_and_sorted(void **state)
{
    (void)state;
    static const double radius[] = {8, 6, 5, 3};
    vv_mesh *mesh = three_spheres();
    for (int by = 0; by < 2; by++) {
        const vvi_pieces_options o = {.size = (vvi_piece_size)by};
        vvi_piece *pieces;
        size_t n;
        assert_int_equal(vvi_find_pieces(&pieces, &n, mesh, &o, NULL), VV_OK);
        assert_int_equal(n, 4);
        for (int i = 0; i < 4; i++) {
            const double area = 4 * M_PI * radius[i] * radius[i], volume = area * radius[i] / 3;
            assert_within(pieces[i].area / area, 1, .04);
            assert_within(pieces[i].volume / volume, radius[i] == 5 ? -1 : 1, .08);
        }
        vvi_free(pieces);
    }
    vv_mesh_release(mesh);
}

static void what_is_kept_is_a_part_each(void **state)
{
    (void)state;
    vv_mesh *mesh = three_spheres(), *kept;
    vv_mesh_part *whole;
    assert_int_equal(vvi_mesh_add_parts(&whole, mesh, 1, NULL), VV_OK);
    strcpy(whole->name, "spheres");
    whole->n_triangles = vv_mesh_get_info(mesh)->n_triangles;
    whole->color = (vv_color){1, .5, 0, 1};
    static const vvi_pieces_options options[] = {
        {.most = 2}, {.least = 400}, {.size = VVI_PIECE_VOLUME, .least = 520}, {.most = 2, .least = 100},
        {.most = 9}, {.least = 1e9}};
    static const size_t n[] = {2, 2, 2, 2, 4, 0};
    for (size_t i = 0; i < 6; i++) {
        assert_int_equal(vvi_mesh_pieces(&kept, mesh, &options[i], NULL), VV_OK);
        const vv_mesh_info *m = vv_mesh_get_info(kept);
        assert_int_equal(m->n_parts, n[i]);
        size_t next = 0;
        for (size_t p = 0; p < m->n_parts; p++) {
            char name[64];
            snprintf(name, sizeof name, "spheres, piece %zu", p + 1);
            assert_string_equal(m->parts[p].name, name);
            assert_true(m->parts[p].color.r == 1);
            assert_int_equal(m->parts[p].first_triangle, next);
            next += m->parts[p].n_triangles;
        }
        assert_int_equal(next, m->n_triangles);
        assert_int_equal(test_mesh_bad_edges(kept), 0);
        assert_int_equal(test_mesh_euler(kept), 2 * (int64_t)n[i]);
        vv_mesh_release(kept);
    }
    vv_mesh_release(mesh);
}

/* Noise: the same pieces, with the same triangles and normals, as the slow way finds. */
static void pieces_of_noise_are_those_found_slowly(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 31, info.grid.dims[1] = 29, info.grid.dims[2] = 37;
    info.type = VV_TYPE_U8;
    vv_field *f = test_field_random(&info, test_seed(), NULL);
    const vvi_marching_options o = {.value = 235.5};
    vv_mesh *mesh, *sorted;
    assert_int_equal(vvi_marching_cubes(&mesh, f, &o, NULL), VV_OK);
    size_t n_pieces, n;
    float *values;
    assert_int_equal(vvi_mesh_add_values(&values, mesh, "number", "", NULL), VV_OK);
    for (size_t v = 0; v < vv_mesh_get_info(mesh)->n_vertices; v++)
        values[v] = (float)v;
    uint32_t *pieces = test_mesh_pieces(mesh, &n_pieces);
    const vvi_pieces_options all = {.size = VVI_PIECE_AREA};
    assert_int_equal(vvi_mesh_pieces(&sorted, mesh, &all, NULL), VV_OK);
    const vv_mesh_info *m = vv_mesh_get_info(sorted), *w = vv_mesh_get_info(mesh);
    assert_int_equal(m->n_parts, n_pieces);
    assert_int_equal(m->n_triangles, w->n_triangles);
    for (size_t i = 0; i < m->n_parts; i++) {
        const uint32_t *t = m->triangles + 3 * m->parts[i].first_triangle;
        const uint32_t piece = pieces[(uint32_t)m->values[t[0]]];
        test_triangle *a = test_mesh_triangles(mesh, pieces, piece, &n);
        assert_int_equal(n, m->parts[i].n_triangles);
        for (size_t k = 0; k < 3 * n; k++) {
            const size_t v = t[k], u = (size_t)m->values[v];
            assert_int_equal(pieces[u], piece);
            assert_memory_equal(m->positions + 3 * v, w->positions + 3 * u, 12);
            assert_memory_equal(m->normals + 3 * v, w->normals + 3 * u, 12);
        }
        free(a);
    }
    free(pieces);
    vv_mesh_release(sorted);
    vv_mesh_release(mesh);
    vv_field_release(f);
}

static vv_status sort_once(void *user)
{
    const vvi_pieces_options o = {.most = 2};
    vv_mesh *out;
    const vv_status st = vvi_mesh_pieces(&out, user, &o, NULL);
    vv_mesh_release(out);
    return st;
}

static void errors_are_told(void **state)
{
    (void)state;
    vv_mesh *mesh = three_spheres(), *out;
    const vvi_pieces_options bad = {.least = NAN};
    assert_int_equal(vvi_mesh_pieces(&out, mesh, &bad, NULL), VV_E_ARGUMENT);
    assert_true(test_fail_each_alloc(sort_once, mesh) > 5);
    vv_mesh_release(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spheres_are_told_apart_and_sorted),
        cmocka_unit_test(what_is_kept_is_a_part_each),
        cmocka_unit_test(pieces_of_noise_are_those_found_slowly),
        cmocka_unit_test(errors_are_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
