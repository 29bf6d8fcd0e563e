/* Normals of meshes that come without, against those of the shapes that they are. */
#include "fail_alloc.h"
#include "grid/mesh.h"
#include "grid/mesh_normals.h"
#include "meshes.h"
#include "scene/smooth_mesh.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double pi = 3.14159265358979323846;

enum { N = 24 };

static vv_mesh *shaded_of(const vv_mesh *mesh)
{
    vv_mesh *out;
    assert_int_equal(vvi_mesh_smooth_shaded(&out, mesh, NULL), VV_OK);
    return out;
}

static void expect_normal(const vv_mesh_info *m, size_t v, double x, double y, double z)
{
    const float *n = m->normals + 3 * v;
    assert_float_equal(n[0], x, 1e-6);
    assert_float_equal(n[1], y, 1e-6);
    assert_float_equal(n[2], z, 1e-6);
}

/* All of a vertex but its normal; triangles between the same places, of the same parts. */
static void expect_same_shape(const vv_mesh *shaded, const vv_mesh *mesh)
{
    const vv_mesh_info *s = vv_mesh_get_info(shaded), *m = vv_mesh_get_info(mesh);
    assert_int_equal(s->n_triangles, m->n_triangles);
    assert_int_equal(s->n_parts, m->n_parts);
    assert_true(s->n_textures == m->n_textures && s->textures == m->textures);
    assert_memory_equal(s->positions, m->positions, 3 * m->n_vertices * sizeof *m->positions);
    for (size_t i = 0; i < m->n_parts; i++)
        assert_memory_equal(&s->parts[i], &m->parts[i], sizeof *m->parts);
    for (size_t i = 0; i < 3 * m->n_triangles; i++) {
        const size_t v = s->triangles[i], w = m->triangles[i];
        assert_true(v < s->n_vertices && (v == w || v >= m->n_vertices));
        assert_memory_equal(s->positions + 3 * v, m->positions + 3 * w, 3 * sizeof *m->positions);
        if (m->values)
            assert_true(s->values[v] == m->values[w]);
        if (m->colors)
            assert_memory_equal(s->colors + 4 * v, m->colors + 4 * w, 4);
        if (m->coordinates)
            assert_memory_equal(s->coordinates + 2 * (s->coordinate_of ? s->coordinate_of[i] : v),
                                m->coordinates + 2 * (m->coordinate_of ? m->coordinate_of[i] : w), 8);
    }
}

static vv_mesh *mesh_of(const float *positions, size_t n_vertices, const uint32_t *triangles, size_t n_triangles)
{
    vv_mesh *mesh;
    const vv_mesh_info info = {.n_vertices = n_vertices,
                               .n_triangles = n_triangles,
                               .positions = positions,
                               .triangles = triangles,
                               .unit = "mm"};
    assert_int_equal(vv_mesh_new(&mesh, &info, NULL), VV_OK);
    return mesh;
}

/* Six squares of 4 x 4 quads between vertices that they share. */
static void a_cube_has_the_normals_of_its_faces(void **state)
{
    (void)state;
    enum { M = 4, P = M + 1 };
    float p[3 * P * P * P];
    uint32_t t[6 * M * M * 6], n = 0;
    for (int i = 0; i < P * P * P; i++) {
        const int at[3] = {i % P, i / P % P, i / P / P};
        for (int a = 0; a < 3; a++)
            p[3 * i + a] = (float)at[a] * 0.3f;
    }
    for (int f = 0; f < 6; f++) {
        const int step[3] = {1, P, P * P}, across = step[(f + 1) % 3], up = step[(f + 2) % 3];
        for (int q = 0; q < M * M; q++) {
            const int a = (f >= 3 ? M * step[f % 3] : 0) + q % M * across + q / M * up;
            const int corner[6] = {a, a + across, a + across + up, a, a + across + up, a + up};
            for (int k = 0; k < 6; k++)
                t[n++] = (uint32_t)corner[f >= 3 ? k : 5 - k];
        }
    }
    vv_mesh *mesh = mesh_of(p, P * P * P, t, n / 3), *shaded = shaded_of(mesh);
    const vv_mesh_info *s = vv_mesh_get_info(shaded);
    expect_same_shape(shaded, mesh);
    for (uint32_t i = 0; i < n; i++) {
        const uint32_t f = i / (6 * M * M);
        const double out = f >= 3 ? 1 : -1;
        expect_normal(s, s->triangles[i], f % 3 == 0 ? out : 0, f % 3 == 1 ? out : 0, f % 3 == 2 ? out : 0);
    }
    assert_int_equal(s->n_vertices, P * P * P + 8 * 2 + 12 * (M - 1)); /* three of each corner, two along edges */
    vv_mesh_release(shaded);
    vv_mesh_release(mesh);
}

