/* Shortest paths: planes, cuboids and spheres by formula; bumps against a fine graph; borders; what is not connected.
 */
#include "core/vec.h"
#include "fail_alloc.h"
#include "fields.h"
#include "jobs.h"
#include "measure/path_thin.h"
#include "shapes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/measure_distance.h>
#include <volvis/measure_path.h>

#include <cmocka.h>

#define assert_within(value, truth, error)                                                                             \
    do {                                                                                                               \
        if (!(fabs((value) - (truth)) <= (error)))                                                                     \
            fail_msg("%s is %.12g and not %.12g +- %.3g", #value, (double)(value), (double)(truth), (double)(error));  \
    } while (0)

/* The length; that the points are a path of that length between the two places is looked at. */
static double length_between(const vv_mesh *mesh, vv_vec3 from, vv_vec3 to, bool shortest)
{
    vv_mesh_path path;
    if (vv_mesh_geodesic(&path, mesh, from, to, NULL, NULL) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    assert_true(path.n_points >= 2);
    assert_within(vv_polyline_length(path.points, path.n_points), path.length.value, 1e-9 * path.length.value);
    assert_within(vv_distance(path.points[0], from), 0, .2);
    assert_within(vv_distance(path.points[path.n_points - 1], to), 0, .2);
    assert_true(path.shortest == shortest);
    assert_true(!shortest || path.length.error <= 1e-8 * path.length.value);
    const double length = path.length.value;
    vv_mesh_path_finish(&path);
    return length;
}

static vv_vec3 random_point(uint64_t index)
{
    return vvi_vec(test_random_unit(test_seed(), 2 * index), test_random_unit(test_seed(), 2 * index + 1), 0);
}

static void paths_in_a_plane_are_straight(void **state)
{
    (void)state;
    static const uint32_t sizes[] = {1, 2, 7, 40, 60};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        vv_mesh *square = test_mesh_square(1, sizes[s]);
        for (uint64_t i = 0; i < 10; i++) {
            const vv_vec3 p = random_point(2 * i), q = random_point(2 * i + 1);
            assert_within(length_between(square, p, q, true), vv_distance(p, q), 1e-6);
        }
        assert_within(length_between(square, vvi_vec(0, 0, 0), vvi_vec(1, 1, 0), true), sqrt(2), 1e-6);
        assert_within(length_between(square, vvi_vec(1, 0, 0), vvi_vec(0, 1, 0), true), sqrt(2), 1e-6);
        assert_within(length_between(square, vvi_vec(0, .3, 0), vvi_vec(1, .3, 0), true), 1, 1e-6);
        vv_mesh_release(square);
    }
}

static void paths_on_cuboids_are_those_of_their_nets(void **state)
{
    (void)state;
    vv_mesh *cube = test_mesh_box(1, 1, 1, (vv_vec3){5, 6, 7});
    assert_within(length_between(cube, vvi_vec(5, 6, 7), vvi_vec(6, 7, 8), true), sqrt(5), 1e-6);
    assert_within(length_between(cube, vvi_vec(5.5, 6.5, 7), vvi_vec(5.5, 6.5, 8), true), 2, 1e-6);
    vv_mesh_release(cube);
    /* Dudeney's spider and fly, 1903: a room of 30 x 12 x 12, 1 from the ceiling to 1 from the floor: 40 */
    vv_mesh *room = test_mesh_box(30, 12, 12, (vv_vec3){0}), *soup = test_mesh_unshared(room);
    assert_within(length_between(room, vvi_vec(0, 6, 11), vvi_vec(30, 6, 1), true), 40, 1e-5);
    assert_within(length_between(soup, vvi_vec(0, 6, 11), vvi_vec(30, 6, 1), true), 40, 1e-5);
    vv_mesh_release(soup);
    vv_mesh_release(room);
}

static void paths_on_a_sphere_are_great_circles(void **state)
{
    (void)state;
    vv_mesh *sphere = test_mesh_sphere((vv_vec3){0}, 1, 5); /* 20480 triangles */
    assert_within(length_between(sphere, vvi_vec(0, 0, 1), vvi_vec(0, 0, -1), true), M_PI, .01 * M_PI);
    for (uint64_t i = 0; i < 6; i++) {
        vv_vec3 p[2];
        for (uint64_t k = 0; k < 2; k++) {
            const double z = 2 * test_random_unit(test_seed(), 4 * i + 2 * k) - 1,
                         a = 2 * M_PI * test_random_unit(test_seed(), 4 * i + 2 * k + 1);
            p[k] = vvi_vec(sqrt(1 - z * z) * cos(a), sqrt(1 - z * z) * sin(a), z);
        }
        const double angle = vv_angle_between(p[0], p[1]);
        assert_within(length_between(sphere, p[0], p[1], true), angle, .002 * angle + 1e-3);
    }
    vv_mesh_release(sphere);
}

/* A square without the quarter x, y > 1/2: paths between its arms turn at the corner in the middle. */
static void paths_go_round_what_is_missing(void **state)
{
    (void)state;
    vv_mesh *square = test_mesh_square(1, 20);
    const vv_mesh_info *m = vv_mesh_get_info(square);
    uint32_t *t = malloc(3 * m->n_triangles * sizeof *t);
    size_t n = 0;
    for (size_t i = 0; i < m->n_triangles; i++) {
        float x = 0, y = 0;
        for (size_t k = 0; k < 3; k++) {
            x += m->positions[3 * (size_t)m->triangles[3 * i + k]] / 3;
            y += m->positions[3 * (size_t)m->triangles[3 * i + k] + 1] / 3;
        }
        if (x < .5f || y < .5f)
            memcpy(t + 3 * n++, m->triangles + 3 * i, 3 * sizeof *t);
    }
    vv_mesh *arms = test_mesh_new(m->positions, m->n_vertices, t, n);
    const vv_vec3 corner = {.5, .5, 0};
    for (uint64_t i = 0; i < 10; i++) {
        const vv_vec3 p = {.6 + .4 * test_random_unit(1, 3 * i), .5 - .1 * test_random_unit(1, 3 * i + 1), 0},
                      q = {.5 - .05 * test_random_unit(1, 3 * i + 2), .9, 0};
        const double up = (q.y - p.y) / (q.x - p.x);
        const double at = p.y + up * (corner.x - p.x); /* where the straight line passes the corner */
        const double truth = at > corner.y ? vv_distance(p, corner) + vv_distance(corner, q) : vv_distance(p, q);
        assert_within(length_between(arms, p, q, true), truth, 1e-6);
    }
    vv_mesh_release(arms);
    vv_mesh_release(square);
    free(t);
}

enum { SIDE = 9, POINTS = 11 }; /* squares a side, places on an edge */

static vv_mesh *bumps(void)
{
    vv_mesh *square = test_mesh_square(SIDE, SIDE);
    const vv_mesh_info *m = vv_mesh_get_info(square);
    float *p = malloc(3 * m->n_vertices * sizeof *p);
    for (size_t i = 0; i < 3 * m->n_vertices; i++)
        p[i] = i % 3 == 2 ? (float)(1.5 * test_random_unit(test_seed(), i)) : m->positions[i];
    vv_mesh *out = test_mesh_new(p, m->n_vertices, m->triangles, m->n_triangles);
    vv_mesh_release(square);
    free(p);
    return out;
}

static vv_vec3 vertex(const vv_mesh_info *m, size_t v)
{
    return vvi_vec((double)m->positions[3 * v], (double)m->positions[3 * v + 1], (double)m->positions[3 * v + 2]);
}

/* Places on all sides of all triangles, those at the same place counting as one by their coordinates; the shortest way
 * through straight lines within triangles (Bellman & Ford): never shorter than the shortest path, and near it. */
static double by_graph(const vv_mesh_info *m, size_t from, size_t to)
{
    enum { EACH = 3 * POINTS };
    const size_t n = m->n_triangles * EACH;
    vv_vec3 *p = malloc(n * sizeof *p);
    double *d = malloc(n * sizeof *d), result = INFINITY;
    uint32_t *same = calloc(n, sizeof *same);
    for (size_t i = 0; i < n; i++) {
        const uint32_t *t = m->triangles + i / EACH * 3;
        const size_t k = i % EACH / POINTS;
        const double u = (double)(i % POINTS) / (POINTS - 1);
        const uint32_t a = t[k], b = t[(k + 1) % 3];
        p[i] = a < b ? vvi_add(vvi_scaled(vertex(m, a), 1 - u), vvi_scaled(vertex(m, b), u))
                     : vvi_add(vvi_scaled(vertex(m, b), 1 - u), vvi_scaled(vertex(m, a), u));
        same[i] = (uint32_t)i;
        for (uint32_t j = 0; j < i; j++)
            if (vv_distance(p[i], p[j]) < 1e-9) {
                same[i] = j;
                break;
            }
        d[i] = vv_distance(p[i], vertex(m, from)) < 1e-9 ? 0 : INFINITY;
    }
    for (bool changed = true; changed;) {
        changed = false;
        for (size_t t = 0; t < m->n_triangles; t++)
            for (size_t i = t * EACH; i < (t + 1) * EACH; i++)
                for (size_t j = t * EACH; j < (t + 1) * EACH; j++) {
                    const double way = d[same[i]] + vv_distance(p[i], p[j]);
                    if (way < d[same[j]] - 1e-12) {
                        d[same[j]] = way;
                        changed = true;
                    }
                }
    }
    for (size_t i = 0; i < n; i++)
        if (vv_distance(p[i], vertex(m, to)) < 1e-9)
            result = fmin(result, d[same[i]]);
    free(p);
    free(d);
    free(same);
    return result;
}

static void paths_over_bumps_are_those_of_a_fine_graph(void **state)
{
    (void)state;
    vv_mesh *mesh = bumps();
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    static const size_t ends[][2] = {{0, 99}, {9, 90}, {44, 97}, {12, 78}};
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
        const double graph = by_graph(m, ends[i][0], ends[i][1]);
        const double length = length_between(mesh, vertex(m, ends[i][0]), vertex(m, ends[i][1]), true);
        assert_true(length <= graph + 1e-9);
        assert_true(length > graph * .99);
        assert_within(length_between(mesh, vertex(m, ends[i][1]), vertex(m, ends[i][0]), true), length, 1e-9);
    }
    vv_mesh_release(mesh);
}

