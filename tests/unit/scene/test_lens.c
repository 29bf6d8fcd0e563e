/* Cameras: where is front, what fits, what happens at the poles. Points are projected by hand. */
#include "fields.h"
#include "scene/lens.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/model.h>

#include <cmocka.h>

static const vv_vec3 box_corners[8] = {{0, 0, 0},  {100, 0, 0},  {0, 60, 0},  {100, 60, 0},
                                       {0, 0, 80}, {100, 0, 80}, {0, 60, 80}, {100, 60, 80}};

static vv_camera *new_camera(const char *json)
{
    vv_object *object = NULL;
    assert_int_equal(vv_object_from_json(&object, &vv_camera_class, json, strlen(json), NULL), VV_OK);
    return (vv_camera *)object;
}

static vvi_aim aim(const char *json, int32_t width, int32_t height, vv_space space)
{
    const vvi_fit fit = {.corner = box_corners, .n_corners = 8, .margin = VVI_FIT_MARGIN, .space = space};
    vv_camera *camera = new_camera(json);
    vvi_aim out;
    assert_int_equal(vvi_aim_camera(&out, camera, width, height, &fit, "views.main.camera"), VV_OK);
    vv_object_release(&camera->base);
    return out;
}

static void assert_vec(vv_vec3 v, double x, double y, double z)
{
    if (vvi_length(vvi_sub(v, vvi_vec(x, y, z))) > 1e-9)
        fail_msg("(%g, %g, %g) is not (%g, %g, %g)", v.x, v.y, v.z, x, y, z);
}

/* Normalised device coordinates. */
static void project(double *x, double *y, const vv_lens *lens, vv_vec3 p)
{
    const vv_vec3 v = vvi_sub(p, lens->eye);
    const double depth = lens->parallel ? 1 : vvi_dot(v, lens->forward);
    *x = vvi_dot(v, lens->right) / depth / lens->half_width;
    *y = vvi_dot(v, lens->up) / depth / lens->half_height;
}

static double largest_coordinate(const vv_lens *lens)
{
    double most = 0;
    for (int i = 0; i < 8; i++) {
        double x, y;
        project(&x, &y, lens, box_corners[i]);
        most = fmax(most, fmax(fabs(x), fabs(y)));
        assert_true(vvi_dot(vvi_sub(box_corners[i], lens->eye), lens->forward) > 0);
    }
    return most;
}

static void front_of_anatomical_data_looks_to_the_back_at_the_face(void **state)
{
    const vvi_aim a = aim("{}", 100, 100, VV_SPACE_RAS);
    assert_vec(a.lens.forward, 0, -1, 0);
    assert_vec(a.lens.up, 0, 0, 1);
    assert_vec(a.lens.right, -1, 0, 0); /* the subject's right is on the left of the picture */
    assert_vec(a.at, 50, 30, 40);
    assert_true(a.lens.eye.y > 60);
}

static void front_of_other_data_looks_along_y(void **state)
{
    const vvi_aim a = aim("{}", 100, 100, VV_SPACE_PLAIN);
    assert_vec(a.lens.forward, 0, 1, 0);
    assert_vec(a.lens.right, 1, 0, 0);
    assert_vec(a.lens.up, 0, 0, 1);
}

static void azimuth_walks_counter_clockwise_and_elevation_climbs(void **state)
{
    vvi_aim a = aim("{\"azimuth\": 90}", 100, 100, VV_SPACE_PLAIN);
    assert_vec(a.lens.forward, -1, 0, 0); /* from +x, the viewer's right */
    assert_true(a.lens.eye.x > 100);
    a = aim("{\"azimuth\": 90}", 100, 100, VV_SPACE_RAS);
    assert_vec(a.lens.forward, 1, 0, 0); /* from the subject's left */
    a = aim("{\"elevation\": 30}", 100, 100, VV_SPACE_PLAIN);
    assert_vec(a.lens.forward, 0, cos(M_PI / 6), -0.5);
    assert_true(a.lens.eye.z > 40);
}

