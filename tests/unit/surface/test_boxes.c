/* The boxes that hold a surface: closed, around all of it, and as few as the budget says. */
#include "fail_alloc.h"
#include "fields.h"
#include "jobs.h"
#include "meshes.h"
#include "surface/boxes.h"
#include "surface/marching.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

static double shell(vv_vec3 p)
{
    return 10 - hypot(hypot(p.x - .3, p.y), p.z);
}

static vv_field *sphere(vv_type type, double scale, bool mirrored)
{
    const test_form form = {.name = "sphere", .value = shell};
    vv_field_info info = vv_field_info_default();
    info.type = type;
    info.value_scale = scale;
    info.value_offset = scale > 0 ? -60 : 60;
    info.grid.dims[0] = 31, info.grid.dims[1] = 47, info.grid.dims[2] = 29;
    info.grid.index_to_world =
        (vv_affine){{{.8, 0, 0}, {.1, .6, 0}, {0, -.1, mirrored ? -.9 : .9}}, {-14, -12, mirrored ? 13 : -13}};
    return test_field(&form, &info, NULL);
}

static vv_mesh *boxes_of(const vv_field *f, int shift, size_t most, bool merged, vv_job *job)
{
    const vvi_surface_boxes_options o = {.shift = shift, .max_triangles = most, .merged = merged};
    vv_mesh *mesh;
    assert_int_equal(vvi_surface_boxes(&mesh, f, &o, job), VV_OK);
    return mesh;
}

/* The volume of all blocks of cells, with corners on both sides or on the surface, by brute force. */
static double volume_of_blocks(const vv_field *f, int64_t side)
{
    const vv_field_info *info = vv_field_get_info(f);
    const int64_t *n = info->grid.dims;
    double cells = 0;
    for (int64_t k = 0; k < n[2] - 1; k += side)
        for (int64_t j = 0; j < n[1] - 1; j += side)
            for (int64_t i = 0; i < n[0] - 1; i += side) {
                double lo = INFINITY, hi = -INFINITY, size = 1;
                for (int64_t z = k; z <= k + side && z < n[2]; z++)
                    for (int64_t y = j; y <= j + side && y < n[1]; y++)
                        for (int64_t x = i; x <= i + side && x < n[0]; x++) {
                            const double v = vv_field_value(f, x, y, z, 0);
                            lo = fmin(lo, v);
                            hi = fmax(hi, v);
                        }
                const int64_t at[3] = {i, j, k};
                for (int a = 0; a < 3; a++)
                    size *= fmin((double)side, (double)(n[a] - 1 - at[a]));
                cells += lo <= 0 && hi >= 0 ? size : 0;
            }
    return cells * fabs(vv_affine_determinant(info->grid.index_to_world));
}

static void assert_within(double found, double expected, double tolerance)
{
    if (!(fabs(found - expected) <= tolerance))
        fail_msg("%.9g is not within %g of %.9g", found, tolerance, expected);
}

static void boxes_are_the_blocks_that_the_surface_passes(void **state)
{
    (void)state;
    for (int type = 0; type < VV_TYPE_COUNT; type++)
        for (int way = 0; way < 4; way++) {
            vv_field *f = sphere((vv_type)type, way & 1 ? -.5 : .5, way >> 1);
            for (int shift = 2; shift < 6; shift++) {
                vv_mesh *all = boxes_of(f, shift, 0, false, NULL), *merged = boxes_of(f, shift, 0, true, NULL);
                const double expected = volume_of_blocks(f, 1 << shift);
                assert_within(test_mesh_volume(all), expected, 1e-4 * expected);
                assert_within(test_mesh_volume(merged), expected, 1e-4 * expected);
                assert_within(test_mesh_area(merged), test_mesh_area(all), 1e-4 * expected);
                assert_true(vv_mesh_get_info(merged)->n_triangles < vv_mesh_get_info(all)->n_triangles);
                vv_mesh_release(all);
                vv_mesh_release(merged);
            }
            vv_field_release(f);
        }
}

