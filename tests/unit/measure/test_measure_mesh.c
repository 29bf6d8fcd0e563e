/* Measures of meshes against closed forms: boxes, spheres, tori; their errors; what is open; parts; threads. */
#include "core/cpu.h"
#include "fail_alloc.h"
#include "fields.h"
#include "grid/mesh.h"
#include "jobs.h"
#include "measure/mass_kernel.h"
#include "shapes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/measure_mesh.h>

#include <cmocka.h>

#define assert_within(value, truth, error)                                                                             \
    do {                                                                                                               \
        if (!(fabs((value) - (truth)) <= (error)))                                                                     \
            fail_msg("%s is %.12g and not %.12g +- %.3g", #value, (double)(value), (double)(truth), (double)(error));  \
    } while (0)

static vv_mesh_measures measured(const vv_mesh *mesh, const vv_mesh_measure_options *options)
{
    vv_mesh_measures m;
    if (vv_mesh_measure(&m, mesh, options, NULL) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    return m;
}

static vv_mesh_measure_options defaults(void)
{
    vv_mesh_measure_options o;
    vv_mesh_measure_options_init(&o, sizeof o);
    return o;
}

static void a_box_has_its_area_volume_and_inertia(void **state)
{
    (void)state;
    static const double shifts[] = {0, 1e4, -1e4};
    for (size_t i = 0; i < 3; i++) {
        const double s = shifts[i];
        vv_mesh *mesh = test_mesh_box(1, 1, 1, (vv_vec3){s, s, s});
        const vv_mesh_measures m = measured(mesh, NULL);
        assert_within(m.area.value, 6, 1e-9);
        assert_within(m.volume.value, 1, 1e-9);
        assert_true(m.closed && !m.inside_out);
        assert_string_equal(m.area.unit, "mm^2");
        assert_string_equal(m.volume.unit, "mm^3");
        for (int c = 0; c < 3; c++) {
            assert_within(m.centroid[c].value, s + .5, 1e-9);
            assert_within(m.inertia[c].value, 1 / 6.0, 1e-9);
            assert_within(m.inertia[3 + c].value, 0, 1e-9);
            assert_true((&m.bounds.lo.x)[c] == s && (&m.bounds.hi.x)[c] == s + 1);
        }
        vv_mesh_release(mesh);
    }
}

/* A box of 2 x 3 x 5, sheared, turned and moved: the volume goes with the determinant; the area is that of the
 * parallelepiped; the inertia that of the moved second moments. */
static void an_affine_map_moves_the_vertices_first(void **state)
{
    (void)state;
    const vv_vec3 side[3] = {{2, .5, 0}, {-.5, 3, 1}, {.25, .5, -2}};
    const double length[3] = {2, 3, 5};
    vv_mesh *mesh = test_mesh_box(length[0], length[1], length[2], (vv_vec3){1, 2, 3});
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        vv_mesh_measure_options o = defaults();
        o.to_world = (vv_affine){.axis = {side[0], side[1], side[2]}, .origin = {10, 20, 30}};
        if (mirrored)
            o.to_world.axis[2] = (vv_vec3){-.25, -.5, 2};
        strcpy(o.unit, "um");
        const vv_mesh_measures m = measured(mesh, &o);
        const double volume = fabs(vv_affine_determinant(o.to_world)) * 30;
        double area = 0, covariance[3][3] = {{0}};
        for (int i = 0; i < 3; i++) {
            const vv_vec3 a = o.to_world.axis[i], b = o.to_world.axis[(i + 1) % 3];
            area += 2 * length[i] * length[(i + 1) % 3] *
                    sqrt(pow(a.y * b.z - a.z * b.y, 2) + pow(a.z * b.x - a.x * b.z, 2) + pow(a.x * b.y - a.y * b.x, 2));
            for (int r = 0; r < 3; r++)
                for (int c = 0; c < 3; c++)
                    covariance[r][c] += length[i] * length[i] / 12 * (&a.x)[r] * (&a.x)[c];
        }
        const vv_vec3 middle = vv_affine_point(o.to_world, (vv_vec3){2, 3.5, 5.5});
        assert_within(m.volume.value, volume, 1e-9 * volume);
        assert_within(m.area.value, area, 1e-9 * area);
        assert_string_equal(m.volume.unit, "um^3");
        assert_true(m.inside_out == false);
        for (int i = 0; i < 3; i++) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            assert_within(m.centroid[i].value, (&middle.x)[i], 1e-9);
            assert_within(m.inertia[i].value, volume * (covariance[j][j] + covariance[k][k]), 1e-9 * volume);
        }
        assert_within(m.inertia[3].value, -volume * covariance[0][1], 1e-9 * volume);
        assert_within(m.inertia[4].value, -volume * covariance[0][2], 1e-9 * volume);
        assert_within(m.inertia[5].value, -volume * covariance[1][2], 1e-9 * volume);
    }
    vv_mesh_release(mesh);
}