static void poles_are_views_like_others(void **state)
{
    vvi_aim a = aim("{\"elevation\": 90}", 100, 100, VV_SPACE_PLAIN);
    assert_vec(a.lens.forward, 0, 0, -1);
    assert_vec(a.lens.up, 0, 1, 0);
    assert_vec(a.lens.right, 1, 0, 0);
    a = aim("{\"elevation\": -90, \"azimuth\": 90}", 100, 100, VV_SPACE_PLAIN);
    assert_vec(a.lens.forward, 0, 0, 1);
    assert_vec(a.lens.right, 0, 1, 0);
    a = aim("{\"eye\": [50, 30, 900]}", 100, 100, VV_SPACE_PLAIN); /* along z, which is also the World's up */
    assert_vec(a.lens.forward, 0, 0, -1);
    assert_vec(a.lens.up, 0, 1, 0);
    a = aim("{\"eye\": [50, 30, 900], \"up\": [0, 0, 2]}", 100, 100, VV_SPACE_PLAIN);
    assert_vec(a.lens.up, 0, 1, 0);
}

static void roll_turns_the_camera_up_to_its_right(void **state)
{
    const vvi_aim a = aim("{\"roll\": 90}", 100, 100, VV_SPACE_PLAIN);
    assert_vec(a.lens.up, 1, 0, 0);
    assert_vec(a.lens.right, 0, 0, -1);
    assert_vec(a.up, 0, 0, 1);
}

static void axes_are_orthonormal_and_right_handed_for_any_angles(void **state)
{
    const uint64_t seed = test_seed();
    for (uint64_t i = 0; i < 200; i++) {
        char json[200];
        snprintf(json, sizeof json, "{\"azimuth\": %.3f, \"elevation\": %.3f, \"roll\": %.3f%s}",
                 720 * test_random_unit(seed, 3 * i) - 360, 360 * test_random_unit(seed, 3 * i + 1) - 180,
                 360 * test_random_unit(seed, 3 * i + 2), i % 2 ? ", \"eye\": [7, 5, -300]" : "");
        const vv_lens l = aim(json, 64, 48, i % 3 ? VV_SPACE_PLAIN : VV_SPACE_RAS).lens;
        assert_true(fabs(vvi_length(l.forward) - 1) < 1e-12 && fabs(vvi_length(l.right) - 1) < 1e-12);
        assert_true(fabs(vvi_dot(l.forward, l.right)) < 1e-12);
        const vv_vec3 up = vvi_cross(l.right, l.forward);
        assert_vec(l.up, up.x, up.y, up.z);
    }
}

static void every_corner_fits_with_five_percent_to_spare(void **state)
{
    const int32_t sizes[][2] = {{100, 100}, {320, 100}, {100, 320}};
    const char *const cameras[] = {"{}", "{\"azimuth\": 33, \"elevation\": 21}", "{\"fov\": 90, \"roll\": 40}",
                                   "{\"projection\": \"parallel\", \"azimuth\": 33, \"elevation\": 21}"};
    for (int s = 0; s < 3; s++) {
        for (int c = 0; c < 4; c++) {
            const vvi_aim a = aim(cameras[c], sizes[s][0], sizes[s][1], VV_SPACE_RAS);
            assert_true(fabs(largest_coordinate(&a.lens) - 0.95) < 1e-9);
        }
    }
}

/* Far from a box's middle, so that looking there leaves an empty half; and no place before which nothing else lies. */
static const vv_vec3 lopsided[5] = {{0, 0, 0}, {90, 10, 5}, {10, 40, 0}, {5, 5, 70}, {20, 15, 12}};

/* Over all azimuths and elevations: the sides are 5 % away from what is nearest to them along the axis that decides,
 * and equally far along the other. */