static void normals_are_those_of_the_triangles(void **state)
{
    (void)state;
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        vv_field *f = sphere(VV_TYPE_F32, 1, mirrored);
        vv_mesh *mesh = boxes_of(f, 2, 0, true, NULL);
        const vv_mesh_info *m = vv_mesh_get_info(mesh);
        for (size_t t = 0; t < m->n_triangles; t++) {
            const uint32_t *v = m->triangles + 3 * t;
            const vv_vec3 a = test_mesh_vertex(mesh, v[0]), b = test_mesh_vertex(mesh, v[1]),
                          c = test_mesh_vertex(mesh, v[2]);
            const double u[3] = {b.x - a.x, b.y - a.y, b.z - a.z}, w[3] = {c.x - a.x, c.y - a.y, c.z - a.z};
            const double n[3] = {u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]};
            const float *given = m->normals + 3 * (size_t)v[0];
            const double length = hypot(hypot(n[0], n[1]), n[2]);
            assert_within((n[0] * given[0] + n[1] * given[1] + n[2] * given[2]) / length, 1, 1e-5);
        }
        vv_mesh_release(mesh);
        vv_field_release(f);
    }
}

static void a_budget_is_kept(void **state)
{
    (void)state;
    vv_field *f = sphere(VV_TYPE_U8, .5, false);
    static const size_t budgets[] = {3000, 1000, 300, 100, 12};
    for (size_t i = 0; i < sizeof budgets / sizeof *budgets; i++)
        for (int merged = 0; merged < 2; merged++) {
            vv_mesh *mesh = boxes_of(f, 0, budgets[i], merged, NULL);
            assert_in_range(vv_mesh_get_info(mesh)->n_triangles, 12, budgets[i]);
            vv_mesh_release(mesh);
        }
    vv_field_release(f);
}

static void threads_change_nothing_and_errors_are_told(void **state)
{
    (void)state;
    vv_field *f = sphere(VV_TYPE_U16, .001, false);
    vv_mesh *one = boxes_of(f, 2, 0, true, NULL);
    for (int threads = 1; threads <= 4; threads *= 2) {
        vv_job *job = test_job(threads, 0);
        vv_mesh *mesh = boxes_of(f, 2, 0, true, job);
        const vv_mesh_info *m = vv_mesh_get_info(mesh), *n = vv_mesh_get_info(one);
        assert_int_equal(m->n_triangles, n->n_triangles);
        assert_memory_equal(m->positions, n->positions, 12 * m->n_vertices);
        vv_mesh_release(mesh);
        vv_job_release(job);
    }
    vv_mesh_release(one);
    vvi_surface_boxes_options bad[] = {
        {.value = NAN}, {.component = 1}, {.component = -1}, {.shift = 1}, {.shift = 40}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(vvi_surface_boxes(&one, f, &bad[i], NULL), VV_E_ARGUMENT);
    one = boxes_of(f, 0, 0, true, NULL);
    vv_mesh_release(one);
    const vvi_surface_boxes_options nothing = {.value = 1e6};
    assert_int_equal(vvi_surface_boxes(&one, f, &nothing, NULL), VV_OK);
    assert_int_equal(vv_mesh_get_info(one)->n_triangles, 0);
    vv_mesh_release(one);
    vv_field_release(f);
}

static vv_status make_once(void *user)
{
    const vvi_surface_boxes_options o = {.shift = 3, .merged = true};
    vv_mesh *mesh;
    const vv_status st = vvi_surface_boxes(&mesh, user, &o, NULL);
    vv_mesh_release(mesh);
    return st;
}

static void without_memory_it_fails_cleanly(void **state)
{
    (void)state;
    vv_field *f = sphere(VV_TYPE_U8, .5, false);
    assert_true(test_fail_each_alloc(make_once, f) > 5);
    vv_field_release(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_are_the_blocks_that_the_surface_passes),
        cmocka_unit_test(normals_are_those_of_the_triangles),
        cmocka_unit_test(a_budget_is_kept),
        cmocka_unit_test(threads_change_nothing_and_errors_are_told),
        cmocka_unit_test(without_memory_it_fails_cleanly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