/* Rings of N vertices at two heights, of which the radii may differ, and the middles of the caps. */
static vv_mesh *lathe(int sides, double low, double high)
{
    float p[3 * (2 * N + 2)] = {0};
    uint32_t t[12 * N], n = 0;
    const uint32_t m = (uint32_t)sides;
    for (uint32_t i = 0; i < m; i++)
        for (uint32_t up = 0; up < 2; up++) {
            float *q = p + 3 * (i + up * m);
            q[0] = (float)((up ? high : low) * cos(2 * pi * i / m));
            q[1] = (float)((up ? high : low) * sin(2 * pi * i / m));
            q[2] = up ? 1 : -1;
        }
    p[3 * (2 * m) + 2] = -1;
    p[3 * (2 * m + 1) + 2] = 1;
    for (uint32_t i = 0; i < m; i++) {
        const uint32_t j = (i + 1) % m;
        const uint32_t of[12] = {i, j, j + m, i, j + m, i + m, j, i, 2 * m, i + m, j + m, 2 * m + 1};
        memcpy(t + n, of, sizeof of);
        n += 12;
    }
    return mesh_of(p, 2 * (size_t)m + 2, t, n / 3);
}

static void a_cylinder_is_smooth_around_and_flat_at_its_ends(void **state)
{
    (void)state;
    vv_mesh *mesh = lathe(N, 2, 2), *shaded = shaded_of(mesh);
    const vv_mesh_info *s = vv_mesh_get_info(shaded);
    expect_same_shape(shaded, mesh);
    assert_int_equal(s->n_vertices, 4 * N + 2);
    for (size_t i = 0; i < 3 * s->n_triangles; i++) {
        const size_t v = s->triangles[i], which = i % 12;
        const float *p = s->positions + 3 * v;
        if (which >= 6)
            expect_normal(s, v, 0, 0, which >= 9 ? 1 : -1);
        else /* not quite outwards: one side of the ring has two triangles, one has one */
            assert_true((double)(s->normals[3 * v] * p[0] + s->normals[3 * v + 1] * p[1]) > 2 * cos(pi / N) &&
                        fabs((double)s->normals[3 * v + 2]) < 1e-6);
    }
    vv_mesh_release(shaded);
    vv_mesh_release(mesh);
}

static void prisms_have_faces_up_to_six_sides(void **state)
{
    (void)state;
    for (int sides = 3; sides <= 8; sides++) {
        vv_mesh *mesh = lathe(sides, 1, 1), *shaded = shaded_of(mesh);
        const vv_mesh_info *s = vv_mesh_get_info(shaded);
        bool flat = true;
        for (size_t i = 0; i < 3 * s->n_triangles; i += 12) {
            const double middle = pi * ((double)i / 6 + 1) / sides;
            for (size_t k = 0; k < 6; k++) {
                const float *n = s->normals + 3 * (size_t)s->triangles[i + k];
                flat &= (double)n[0] * cos(middle) + (double)n[1] * sin(middle) > 1 - 1e-6;
            }
        }
        assert_int_equal(flat, sides <= 6);
        vv_mesh_release(shaded);
        vv_mesh_release(mesh);
    }
}

static void the_tip_of_a_cone_has_the_normal_of_each_side(void **state)
{
    (void)state;
    vv_mesh *mesh = lathe(N, 1, 0), *shaded = shaded_of(mesh);
    const vv_mesh_info *s = vv_mesh_get_info(shaded);
    for (size_t i = 0; i < 3 * s->n_triangles; i += 12) { /* the outward normal of the first of each side */
        const double middle = 2 * pi * ((double)i / 12 + 0.5) / N, r = cos(pi / N), length = hypot(2, r);
        expect_normal(s, s->triangles[i + 2], 2 * cos(middle) / length, 2 * sin(middle) / length, r / length);
    }
    vv_mesh_release(shaded);
    vv_mesh_release(mesh);
}