static void little_effort_is_told_and_bounded(void **state)
{
    (void)state;
    vv_mesh *sphere = test_mesh_sphere((vv_vec3){0}, 1, 5);
    vv_mesh_path_options o;
    vv_mesh_path path;
    vv_mesh_path_options_init(&o, sizeof o);
    o.max_windows = 3000;
    o.to_world = (vv_affine){.axis = {{2, 0, 0}, {0, 2, 0}, {0, 0, 2}}, .origin = {1, 2, 3}};
    strcpy(o.unit, "um");
    assert_int_equal(vv_mesh_geodesic(&path, sphere, vvi_vec(1, 2, 5), vvi_vec(1, 2, 1), &o, NULL), VV_OK);
    assert_false(path.shortest);
    assert_string_equal(path.length.unit, "um");
    assert_true(path.length.value > 2 * M_PI * .99 && path.length.value < 2 * M_PI * 1.15);
    assert_true(path.length.value - path.length.error < 2 * M_PI);
    vv_mesh_path_finish(&path);
    vv_mesh_release(sphere);
}

static void what_cannot_be_is_an_error_and_nowhere_is_no_way(void **state)
{
    (void)state;
    vv_mesh_path path;
    vv_mesh *none = test_mesh_new(NULL, 0, NULL, 0);
    assert_int_equal(vv_mesh_geodesic(&path, none, vvi_vec(0, 0, 0), vvi_vec(1, 0, 0), NULL, NULL), VV_E_ARGUMENT);
    vv_mesh_release(none);
    const float p[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0, 6, 0, 0, 5, 1, 0};
    const uint32_t t[6] = {0, 1, 2, 3, 4, 5};
    vv_mesh *two = test_mesh_new(p, 6, t, 2);
    assert_int_equal(vv_mesh_geodesic(&path, two, vvi_vec(0, 0, 0), vvi_vec(5, 0, 0), NULL, NULL), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "not connected"));
    vv_mesh_release(two);
    vv_mesh *square = test_mesh_square(1, 4);
    assert_within(length_between(square, vvi_vec(.3, .3, 0), vvi_vec(.3, .3, 0), true), 0, 0);
    assert_within(length_between(square, vvi_vec(.30, .31, 0), vvi_vec(.31, .3, 0), true), .01 * sqrt(2), 1e-7);
    vv_mesh_release(square);
}

