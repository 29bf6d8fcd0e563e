/* The reduced surface: closed, as near as its eighths allow, in as many bits as were counted by hand, and within its
 * budgets. */
#include "fail_alloc.h"
#include "fields.h"
#include "grid/field.h"
#include "jobs.h"
#include "mesh_pieces.h"
#include "meshes.h"
#include "surface/cases.h"
#include "surface/marching.h"
#include "surface/reduced.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void assert_within(double found, double expected, double tolerance)
{
    if (!(fabs(found - expected) <= tolerance))
        fail_msg("%.6g is not within %g of %.6g", found, tolerance, expected);
}

static vvi_reduced *reduce(const vv_field *f, const vvi_reduced_options *o, vv_job *job)
{
    vvi_reduced *r;
    assert_int_equal(vvi_reduced_make(&r, f, o, job), VV_OK);
    return r;
}

static vv_mesh *mesh_of(const vvi_reduced *r, vv_job *job)
{
    vv_mesh *mesh;
    assert_int_equal(vvi_reduced_mesh(&mesh, r, job), VV_OK);
    return mesh;
}

static const vv_vec3 center = {.13, .27, .41};
static double radius;

static double sphere(vv_vec3 p)
{
    const double x = p.x - center.x, y = p.y - center.y, z = p.z - center.z;
    return radius - sqrt(x * x + y * y + z * z);
}

static vv_field *cube_of(double (*value)(vv_vec3), int64_t half, vv_type type)
{
    const test_form form = {.name = "shape", .value = value};
    vv_field_info info = vv_field_info_default();
    info.type = type;
    for (int a = 0; a < 3; a++)
        info.grid.dims[a] = 2 * half + 1;
    info.grid.index_to_world.origin = (vv_vec3){(double)-half, (double)-half, (double)-half};
    return test_field(&form, &info, NULL);
}

/* What a cell can give: all of it is counted. */
static int by_number(const void *a, const void *b)
{
    const int x = *(const int *)a, y = *(const int *)b;
    return (x > y) - (x < y);
}

static size_t count_different(int *numbers, size_t n)
{
    size_t different = n > 0;
    qsort(numbers, n, sizeof *numbers, by_number);
    for (size_t i = 1; i < n; i++)
        different += numbers[i] != numbers[i - 1];
    return different;
}

static void place(int out[3], int edge, int q)
{
    const int axis = edge / 4;
    out[axis] = 2 * q + 1;
    out[axis == 0 ? 1 : 0] = 8 * (edge & 1);
    out[axis == 2 ? 1 : 2] = 8 * (edge >> 1 & 1);
}

/* The direction of a triangle as one number; 0: it has no area. */
static int direction(const int p[3][3])
{
    int n[3];
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        n[a] = (p[1][b] - p[0][b]) * (p[2][c] - p[0][c]) - (p[1][c] - p[0][c]) * (p[2][b] - p[0][b]);
    }
    int x = 0; /* the greatest common divisor, by Euclid */
    for (int a = 0; a < 3; a++)
        for (int y = abs(n[a]); y;) {
            const int rest = x % y;
            x = y;
            y = rest;
        }
    return x ? ((n[0] / x + 200) * 500 + n[1] / x + 200) * 500 + n[2] / x + 200 : 0;
}

/* The counts go with the choice of diagonals: another one has 240 triples, 15360 triangles and 5844 directions. */
static void cells_have_as_many_triangles_as_were_counted(void **state)
{
    (void)state;
    int triples[820], n = 0, *directions = malloc(15360 * sizeof *directions);
    for (int pattern = 0; pattern < 256; pattern++) {
        const vvi_case *k = &vvi_cases[vvi_case_first[pattern]];
        for (int t = 0; t < k->n_triangles; t++) {
            int e[3], first = 0;
            for (int v = 1; v < 3; v++)
                first = k->triangle[3 * t + v] < k->triangle[3 * t + first] ? v : first;
            for (int v = 0; v < 3; v++)
                e[v] = k->triangle[3 * t + (first + v) % 3];
            triples[n++] = (e[0] * 12 + e[1]) * 12 + e[2];
        }
    }
    assert_int_equal(n, 820);
    assert_int_equal(count_different(triples, 820), 232);
    size_t m = 0;
    for (int i = 0; i < n; i++)
        for (int q = 0; q < 64 && (i == 0 || triples[i] != triples[i - 1]); q++) {
            int p[3][3];
            place(p[0], triples[i] / 144, q & 3);
            place(p[1], triples[i] / 12 % 12, q >> 2 & 3);
            place(p[2], triples[i] % 12, q >> 4);
            assert_true(m < 15360);
            directions[m] = direction((const int(*)[3])p);
            assert_int_not_equal(directions[m++], 0);
        }
    assert_int_equal(m, 14848);
    assert_int_equal(count_different(directions, m), 5590);
    free(directions);
}

