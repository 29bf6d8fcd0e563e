/* Smoothing: a filter that never amplifies; spheres keep their volume and lose their noise; borders; vertices at the
 * same place; threads. */
#include "core/memory.h"
#include "fail_alloc.h"
#include "fields.h"
#include "grid/mesh.h"
#include "jobs.h"
#include "meshes.h"
#include "shapes.h"
#include "surface/smooth.h"
#include "surface/smooth_filter.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static vv_mesh *smoothed(const vv_mesh *mesh, const vvi_smooth_options *options, vv_job *job)
{
    vv_mesh *out;
    if (vvi_mesh_smooth(&out, mesh, options, job) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    return out;
}

/* A sphere of radius 10 whose vertices are off by up to `noise` along the radius. */
static vv_mesh *noisy_sphere(double noise)
{
    vv_mesh *sphere = test_mesh_sphere((vv_vec3){0}, 10, 5);
    const vv_mesh_info *m = vv_mesh_get_info(sphere);
    float *p = malloc(3 * m->n_vertices * sizeof *p);
    for (size_t i = 0; i < 3 * m->n_vertices; i++)
        p[i] = m->positions[i] * (float)(1 + noise / 10 * (2 * test_random_unit(test_seed(), i / 3) - 1));
    vv_mesh *out = test_mesh_new(p, m->n_vertices, m->triangles, m->n_triangles);
    vv_mesh_release(sphere);
    free(p);
    return out;
}

static double roughness(const vv_mesh *mesh)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    double sum = 0, mean = 0;
    for (size_t v = 0; v < m->n_vertices; v++) {
        const vv_vec3 p = test_mesh_vertex(mesh, v);
        const double r = sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
        sum += r * r;
        mean += r;
    }
    mean /= (double)m->n_vertices;
    return sqrt(fmax(0, sum / (double)m->n_vertices - mean * mean));
}

static void a_sphere_keeps_its_volume_and_loses_its_noise(void **state)
{
    (void)state;
    vv_mesh *noisy = noisy_sphere(.3);
    vvi_smooth_options o = vvi_smooth_options_default();
    for (o.iterations = 10; o.iterations <= 100; o.iterations *= 10) {
        vv_mesh *out = smoothed(noisy, &o, NULL);
        assert_true(fabs(test_mesh_volume(out) / test_mesh_volume(noisy) - 1) < 1e-5);
        assert_true(roughness(out) < .4 * roughness(noisy));
        assert_int_equal(test_mesh_bad_edges(out), 0);
        vv_mesh_release(out);
    }
    vv_mesh_release(noisy);
}

static double gain_of(const vvi_smooth_filter *f, double x)
{
    double sum = 0;
    for (int i = 0; i < f->n; i++)
        sum += f->c[i] * cos(i * acos(x));
    return sum;
}

/* The polynomial is what its definition says: 1 for what is constant, never more, and less and less. */
static void the_filter_never_amplifies(void **state)
{
    (void)state;
    static const double bands[] = {.001, .01, .1, .5, 1, 1.5, 1.9};
    static const int steps[] = {2, 40, 2000};
    for (size_t i = 0; i < 21; i++) {
        vvi_smooth_filter f;
        const double band = bands[i / 3], m = vvi_smooth_order(steps[i % 3], band);
        assert_int_equal(vvi_smooth_filter_make(&f, steps[i % 3], band, NULL), VV_OK);
        double before = 1;
        for (int k = 0; k <= 500; k++) {
            const double gain = gain_of(&f, 1 - k / 250.);
            assert_true(fabs(gain - vvi_smooth_gain(steps[i % 3], m, k / 500.)) < 1e-7);
            assert_true(gain < before + 1e-7 && gain > -1e-7);
            before = gain;
        }
        assert_true(fabs(gain_of(&f, 1) - 1) < 1e-7 && gain_of(&f, 1 - band) > VVI_SMOOTH_KEPT - 1e-6);
        vvi_free(f.c);
    }
}

/* Of another way to the same number: trials that are drawn one after another. */
static void the_gain_is_a_probability(void **state)
{
    (void)state;
    double p[42] = {1};
    for (int trial = 0; trial < 40; trial++)
        for (int j = 40; j >= 0; j--)
            p[j] = p[j] * .9 + (j ? p[j - 1] * .1 : 0);
    assert_true(fabs(vvi_smooth_gain(40, 3.25, .1) - (p[0] + p[1] + p[2] + p[3] + .25 * p[4])) < 1e-12);
    assert_true(vvi_smooth_gain(40, 3, 0) == 1 && vvi_smooth_gain(40, 3, 1) == 0 && vvi_smooth_gain(40, 40, .7) == 1);
}

