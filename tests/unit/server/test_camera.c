/* A view's camera to a pose and back. */
#include "fields.h"
#include "jobs.h"
#include "server/camera.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <volvis/file.h>
#include <volvis/sys/scene.h>

static void ok(vv_status st)
{
    if (st != VV_OK)
        fail_msg("%s", vv_error_last()->message);
}

static char paths[2][64]; /* a cube that lies plainly, and in a body */

static int write_cubes(void **state)
{
    vv_job *job = test_job(1, 0);
    (void)state;
    for (int anatomical = 0; anatomical < 2; anatomical++) {
        vv_field_info info = vv_field_info_default();
        info.grid = test_cube(9, 0, 8);
        info.grid.space = anatomical ? VV_SPACE_RAS : VV_SPACE_PLAIN;
        info.type = VV_TYPE_F32;
        vv_field *field = test_field(&test_form_sphere, &info, job);
        snprintf(paths[anatomical], sizeof *paths, "/tmp/volvis-camera-XXXXXX.nrrd");
        const int fd = mkstemps(paths[anatomical], 5);
        assert_true(fd >= 0 && field);
        close(fd);
        ok(vv_field_write(paths[anatomical], (const vv_field *const *)&field, 1, NULL, job));
        vv_field_release(field);
    }
    vv_job_release(job);
    return 0;
}

static int remove_cubes(void **state)
{
    (void)state;
    return unlink(paths[0]) | unlink(paths[1]);
}

static vv_world *world_of(bool anatomical, vv_job *job)
{
    vv_world *world = NULL;
    ok(vv_world_for_file(&world, paths[anatomical], NULL, job));
    return world;
}

static void set(vv_world **world, const char *path, const char *json)
{
    vv_object *root = &(*world)->base;
    ok(vv_path_set(&root, path, json, NULL));
    *world = (vv_world *)(void *)root;
}

static vv_lens lens_of(vv_world *world, vv_job *job)
{
    vv_scene *scene = NULL;
    ok(vv_scene_resolve(&scene, world, "main", job));
    const vv_lens lens = scene->lens;
    vv_scene_release(scene);
    return lens;
}

static void assert_same(vv_vec3 a, vv_vec3 b)
{
    if (!(vvi_length(vvi_sub(a, b)) <= 1e-9 * (1 + vvi_length(a))))
        fail_msg("%.12g %.12g %.12g is not %.12g %.12g %.12g", a.x, a.y, a.z, b.x, b.y, b.z);
}

static void check_round_trip(bool anatomical, const char *camera, int32_t width, int32_t height, vv_job *job)
{
    char number[16];
    vv_world *world = world_of(anatomical, job), *again = NULL;
    vvi_stand stand;
    snprintf(number, sizeof number, "%d", width);
    set(&world, "views.main.width", number);
    snprintf(number, sizeof number, "%d", height);
    set(&world, "views.main.height", number);
    set(&world, "views.main.camera", camera);
    const vv_lens before = lens_of(world, job);
    ok(vvi_camera_stand(&stand, world, "main", job));
    assert_int_equal(stand.anatomical, anatomical);
    ok(vvi_camera_world(&again, world, "main", &stand.pose, width, height));
    const vv_lens after = lens_of(again, job);
    assert_same(before.eye, after.eye);
    assert_same(before.right, after.right);
    assert_same(before.up, after.up);
    assert_same(before.forward, after.forward);
    assert_int_equal(before.parallel, after.parallel);
    assert_float_equal(before.half_width, after.half_width, 1e-9 * before.half_width);
    assert_float_equal(before.half_height, after.half_height, 1e-9 * before.half_height);
    vv_object_release(&again->base);
    vv_object_release(&world->base);
}

