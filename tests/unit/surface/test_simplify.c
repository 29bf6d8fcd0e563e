/* Simplified spheres, boxes and squares: budget, error, topology, border, parts, what vertices carry. */
#include "fail_alloc.h"
#include "grid/mesh.h"
#include "meshes.h"
#include "shapes.h"
#include "surface/simplify.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static int needs_the_library(void **state)
{
    (void)state;
    if (vvi_can_simplify())
        return 0;
    vv_mesh *box = test_mesh_box(1, 1, 1, (vv_vec3){0}), *out;
    const vvi_simplify_options o = {.triangles = 4};
    assert_int_equal(vvi_mesh_simplify(&out, NULL, box, &o, NULL), VV_E_UNSUPPORTED);
    vv_mesh_release(box);
    print_message("skipped: this build has no meshoptimizer\n");
    exit(77);
}

static vv_mesh *simplified(vvi_simplify_result *result, const vv_mesh *mesh, uint64_t triangles, double error)
{
    vv_mesh *out;
    const vvi_simplify_options o = {.triangles = triangles, .error = error};
    if (vvi_mesh_simplify(&out, result, mesh, &o, NULL) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    return out;
}

static void a_sphere_of_a_tenth_of_the_triangles_is_still_one(void **state)
{
    (void)state;
    vv_mesh *sphere = test_mesh_marched_sphere(20, true);
    const size_t n = vv_mesh_get_info(sphere)->n_triangles;
    vvi_simplify_result r;
    vv_mesh *out = simplified(&r, sphere, n / 10, 0);
    const vv_mesh_info *m = vv_mesh_get_info(out);
    assert_false(r.over_budget);
    assert_int_equal(m->n_triangles, r.n_triangles);
    assert_true(m->n_triangles <= n / 10 && m->n_triangles > n / 12);
    assert_int_equal(test_mesh_bad_edges(out), 0);
    assert_int_equal(test_mesh_euler(out), 2);
    assert_true(fabs(test_mesh_volume(out) / (4 * M_PI * 8000 / 3) - 1) < .02);
    assert_true(r.error > 0 && r.error < .3);
    assert_non_null(m->normals);
    for (size_t v = 0; v < m->n_vertices; v++) { /* vertices are some of the old ones; normals point outwards */
        const vv_vec3 p = test_mesh_vertex(out, v);
        const double x = p.x - .13, y = p.y - .27, z = p.z - .41;
        assert_true(fabs(sqrt(x * x + y * y + z * z) - 20) < .02);
        const float *k = m->normals + 3 * v;
        assert_true(((double)k[0] * x + (double)k[1] * y + (double)k[2] * z) / 20 > .95);
    }
    vv_mesh_release(out);
    vv_mesh_release(sphere);
}

static void the_error_bound_is_kept_and_less_error_means_more_triangles(void **state)
{
    (void)state;
    static const double errors[] = {.02, .1, .5};
    vv_mesh *sphere = test_mesh_sphere((vv_vec3){0}, 50, 5);
    size_t before = vv_mesh_get_info(sphere)->n_triangles;
    for (size_t i = 0; i < 3; i++) {
        vvi_simplify_result r;
        vv_mesh *out = simplified(&r, sphere, 0, errors[i]);
        assert_true(r.error <= errors[i] && r.error > errors[i] / 4);
        assert_true(r.n_triangles < before);
        before = r.n_triangles;
        /* inscribed: the volume that is missing, spread over the sphere, is less than a few times the error */
        const double missing = 4 * M_PI * 125000 / 3 - test_mesh_volume(out);
        assert_true(missing > 0 && missing < 3 * errors[i] * 4 * M_PI * 2500);
        vv_mesh_release(out);
    }
    vv_mesh_release(sphere);
}

static void a_flat_square_keeps_its_area_and_outline(void **state)
{
    (void)state;
    vv_mesh *square = test_mesh_square(7, 23);
    vvi_simplify_result r;
    vv_mesh *out = simplified(&r, square, 0, 1e-3);
    assert_true(r.n_triangles < 40);
    assert_true(fabs(test_mesh_area(out) - 49) < 1e-2);
    vv_mesh_release(out);
    const vvi_simplify_options o = {.error = 1e-3, .fix_border = true};
    assert_int_equal(vvi_mesh_simplify(&out, &r, square, &o, NULL), VV_OK);
    assert_int_equal(test_mesh_bad_edges(out), 4 * 23);
    assert_true(fabs(test_mesh_area(out) - 49) < 1e-4);
    vv_mesh_release(out);
    vv_mesh_release(square);
}

/* Two spheres as two parts; the value of a vertex is its x, its colour says which sphere. */
static vv_mesh *two_spheres(void)
{
    vv_mesh *mesh, *one = test_mesh_sphere((vv_vec3){0}, 10, 4);
    const vv_mesh_info *m = vv_mesh_get_info(one);
    vvi_mesh_arrays a;
    const size_t v = m->n_vertices, t = m->n_triangles;
    const vv_mesh_info info = {.n_vertices = 2 * v, .n_triangles = 2 * t, .n_parts = 2, .origin = {1e5, 0, 0}};
    assert_int_equal(vvi_mesh_new(&mesh, &a, &info, VVI_MESH_VALUES | VVI_MESH_COLORS, NULL), VV_OK);
    for (size_t i = 0; i < 2 * v; i++) {
        memcpy(a.positions + 3 * i, m->positions + 3 * (i % v), 3 * sizeof(float));
        a.positions[3 * i] += i < v ? 0 : 100;
        a.values[i] = a.positions[3 * i];
        memset(a.colors + 4 * i, i < v ? 10 : 20, 4);
    }
    for (size_t i = 0; i < 6 * t; i++)
        a.triangles[i] = m->triangles[i % (3 * t)] + (i < 3 * t ? 0 : (uint32_t)v);
    for (size_t p = 0; p < 2; p++) {
        a.parts[p].first_triangle = p * t;
        a.parts[p].n_triangles = t;
        strcpy(a.parts[p].name, p ? "b" : "a");
    }
    vv_mesh_release(one);
    return mesh;
}

static void parts_values_and_colours_stay(void **state)
{
    (void)state;
    vv_mesh *mesh = two_spheres();
    vvi_simplify_result r;
    vv_mesh *out = simplified(&r, mesh, 1000, 0);
    const vv_mesh_info *m = vv_mesh_get_info(out);
    assert_int_equal(m->n_parts, 2);
    assert_true(m->origin.x == 1e5 && !m->normals);
    assert_string_equal(m->parts[1].name, "b");
    assert_int_equal(m->parts[0].first_triangle, 0);
    assert_int_equal(m->parts[1].first_triangle, m->parts[0].n_triangles);
    assert_int_equal(m->parts[0].n_triangles + m->parts[1].n_triangles, m->n_triangles);
    assert_true(m->parts[0].n_triangles > 450 && m->parts[0].n_triangles <= 500);
    for (size_t t = 0; t < 3 * m->n_triangles; t++) {
        const uint32_t v = m->triangles[t];
        assert_true(m->values[v] == m->positions[3 * (size_t)v]);
        assert_int_equal(m->colors[4 * (size_t)v], t < 3 * m->parts[0].n_triangles ? 10 : 20);
    }
    assert_int_equal(test_mesh_bad_edges(out), 0);
    vv_mesh_release(out);
    vv_mesh_release(mesh);
}

static void what_cannot_be_met_is_told(void **state)
{
    (void)state;
    vv_mesh *sphere = test_mesh_sphere((vv_vec3){0}, 10, 4), *out;
    vvi_simplify_result r;
    out = simplified(&r, sphere, 100, 1e-6);
    assert_true(r.over_budget && r.error <= 1e-6);
    vv_mesh_release(out);
    static const vvi_simplify_options bad[] = {
        {0}, {.error = -1}, {.error = NAN}, {.error = INFINITY}, {.triangles = 5, .error = -1}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(vvi_mesh_simplify(&out, NULL, sphere, &bad[i], NULL), VV_E_ARGUMENT);
    vv_mesh_release(sphere);
    vv_mesh *none = test_mesh_new(NULL, 0, NULL, 0);
    out = simplified(&r, none, 10, 0);
    assert_int_equal(r.n_triangles, 0);
    vv_mesh_release(out);
    vv_mesh_release(none);
}

static vv_status simplify_once(void *user)
{
    vv_mesh *out;
    const vvi_simplify_options o = {.triangles = 100};
    const vv_status st = vvi_mesh_simplify(&out, NULL, user, &o, NULL);
    vv_mesh_release(out);
    return st;
}

static void every_failing_allocation_is_reported(void **state)
{
    (void)state;
    vv_mesh *mesh = two_spheres();
    assert_true(test_fail_each_alloc(simplify_once, mesh) >= 10);
    vv_mesh_release(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sphere_of_a_tenth_of_the_triangles_is_still_one),
        cmocka_unit_test(the_error_bound_is_kept_and_less_error_means_more_triangles),
        cmocka_unit_test(a_flat_square_keeps_its_area_and_outline),
        cmocka_unit_test(parts_values_and_colours_stay),
        cmocka_unit_test(what_cannot_be_met_is_told),
        cmocka_unit_test(every_failing_allocation_is_reported),
    };
    return cmocka_run_group_tests(tests, needs_the_library, NULL);
}