/* The errors of Marching Cubes are -31 / R^2 % and -60 / R^2 %. */
static void spheres_of_marching_cubes_have_known_errors(void **state)
{
    (void)state;
    static const double table[][3] = {
        {3, -3.505, -6.577}, {5, -1.257, -2.383}, {10, -.314, -.596}, {20, -.0783, -.1491}, {30, -.0348, -.0663}};
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        const double r = table[i][0], area = 4 * M_PI * r * r, volume = area * r / 3;
        vv_mesh *mesh = test_mesh_marched_sphere(r, true);
        vv_mesh_measure_options o = defaults();
        o.sampled = true;
        const vv_mesh_measures m = measured(mesh, &o);
        assert_within(100 * (m.area.value / area - 1), table[i][1], .05 * fabs(table[i][1]));
        assert_within(100 * (m.volume.value / volume - 1), table[i][2], .05 * fabs(table[i][2]));
        vv_mesh_release(mesh);
    }
}

static void a_torus_of_marching_cubes_has_known_errors(void **state)
{
    (void)state;
    vv_mesh *mesh = test_mesh_marched_torus(12, 5);
    vv_mesh_measure_options o = defaults();
    o.sampled = true;
    const vv_mesh_measures m = measured(mesh, &o);
    assert_within(100 * (m.area.value / 2368.705 - 1), -.235, .05 * .235);
    assert_within(100 * (m.volume.value / 5921.763 - 1), -.826, .05 * .826);
    assert_within(m.area.value, 2368.705, m.area.error);
    assert_within(m.volume.value, 5921.763, m.volume.error);
    assert_true(m.volume.error < 3 * .00826 * 5921);
    vv_mesh_release(mesh);
}

/* `loosest` is how much larger than the truth the estimate may be. */
static void check_sphere(vv_mesh *mesh, double r, const vv_affine *scale, double loosest)
{
    vv_mesh_measure_options o = defaults();
    o.sampled = true;
    double s = 1;
    if (scale) {
        o.to_world = *scale;
        s = fabs(scale->axis[0].x);
    }
    const double area = 4 * M_PI * r * r * s * s, volume = area * r * s / 3;
    const vv_mesh_measures m = measured(mesh, &o);
    assert_within(m.area.value, area, m.area.error);
    assert_within(m.volume.value, volume, m.volume.error);
    assert_true(m.area.error < loosest * fabs(m.area.value - area));
    assert_true(m.volume.error < loosest * fabs(m.volume.value - volume));
    const double inertia = .4 * volume * r * r * s * s;
    for (int i = 0; i < 3; i++) {
        assert_within(m.inertia[i].value, inertia, m.inertia[i].error);
        assert_within(m.inertia[3 + i].value, 0, m.inertia[3 + i].error);
    }
}

