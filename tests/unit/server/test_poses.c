/* Where one has stood: back, forward, and what is forgotten. */
#include "server/poses.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static vvi_pose pose_at(double x)
{
    return (vvi_pose){.eye = {x, 0, 10}, .turn = {1, 0, 0, 0}, .fov = 0.5, .height = 1};
}

static void note(vvi_poses *poses, double x)
{
    const vvi_pose pose = pose_at(x);
    vvi_poses_note(poses, &pose);
}

static void expect(vvi_poses *poses, int by, double x)
{
    vvi_pose pose;
    assert_true(vvi_poses_step(&pose, poses, by));
    assert_true(pose.eye.x == x);
}

static void one_goes_back_and_forward(void **state)
{
    (void)state;
    vvi_poses poses = {0};
    vvi_pose pose;
    assert_false(vvi_poses_step(&pose, &poses, -1) || vvi_poses_step(&pose, &poses, 1));
    for (int i = 0; i < 100; i++) {
        note(&poses, i);
        note(&poses, i); /* it has not moved */
    }
    assert_false(vvi_poses_step(&pose, &poses, 1));
    for (int i = 98; i >= 0; i--)
        expect(&poses, -1, i);
    assert_false(vvi_poses_step(&pose, &poses, -1));
    for (int i = 1; i < 100; i++)
        expect(&poses, 1, i);
    vvi_poses_free(&poses);
}

static void the_oldest_are_forgotten(void **state)
{
    (void)state;
    vvi_poses poses = {0};
    vvi_pose pose;
    for (int i = 0; i < 5000; i++)
        note(&poses, i);
    assert_true(poses.room <= 2 * VVI_POSES_MOST);
    for (int i = 4998; i >= 5000 - VVI_POSES_MOST; i--)
        expect(&poses, -1, i);
    assert_false(vvi_poses_step(&pose, &poses, -1));
    vvi_poses_free(&poses);
}

static void a_new_way_ends_the_old_one(void **state)
{
    (void)state;
    vvi_poses poses = {0};
    vvi_pose pose;
    for (int i = 0; i < 4; i++)
        note(&poses, i);
    expect(&poses, -1, 2);
    expect(&poses, -1, 1);
    note(&poses, 1); /* it came to rest where it went back to */
    expect(&poses, 1, 2);
    expect(&poses, -1, 1);
    note(&poses, 7);
    assert_false(vvi_poses_step(&pose, &poses, 1));
    expect(&poses, -1, 1);
    expect(&poses, 1, 7);
    vvi_poses_free(&poses);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_goes_back_and_forward),
        cmocka_unit_test(the_oldest_are_forgotten),
        cmocka_unit_test(a_new_way_ends_the_old_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