static void a_pose_written_as_a_camera_looks_the_same(void **state)
{
    static const char *const cameras[] = {
        "{}",
        "{\"azimuth\": 30, \"elevation\": 15}",
        "{\"azimuth\": -100, \"elevation\": -89, \"roll\": 40, \"fov\": 70}",
        "{\"azimuth\": 10, \"projection\": \"parallel\"}",
        "{\"projection\": \"parallel\", \"height\": 3, \"roll\": 5}",
        "{\"eye\": [20, 3, 5], \"at\": [1, 2, 3], \"up\": [0, 1, 0.5], \"fov\": 12}",
    };
    static const int32_t sizes[][2] = {{64, 48}, {48, 64}, {50, 50}, {1, 97}};
    vv_job *job = test_job(1, 0);
    (void)state;
    for (size_t c = 0; c < sizeof cameras / sizeof *cameras; c++)
        for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
            for (int anatomical = 0; anatomical < 2; anatomical++)
                check_round_trip(anatomical, cameras[c], sizes[i][0], sizes[i][1], job);
    vv_job_release(job);
}

static void angles_of_a_pose_are_those_of_its_camera(void **state)
{
    static const double angles[][2] = {{0, 0}, {30, 15}, {-90, 0}, {90, 45}, {179, -60}, {-135, 80}, {12.5, -89}};
    vv_job *job = test_job(1, 0);
    (void)state;
    for (size_t i = 0; i < sizeof angles / sizeof *angles; i++) {
        for (int k = 0; k < 4; k++) {
            vv_world *world = world_of(k & 1, job);
            vvi_stand stand;
            char camera[96];
            double found[2];
            set(&world, "up", k & 2 ? "\"y\"" : "\"z\"");
            snprintf(camera, sizeof camera, "{\"azimuth\": %.17g, \"elevation\": %.17g}", angles[i][0], angles[i][1]);
            set(&world, "views.main.camera", camera);
            ok(vvi_camera_stand(&stand, world, "main", job));
            vvi_camera_angles(found, &stand);
            assert_float_equal(found[0], angles[i][0], 1e-6);
            assert_float_equal(found[1], angles[i][1], 1e-6);
            vv_object_release(&world->base);
        }
    }
    vv_job_release(job);
}

/* Half a turn of a camera that looks down ends as high as it began, and level; so does one that was saved. */
static void turntables_turn_about_the_worlds_up(void **state)
{
    static const char *const cameras[] = {"{\"azimuth\": 30, \"elevation\": 25}", "{\"eye\": [20, 20, 20]}",
                                          "{\"elevation\": 90}"};
    vv_job *job = test_job(1, 0);
    (void)state;
    for (size_t i = 0; i < sizeof cameras / sizeof *cameras; i++) {
        for (int y_up = 0; y_up < 2; y_up++) {
            const vv_vec3 up = y_up ? vvi_vec(0, 1, 0) : vvi_vec(0, 0, 1);
            vv_world *world = world_of(false, job), *saved = NULL;
            vvi_stand stand, again;
            set(&world, "up", y_up ? "\"y\"" : "\"z\"");
            set(&world, "views.main.camera", cameras[i]);
            ok(vvi_camera_stand(&stand, world, "main", job));
            assert_same(stand.up, up);
            ok(vvi_camera_world(&saved, world, "main", &stand.pose, 64, 48));
            ok(vvi_camera_stand(&again, saved, "main", job));
            assert_same(again.up, up);
            const vvi_pose turned = vvi_orbit(&again.pose, 0.5, 0, again.up);
            assert_float_equal(vvi_dot(turned.eye, up), vvi_dot(stand.pose.eye, up), 1e-3);
            vv_object_release(&saved->base);
            vv_object_release(&world->base);
        }
    }
    vv_job_release(job);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pose_written_as_a_camera_looks_the_same),
        cmocka_unit_test(angles_of_a_pose_are_those_of_its_camera),
        cmocka_unit_test(turntables_turn_about_the_worlds_up),
    };
    return cmocka_run_group_tests(tests, write_cubes, remove_cubes);
}