/* How far from the sphere a vertex lies, at most. */
static double off_sphere(const vv_mesh *mesh, double radius)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    vv_vec3 middle = {0};
    double most = 0;
    for (size_t v = 0; v < m->n_vertices; v++) {
        const vv_vec3 p = test_mesh_vertex(mesh, v);
        middle = (vv_vec3){middle.x + p.x, middle.y + p.y, middle.z + p.z};
    }
    const double n = (double)m->n_vertices;
    for (size_t v = 0; v < m->n_vertices; v++) {
        const vv_vec3 p = test_mesh_vertex(mesh, v);
        const double x = p.x - middle.x / n, y = p.y - middle.y / n, z = p.z - middle.z / n;
        most = fmax(most, fabs(sqrt(x * x + y * y + z * z) - radius));
    }
    return most;
}

static void check_ball(const vv_mesh *ball, double radius, const vvi_smooth_options *o)
{
    vv_mesh *out = smoothed(ball, o, NULL);
    assert_true(fabs(test_mesh_volume(out) / test_mesh_volume(ball) - 1) < 1e-5);
    assert_true(test_mesh_area(out) < 1.006 * test_mesh_area(ball)); /* vertices move along the surface as well */
    assert_true(off_sphere(out, radius) < .07 * radius);
    vv_mesh_release(out);
}

static void balls_stay_balls_whatever_is_asked_for(void **state)
{
    (void)state;
    static const double bands[] = {.001, .01, .05, .1, .2, .5, 1, 1.5, 1.9};
    for (double radius = 6; radius <= 15; radius += 9) {
        vv_mesh *ball = test_mesh_marched_sphere(radius, false);
        for (int i = 0; i < 27; i++) {
            const vvi_smooth_options o = {.iterations = i % 3 ? i % 3 == 1 ? 100 : 1000 : 20,
                                          .pass_band = bands[i / 3]};
            check_ball(ball, radius, &o);
        }
        vv_mesh_release(ball);
    }
}

/* An octahedron is all short waves, far from the origin or not; beside a ball it is filtered by itself. */
static void a_piece_of_few_triangles_does_not_vanish(void **state)
{
    (void)state;
    static const float p[] = {1001, 0, 0, 999, 0, 0, 1000, 1, 0, 1000, -1, 0, 1000, 0, 1, 1000, 0, -1};
    static const uint32_t t[] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    vv_mesh *mesh = test_mesh_new(p, 6, t, 8);
    const vvi_smooth_options o = vvi_smooth_options_default();
    vv_mesh *out = smoothed(mesh, &o, NULL);
    assert_true(fabs(test_mesh_volume(out) / (4. / 3) - 1) < 1e-4);
    vv_mesh_release(out);
    vv_mesh_release(mesh);
}

/* Of noise that the filter takes out, a pass band above it keeps all. */
static void only_a_wide_pass_band_keeps_noise(void **state)
{
    (void)state;
    vv_mesh *noisy = noisy_sphere(.3);
    vvi_smooth_options narrow = {.iterations = 50, .pass_band = .05}, wide = {.iterations = 50, .pass_band = .9};
    vv_mesh *a = smoothed(noisy, &narrow, NULL), *b = smoothed(noisy, &wide, NULL);
    assert_true(roughness(a) < .7 * roughness(b));
    vv_mesh_release(a);
    vv_mesh_release(b);
    narrow.iterations = 0;
    a = smoothed(noisy, &narrow, NULL);
    const vv_mesh_info *m = vv_mesh_get_info(noisy);
    assert_memory_equal(vv_mesh_get_info(a)->positions, m->positions, 12 * m->n_vertices);
    vv_mesh_release(a);
    vv_mesh_release(noisy);
}

static bool on_border(const float *p, float size)
{
    return p[0] == 0 || p[1] == 0 || p[0] == size || p[1] == size;
}

