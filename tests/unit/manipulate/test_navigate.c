/* Control laws of the camera against geometry. */
#include "fields.h"
#include "manipulate/navigate.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

static const vv_vec3 up_z = {0, 0, 1};

static vvi_pose start(void)
{
    const vv_vec3 right = {1, 0, 0}, up = {0, 0, 1}, back = {0, -1, 0};
    return (vvi_pose){
        .eye = {2, -7, 3}, .turn = vvi_turn_of_axes(right, up, back), .pivot = {2, 3, 3}, .fov = 0.6, .height = 5};
}

static void assert_near(double found, double expected, double tolerance)
{
    if (!(fabs(found - expected) <= tolerance))
        fail_msg("%.17g is not %.17g", found, expected);
}

static void assert_vec(vv_vec3 found, vv_vec3 expected, double tolerance)
{
    assert_near(found.x, expected.x, tolerance);
    assert_near(found.y, expected.y, tolerance);
    assert_near(found.z, expected.z, tolerance);
}

/* q and -q are one turn. */
static void assert_turn(vvi_quaternion found, vvi_quaternion expected, double tolerance)
{
    const double s = vvi_turn_dot(found, expected) < 0 ? -1 : 1;
    assert_near(s * found.w, expected.w, tolerance);
    assert_vec(vvi_vec(s * found.x, s * found.y, s * found.z), vvi_vec(expected.x, expected.y, expected.z), tolerance);
}

static void assert_pose(const vvi_pose *found, const vvi_pose *expected, double tolerance)
{
    assert_vec(found->eye, expected->eye, tolerance);
    assert_vec(found->pivot, expected->pivot, tolerance);
    assert_turn(found->turn, expected->turn, tolerance);
    assert_near(found->height, expected->height, tolerance);
}

static double number(uint64_t i)
{
    return (double)(test_random(5, i) % 2000001) / 1e6 - 1;
}

static vvi_quaternion any_turn(uint64_t i)
{
    return vvi_turn_by(vvi_vec(3 * number(3 * i), 3 * number(3 * i + 1), 3 * number(3 * i + 2)));
}

/* Turns ----------------------------------------------------------------------------------------------------------- */

static void turns_are_the_rotations_that_they_should_be(void **state)
{
    (void)state;
    const vvi_quaternion quarter = vvi_turn_about(up_z, M_PI / 2);
    assert_vec(vvi_turned(quarter, vvi_vec(1, 0, 0)), vvi_vec(0, 1, 0), 1e-15);
    for (uint64_t i = 0; i < 200; i++) {
        const vvi_quaternion a = any_turn(i), b = any_turn(i + 1000);
        const vv_vec3 v = {number(7 * i), number(7 * i + 1), number(7 * i + 2)};
        assert_vec(vvi_turned(vvi_turn_after(a, b), v), vvi_turned(a, vvi_turned(b, v)), 1e-14);
        assert_vec(vvi_turned(vvi_turn_back(a), vvi_turned(a, v)), v, 1e-14);
        assert_turn(vvi_turn_by(vvi_turn_log(a)), a, 1e-13);
        assert_turn(vvi_turn_of_axes(vvi_turned(a, vvi_vec(1, 0, 0)), vvi_turned(a, vvi_vec(0, 1, 0)),
                                     vvi_turned(a, vvi_vec(0, 0, 1))),
                    a, 1e-14);
        vv_vec3 from = vvi_turned(a, vvi_vec(1, 0, 0)), to = vvi_turned(b, vvi_vec(0, 1, 0));
        assert_vec(vvi_turned(vvi_turn_between(from, to), from), to, 1e-13);
    }
    assert_vec(vvi_turned(vvi_turn_between(up_z, vvi_vec(0, 0, -1)), up_z), vvi_vec(0, 0, -1), 1e-14);
    assert_vec(vvi_turn_log(vvi_no_turn()), vvi_vec(0, 0, 0), 0);
}