static void the_truth_of_spheres_lies_within_the_error(void **state)
{
    (void)state;
    static const double radii[] = {5, 7.3, 10, 14.9, 20, 30, 40};
    const vv_affine mirror = {.axis = {{-.3, 0, 0}, {0, .3, 0}, {0, 0, .3}}, .origin = {1, 2, 3}};
    for (size_t i = 0; i < sizeof radii / sizeof *radii; i++)
        for (int normals = 0; normals < 2; normals++) {
            vv_mesh *mesh = test_mesh_marched_sphere(radii[i], normals);
            check_sphere(mesh, radii[i], NULL, 2);
            check_sphere(mesh, radii[i], &mirror, 2);
            vv_mesh_release(mesh);
        }
    for (int splits = 2; splits < 6;
         splits++) { /* vertices on the sphere: the estimate has nothing to do with voxels */
        vv_mesh *mesh = test_mesh_sphere((vv_vec3){100, 200, 300}, 25, splits);
        check_sphere(mesh, 25, NULL, 2.2);
        vv_mesh_release(mesh);
    }
}

/* Vertices that were rounded to floats: what was meant lies within the error. */
static void the_rounding_of_vertices_is_within_the_error(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 50; i++) {
        const double a = 1 + test_random_unit(test_seed(), 4 * i), b = 1 + test_random_unit(test_seed(), 4 * i + 1),
                     c = 1 + test_random_unit(test_seed(), 4 * i + 2),
                     s = 1e4 * test_random_unit(test_seed(), 4 * i + 3);
        vv_mesh *mesh = test_mesh_box(a, b, c, (vv_vec3){s, -s, s});
        const vv_mesh_measures m = measured(mesh, NULL);
        assert_within(m.area.value, 2 * (a * b + b * c + c * a), m.area.error);
        assert_within(m.volume.value, a * b * c, m.volume.error);
        for (int k = 0; k < 3; k++)
            assert_within(m.centroid[k].value,
                          (k == 1 ? -s : s) + (k == 0   ? a
                                               : k == 1 ? b
                                                        : c) /
                                                  2,
                          m.centroid[k].error);
        assert_true(m.volume.error < .05);
        vv_mesh_release(mesh);
    }
}

static void an_open_mesh_is_an_error_that_says_where(void **state)
{
    (void)state;
    vv_mesh *box = test_mesh_box(1, 1, 1, (vv_vec3){0}), *open = test_mesh_less(box, 1);
    vv_mesh_measures m;
    assert_int_equal(vv_mesh_measure(&m, open, NULL, NULL), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "open"));
    assert_non_null(strstr(vv_error_last()->message, "3 edges"));
    vv_mesh_measure_options o = defaults();
    o.open = true;
    m = measured(open, &o);
    assert_false(m.closed);
    assert_int_equal(m.n_open_edges, 3);
    assert_within(m.open_at.x, 1, 0); /* the last triangle lies at x = 1 */
    assert_within(m.area.value, 5.5, 1e-9);
    assert_true(isnan(m.volume.value) && isnan(m.centroid[0].value) && isinf(m.volume.error));
    vv_mesh_release(open);
    vv_mesh *square = test_mesh_square(3, 7);
    m = measured(square, &o);
    assert_int_equal(m.n_open_edges, 28);
    assert_within(m.area.value, 9, 1e-6);
    vv_mesh_release(square);
    vv_mesh_release(box);
}

static void a_mesh_without_shared_vertices_can_be_closed(void **state)
{
    (void)state;
    vv_mesh *sphere = test_mesh_sphere((vv_vec3){0}, 2, 3), *soup = test_mesh_unshared(sphere);
    const vv_mesh_measures a = measured(sphere, NULL), b = measured(soup, NULL);
    assert_true(b.closed);
    assert_true(a.volume.value == b.volume.value);
    vv_mesh *open = test_mesh_less(soup, 2);
    vv_mesh_measures m;
    assert_int_equal(vv_mesh_measure(&m, open, NULL, NULL), VV_E_ARGUMENT);
    assert_int_equal(m.n_open_edges, 6);
    vv_mesh_release(open);
    vv_mesh_release(soup);
    vv_mesh_release(sphere);
}

