/* Meshes cut by planes: against closed forms, and both sides of a plane against the whole. */
#include "core/memory.h"
#include "core/vec.h"
#include "fields.h"
#include "meshes.h"
#include "surface/clip.h"
#include "surface/fill.h"
#include "surface/marching.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

static double ball(vv_vec3 p)
{
    return 10 - hypot(hypot(p.x, p.y), p.z);
}

static double torus(vv_vec3 p)
{
    return 4 - hypot(hypot(p.x, p.y) - 8, p.z);
}

static vv_mesh *surface_of(double (*value)(vv_vec3), int64_t n, double reach)
{
    const test_form form = {.name = "form", .value = value};
    vv_field *f = test_field_cube(&form, n, -reach, reach, NULL);
    vv_mesh *mesh;
    assert_int_equal(vvi_marching_cubes(&mesh, f, &(vvi_marching_options){.cap = true}, NULL), VV_OK);
    vv_field_release(f);
    return mesh;
}

static vv_mesh *clipped(const vv_mesh *mesh, vv_vec3 normal, double offset, bool cap)
{
    const double length = sqrt(normal.x * normal.x + normal.y * normal.y + normal.z * normal.z);
    const vv_plane plane = {{normal.x / length, normal.y / length, normal.z / length}, offset};
    vv_mesh *out;
    assert_int_equal(vvi_mesh_clip(&out, mesh, &plane, 1, cap, NULL), VV_OK);
    return out;
}

static void assert_share(double found, double expected, double share)
{
    if (!(fabs(found - expected) <= share * fabs(expected)))
        fail_msg("%.8g is not %.8g", found, expected);
}

static void half_a_ball_has_half_the_volume_and_a_disk_more(void **state)
{
    static const vv_vec3 normals[] = {{0, 0, 1}, {1, 0, 0}, {-1, 2, 3}, {.3, -1, .02}};
    vv_mesh *mesh = surface_of(ball, 51, 12);
    const double area = test_mesh_area(mesh), volume = test_mesh_volume(mesh);
    (void)state;
    for (size_t i = 0; i < 4; i++) {
        vv_mesh *half = clipped(mesh, normals[i], 0, true), *open = clipped(mesh, normals[i], 0, false);
        assert_int_equal(test_mesh_bad_edges(half), 0);
        assert_true(test_mesh_bad_edges(open) > 100);
        assert_share(test_mesh_volume(half), volume / 2, 1e-3);
        assert_share(test_mesh_area(open), area / 2, 1e-3);
        assert_share(test_mesh_area(half), area / 2 + M_PI * 100, 5e-3);
        assert_int_equal(test_mesh_euler(half), 2);
        assert_non_null(vv_mesh_get_info(open)->normals);
        assert_null(vv_mesh_get_info(half)->normals);
        vv_mesh_release(half);
        vv_mesh_release(open);
    }
    vv_mesh_release(mesh);
}

static void a_cut_with_a_hole_is_a_ring(void **state)
{
    vv_mesh *mesh = surface_of(torus, 61, 13), *half = clipped(mesh, (vv_vec3){0, 0, 1}, 0.1, true);
    const double inner = 8 - sqrt(16 - .01), outer = 8 + sqrt(16 - .01);
    vv_mesh *open = clipped(mesh, (vv_vec3){0, 0, 1}, 0.1, false);
    (void)state;
    assert_int_equal(test_mesh_bad_edges(half), 0);
    assert_share(test_mesh_area(half) - test_mesh_area(open), M_PI * (outer * outer - inner * inner), 5e-3);
    assert_int_equal(test_mesh_euler(half), 0);
    vv_mesh *quarter = clipped(half, (vv_vec3){0, 1, 0}, 0, true); /* through the cap */
    assert_int_equal(test_mesh_bad_edges(quarter), 0);
    assert_share(test_mesh_volume(quarter), test_mesh_volume(half) / 2, 1e-3);
    vv_mesh_release(quarter);
    vv_mesh_release(open);
    vv_mesh_release(half);
    vv_mesh_release(mesh);
}