static void assert_centred(const char *projection, int32_t width, int32_t height)
{
    const vvi_fit fit = {.corner = lopsided, .n_corners = 5, .margin = VVI_FIT_MARGIN, .centred = true};
    for (int turn = 0; turn < 60; turn++) {
        char json[128];
        vvi_aim a;
        double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY};
        snprintf(json, sizeof json, "{\"projection\": \"%s\", \"azimuth\": %d, \"elevation\": %d, \"roll\": %d}",
                 projection, turn * 37 % 360, turn * 29 % 180 - 90, turn * 53 % 360);
        vv_camera *camera = new_camera(json);
        assert_int_equal(vvi_aim_camera(&a, camera, width, height, &fit, "views.main.camera"), VV_OK);
        vv_object_release(&camera->base);
        for (int i = 0; i < 5; i++) {
            double p[2];
            project(&p[0], &p[1], &a.lens, lopsided[i]);
            for (int c = 0; c < 2; c++) {
                lo[c] = fmin(lo[c], p[c]);
                hi[c] = fmax(hi[c], p[c]);
            }
        }
        const int c = hi[0] - lo[0] > hi[1] - lo[1] ? 0 : 1; /* the axis that fills the picture */
        assert_float_equal(lo[c], -0.95, 1e-9);
        assert_float_equal(hi[c], 0.95, 1e-9);
        assert_float_equal(lo[1 - c], -hi[1 - c], 1e-9);
        assert_true(hi[1 - c] <= 0.95);
        assert_vec(vvi_sub(a.at, a.lens.eye), a.lens.forward.x * vvi_length(vvi_sub(a.at, a.lens.eye)),
                   a.lens.forward.y * vvi_length(vvi_sub(a.at, a.lens.eye)),
                   a.lens.forward.z * vvi_length(vvi_sub(a.at, a.lens.eye)));
    }
}

static void what_is_seen_reaches_as_near_to_one_side_as_to_the_other(void **state)
{
    assert_centred("perspective", 100, 100);
    assert_centred("perspective", 320, 100);
    assert_centred("parallel", 100, 100);
    assert_centred("parallel", 100, 240);
}

static void zoom_divides_what_the_image_shows(void **state)
{
    const char *const cameras[][2] = {
        {"{}", "{\"zoom\": 2}"}, {"{\"projection\": \"parallel\"}", "{\"projection\": \"parallel\", \"zoom\": 2}"}};
    for (int c = 0; c < 2; c++) {
        const vvi_aim one = aim(cameras[c][0], 100, 100, VV_SPACE_PLAIN);
        const vvi_aim two = aim(cameras[c][1], 100, 100, VV_SPACE_PLAIN);
        assert_true(fabs(two.lens.half_height - one.lens.half_height / 2) < 1e-12);
        assert_true(fabs(two.lens.half_width - one.lens.half_width / 2) < 1e-12);
        assert_vec(two.lens.eye, one.lens.eye.x, one.lens.eye.y, one.lens.eye.z);
        assert_true(fabs(two.height - one.height) < 1e-9);
    }
}

static void given_points_are_kept(void **state)
{
    vvi_aim a = aim("{\"eye\": [-500, 30, 40]}", 100, 100, VV_SPACE_RAS);
    assert_vec(a.lens.eye, -500, 30, 40);
    assert_vec(a.lens.forward, 1, 0, 0);
    a = aim("{\"at\": [10, 20, 30]}", 100, 100, VV_SPACE_PLAIN);
    assert_vec(a.at, 10, 20, 30);
    assert_vec(a.lens.forward, 0, 1, 0);
    assert_true(fabs(largest_coordinate(&a.lens) - 0.95) < 1e-9);
    a = aim("{\"projection\": \"parallel\", \"height\": 300}", 200, 100, VV_SPACE_PLAIN);
    assert_true(a.lens.half_height == 150 && a.lens.half_width == 300);
    a = aim("{\"fov\": 60}", 200, 100, VV_SPACE_PLAIN);
    assert_true(fabs(a.lens.half_height - tan(M_PI / 6)) < 1e-12);
    a = aim("{\"up\": [0, -3, 0], \"elevation\": 90}", 100, 100, VV_SPACE_PLAIN);
    assert_vec(a.lens.up, 0, -1, 0);
}

static void an_eye_on_what_it_looks_at_is_an_error_with_its_path(void **state)
{
    const vvi_fit fit = {box_corners, 8, VV_SPACE_PLAIN};
    vv_camera *camera = new_camera("{\"eye\": [1, 2, 3], \"at\": [1, 2, 3]}");
    vvi_aim out;
    assert_int_equal(vvi_aim_camera(&out, camera, 10, 10, &fit, "views.main.camera"), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "views.main.camera.eye"));
    vv_object_release(&camera->base);
}

