/* Large meshes within an error, in blocks: what they keep is known of a sphere. */
#include "fields.h"
#include "jobs.h"
#include "meshes.h"
#include "operations.h"
#include "registry.h"
#include "shapes.h"
#include "surface/simplify.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { LEVEL = 6, TRIANGLES = 20 << 2 * LEVEL }; /* 81920: two blocks */
#define RADIUS 50.0

static vv_mesh *simplified(vv_mesh *mesh, const char *settings, int threads)
{
    vv_job *job = test_job(threads, 0);
    const vv_grid grid = test_cube(8, 0, 7);
    vv_object *params = test_params(&vvi_operation_simplify, settings, &grid);
    const vv_data in = {.mesh = mesh};
    vv_data out;
    assert_non_null(params);
    assert_int_equal(vv_operation_make(&out, &vvi_operation_simplify, &in, 1, params, job), VV_OK);
    vv_object_release(params);
    vv_job_release(job);
    return out.mesh;
}

static vv_vec3 minus(vv_vec3 a, vv_vec3 b)
{
    return (vv_vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static double dot(vv_vec3 a, vv_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static double least_on_edge(vv_vec3 a, vv_vec3 b)
{
    const vv_vec3 u = minus(b, a);
    const double t = fmin(fmax(-dot(a, u) / fmax(dot(u, u), 1e-300), 0), 1);
    const vv_vec3 p = {a.x + t * u.x, a.y + t * u.y, a.z + t * u.z};
    return sqrt(dot(p, p));
}

static vv_vec3 cross(vv_vec3 u, vv_vec3 v)
{
    return (vv_vec3){u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}

/* How near a triangle comes to the middle of the sphere: facets of vertices on it are inscribed. */
static double least_of(const vv_mesh *mesh, size_t triangle)
{
    const uint32_t *k = vv_mesh_get_info(mesh)->triangles + 3 * triangle;
    vv_vec3 p[3];
    bool inside = true;
    double least = INFINITY;
    for (int i = 0; i < 3; i++)
        p[i] = test_mesh_vertex(mesh, k[i]);
    const vv_vec3 n = cross(minus(p[1], p[0]), minus(p[2], p[0]));
    for (int i = 0; i < 3; i++) {
        const vv_vec3 edge = minus(p[(i + 1) % 3], p[i]);
        least = fmin(least, least_on_edge(p[i], p[(i + 1) % 3]));
        inside = inside && dot(cross(edge, (vv_vec3){-p[i].x, -p[i].y, -p[i].z}), n) >= 0;
    }
    return inside && dot(n, n) > 0 ? fabs(dot(n, p[0])) / sqrt(dot(n, n)) : least;
}

static void expect_same(const vv_mesh *a_mesh, const vv_mesh *b_mesh)
{
    const vv_mesh_info *a = vv_mesh_get_info(a_mesh), *b = vv_mesh_get_info(b_mesh);
    assert_int_equal(a->n_triangles, b->n_triangles);
    assert_int_equal(a->n_vertices, b->n_vertices);
    assert_memory_equal(a->triangles, b->triangles, 3 * a->n_triangles * sizeof *a->triangles);
    assert_memory_equal(a->positions, b->positions, 3 * a->n_vertices * sizeof *a->positions);
}

static void a_sphere_keeps_its_distance_and_stays_closed(void **state)
{
    const double error = 0.2, facets = 0.016; /* as far as the facets of the sphere were inside */
    if (!vvi_can_simplify())
        skip();
    vv_mesh *sphere = test_mesh_sphere((vv_vec3){0, 0, 0}, RADIUS, LEVEL);
    assert_int_equal(vv_mesh_get_info(sphere)->n_triangles, TRIANGLES);
    vv_mesh *out = simplified(sphere, "error=0.2", 2);
    const size_t n = vv_mesh_get_info(out)->n_triangles;
    double least = INFINITY;
    for (size_t t = 0; t < n; t++)
        least = fmin(least, least_of(out, t));
    if (!(least >= RADIUS - error - facets))
        fail_msg("a triangle lies %g inside", RADIUS - least);
    assert_true(n < TRIANGLES / 10);
    assert_int_equal(test_mesh_bad_edges(out), 0);
    vv_mesh *alone = simplified(sphere, "error=0.2", 1);
    expect_same(out, alone); /* whatever the number of threads */
    vv_mesh_release(alone);
    vv_mesh_release(out);
    vv_mesh_release(sphere);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sphere_keeps_its_distance_and_stays_closed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