/* Noise: thousands of loops, in each other, touching. */
static void both_sides_of_noise_are_closed_and_add_up(void **state)
{
    static const vv_vec3 normals[] = {{0, 0, 1}, {1, 1, 1}, {.2, -1, .5}};
    vv_field_info info = vv_field_info_default();
    info.grid = test_cube(37, 0, 36);
    info.type = VV_TYPE_U8;
    (void)state;
    for (size_t i = 0; i < 9; i++) {
        vv_field *f = test_field_random(&info, test_seed() + i, NULL);
        vv_mesh *mesh;
        const vvi_marching_options o = {.value = 100 + 25 * (double)(i % 3), .cap = true};
        assert_int_equal(vvi_marching_cubes(&mesh, f, &o, NULL), VV_OK);
        const vv_vec3 n = normals[i / 3];
        const double offset = i / 3 == 0 ? 18 : 12.3;
        vv_mesh *a = clipped(mesh, n, offset, true), *b = clipped(mesh, (vv_vec3){-n.x, -n.y, -n.z}, -offset, true);
        vv_mesh *a_open = clipped(mesh, n, offset, false),
                *b_open = clipped(mesh, (vv_vec3){-n.x, -n.y, -n.z}, -offset, false);
        assert_int_equal(test_mesh_bad_edges(mesh), 0);
        assert_int_equal(test_mesh_bad_edges(a), 0);
        assert_int_equal(test_mesh_bad_edges(b), 0);

        assert_share(test_mesh_volume(a) + test_mesh_volume(b), test_mesh_volume(mesh), 1e-5);
        const double cap_a = test_mesh_area(a) - test_mesh_area(a_open),
                     cap_b = test_mesh_area(b) - test_mesh_area(b_open);
        assert_share(cap_a, cap_b, 1e-4);
        vv_mesh_release(a);
        vv_mesh_release(b);
        vv_mesh_release(a_open);
        vv_mesh_release(b_open);
        vv_mesh_release(mesh);
        vv_field_release(f);
    }
}

/* The sum of the triangles in a plane, each counted as positive, and with its sign. */
static void sum_in_plane(double *sum_out, double *signed_out, const vv_mesh *mesh, vv_vec3 normal, double offset)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    *sum_out = *signed_out = 0;
    for (size_t t = 0; t < m->n_triangles; t++) {
        vv_vec3 p[3];
        bool flat = true;
        for (int i = 0; i < 3; i++) {
            const float *at = m->positions + 3 * (size_t)m->triangles[3 * t + (size_t)i];
            p[i] = (vv_vec3){m->origin.x + (double)at[0], m->origin.y + (double)at[1], m->origin.z + (double)at[2]};
            flat &= fabs(vvi_dot(p[i], normal) - offset) < 1e-4;
        }
        const double area = vvi_dot(vvi_cross(vvi_sub(p[1], p[0]), vvi_sub(p[2], p[0])), normal) / 2;
        *sum_out += flat ? fabs(area) : 0;
        *signed_out -= flat ? area : 0;
    }
}

static double sevenths(vv_vec3 p)
{
    uint64_t x = (uint64_t)(p.x + 64 * p.y + 4096 * p.z + 0.5) * 0x9e3779b97f4a7c15u;
    x = (x ^ x >> 29) * 0xbf58476d1ce4e5b9u;
    return (double)((x ^ x >> 32) % 7);
}

/* Whole numbers, of which a seventh are the value of the surface: it comes as near to itself as can be at each. */
static void a_cap_lies_flat_where_samples_equal_the_value(void **state)
{
    static const vv_vec3 normals[] = {{0, 0, 1}, {1, 0, 0}, {1, 1, 1}, {.2, -1, .5}};
    static const double offsets[] = {7.3, 20.2, 30, 3.1};
    const test_form form = {.name = "sevenths", .value = sevenths};
    vv_field *f = test_field_cube(&form, 61, 0, 60, NULL);
    (void)state;
    for (size_t i = 0; i < 4; i++) {
        const double length = sqrt(vvi_dot(normals[i], normals[i]));
        const vvi_marching_options o = {.value = 3, .cap = true};
        vv_mesh *mesh;
        double sum, with_sign;
        assert_int_equal(vvi_marching_cubes(&mesh, f, &o, NULL), VV_OK);
        vv_mesh *half = clipped(mesh, normals[i], offsets[i], true);
        sum_in_plane(&sum, &with_sign, half, vvi_scaled(normals[i], 1 / length), offsets[i]);
        assert_int_equal(test_mesh_bad_edges(half), 0);
        assert_true(sum > 1000);
        assert_share(sum, with_sign, 1e-4);
        vv_mesh_release(half);
        vv_mesh_release(mesh);
    }
    vv_field_release(f);
}