/* Half of a quarter about z: (cos 22.5, 0, 0, sin 22.5 degrees). */
static void slerp_is_steady_and_goes_the_short_way(void **state)
{
    (void)state;
    const vvi_quaternion a = vvi_no_turn(), b = vvi_turn_about(up_z, M_PI / 2);
    assert_turn(vvi_slerp(a, b, 0.5), (vvi_quaternion){0.923879532511287, 0, 0, 0.382683432365090}, 1e-15);
    const vvi_quaternion other = {-b.w, -b.x, -b.y, -b.z};
    for (int k = 0; k <= 10; k++) {
        assert_turn(vvi_slerp(a, b, k / 10.0), vvi_turn_about(up_z, k * M_PI / 20), 1e-14);
        assert_turn(vvi_slerp(a, other, k / 10.0), vvi_turn_about(up_z, k * M_PI / 20), 1e-14);
    }
}

/* Laws ------------------------------------------------------------------------------------------------------------ */

static void a_turntable_turns_once_for_a_drag_across_and_stops_before_the_poles(void **state)
{
    (void)state;
    const vvi_pose p = start();
    vvi_pose q = vvi_orbit(&p, 0.25, 0, up_z); /* what was in front is at the right: we look from the left */
    assert_vec(q.eye, vvi_vec(-8, 3, 3), 1e-12);
    assert_vec(vvi_pose_forward(&q), vvi_vec(1, 0, 0), 1e-14);
    assert_vec(vvi_pose_up(&q), up_z, 1e-14);
    q = vvi_orbit(&p, 1, 0, up_z);
    assert_pose(&q, &p, 1e-12);
    q = vvi_orbit(&p, 0, -0.25, up_z); /* down: from above */
    assert_vec(q.eye, vvi_vec(2, 3 - 10 * sqrt(0.5), 3 + 10 * sqrt(0.5)), 1e-12);
    for (int k = 0; k < 5; k++)
        q = vvi_orbit(&q, 0.01, -0.3, up_z);
    assert_near(asin(-vvi_dot(vvi_pose_forward(&q), up_z)), 89.9 * M_PI / 180, 1e-9);
    assert_true(vvi_dot(vvi_pose_up(&q), up_z) > 0);
    for (int k = 0; k < 36; k++)
        q = vvi_orbit(&q, 1 / 36.0, 0.02, up_z);
    assert_near(vvi_pose_distance(&q), 10, 1e-12);
    assert_near(vvi_dot(vvi_pose_right(&q), up_z), 0, 1e-12); /* the horizon stays level */
}

static void an_arcball_turns_half_way_from_middle_to_edge_and_closes_every_loop(void **state)
{
    (void)state;
    const vvi_pose p = start();
    const double middle[2] = {0, 0}, edge[2] = {1, 0};
    vvi_pose q = vvi_arcball(&p, middle, edge);
    assert_vec(q.eye, vvi_vec(2, 13, 3), 1e-12);
    assert_vec(vvi_pose_up(&q), up_z, 1e-14);
    q = p;
    double at[2] = {0.3, -0.2}, first[2] = {0.3, -0.2};
    for (uint64_t i = 0; i < 50; i++) {
        const double next[2] = {1.3 * number(2 * i), 1.3 * number(2 * i + 1)}; /* outside too */
        q = vvi_arcball(&q, at, next);
        at[0] = next[0], at[1] = next[1];
    }
    q = vvi_arcball(&q, at, first);
    assert_pose(&q, &p, 1e-12);
}

static void a_trackball_follows_the_pointer_and_has_no_step_where_its_sheet_begins(void **state)
{
    (void)state;
    const vvi_pose p = start();
    const double middle[2] = {0, 0}, right[2] = {0.5, 0}, r = sqrt(0.5);
    vvi_pose q = vvi_trackball(&p, middle, right); /* 30 degrees: where the ball is 0.5 to the right of its middle */
    assert_vec(vvi_pose_forward(&q), vvi_vec(0.5, cos(M_PI / 6), 0), 1e-12);
    const double within[2] = {r - 1e-9, 0}, without[2] = {r + 1e-9, 0};
    vvi_pose a = vvi_trackball(&p, middle, within), b = vvi_trackball(&p, middle, without);
    assert_pose(&a, &b, 1e-7);
    const double far[2] = {40, 0}, farther[2] = {50, 0};
    q = vvi_trackball(&p, far, farther);
    assert_near(vvi_pose_distance(&q), 10, 1e-12);
}