/* Two boxes, the second inside out. */
static vv_mesh *two_boxes(void)
{
    vv_mesh *mesh, *box[2] = {test_mesh_box(2, 2, 2, (vv_vec3){0}), test_mesh_box(1, 1, 1, (vv_vec3){.5, .5, .5})};
    vvi_mesh_arrays a;
    const vv_mesh_info info = {.n_vertices = 16, .n_triangles = 24, .n_parts = 2};
    assert_int_equal(vvi_mesh_new(&mesh, &a, &info, 0, NULL), VV_OK);
    for (size_t i = 0; i < 2; i++) {
        const vv_mesh_info *m = vv_mesh_get_info(box[i]);
        memcpy(a.positions + 24 * i, m->positions, 24 * sizeof(float));
        for (size_t t = 0; t < 36; t++)
            a.triangles[36 * i + t] = (uint32_t)(8 * i) + m->triangles[i ? t / 3 * 3 + 2 - t % 3 : t];
        a.parts[i].first_triangle = 12 * i;
        a.parts[i].n_triangles = 12;
        vv_mesh_release(box[i]);
    }
    return mesh;
}

static void parts_are_measured_alone_and_hollows_are_left_out(void **state)
{
    (void)state;
    vv_mesh *mesh = two_boxes();
    vv_mesh_measure_options o = defaults();
    vv_mesh_measures m = measured(mesh, NULL);
    assert_within(m.volume.value, 7, 1e-9);
    assert_within(m.area.value, 30, 1e-9);
    assert_within(m.inertia[0].value, 8 * 8 / 12.0 - 1 / 6.0, 1e-9);
    o.part = 0;
    assert_within(measured(mesh, &o).volume.value, 8, 1e-9);
    o.part = 1;
    m = measured(mesh, &o);
    assert_within(m.volume.value, 1, 1e-9);
    assert_within(m.area.value, 6, 1e-9);
    assert_within(m.centroid[1].value, 1, 1e-9);
    assert_within(m.bounds.lo.x, .5, 0);
    assert_within(m.bounds.hi.z, 1.5, 0);
    assert_true(m.inside_out);
    assert_string_equal(m.area.unit, "");
    o.part = 2;
    assert_int_equal(vv_mesh_measure(&m, mesh, &o, NULL), VV_E_ARGUMENT);
    vv_mesh_release(mesh);
}

static void nothing_has_no_area_and_no_number_is_an_error(void **state)
{
    (void)state;
    vv_mesh *none = test_mesh_new(NULL, 0, NULL, 0);
    vv_mesh_measure_options o = defaults();
    for (int sampled = 0; sampled < 2; sampled++) {
        o.sampled = sampled;
        const vv_mesh_measures m = measured(none, &o);
        assert_true(m.area.value == 0 && m.volume.value == 0 && m.closed && isnan(m.centroid[0].value));
        assert_true(m.bounds.hi.x < m.bounds.lo.x);
    }
    vv_mesh_release(none);
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 3; i++) {
        const float p[9] = {0, 0, 0, 1, 0, 0, 0, bad[i], 0};
        const uint32_t t[3] = {0, 1, 2};
        vv_mesh *mesh = test_mesh_new(p, 3, t, 1);
        vv_mesh_measures m;
        assert_int_equal(vv_mesh_measure(&m, mesh, NULL, NULL), VV_E_ARGUMENT);
        vv_mesh_release(mesh);
    }
}