static double off_segment(vv_vec3 p, vv_vec3 from, vv_vec3 to)
{
    double least = INFINITY;
    for (int i = 0; i <= 2000; i++) {
        const vv_vec3 on = vvi_add(from, vvi_scaled(vvi_sub(to, from), i / 2000.));
        const vv_vec3 off = vvi_sub(p, on);
        least = fmin(least, sqrt(vvi_dot(off, off)));
    }
    return least;
}

/* A circle: chords of half an angle a are off by r (1 - cos a), so so many are needed, and half of them are too few. */
static void a_thinned_path_is_as_near_as_is_said(void **state)
{
    (void)state;
    enum { N = 1009 };
    const double far = 0.01, half_angle = acos(1 - far / 5);
    const size_t least = (size_t)ceil(2 * M_PI / (2 * half_angle));
    vv_vec3 full[N], p[N];
    size_t n, at = 0;
    for (int i = 0; i < N; i++)
        p[i] = full[i] = vvi_vec(5 * cos(2 * M_PI * i / (N - 1)), 5 * sin(2 * M_PI * i / (N - 1)), 0.001 * i);
    assert_int_equal(vvi_path_thin(&n, p, N, far), VV_OK);
    assert_true(n - 1 >= least && n - 1 <= 2 * least + 2);
    assert_memory_equal(&p[0], &full[0], sizeof *p);
    assert_memory_equal(&p[n - 1], &full[N - 1], sizeof *p);
    for (int i = 0; i < N; i++) {
        if (vv_distance(full[i], p[at + 1]) == 0 && at + 2 < n)
            at++;
        assert_true(off_segment(full[i], p[at], p[at + 1]) <= far + 1e-5);
    }
}