static void the_plane_of_the_pivot_follows_a_pan(void **state)
{
    (void)state;
    vvi_pose p = start();
    vvi_pose q = vvi_pan(&p, 0.5, -0.25); /* extent: 20 tan 0.3 */
    const double extent = 20 * tan(0.3);
    assert_vec(vvi_sub(q.pivot, p.pivot), vvi_vec(-0.5 * extent, 0, 0.25 * extent), 1e-12);
    assert_vec(vvi_sub(q.eye, p.eye), vvi_sub(q.pivot, p.pivot), 1e-12);
    p.parallel = true;
    q = vvi_pan(&p, 1, 0);
    assert_vec(vvi_sub(q.pivot, p.pivot), vvi_vec(-5, 0, 0), 1e-12);
}

/* The place of a world point in the viewport, as the laws count it. */
static void project(double out[2], const vvi_pose *p, vv_vec3 point)
{
    const vv_vec3 d = vvi_sub(point, p->eye);
    const double depth = vvi_dot(d, vvi_pose_forward(p));
    const double half = p->parallel ? p->height / 2 : depth * tan(p->fov / 2);
    out[0] = vvi_dot(d, vvi_pose_right(p)) / half;
    out[1] = vvi_dot(d, vvi_pose_up(p)) / half;
}

static void a_zoom_keeps_what_lies_under_the_pointer(void **state)
{
    (void)state;
    for (int parallel = 0; parallel < 2; parallel++) {
        vvi_pose p = start();
        p.parallel = parallel;
        const double at[2] = {0.6, -0.4};
        const double half = vvi_pose_extent(&p) / 2;
        const vv_vec3 point = vvi_add(p.pivot, vvi_vec(0.6 * half, 0, -0.4 * half));
        for (int k = 0; k < 6; k++) {
            const double before = vvi_pose_extent(&p);
            double found[2];
            p = vvi_zoom(&p, k % 2 ? -0.35 : 0.5, at);
            assert_near(vvi_pose_extent(&p) / before, exp(k % 2 ? 0.7 : -1), 1e-12);
            project(found, &p, point);
            assert_near(found[0], at[0], 1e-12);
            assert_near(found[1], at[1], 1e-12);
        }
    }
}

static void a_zoom_beyond_what_doubles_hold_does_nothing(void **state)
{
    (void)state;
    const vvi_pose p = start();
    static const double amounts[] = {1e3, -1e3, INFINITY, NAN, 20};
    for (size_t i = 0; i < sizeof amounts / sizeof *amounts; i++) {
        const vvi_pose q = vvi_zoom(&p, amounts[i], NULL);
        assert_true(vvi_pose_equal(&q, &p));
    }
}

static void a_roll_turns_the_picture_and_nothing_else(void **state)
{
    (void)state;
    const vvi_pose p = start(), q = vvi_roll(&p, M_PI / 2);
    assert_vec(q.eye, p.eye, 0);
    assert_vec(vvi_pose_forward(&q), vvi_pose_forward(&p), 1e-15);
    double found[2];
    project(found, &q, vvi_vec(3, 3, 3)); /* was right of the middle */
    assert_true(fabs(found[0]) < 1e-12 && found[1] > 0);
}

