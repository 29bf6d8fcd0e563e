/* What a camera that nobody placed looks at of meshes: all vertices of triangles are in the picture, and it is full. */
#include "core/vec.h"
#include "fail_alloc.h"
#include "jobs.h"
#include "scene/visible_mesh.h"
#include "shapes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <volvis/mesh_file.h>
#include <volvis/render.h>

static const vv_affine turned = {.axis = {{0, 3, 0}, {-2, 0, 0.5}, {0, 0.25, 1}}, .origin = {100, -7, 3}};

/* A long piece of a strip, and a vertex far away of which there is no triangle. */
static vv_mesh *strip(void)
{
    enum { N = 3000 };
    static float positions[3 * N + 3];
    static uint32_t triangles[3 * (N - 2)];
    for (size_t i = 0; i < N; i++) {
        const double t = 0.01 * (double)i;
        positions[3 * i] = (float)(t * cos(3 * t));
        positions[3 * i + 1] = (float)(0.2 * t * sin(3 * t));
        positions[3 * i + 2] = (float)(5 * sin(t));
    }
    for (size_t k = 0; k < 3; k++)
        positions[3 * N + k] = 1e6f;
    for (size_t k = 0; k < 3 * (N - 2); k++)
        triangles[k] = (uint32_t)(k / 3 + k % 3);
    return test_mesh_new(positions, N + 1, triangles, N - 2);
}

/* Along each direction nothing lies farther out than the point that is told. */
static void points_lie_farthest_out(void **state)
{
    (void)state;
    vv_job *job = test_job(1, 0);
    vv_mesh *const meshes[] = {strip(), test_mesh_sphere((vv_vec3){50, 60, 70}, 10, 4),
                               test_mesh_box(1, 2, 3, (vv_vec3){1e5, 0, 0})};
    for (size_t i = 0; i < 3; i++) {
        const vv_mesh_actor shape = {.mesh = meshes[i], .place = turned};
        const vv_mesh_info *m = vv_mesh_get_info(meshes[i]);
        vv_vec3 points[VVI_SHAPE_POINTS];
        int n = 0;
        assert_int_equal(vvi_visible_mesh_points(points, &shape, job), VV_OK);
        for (int d = 0; d < 729; d++) {
            const vv_vec3 direction = vvi_vec(d % 9 - 4, d / 9 % 9 - 4, d / 81 - 4);
            double most = -INFINITY;
            if (fmax(fmax(fabs(direction.x), fabs(direction.y)), fabs(direction.z)) < 4)
                continue;
            for (size_t k = 0; k < 3 * m->n_triangles; k++) {
                const float *p = m->positions + 3 * (size_t)m->triangles[k];
                const vv_vec3 at = vvi_vec((double)p[0], (double)p[1], (double)p[2]);
                most = fmax(most, vvi_dot(direction, vv_affine_point(turned, vvi_add(at, m->origin))));
            }
            const double told = vvi_dot(direction, points[n++]);
            assert_true(fabs(told - most) <= 1e-9 * (1 + fabs(most)));
        }
        assert_int_equal(n, VVI_SHAPE_POINTS);
        vv_mesh_release(meshes[i]);
    }
    vv_job_release(job);
}

/* Nothing to look at is somewhere. */
static void an_empty_mesh_is_a_place(void **state)
{
    (void)state;
    vv_job *job = test_job(1, 0);
    vv_mesh *none = test_mesh_new(NULL, 0, NULL, 0);
    const vv_mesh_actor shape = {.mesh = none, .place = turned};
    vv_vec3 points[VVI_SHAPE_POINTS];
    assert_int_equal(vvi_visible_mesh_points(points, &shape, job), VV_OK);
    assert_true(points[0].x == 100 && points[VVI_SHAPE_POINTS - 1].y == -7);
    vv_mesh_release(none);
    vv_job_release(job);
}

static void set(vv_object **world, const char *path, double value)
{
    char text[32];
    snprintf(text, sizeof text, "%.17g", value);
    const vv_property_context context = {0};
    assert_int_equal(vv_path_set(world, path, text, &context), VV_OK);
}

/* How far out of the middle the farthest vertex lies in the picture: 1 is its rim. */
static double fullness(const vv_scene *scene)
{
    const vv_mesh_info *m = vv_mesh_get_info(scene->mesh_actors[0].mesh);
    const vv_lens *lens = &scene->lens;
    double most = 0;
    for (size_t k = 0; k < 3 * m->n_triangles; k++) {
        const float *p = m->positions + 3 * (size_t)m->triangles[k];
        const vv_vec3 at = vvi_add(vvi_vec((double)p[0], (double)p[1], (double)p[2]), m->origin);
        const vv_vec3 d = vvi_sub(vv_affine_point(scene->mesh_actors[0].place, at), lens->eye);
        const double depth = lens->parallel ? 1 : vvi_dot(d, lens->forward);
        most = fmax(most, fabs(vvi_dot(d, lens->right)) / depth / lens->half_width);
        most = fmax(most, fabs(vvi_dot(d, lens->up)) / depth / lens->half_height);
    }
    return most;
}

static void a_picture_is_full_from_everywhere(void **state)
{
    (void)state;
    vv_job *job = test_job(1, 0);
    vv_mesh *const meshes[] = {strip(), test_mesh_sphere((vv_vec3){50, 60, 70}, 10, 4)};
    for (size_t i = 0; i < 2; i++) {
        vv_world *world = NULL;
        char path[64];
        snprintf(path, sizeof path, "visible_shape_%d.ply", (int)getpid());
        assert_int_equal(vv_mesh_write(path, meshes[i], NULL, job), VV_OK);
        assert_int_equal(vv_world_for_file(&world, path, NULL, job), VV_OK);
        vv_object *object = &world->base;
        for (int view = 0; view < 12; view++) {
            vv_scene *scene;
            set(&object, "views.main.camera.azimuth", 0.5 * view);
            set(&object, "views.main.camera.elevation", 0.4 * view - 1.5 < 1.5 ? 0.4 * view - 1.5 : 0);
            const vv_property_context context = {0};
            assert_int_equal(vv_path_set(&object, "views.main.camera.projection",
                                         view % 2 ? "\"parallel\"" : "\"perspective\"", &context),
                             VV_OK);
            assert_int_equal(vv_scene_resolve(&scene, (vv_world *)object, NULL, job), VV_OK);
            const double full = fullness(scene);
            assert_true(full > 0.9499 && full < 0.97);
            vv_scene_release(scene);
        }
        vv_object_release(object);
        vv_mesh_release(meshes[i]);
        remove(path);
    }
    vv_job_release(job);
}

static vv_status find(void *user)
{
    const vv_mesh_actor shape = {.mesh = user, .place = turned};
    vv_vec3 points[VVI_SHAPE_POINTS];
    return vvi_visible_mesh_points(points, &shape, NULL);
}

static void short_memory_is_an_error(void **state)
{
    (void)state;
    vv_mesh *sphere = test_mesh_sphere((vv_vec3){0}, 10, 2);
    assert_true(test_fail_each_alloc(find, sphere) >= 2);
    vv_mesh_release(sphere);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_lie_farthest_out),
        cmocka_unit_test(an_empty_mesh_is_a_place),
        cmocka_unit_test(a_picture_is_full_from_everywhere),
        cmocka_unit_test(short_memory_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