static void a_sphere_is_as_near_as_eighths_allow(void **state)
{
    (void)state;
    static const double table[][3] = {{10, .64, .06}, {20, .9, .12}, {30, .93, .06}};
    for (int i = 0; i < 3; i++) {
        radius = table[i][0];
        vv_field *f = cube_of(sphere, (int64_t)radius + 3, VV_TYPE_F32);
        const vvi_reduced_options o = {.step = 1};
        vvi_reduced *r = reduce(f, &o, NULL);
        vv_mesh *mesh = mesh_of(r, NULL);
        const vv_mesh_info *m = vv_mesh_get_info(mesh);
        double most = 0, squares = 0, angle = 0, sum = 0;
        assert_int_equal(test_mesh_bad_edges(mesh), 0);
        assert_int_equal(test_mesh_euler(mesh), 2);
        for (size_t v = 0; v < m->n_vertices; v++) {
            const vv_vec3 p = test_mesh_vertex(mesh, v);
            const float *n = m->normals + 3 * v;
            const double d = sphere(p),
                         dot = ((p.x - center.x) * n[0] + (p.y - center.y) * n[1] + (p.z - center.z) * n[2]);
            const double a = acos(fmin(dot / (radius - d), 1)) * 180 / M_PI;
            most = fmax(most, fabs(d));
            squares += d * d;
            angle = fmax(angle, a);
            sum += a * a;
        }
        const double n = (double)m->n_vertices, rms = sqrt(squares / n);
        print_message("R=%g: error at most %.4f, rms %.4f; normals at most %.1f, rms %.2f degrees; area %+.2f %%\n",
                      radius, most, rms, angle, sqrt(sum / n),
                      100 * (test_mesh_area(mesh) / (4 * M_PI * radius * radius) - 1));
        assert_within(100 * (test_mesh_area(mesh) / (4 * M_PI * radius * radius) - 1), table[i][1], table[i][2]);
        assert_true(most < .1255);
        assert_within(rms, .051, .003);
        if (radius == 20) {
            assert_int_equal(r->n_cells, 7542);
            assert_int_equal(r->n_triangles, 15076);
            assert_int_equal(m->n_vertices, 7540);
            assert_within(8. * (double)r->n_bytes / (double)r->n_cells, 28, .05);
        }
        vv_mesh_release(mesh);
        vvi_reduced_free(r);
        vv_field_release(f);
    }
}

/* Same triangles as the whole surface, each corner within an eighth of a cell along its edge. */
static void triangles_are_those_of_the_whole_surface(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{12, 13, 11}, {2, 2, 2}, {3, 40, 5}, {67, 4, 35}, {17, 33, 18}, {66, 18, 3}};
    for (int type = 0; type < VV_TYPE_COUNT; type++)
        for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
            for (int falls = 0; falls < 2; falls++) {
                vv_field_info info = vv_field_info_default();
                memcpy(info.grid.dims, sizes[s], sizeof info.grid.dims);
                info.type = (vv_type)type;
                info.value_scale = falls ? -1 : 1;
                if (falls)
                    info.grid.index_to_world.axis[2].z = -1;
                vv_field *f = test_field_random(&info, test_seed() + s, NULL);
                const double value = vvi_type_min(info.type) * .3 + vvi_type_max(info.type) * .7;
                const vvi_reduced_options o = {.step = 1,
                                               .value = (falls ? -1 : 1) * (vv_type_is_float(info.type) ? 300 : value)};
                const vvi_marching_options p = {.value = o.value, .topology = VVI_MARCHING_APART};
                vvi_reduced *r = reduce(f, &o, NULL);
                vv_mesh *mesh = mesh_of(r, NULL), *whole;
                assert_int_equal(vvi_marching_cubes(&whole, f, &p, NULL), VV_OK);
                const vv_mesh_info *m = vv_mesh_get_info(mesh), *w = vv_mesh_get_info(whole);
                assert_int_equal(m->n_triangles, w->n_triangles);
                assert_int_equal(m->n_vertices, w->n_vertices);
                assert_int_equal(test_mesh_bad_edges(mesh), test_mesh_bad_edges(whole));
                assert_within(test_mesh_volume(mesh), test_mesh_volume(whole), 1e-3 + .03 * (double)m->n_triangles);
                for (size_t v = 0; v < m->n_vertices && v < 50; v++) {
                    const vv_vec3 a = test_mesh_vertex(mesh, v);
                    const vv_vec3 b = test_mesh_vertex(whole, test_mesh_nearest(whole, a));
                    assert_true(hypot(hypot(a.x - b.x, a.y - b.y), a.z - b.z) <= .1251);
                }
                vv_mesh_release(mesh);
                vv_mesh_release(whole);
                vvi_reduced_free(r);
                vv_field_release(f);
            }
}