static void a_sphere_is_as_it_was(void **state)
{
    (void)state;
    float p[3 * (N / 2 + 1) * (N + 1)], n[3 * (N / 2 + 1) * (N + 1)];
    uint32_t t[6 * (N / 2) * N], to[6 * (N / 2) * N], k = 0;
    const uint32_t row = N + 1, n_vertices = row * (N / 2 + 1);
    for (uint32_t v = 0; v < n_vertices; v++) { /* a map of the Earth: a seam of vertices that are there twice, poles */
        const uint32_t at[2] = {v % row % N, v / row};
        const double along = 2 * pi * at[0] / N, down = 2 * pi * at[1] / N;
        const double ring = at[1] % (N / 2) == 0 ? 0 : sin(down);
        p[3 * v] = (float)(ring * cos(along));
        p[3 * v + 1] = (float)(ring * sin(along));
        p[3 * v + 2] = (float)cos(down);
    }
    for (uint32_t i = 0; i < N / 2; i++)
        for (uint32_t j = 0; j < N; j++) {
            const uint32_t a = i * row + j, of[6] = {a, a + row, a + row + 1, a, a + row + 1, a + 1};
            memcpy(t + k, of, sizeof of);
            k += 6;
        }
    vv_mesh *mesh = mesh_of(p, n_vertices, t, k / 3), *shaded = shaded_of(mesh);
    const vv_mesh_info *s = vv_mesh_get_info(shaded);
    assert_int_equal(s->n_vertices, n_vertices);
    assert_memory_equal(s->triangles, t, k * sizeof *t);
    for (uint32_t i = 0; i < k; i++) { /* seams and poles: by the first vertex there */
        const uint32_t v = t[i];
        to[i] = v < row ? 0 : v >= n_vertices - row ? n_vertices - row : v % row == N ? v - N : v;
    }
    assert_int_equal(vvi_normals_of(n, p, n_vertices, to, k / 3, NULL), VV_OK);
    for (uint32_t i = 0; i < k; i++) {
        const float *own = s->normals + 3 * (size_t)t[i], *q = p + 3 * (size_t)t[i];
        assert_memory_equal(own, n + 3 * (size_t)to[i], 3 * sizeof *n);
        assert_true((double)(own[0] * q[0] + own[1] * q[1] + own[2] * q[2]) > 1 - 1e-5);
    }
    vv_mesh_release(shaded);
    vv_mesh_release(mesh);
}

static void what_belongs_to_vertices_goes_along(void **state)
{
    (void)state;
    for (unsigned with = 0; with < 128; with++) {
        if (with & TEST_MESH_NORMALS)
            continue;
        vv_mesh *mesh = test_mesh_strip(50, with), *shaded = shaded_of(mesh), *again = shaded_of(mesh);
        assert_true(vv_mesh_get_info(shaded)->n_vertices > vv_mesh_get_info(mesh)->n_vertices);
        expect_same_shape(shaded, mesh);
        assert_int_equal(vv_mesh_checksum(shaded), vv_mesh_checksum(again));
        vv_mesh_release(again);
        vv_mesh_release(shaded);
        vv_mesh_release(mesh);
    }
}

static void meshes_of_nothing_stay_so(void **state)
{
    (void)state;
    const float p[9] = {0, 0, 0, 1, 0, 0, 2, 0, 0};
    const uint32_t t[3] = {0, 1, 2};
    for (size_t n = 0; n < 3; n++) { /* no vertex, no triangle, one without area */
        vv_mesh *mesh = mesh_of(p, n ? 3 : 0, t, n / 2), *shaded = shaded_of(mesh);
        expect_same_shape(shaded, mesh);
        assert_int_equal(vv_mesh_get_info(shaded)->n_vertices, n ? 3 : 0);
        vv_mesh_release(shaded);
        vv_mesh_release(mesh);
    }
}

static vv_status shade(void *user)
{
    vv_mesh *shaded;
    const vv_status st = vvi_mesh_smooth_shaded(&shaded, user, NULL);
    vv_mesh_release(shaded);
    return st;
}

static void short_memory_is_an_error(void **state)
{
    (void)state;
    vv_mesh *mesh = test_mesh_strip(50, TEST_MESH_VALUES | TEST_MESH_PARTS);
    assert_true(test_fail_each_alloc(shade, mesh) >= 10);
    vv_mesh_release(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cube_has_the_normals_of_its_faces),
        cmocka_unit_test(a_cylinder_is_smooth_around_and_flat_at_its_ends),
        cmocka_unit_test(prisms_have_faces_up_to_six_sides),
        cmocka_unit_test(the_tip_of_a_cone_has_the_normal_of_each_side),
        cmocka_unit_test(a_sphere_is_as_it_was),
        cmocka_unit_test(what_belongs_to_vertices_goes_along),
        cmocka_unit_test(meshes_of_nothing_stay_so),
        cmocka_unit_test(short_memory_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
