/* Distances against closed forms of spheres, boxes and squares, and against trying every triangle. */
#include "core/vec.h"
#include "fail_alloc.h"
#include "fields.h"
#include "grid/mesh.h"
#include "jobs.h"
#include "measure/bvh.h"
#include "shapes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/measure_distance.h>

#include <cmocka.h>

#define assert_within(value, truth, error)                                                                             \
    do {                                                                                                               \
        if (!(fabs((value) - (truth)) <= (error)))                                                                     \
            fail_msg("%s is %.12g and not %.12g +- %.3g", #value, (double)(value), (double)(truth), (double)(error));  \
    } while (0)

static vv_mesh_tree *tree_of(vv_mesh *mesh, const vv_affine *map)
{
    vv_mesh_tree *tree;
    if (vv_mesh_tree_new(&tree, mesh, map, NULL) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    vv_mesh_release(mesh);
    return tree;
}

static double random_in(double lo, double hi, uint64_t index)
{
    return lo + (hi - lo) * test_random_unit(test_seed(), index);
}

static vv_vec3 random_point(double lo, double hi, uint64_t index)
{
    return vvi_vec(random_in(lo, hi, 3 * index), random_in(lo, hi, 3 * index + 1), random_in(lo, hi, 3 * index + 2));
}

static void points_and_angles(void **state)
{
    (void)state;
    const vv_vec3 p[4] = {{0, 0, 0}, {3, 4, 0}, {3, 4, 12}, {3, 4, 11}};
    assert_within(vv_distance(p[0], p[2]), 13, 0);
    assert_within(vv_polyline_length(p, 4), 18, 0);
    assert_within(vv_polyline_length(p, 1), 0, 0);
    assert_within(vv_polyline_length(p, 0), 0, 0);
    assert_within(vv_angle_at(p[0], p[1], p[2]), M_PI / 2, 1e-15);
    assert_within(vv_angle_between(vvi_vec(1, 0, 0), vvi_vec(-2, 0, 0)), M_PI, 0);
    assert_within(vv_angle_between(vvi_vec(1, 0, 0), vvi_vec(1, 1e-9, 0)), 1e-9, 1e-24); /* acos() would say 0 */
    assert_true(isnan(vv_angle_between(vvi_vec(1, 0, 0), vvi_vec(0, 0, 0))));
    assert_true(isnan(vv_angle_at(p[1], p[1], p[2])));
}

/* Triangles of every kind: any, slivers, points. */
static vvi_triangle random_triangle(uint64_t i)
{
    vvi_triangle t = {random_point(-1, 1, 3 * i), random_point(-1, 1, 3 * i + 1), random_point(-1, 1, 3 * i + 2)};
    if (i % 5 == 1)
        t.c = vvi_between(t.a, t.b, random_in(-.5, 1.5, i));
    if (i % 5 == 2)
        t.b = t.c;
    if (i % 25 == 3)
        t.a = t.b = t.c;
    return t;
}

static void the_nearest_place_of_a_triangle_is_nearer_than_all_others(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 3000; i++) {
        const vvi_triangle t = random_triangle(i);
        const vv_vec3 p = random_point(-2, 2, 100000 + i), w = vvi_nearest_weights(p, &t);
        assert_true(w.x >= 0 && w.y >= 0 && w.z >= 0);
        assert_within(w.x + w.y + w.z, 1, 1e-12);
        const double best = vv_distance(p, vvi_triangle_at(&t, w));
        assert_within(sqrt(vvi_triangle_square(p, &t)), best, 1e-15);
        for (int u = 0; u <= 12; u++)
            for (int v = 0; u + v <= 12; v++) {
                const vv_vec3 other = {(12 - u - v) / 12.0, u / 12.0, v / 12.0};
                assert_true(vv_distance(p, vvi_triangle_at(&t, other)) >= best - 1e-12);
            }
    }
}

/* Sampled, the distance of two triangles is never less; it is reached at the places that are told. */
static void two_triangles_are_no_nearer_than_is_said(void **state)
{
    (void)state;
    int crossing = 0;
    for (uint64_t i = 0; i < 3000; i++) {
        vvi_triangle s = random_triangle(2 * i), t = random_triangle(2 * i + 1);
        const vv_vec3 by = random_point(-1.5, 1.5, 200000 + i);
        t = (vvi_triangle){vvi_add(t.a, by), vvi_add(t.b, by), vvi_add(t.c, by)};
        vv_vec3 p, q;
        const double d = sqrt(vvi_triangles_square(&p, &q, &s, &t));
        crossing += d == 0;
        assert_within(vv_distance(p, q), d, 1e-12);
        assert_true(vvi_triangle_square(p, &s) < 1e-20 && vvi_triangle_square(q, &t) < 1e-20);
        for (int u = 0; u <= 8; u++)
            for (int v = 0; u + v <= 8; v++) {
                const vv_vec3 w = {(8 - u - v) / 8.0, u / 8.0, v / 8.0};
                assert_true(sqrt(vvi_triangle_square(vvi_triangle_at(&s, w), &t)) >= d - 1e-9);
            }
    }
    assert_true(crossing > 20 && crossing < 2000);
}

static void the_tree_finds_what_trying_all_triangles_finds(void **state)
{
    (void)state;
    static const uint32_t sizes[] = {1, 2, 3, 5, 11, 40};
    const vv_affine turned = {.axis = {{.8, .6, 0}, {-.6, .8, 0}, {0, 0, 2}}, .origin = {1e3, 2e3, -1e3}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (int mapped = 0; mapped < 2; mapped++) {
            vv_mesh_tree *tree = tree_of(test_mesh_square(3, sizes[s]), mapped ? &turned : NULL);
            for (uint64_t i = 0; i < 200; i++) {
                vv_vec3 p = random_point(-2, 5, i);
                if (mapped)
                    p = vv_affine_point(turned, p);
                double square = INFINITY;
                for (size_t t = 0; t < tree->n; t++) {
                    const vvi_triangle tri = vvi_bvh_triangle(tree, t);
                    square = fmin(square, vvi_triangle_square(vvi_sub(p, tree->origin), &tri));
                }
                vv_mesh_foot f;
                vv_mesh_tree_nearest(&f, tree, p);
                assert_true(f.distance == sqrt(square));
                assert_within(vv_distance(f.at, p), f.distance, 1e-9);
                assert_true(isnan(f.signed_distance));
            }
            vv_mesh_tree_release(tree);
        }
}

static void every_triangle_is_once_in_the_tree(void **state)
{
    (void)state;
    vv_mesh_tree *tree = tree_of(test_mesh_sphere((vv_vec3){5, 6, 7}, 3, 4), NULL);
    char *seen = calloc(tree->n, 1);
    for (size_t i = 0; i < tree->n; i++)
        assert_int_equal(seen[tree->order[i]]++, 0);
    free(seen);
    vv_mesh_tree_release(tree);
}

/* Distance from a box, negative inside. */
static double box_distance(vv_vec3 p, vv_vec3 half)
{
    const vv_vec3 q = {fabs(p.x) - half.x, fabs(p.y) - half.y, fabs(p.z) - half.z};
    const double inside = fmin(fmax(q.x, fmax(q.y, q.z)), 0);
    return vvi_length(vvi_vec(fmax(q.x, 0), fmax(q.y, 0), fmax(q.z, 0))) + inside;
}

static void signs_say_what_is_inside(void **state)
{
    (void)state;
    const vv_affine mirror = {.axis = {{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    for (int way = 0; way < 3; way++) {
        vv_mesh *box = test_mesh_box(2, 4, 6, (vv_vec3){-1, -2, -3});
        if (way == 1) { /* each triangle with its own vertices */
            vv_mesh *soup = test_mesh_unshared(box);
            vv_mesh_release(box);
            box = soup;
        }
        vv_mesh_tree *tree = tree_of(box, way == 2 ? &mirror : NULL);
        assert_true(vv_mesh_tree_closed(tree));
        for (uint64_t i = 0; i < 2000; i++) {
            const vv_vec3 p = random_point(-5, 5, i);
            vv_mesh_foot f;
            vv_mesh_tree_nearest(&f, tree, p);
            assert_within(f.signed_distance, box_distance(p, vvi_vec(1, 2, 3)), 1e-12);
        }
        vv_mesh_tree_release(tree);
    }
    vv_mesh_tree *tree = tree_of(test_mesh_sphere((vv_vec3){1, 2, 3}, 10, 4), NULL);
    for (uint64_t i = 0; i < 2000; i++) {
        const vv_vec3 p = random_point(-15, 15, i);
        vv_mesh_foot f;
        vv_mesh_tree_nearest(&f, tree, p);
        assert_within(f.signed_distance, vvi_length(vvi_sub(p, vvi_vec(1, 2, 3))) - 10, .03);
    }
    vv_mesh_tree_release(tree);
}

static void spheres_apart_have_their_least_distance(void **state)
{
    (void)state;
    vv_mesh_tree *a = tree_of(test_mesh_sphere((vv_vec3){1, 2, 3}, 6, 5), NULL);
    vv_mesh_foot p, q;
    const vv_affine away = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .origin = {18, 0, 0}};
    vv_mesh_tree *b = tree_of(test_mesh_sphere((vv_vec3){1, 2, 3}, 6, 5), &away);
    assert_int_equal(vv_mesh_least_distance(&p, &q, a, b, NULL), VV_OK);
    assert_within(p.distance, 6, .03);
    assert_within(vv_distance(p.at, q.at), p.distance, 1e-9);
    vv_mesh_foot foot;
    vv_mesh_tree_nearest(&foot, b, p.at);
    assert_within(foot.distance, p.distance, 1e-9);
    vv_mesh_tree_release(b);
    const vv_affine near = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .origin = {7, 3, 1}};
    b = tree_of(test_mesh_sphere((vv_vec3){1, 2, 3}, 6, 5), &near);
    assert_int_equal(vv_mesh_least_distance(&p, &q, a, b, NULL), VV_OK);
    assert_within(p.distance, 0, 0);
    assert_within(vv_distance(p.at, q.at), 0, 1e-6);
    vv_mesh_tree_nearest(&foot, b, p.at);
    assert_within(foot.distance, 0, 1e-5);
    vv_mesh_tree_release(b);
    vv_mesh_tree_release(a);
}

/* Random pieces of surfaces against all pairs of triangles. */
static void the_least_distance_is_that_of_all_pairs(void **state)
{
    (void)state;
    for (uint64_t k = 0; k < 20; k++) {
        const vv_vec3 to = random_point(-3, 3, k);
        const vv_affine map = {.axis = {{.8, .6, 0}, {-.6, .8, 0}, {0, 0, 1}}, .origin = to};
        vv_mesh_tree *a = tree_of(test_mesh_square(2, 5), NULL),
                     *b = tree_of(test_mesh_sphere((vv_vec3){0}, 1, 2), &map);
        double square = INFINITY;
        for (size_t i = 0; i < a->n; i++)
            for (size_t j = 0; j < b->n; j++) {
                vv_vec3 p, q;
                const vvi_triangle s = vvi_bvh_triangle(a, i);
                vvi_triangle t = vvi_bvh_triangle(b, j);
                const vv_vec3 by = vvi_sub(b->origin, a->origin);
                t = (vvi_triangle){vvi_add(t.a, by), vvi_add(t.b, by), vvi_add(t.c, by)};
                square = fmin(square, vvi_triangles_square(&p, &q, &s, &t));
            }
        vv_mesh_foot p, q;
        assert_int_equal(vv_mesh_least_distance(&p, &q, a, b, NULL), VV_OK);
        assert_within(p.distance, sqrt(square), 1e-9);
        vv_mesh_tree_release(a);
        vv_mesh_tree_release(b);
    }
}

static void concentric_spheres_are_apart_by_their_radii(void **state)
{
    (void)state;
    vv_mesh_tree *a = tree_of(test_mesh_sphere((vv_vec3){1, 2, 3}, 10, 5), NULL),
                 *b = tree_of(test_mesh_sphere((vv_vec3){1, 2, 3}, 12, 5), NULL);
    vv_mesh_distances d;
    assert_int_equal(vv_mesh_distance(&d, a, b, NULL, NULL), VV_OK);
    assert_within(d.hausdorff.value, 2, .02);
    assert_within(d.a_to_b.mean.value, 2, .02);
    assert_within(d.a_to_b.rms.value, 2, .02);
    assert_within(d.b_to_a.max.value, 2, .02);
    assert_true(d.hausdorff.error < .03 && d.a_to_b.mean.error < 1e-3);
    assert_true(d.a_to_b.n_samples > 190000 && d.a_to_b.n_samples < 210000);
    assert_string_equal(d.hausdorff.unit, vv_mesh_get_info(a->mesh)->unit);
    assert_within(vv_distance(d.b_to_a.worst, d.b_to_a.worst_foot), d.b_to_a.max.value, 1e-9);
    vv_mesh_tree_release(a);
    vv_mesh_tree_release(b);
}

/* A small square over the middle of a large one: near one way, far the other, where the corners are. */
static void one_way_is_not_the_other(void **state)
{
    (void)state;
    const vv_affine up = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .origin = {4, 4, 1}};
    vv_mesh_tree *a = tree_of(test_mesh_square(10, 9), NULL), *b = tree_of(test_mesh_square(2, 2), &up);
    vv_mesh_distances d;
    assert_int_equal(vv_mesh_distance(&d, a, b, NULL, NULL), VV_OK);
    assert_within(d.b_to_a.max.value, 1, 1e-6);
    assert_within(d.b_to_a.mean.value, 1, 1e-6);
    assert_within(d.b_to_a.max.error, 0, 2e-3);
    assert_within(d.a_to_b.max.value, sqrt(33), 1e-6);
    assert_within(d.a_to_b.max.error, 0, 1e-4);
    assert_within(d.hausdorff.value, sqrt(33), 1e-6);
    double mean = 0; /* over the large square, by the midpoint rule */
    const int n = 1000;
    for (int i = 0; i < n * n; i++) {
        const double x = fmax(0, fabs((i % n + .5) * 10 / n - 5) - 1), y = fmax(0, fabs((i / n + .5) * 10 / n - 5) - 1);
        mean += sqrt(x * x + y * y + 1) / n / n;
    }
    assert_within(d.a_to_b.mean.value, mean, d.a_to_b.mean.error);
    vv_mesh_tree_release(a);
    vv_mesh_tree_release(b);
}

/* Two triangles over 20000: of places inside the large ones no vertex tells. */
static void large_flat_triangles_are_bounded_too(void **state)
{
    (void)state;
    const vv_affine up = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .origin = {0, 0, 2}};
    vv_mesh_tree *fine = tree_of(test_mesh_square(100, 100), NULL), *flat = tree_of(test_mesh_square(100, 1), &up);
    vv_mesh_distances d;
    assert_int_equal(vv_mesh_distance(&d, fine, flat, NULL, NULL), VV_OK);
    assert_within(d.hausdorff.value, 2, 1e-5);
    assert_true(d.a_to_b.max.error < .002 * 2 && d.b_to_a.max.error < .04 * 2);
    vv_mesh_tree_release(fine);
    vv_mesh_tree_release(flat);
    /* boxes in boxes: between their corners, and between their faces */
    vv_mesh_tree *inner = tree_of(test_mesh_box(40, 60, 80, (vv_vec3){-20, -30, -40}), NULL);
    vv_mesh_tree *outer = tree_of(test_mesh_box(42, 62, 82, (vv_vec3){-21, -31, -41}), NULL);
    assert_int_equal(vv_mesh_distance(&d, inner, outer, NULL, NULL), VV_OK);
    assert_within(d.a_to_b.max.value, 1, 1e-5);
    assert_within(d.b_to_a.max.value, sqrt(3), 1e-5);
    assert_true(d.a_to_b.max.error < .002 && d.b_to_a.max.error < .004);
    vv_mesh_tree_release(inner);
    vv_mesh_tree_release(outer);
}

/* A sphere in a box: from the sphere the farthest places are inside triangles, where no vertex is. The bound holds,
 * with as good as no samples too. */
static void the_error_bounds_what_samples_missed(void **state)
{
    (void)state;
    for (int coarse = 0; coarse < 2; coarse++) {
        vv_mesh_tree *sphere = tree_of(test_mesh_sphere((vv_vec3){0}, 10, 5), NULL);
        vv_mesh_tree *box = tree_of(test_mesh_box(40, 40, 40, (vv_vec3){-20, -20, -20}), NULL);
        vv_mesh_distance_options o;
        vv_mesh_distances d;
        vv_mesh_distance_options_init(&o, sizeof o);
        o.density = coarse ? 1e-9 : 3;
        assert_int_equal(vv_mesh_distance(&d, box, sphere, &o, NULL), VV_OK);
        const double from_box = 20 * sqrt(3) - 10;
        assert_within(d.a_to_b.max.value, from_box, .02);
        assert_true(d.a_to_b.max.value + d.a_to_b.max.error >= from_box - .02);
        assert_true(d.b_to_a.max.value <= 20 - 10 / sqrt(3) + .02); /* the diagonal places of the sphere */
        assert_true(d.b_to_a.max.value + d.b_to_a.max.error >= 20 - 10 / sqrt(3) - .02);
        assert_true(d.b_to_a.max.error < .5);
        assert_true(coarse ? isnan(d.a_to_b.mean.value) || d.a_to_b.n_samples > 0 : d.a_to_b.n_samples > 20000);
        vv_mesh_tree_release(sphere);
        vv_mesh_tree_release(box);
    }
}

static void the_same_bytes_come_from_any_number_of_threads(void **state)
{
    (void)state;
    vv_mesh *a = test_mesh_marched_sphere(13, true), *b = test_mesh_marched_torus(12, 5);
    vv_mesh_distances one = {0};
    vv_mesh_distance_options o;
    vv_mesh_distance_options_init(&o, sizeof o);
    o.density = 10; /* items are triangles, whatever the samples: 20000 of these are as hard as 200000 */
    for (int threads = 1; threads <= 4; threads *= 2) {
        vv_job *job = test_job(threads, 0);
        vv_mesh_tree *s, *t;
        vv_mesh_distances d = {0};
        assert_int_equal(vv_mesh_tree_new(&s, a, NULL, job), VV_OK);
        assert_int_equal(vv_mesh_tree_new(&t, b, NULL, job), VV_OK);
        assert_int_equal(vv_mesh_distance(&d, s, t, &o, job), VV_OK);
        if (threads == 1)
            one = d;
        assert_true(d.a_to_b.mean.value == one.a_to_b.mean.value && d.b_to_a.rms.value == one.b_to_a.rms.value);
        assert_true(d.hausdorff.value == one.hausdorff.value && d.hausdorff.error == one.hausdorff.error);
        vv_mesh_tree_release(s);
        vv_mesh_tree_release(t);
        vv_job_release(job);
    }
    vv_mesh_release(a);
    vv_mesh_release(b);
}

static void what_cannot_be_is_an_error(void **state)
{
    (void)state;
    vv_mesh *none = test_mesh_new(NULL, 0, NULL, 0);
    vv_mesh_tree *tree;
    assert_int_equal(vv_mesh_tree_new(&tree, none, NULL, NULL), VV_E_ARGUMENT);
    assert_null(tree);
    vv_mesh_release(none);
    vv_mesh_tree *a = tree_of(test_mesh_square(1, 1), NULL);
    vv_mesh_distance_options o;
    vv_mesh_distance_options_init(&o, sizeof o);
    vv_mesh_distances d;
    static const double bad[] = {-1, NAN, INFINITY, 1e30};
    for (size_t i = 0; i < 4; i++) {
        o.density = bad[i];
        assert_int_equal(vv_mesh_distance(&d, a, a, &o, NULL), VV_E_ARGUMENT);
    }
    vv_mesh_tree_release(vv_mesh_tree_retain(a));
    vv_mesh_tree_release(a);
    vv_mesh_tree_release(NULL);
}

static vv_status measure_all(void *user)
{
    vv_mesh_tree *tree;
    vv_mesh_distances d;
    vv_mesh_distance_options o;
    vv_mesh_distance_options_init(&o, sizeof o);
    o.density = 1;
    vv_status st = vv_mesh_tree_new(&tree, user, NULL, NULL);
    if (st == VV_OK)
        st = vv_mesh_distance(&d, tree, tree, &o, NULL);
    vv_mesh_tree_release(tree);
    return st;
}

static void every_failing_allocation_is_reported(void **state)
{
    (void)state;
    vv_mesh *mesh = test_mesh_square(3, 9);
    assert_true(test_fail_each_alloc(measure_all, mesh) >= 15);
    vv_mesh_release(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_and_angles),
        cmocka_unit_test(the_nearest_place_of_a_triangle_is_nearer_than_all_others),
        cmocka_unit_test(two_triangles_are_no_nearer_than_is_said),
        cmocka_unit_test(every_triangle_is_once_in_the_tree),
        cmocka_unit_test(the_tree_finds_what_trying_all_triangles_finds),
        cmocka_unit_test(signs_say_what_is_inside),
        cmocka_unit_test(spheres_apart_have_their_least_distance),
        cmocka_unit_test(the_least_distance_is_that_of_all_pairs),
        cmocka_unit_test(concentric_spheres_are_apart_by_their_radii),
        cmocka_unit_test(one_way_is_not_the_other),
        cmocka_unit_test(large_flat_triangles_are_bounded_too),
        cmocka_unit_test(the_error_bounds_what_samples_missed),
        cmocka_unit_test(the_same_bytes_come_from_any_number_of_threads),
        cmocka_unit_test(what_cannot_be_is_an_error),
        cmocka_unit_test(every_failing_allocation_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