static void what_no_plane_meets_stays_or_goes(void **state)
{
    vv_mesh *mesh = surface_of(ball, 21, 12);
    vv_mesh *all = clipped(mesh, (vv_vec3){0, 0, 1}, -30, true), *none = clipped(mesh, (vv_vec3){0, 0, 1}, 30, true);
    (void)state;
    assert_ptr_equal(all, mesh);
    assert_int_equal(vv_mesh_get_info(none)->n_triangles, 0);
    assert_int_equal(vv_mesh_get_info(none)->n_vertices, 0);
    vv_mesh_release(all);
    vv_mesh_release(none);
    vv_mesh_release(mesh);
}

/* A disk with n corners, and k holes in rows. */
static void loops_are_filled_exactly(void **state)
{
    enum { MOST = 20000 };
    static double at[2 * MOST];
    static uint32_t points[MOST];
    static size_t begin[MOST];
    (void)state;
    for (int side = 0; side < 20; side += 3) {
        size_t n = 0, n_loops = 0;
        double expected = 0;
        for (int hole = -1; hole < side * side; hole++) {
            const size_t corners = hole < 0 ? 997 : 7;
            const double r = hole < 0 ? 2 * (side + 1) : .5, turned = hole < 0 ? 1 : -1;
            const double x = hole < 0 ? 0 : 2 * (hole % side - side / 2),
                         y = hole < 0 ? 0 : 2 * (hole / side - side / 2);
            begin[n_loops++] = n;
            for (size_t i = 0; i < corners; i++, n++) {
                const double angle = turned * 2 * M_PI * (double)i / (double)corners;
                points[n] = (uint32_t)n;
                at[2 * n] = x + r * cos(angle);
                at[2 * n + 1] = y + r * sin(angle);
            }
            expected += turned * r * r * (double)corners / 2 * sin(2 * M_PI / (double)corners);
        }
        begin[n_loops] = n;
        uint32_t *t;
        size_t n_triangles;
        const vvi_loops loops = {at, points, begin, n_loops};
        assert_int_equal(vvi_fill_loops(&t, &n_triangles, &loops, NULL), VV_OK);
        double area = 0, turned_area = 0;
        for (size_t i = 0; i < n_triangles; i++) {
            const double *a = at + 2 * t[3 * i], *b = at + 2 * t[3 * i + 1], *c = at + 2 * t[3 * i + 2];
            const double one = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
            area += one;
            turned_area += one < 0 ? -one : 0;
        }
        assert_int_equal(n_triangles, n + 2 * (n_loops - 1) - 2);
        assert_share(area, expected, 1e-9);
        assert_true(turned_area < 1e-9);
        vvi_free(t);
    }
}

/* The mesh with triangles that share no vertices (apart), are inside out (turned), are of two parts. */
static vv_mesh *altered(const vv_mesh *mesh, bool apart, bool turned, bool parts)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    const size_t n = m->n_triangles;
    float *positions = malloc(9 * n * sizeof *positions);
    uint32_t *triangles = malloc(3 * n * sizeof *triangles);
    assert_true(positions && triangles);
    for (size_t i = 0; i < 3 * n; i++) {
        const size_t from = turned ? 3 * n - 1 - i : i;
        triangles[i] = apart ? (uint32_t)i : m->triangles[from];
        for (size_t a = 0; a < 3 && apart; a++)
            positions[3 * i + a] = m->positions[3 * (size_t)m->triangles[from] + a];
    }
    vv_mesh_part part[2] = {{.color.a = -1, .n_triangles = n / 3}, {.color.a = -1, .n_triangles = n - n / 3}};
    part[1].first_triangle = n / 3;
    vv_mesh_info info = {.n_vertices = apart ? 3 * n : m->n_vertices,
                         .n_triangles = n,
                         .positions = apart ? positions : m->positions,
                         .triangles = triangles,
                         .origin = m->origin,
                         .n_parts = parts ? 2 : 0,
                         .parts = part};
    vv_mesh *out;
    assert_int_equal(vv_mesh_new(&out, &info, NULL), VV_OK);
    free(positions);
    free(triangles);
    return out;
}