static void thin_paths_of_few_points(void **state)
{
    (void)state;
    vv_vec3 line[5] = {{0, 0, 0}, {1, 2, 3}, {2, 4, 6}, {2, 4, 6}, {4, 8, 12}};
    size_t n;
    assert_int_equal(vvi_path_thin(&n, line, 0, 0), VV_OK);
    assert_int_equal(n, 0);
    assert_int_equal(vvi_path_thin(&n, line, 1, 0), VV_OK);
    assert_int_equal(n, 1);
    assert_int_equal(vvi_path_thin(&n, line, 5, 1e-12), VV_OK);
    assert_int_equal(n, 2);
    assert_within(line[1].z, 12, 0);
    vv_vec3 there_and_back[3] = {{0, 0, 0}, {3, 0, 0}, {0, 0, 0}};
    assert_int_equal(vvi_path_thin(&n, there_and_back, 3, 0.1), VV_OK);
    assert_int_equal(n, 3);
}

static vv_status find_one(void *user)
{
    vv_mesh_path path;
    const vv_status st = vv_mesh_geodesic(&path, user, vvi_vec(.1, .2, 0), vvi_vec(.9, .7, 0), NULL, NULL);
    vv_mesh_path_finish(&path);
    return st;
}

static void every_failing_allocation_is_reported(void **state)
{
    (void)state;
    vv_mesh *square = test_mesh_square(1, 6);
    assert_true(test_fail_each_alloc(find_one, square) >= 15);
    vv_mesh_release(square);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(paths_in_a_plane_are_straight),
        cmocka_unit_test(paths_on_cuboids_are_those_of_their_nets),
        cmocka_unit_test(paths_on_a_sphere_are_great_circles),
        cmocka_unit_test(paths_go_round_what_is_missing),
        cmocka_unit_test(paths_over_bumps_are_those_of_a_fine_graph),
        cmocka_unit_test(little_effort_is_told_and_bounded),
        cmocka_unit_test(what_cannot_be_is_an_error_and_nowhere_is_no_way),
        cmocka_unit_test(a_thinned_path_is_as_near_as_is_said),
        cmocka_unit_test(thin_paths_of_few_points),
        cmocka_unit_test(every_failing_allocation_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