/* A square with bumps: its border is a straight line, along which vertices may move, or they are fixed. */
static void borders_are_smoothed_along_themselves_or_fixed(void **state)
{
    (void)state;
    vv_mesh *square = test_mesh_square(16, 16);
    const vv_mesh_info *m = vv_mesh_get_info(square);
    float *p = malloc(3 * m->n_vertices * sizeof *p);
    memcpy(p, m->positions, 3 * m->n_vertices * sizeof *p);
    for (size_t v = 0; v < m->n_vertices; v++)
        if (!on_border(p + 3 * v, 16))
            p[3 * v + 2] = (float)test_random_unit(test_seed(), v);
    vv_mesh *rough = test_mesh_new(p, m->n_vertices, m->triangles, m->n_triangles);
    vvi_smooth_options o = vvi_smooth_options_default();
    for (int fixed = 0; fixed < 2; fixed++) {
        o.fix_border = fixed;
        vv_mesh *out = smoothed(rough, &o, NULL);
        const float *q = vv_mesh_get_info(out)->positions;
        for (size_t v = 0; v < m->n_vertices; v++)
            if (on_border(p + 3 * v, 16)) {
                assert_true(fabsf(q[3 * v + 2]) == 0); /* nothing inside draws at it */
                assert_true(!fixed || memcmp(p + 3 * v, q + 3 * v, 3 * sizeof *p) == 0);
            }
        vv_mesh_release(out);
    }
    vv_mesh_release(rough);
    vv_mesh_release(square);
    free(p);
}

static void vertices_at_the_same_place_stay_together(void **state)
{
    (void)state;
    vv_mesh *sphere = test_mesh_marched_sphere(6, false), *soup = test_mesh_unshared(sphere);
    const vvi_smooth_options o = vvi_smooth_options_default();
    vv_mesh *a = smoothed(sphere, &o, NULL), *b = smoothed(soup, &o, NULL);
    const vv_mesh_info *m = vv_mesh_get_info(a), *n = vv_mesh_get_info(b);
    for (size_t i = 0; i < 3 * m->n_triangles; i++)
        for (size_t c = 0; c < 3; c++) /* neighbours are added up in another order */
            assert_true(fabsf(m->positions[3 * (size_t)m->triangles[i] + c] - n->positions[3 * i + c]) < 1e-5f);
    vv_mesh_release(a);
    vv_mesh_release(b);
    vv_mesh_release(sphere);
    vv_mesh_release(soup);
}

static void the_same_bytes_come_from_any_number_of_threads(void **state)
{
    (void)state;
    vv_mesh *mesh = test_mesh_marched_sphere(35, true), *one = NULL;
    const vvi_smooth_options o = vvi_smooth_options_default();
    for (int threads = 1; threads <= 4; threads *= 2) {
        vv_job *job = test_job(threads, 0);
        vv_mesh *out = smoothed(mesh, &o, job);
        const vv_mesh_info *m = vv_mesh_get_info(out);
        if (one) {
            assert_memory_equal(m->positions, vv_mesh_get_info(one)->positions, 12 * m->n_vertices);
            assert_memory_equal(m->normals, vv_mesh_get_info(one)->normals, 12 * m->n_vertices);
            vv_mesh_release(out);
        } else {
            one = out;
        }
        vv_job_release(job);
    }
    vv_mesh_release(one);
    vv_mesh_release(mesh);
}

static void options_out_of_range_and_empty_meshes(void **state)
{
    (void)state;
    vv_mesh *none = test_mesh_new(NULL, 0, NULL, 0), *out;
    vvi_smooth_options o = vvi_smooth_options_default();
    vv_mesh_release(smoothed(none, &o, NULL));
    static const vvi_smooth_options bad[] = {{-1, .1, false}, {1001, .1, false}, {1, 0, false},
                                             {1, 2, false},   {1, NAN, false},   {1, -1, false}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(vvi_mesh_smooth(&out, none, &bad[i], NULL), VV_E_ARGUMENT);
    vv_mesh_release(none);
}

static vv_status smooth_once(void *user)
{
    vv_mesh *out;
    vvi_smooth_options o = vvi_smooth_options_default();
    o.iterations = 1;
    const vv_status st = vvi_mesh_smooth(&out, user, &o, NULL);
    vv_mesh_release(out);
    return st;
}

static void every_failing_allocation_is_reported(void **state)
{
    (void)state;
    vv_mesh *mesh = test_mesh_square(1, 3);
    assert_true(test_fail_each_alloc(smooth_once, mesh) >= 10);
    vv_mesh_release(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sphere_keeps_its_volume_and_loses_its_noise),
        cmocka_unit_test(the_filter_never_amplifies),
        cmocka_unit_test(the_gain_is_a_probability),
        cmocka_unit_test(balls_stay_balls_whatever_is_asked_for),
        cmocka_unit_test(a_piece_of_few_triangles_does_not_vanish),
        cmocka_unit_test(only_a_wide_pass_band_keeps_noise),
        cmocka_unit_test(borders_are_smoothed_along_themselves_or_fixed),
        cmocka_unit_test(vertices_at_the_same_place_stay_together),
        cmocka_unit_test(the_same_bytes_come_from_any_number_of_threads),
        cmocka_unit_test(options_out_of_range_and_empty_meshes),
        cmocka_unit_test(every_failing_allocation_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