/* Y up is z up with the World turned by a right angle about x. */
static void y_up_is_z_up_turned(void **state)
{
    static const char *const cameras[] = {"{}", "{\"azimuth\": 30, \"elevation\": 15, \"roll\": 7}",
                                          "{\"elevation\": 90}"};
    (void)state;
    for (size_t i = 0; i < sizeof cameras / sizeof *cameras; i++) {
        const vvi_fit plain = {.space = VV_SPACE_PLAIN}, turned = {.space = VV_SPACE_PLAIN, .up = VV_UP_Y};
        vv_camera *camera = new_camera(cameras[i]);
        vvi_aim z, y;
        assert_int_equal(vvi_aim_camera(&z, camera, 30, 20, &plain, "c"), VV_OK);
        assert_int_equal(vvi_aim_camera(&y, camera, 30, 20, &turned, "c"), VV_OK);
        assert_vec(y.lens.forward, z.lens.forward.x, z.lens.forward.z, -z.lens.forward.y);
        assert_vec(y.lens.up, z.lens.up.x, z.lens.up.z, -z.lens.up.y);
        assert_vec(y.lens.right, z.lens.right.x, z.lens.right.z, -z.lens.right.y);
        assert_vec(y.up, 0, 1, 0);
        vv_object_release(&camera->base);
    }
}

static void nothing_to_fit_still_gives_a_lens(void **state)
{
    const vvi_fit none = {0}, point = {(const vv_vec3[]){{3, 3, 3}}, 1, VV_SPACE_PLAIN};
    const vvi_fit *const fits[] = {&none, &point};
    for (int p = 0; p < 4; p++) {
        vv_camera *camera = new_camera(p % 2 ? "{\"projection\": \"parallel\"}" : "{}");
        vvi_aim out;
        assert_int_equal(vvi_aim_camera(&out, camera, 10, 10, fits[p / 2], "c"), VV_OK);
        assert_true(out.lens.half_height > 0 && vvi_length(vvi_sub(out.at, out.lens.eye)) > 0);
        vv_object_release(&camera->base);
    }
}

static void rays_pass_through_their_pixels(void **state)
{
    const char *const cameras[] = {"{\"azimuth\": 20, \"elevation\": -35}",
                                   "{\"azimuth\": 20, \"elevation\": -35, \"projection\": \"parallel\"}"};
    for (int c = 0; c < 2; c++) {
        const vv_lens lens = aim(cameras[c], 64, 48, VV_SPACE_PLAIN).lens;
        vv_vec3 origin, direction;
        double x, y;
        vvi_lens_ray(&origin, &direction, &lens, 64, 48, 10.5, 40.5);
        assert_true(fabs(vvi_length(direction) - 1) < 1e-12);
        project(&x, &y, &lens, vvi_add(origin, vvi_scaled(direction, 123)));
        assert_true(fabs((x + 1) * 32 - 10.5) < 1e-9);
        assert_true(fabs((1 - y) * 24 - 40.5) < 1e-9);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(front_of_anatomical_data_looks_to_the_back_at_the_face),
        cmocka_unit_test(front_of_other_data_looks_along_y),
        cmocka_unit_test(azimuth_walks_counter_clockwise_and_elevation_climbs),
        cmocka_unit_test(poles_are_views_like_others),
        cmocka_unit_test(roll_turns_the_camera_up_to_its_right),
        cmocka_unit_test(axes_are_orthonormal_and_right_handed_for_any_angles),
        cmocka_unit_test(every_corner_fits_with_five_percent_to_spare),
        cmocka_unit_test(what_is_seen_reaches_as_near_to_one_side_as_to_the_other),
        cmocka_unit_test(zoom_divides_what_the_image_shows),
        cmocka_unit_test(given_points_are_kept),
        cmocka_unit_test(an_eye_on_what_it_looks_at_is_an_error_with_its_path),
        cmocka_unit_test(y_up_is_z_up_turned),
        cmocka_unit_test(nothing_to_fit_still_gives_a_lens),
        cmocka_unit_test(rays_pass_through_their_pixels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