/* Every build against test_mesh_area() and the formulas one triangle at a time; lengths around the width. */
static void every_build_sums_the_same(void **state)
{
    (void)state;
    vv_mesh *mesh = test_mesh_marched_sphere(9, true);
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    static const size_t lengths[] = {0, 1, 7, 8, 9, 101, 1000};
    for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++)
        for (int mapped = 0; mapped < 2; mapped++) {
            vvi_mass_block block = {.positions = m->positions,
                                    .normals = m->normals,
                                    .triangles = m->triangles,
                                    .n = lengths[i],
                                    .matrix = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                    .determinant = 1};
            if (mapped)
                block.matrix[0][1] = .5;
            double expected[VVI_MASS_SUMS] = {0}, sums[VVI_MASS_SUMS];
            uint64_t edges = 0;
            for (size_t t = 0; t < lengths[i]; t++) {
                vvi_mass_block one = block;
                one.triangles += 3 * t;
                one.n = 1;
                vvi_mass_kernels_for(0)->sum(sums, &edges, &one);
                for (int s = 0; s < VVI_MASS_SUMS; s++)
                    expected[s] += sums[s];
            }
            for (size_t k = 0; vvi_mass_kernels_nth(k); k++) {
                uint64_t found = 0;
                if (vvi_mass_kernels_nth(k)->needs & ~vvi_cpu_detect())
                    continue;
                vvi_mass_kernels_nth(k)->sum(sums, &found, &block);
                assert_true(found == edges);
                for (int s = 0; s < VVI_MASS_SUMS; s++)
                    assert_within(sums[s], expected[s], 1e-12 * fabs(expected[VVI_MASS_AREA]) * 1000);
            }
        }
    vv_mesh_release(mesh);
}

static void the_same_bytes_come_from_any_number_of_threads(void **state)
{
    (void)state;
    vv_mesh *mesh = test_mesh_marched_sphere(53, true);
    vv_mesh_measure_options o = defaults();
    o.sampled = true;
    vv_mesh_measures one;
    for (int threads = 1; threads <= 8; threads *= 2) {
        vv_job *job = test_job(threads, 0);
        vv_mesh_measures m;
        memset(&m, 0, sizeof m);
        assert_int_equal(vv_mesh_measure(&m, mesh, &o, job), VV_OK);
        if (threads == 1)
            one = m;
        assert_true(m.area.value == one.area.value && m.area.error == one.area.error);
        assert_true(m.volume.value == one.volume.value && m.volume.error == one.volume.error);
        for (int i = 0; i < 6; i++)
            assert_true(m.inertia[i].value == one.inertia[i].value);
        vv_job_release(job);
    }
    vv_mesh_release(mesh);
}

static vv_status measure_open_soup(void *user)
{
    vv_mesh_measures m;
    vv_mesh_measure_options o = defaults();
    o.open = o.sampled = true;
    return vv_mesh_measure(&m, user, &o, NULL);
}

static void every_failing_allocation_is_reported(void **state)
{
    (void)state;
    vv_mesh *mesh = test_mesh_square(1, 5);
    assert_true(test_fail_each_alloc(measure_open_soup, mesh) >= 7);
    vv_mesh_release(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_has_its_area_volume_and_inertia),
        cmocka_unit_test(an_affine_map_moves_the_vertices_first),
        cmocka_unit_test(spheres_of_marching_cubes_have_known_errors),
        cmocka_unit_test(a_torus_of_marching_cubes_has_known_errors),
        cmocka_unit_test(the_truth_of_spheres_lies_within_the_error),
        cmocka_unit_test(the_rounding_of_vertices_is_within_the_error),
        cmocka_unit_test(an_open_mesh_is_an_error_that_says_where),
        cmocka_unit_test(a_mesh_without_shared_vertices_can_be_closed),
        cmocka_unit_test(parts_are_measured_alone_and_hollows_are_left_out),
        cmocka_unit_test(nothing_has_no_area_and_no_number_is_an_error),
        cmocka_unit_test(every_build_sums_the_same),
        cmocka_unit_test(the_same_bytes_come_from_any_number_of_threads),
        cmocka_unit_test(every_failing_allocation_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