/* Straight ahead at 1 a second while turning by 1 radian a second: a circle of radius 1, whatever the step. */
static void flight_in_steps_leads_where_one_long_one_does(void **state)
{
    (void)state;
    static const int rates[] = {10, 60, 240};
    const vvi_pose p = start();
    const vv_vec3 speed = {0, 0, -1}, spin = {0, 1, 0};
    for (int r = 0; r < 3; r++) {
        const int n = 2 * rates[r];
        vvi_pose q = p;
        for (int k = 0; k < n; k++) {
            q = vvi_fly(&q, speed, spin, 2 * M_PI / n);
            const vv_vec3 centre = vvi_sub(p.eye, vvi_pose_right(&p)); /* spin about up turns to the left */
            assert_near(vvi_length(vvi_sub(q.eye, centre)), 1, 1e-12);
        }
        assert_pose(&q, &p, 1e-11); /* the pivot lies ten radii ahead */
    }
    const vv_vec3 any_speed = {0.3, -0.2, -2}, any_spin = {0.7, -0.4, 0.2};
    const vvi_pose once = vvi_fly(&p, any_speed, any_spin, 3);
    vvi_pose often = p;
    for (int k = 0; k < 30000; k++)
        often = vvi_fly(&often, any_speed, any_spin, 1e-4);
    assert_pose(&often, &once, 1e-9);
    const vvi_pose straight = vvi_fly(&p, any_speed, vvi_vec(0, 0, 0), 2);
    assert_vec(vvi_sub(straight.eye, p.eye), vvi_vec(0.6, 4, -0.4), 1e-12);
}

static void a_stick_is_still_in_its_dead_zone_and_gentle_beside_it(void **state)
{
    (void)state;
    assert_near(vvi_stick(0.1, 0.1), 0, 0);
    assert_near(vvi_stick(-0.05, 0.1), 0, 0);
    assert_near(vvi_stick(1, 0.1), 1, 1e-15);
    assert_near(vvi_stick(-3, 0.1), -1, 1e-15);
    assert_near(vvi_stick(0.55, 0.1), 0.125, 1e-15);
    assert_near(vvi_stick(NAN, 0.1), 0, 0);
}

static void the_way_between_poses_begins_and_ends_at_them(void **state)
{
    (void)state;
    const vvi_pose a = start();
    vvi_pose b = vvi_orbit(&a, 0.2, -0.1, up_z);
    b = vvi_zoom(&b, 0.7, NULL);
    b = vvi_pan(&b, 0.1, 0.2);
    for (int k = 0; k <= 4; k++) {
        const vvi_pose p = vvi_pose_between(&a, &b, k / 4.0);
        assert_near(vvi_pose_distance(&p), 10 * exp(-1.4 * k / 4), 1e-12);
    }
    const vvi_pose first = vvi_pose_between(&a, &b, 0), last = vvi_pose_between(&a, &b, 1);
    const vvi_pose nearly = vvi_pose_between(&a, &b, 1 - 1e-12);
    assert_pose(&first, &a, 0);
    assert_pose(&last, &b, 0);
    assert_pose(&nearly, &b, 1e-9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(turns_are_the_rotations_that_they_should_be),
        cmocka_unit_test(slerp_is_steady_and_goes_the_short_way),
        cmocka_unit_test(a_turntable_turns_once_for_a_drag_across_and_stops_before_the_poles),
        cmocka_unit_test(an_arcball_turns_half_way_from_middle_to_edge_and_closes_every_loop),
        cmocka_unit_test(a_trackball_follows_the_pointer_and_has_no_step_where_its_sheet_begins),
        cmocka_unit_test(the_plane_of_the_pivot_follows_a_pan),
        cmocka_unit_test(a_zoom_keeps_what_lies_under_the_pointer),
        cmocka_unit_test(a_zoom_beyond_what_doubles_hold_does_nothing),
        cmocka_unit_test(a_roll_turns_the_picture_and_nothing_else),
        cmocka_unit_test(flight_in_steps_leads_where_one_long_one_does),
        cmocka_unit_test(a_stick_is_still_in_its_dead_zone_and_gentle_beside_it),
        cmocka_unit_test(the_way_between_poses_begins_and_ends_at_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