/* The bricks' own triangles are those of the mesh. */
static void bricks_expand_to_the_same_triangles(void **state)
{
    (void)state;
    radius = 20;
    vv_field *f = cube_of(sphere, 25, VV_TYPE_I16);
    const vvi_reduced_options o = {.step = 1, .value = .5};
    vvi_reduced *r = reduce(f, &o, NULL);
    vv_mesh *mesh = mesh_of(r, NULL);
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    vvi_reduced_triangle *triangles = malloc(r->n_triangles * sizeof *triangles);
    for (size_t b = 0; b < r->n_bricks; b++) {
        const vvi_reduced_brick *brick = &r->bricks[b];
        vvi_reduced_expand(triangles + brick->first_triangle, r, b);
        for (size_t t = brick->first_triangle; t < brick->first_triangle + brick->n_triangles; t++)
            for (size_t v = 0; v < 3; v++)
                for (size_t a = 0; a < 3; a++) {
                    const double at = brick->at[a] * 16 + triangles[t].corner[v][a] / 8.;
                    assert_true((double)m->positions[3 * m->triangles[3 * t + v] + a] == at);
                }
    }
    free(triangles);
    vv_mesh_release(mesh);
    vvi_reduced_free(r);
    vv_field_release(f);
}

static void fewer_samples_are_a_coarser_sphere(void **state)
{
    (void)state;
    radius = 20;
    vv_field *f = cube_of(sphere, 25, VV_TYPE_F32);
    size_t before = SIZE_MAX;
    for (int step = 1; step <= 8; step *= 2) {
        const vvi_reduced_options o = {.step = step};
        vvi_reduced *r = reduce(f, &o, NULL);
        vv_mesh *mesh = mesh_of(r, NULL);
        assert_int_equal(r->step[0], step);
        assert_int_equal(test_mesh_bad_edges(mesh), 0);
        assert_int_equal(test_mesh_euler(mesh), 2);
        assert_true(r->n_triangles <= before / 3);
        for (size_t v = 0; v < vv_mesh_get_info(mesh)->n_vertices; v++)
            assert_within(sphere(test_mesh_vertex(mesh, v)), 0, .25 * step);
        before = r->n_triangles;
        vv_mesh_release(mesh);
        vvi_reduced_free(r);
    }
    vv_field_release(f);
}

static double threads_of_a_web(vv_vec3 p)
{
    const double x = fmod(p.x + 1000, 10) - 5, y = fmod(p.y + 1000, 10) - 5;
    return 1.2 - hypot(x, y);
}

/* A ball grows by about half a step, and stays where it was. */
static void what_is_kept_stays_in_place(void **state)
{
    (void)state;
    radius = 20;
    vv_field *f = cube_of(sphere, 31, VV_TYPE_F32);
    for (int step = 2; step <= 4; step *= 2)
        for (int high = 0; high < 2; high++) {
            const vvi_reduced_options o = {.step = step, .filter = high ? VVI_REDUCED_KEEP_HIGH : VVI_REDUCED_KEEP_LOW};
            vvi_reduced *r = reduce(f, &o, NULL);
            vv_mesh *mesh = mesh_of(r, NULL);
            const vv_bounds b = vv_mesh_bounds(mesh);
            const double grown = cbrt(test_mesh_volume(mesh) * 3 / (4 * M_PI)) - radius;
            assert_int_equal(test_mesh_euler(mesh), 2);
            assert_within(grown, (high ? .6 : -.6) * (step - 1), .35 * (step - 1));
            assert_within((b.lo.x + b.hi.x) / 2, center.x, .2 * step);
            assert_within((b.lo.y + b.hi.y) / 2, center.y, .2 * step);
            assert_within((b.lo.z + b.hi.z) / 2, center.z, .2 * step);
            vv_mesh_release(mesh);
            vvi_reduced_free(r);
        }
    vv_field_release(f);
}

/* Thin parts: means lose them, the largest values do not. */
static void thin_parts_are_kept_when_asked(void **state)
{
    (void)state;
    vv_field *f = cube_of(threads_of_a_web, 20, VV_TYPE_F32);
    size_t triangles[3];
    for (int filter = 0; filter < 3; filter++) {
        const vvi_reduced_options o = {.value = 0, .step = 4, .filter = (vvi_reduced_filter)filter};
        vvi_reduced *r = reduce(f, &o, NULL);
        triangles[filter] = r->n_triangles;
        vvi_reduced_free(r);
    }
    assert_int_equal(triangles[VVI_REDUCED_KEEP_LOW], 0);
    assert_true(triangles[VVI_REDUCED_KEEP_HIGH] > 0);
    vv_field_release(f);
}