/* Triangles of a section face the cut-off side, in its plane. */
static double section_area(const vv_mesh *mesh, const vv_plane *plane, size_t *n_gaps)
{
    vv_mesh *face;
    double area = 0;
    assert_int_equal(vvi_mesh_section(&face, n_gaps, mesh, plane, NULL), VV_OK);
    for (size_t t = 0; face && t < vv_mesh_get_info(face)->n_triangles; t++) {
        vv_vec3 p[3];
        for (size_t k = 0; k < 3; k++) {
            p[k] = test_mesh_vertex(face, vv_mesh_get_info(face)->triangles[3 * t + k]);
            assert_true(fabs(vvi_dot(p[k], plane->normal) - plane->offset) < 1e-5);
        }
        area -= vvi_dot(vvi_cross(vvi_sub(p[1], p[0]), vvi_sub(p[2], p[0])), plane->normal) / 2;
    }
    vv_mesh_release(face);
    return area;
}

static void a_section_is_the_face_of_a_cut_however_the_mesh_is_held(void **state)
{
    vv_mesh *ball_mesh = surface_of(ball, 51, 12), *ring = surface_of(torus, 61, 13);
    const double inner = 8 - sqrt(16 - .01), outer = 8 + sqrt(16 - .01);
    size_t n_gaps;
    (void)state;
    for (int way = 0; way < 8; way++) {
        vv_mesh *m = altered(ball_mesh, way & 1, way & 2, way & 4), *r = altered(ring, way & 1, way & 2, way & 4);
        for (int side = -1; side <= 1; side += 2) {
            const vv_plane low = {{0.6 * side, 0.8 * side, 0}, 6.0 * side}, flat = {{0, 0, side}, .1 * side};
            assert_share(section_area(m, &low, &n_gaps), M_PI * 64, 5e-3);
            assert_int_equal(n_gaps, 0);
            assert_share(section_area(r, &flat, &n_gaps), M_PI * (outer * outer - inner * inner), 5e-3);
            assert_int_equal(n_gaps, 0);
        }
        vv_mesh_release(m);
        vv_mesh_release(r);
    }
    assert_true(section_area(ball_mesh, &(vv_plane){{1, 0, 0}, 11}, &n_gaps) == 0 && n_gaps == 0);
    assert_true(section_area(ball_mesh, &(vv_plane){{1, 0, 0}, -11}, &n_gaps) == 0 && n_gaps == 0);
    vv_mesh_release(ball_mesh);
    vv_mesh_release(ring);
}

static void a_section_of_an_open_mesh_is_open_there(void **state)
{
    vv_mesh *whole = surface_of(ball, 51, 12), *bowl = clipped(whole, (vv_vec3){0, 0, -1}, -5, false);
    size_t n_gaps;
    (void)state;
    assert_true(section_area(bowl, &(vv_plane){{0, 0, 1}, 0}, &n_gaps) > 300 && n_gaps == 0); /* below the rim */
    assert_true(section_area(bowl, &(vv_plane){{1, 0, 0}, 0}, &n_gaps) == 0 && n_gaps == 1);
    vv_mesh_release(bowl);
    vv_mesh_release(whole);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(loops_are_filled_exactly),
        cmocka_unit_test(half_a_ball_has_half_the_volume_and_a_disk_more),
        cmocka_unit_test(a_cut_with_a_hole_is_a_ring),
        cmocka_unit_test(a_cap_lies_flat_where_samples_equal_the_value),
        cmocka_unit_test(both_sides_of_noise_are_closed_and_add_up),
        cmocka_unit_test(what_no_plane_meets_stays_or_goes),
        cmocka_unit_test(a_section_is_the_face_of_a_cut_however_the_mesh_is_held),
        cmocka_unit_test(a_section_of_an_open_mesh_is_open_there),
    };
    return cmocka_run_group_tests_name("surface/clip", tests, NULL, NULL);
}