static void budgets_are_kept(void **state)
{
    (void)state;
    radius = 20;
    vv_field *f = cube_of(sphere, 25, VV_TYPE_U8);
    static const size_t budgets[] = {20000, 15075, 4000, 1000, 300};
    int step = 0;
    for (size_t i = 0; i < sizeof budgets / sizeof *budgets; i++)
        for (int kind = 0; kind < 2; kind++) {
            vvi_reduced_options o = {.value = .5};
            *(kind ? &o.max_bytes : &o.max_triangles) = budgets[i];
            vvi_reduced *r = reduce(f, &o, NULL);
            assert_true(r->n_triangles > 0);
            assert_true((kind ? r->n_bytes : r->n_triangles) <= budgets[i] || r->n[0] * r->n[1] * r->n[2] == 1);
            assert_true(kind || r->step[0] >= step);
            step = kind ? step : r->step[0];
            vvi_reduced_free(r);
        }
    vv_field_release(f);
}

static void threads_change_nothing_and_errors_are_told(void **state)
{
    (void)state;
    radius = 20;
    vv_field *f = cube_of(sphere, 40, VV_TYPE_F64);
    const vvi_reduced_options o = {.value = .5, .max_triangles = 9000};
    vvi_reduced *first = reduce(f, &o, NULL);
    vv_mesh *one = mesh_of(first, NULL);
    for (int threads = 1; threads <= 8; threads *= 2) {
        vv_job *job = test_job(threads, 0);
        vvi_reduced *r = reduce(f, &o, job);
        vv_mesh *mesh = mesh_of(r, job);
        const vv_mesh_info *m = vv_mesh_get_info(mesh), *n = vv_mesh_get_info(one);
        assert_int_equal(r->n_bytes, first->n_bytes);
        assert_memory_equal(r->records, first->records, r->n_bytes);
        assert_int_equal(m->n_vertices, n->n_vertices);
        assert_memory_equal(m->positions, n->positions, 12 * m->n_vertices);
        assert_memory_equal(m->normals, n->normals, 12 * m->n_vertices);
        assert_memory_equal(m->triangles, n->triangles, 12 * m->n_triangles);
        vv_mesh_release(mesh);
        vvi_reduced_free(r);
        vv_job_release(job);
    }
    vv_mesh_release(one);
    vvi_reduced_free(first);
    const vvi_reduced_options bad[] = {{.step = 3}, {.step = -1}, {.step = 512}, {.value = NAN}, {.component = 1}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_int_equal(vvi_reduced_make(&first, f, &bad[i], NULL), VV_E_ARGUMENT);
        assert_null(first);
    }
    const vvi_reduced_options nothing = {.value = 1e9};
    first = reduce(f, &nothing, NULL);
    one = mesh_of(first, NULL);
    assert_int_equal(vv_mesh_get_info(one)->n_triangles, 0);
    vv_mesh_release(one);
    vvi_reduced_free(first);
    vv_field_release(f);
}

static vv_status make_once(void *user)
{
    const vvi_reduced_options o = {.value = .5, .step = 2};
    vvi_reduced *r;
    vv_mesh *mesh = NULL;
    vv_status st = vvi_reduced_make(&r, user, &o, NULL);
    if (st == VV_OK)
        st = vvi_reduced_mesh(&mesh, r, NULL);
    vv_mesh_release(mesh);
    vvi_reduced_free(r);
    return st;
}

static void without_memory_it_fails_cleanly(void **state)
{
    (void)state;
    radius = 10;
    vv_field *f = cube_of(sphere, 15, VV_TYPE_F64);
    assert_true(test_fail_each_alloc(make_once, f) > 10);
    vv_field_release(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cells_have_as_many_triangles_as_were_counted),
        cmocka_unit_test(a_sphere_is_as_near_as_eighths_allow),
        cmocka_unit_test(triangles_are_those_of_the_whole_surface),
        cmocka_unit_test(bricks_expand_to_the_same_triangles),
        cmocka_unit_test(fewer_samples_are_a_coarser_sphere),
        cmocka_unit_test(what_is_kept_stays_in_place),
        cmocka_unit_test(thin_parts_are_kept_when_asked),
        cmocka_unit_test(budgets_are_kept),
        cmocka_unit_test(threads_change_nothing_and_errors_are_told),
        cmocka_unit_test(without_memory_it_fails_cleanly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
