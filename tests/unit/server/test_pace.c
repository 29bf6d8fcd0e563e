/* Sizes of frames while a view moves, and which of them is sent. */
#include "server/pace.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { W = 1280, H = 720 };

static int64_t next_pixels(vvi_pace *pace)
{
    int32_t size[2];
    vvi_pace_size(size, pace, W, H);
    return (int64_t)size[0] * size[1];
}

/* A machine that needs so many seconds for a full frame, and a line of so many. */
static int64_t settle(vvi_pace *pace, double full, double travel, int frames)
{
    int64_t pixels = 0;
    for (int i = 0; i < frames; i++) {
        pixels = next_pixels(pace);
        vvi_pace_took(pace, pixels, full * (double)pixels / (W * H), travel);
    }
    return pixels;
}

/* Before it is known what a pixel takes, and where a picture has more of them than screens have. */
static void frames_of_immense_views_are_small(void **state)
{
    (void)state;
    vvi_pace pace;
    int32_t size[2];
    vvi_pace_init(&pace, 0.033);
    vvi_pace_size(size, &pace, 8192, 8192);
    assert_true(size[0] * size[1] <= 1 << 18);
    for (int i = 0; i < 20; i++) {
        vvi_pace_took(&pace, size[0] * size[1], 1e-6 * size[0] * size[1], 0.001);
        vvi_pace_size(size, &pace, 8192, 8192);
    }
    assert_true(size[0] * size[1] <= 1 << 16);
}

static void frames_are_as_large_as_time_allows(void **state)
{
    (void)state;
    vvi_pace pace;
    vvi_pace_init(&pace, 0.033);
    assert_int_equal(settle(&pace, 0.01, 0.002, 20), W * H);
    const int64_t slow = settle(&pace, 0.2, 0.005, 30); /* 28 ms are left: a seventh of the pixels at most */
    assert_true((double)slow <= 0.14 * W * H);
    assert_true((double)slow >= 0.8 * 0.14 / sqrt(2) * W * H);
    assert_int_equal(settle(&pace, 0.001, 0.001, 30), W * H);
    settle(&pace, 100, 0, 30);
    assert_int_equal(pace.step, VVI_PACE_STEPS);
    vvi_pace_init(&pace, 0.033);
    vvi_pace_took(&pace, 100, NAN, 0);
    vvi_pace_took(&pace, 0, 1, 0);
    assert_true(pace.pixel == 0);
}

/* Times that tremble by a tenth do not make the size tremble. */
static void sizes_do_not_flutter(void **state)
{
    (void)state;
    for (int full = 35; full < 400; full += 7) {
        vvi_pace pace;
        vvi_pace_init(&pace, 0.033);
        settle(&pace, full / 1000.0, 0.002, 60);
        int changes = 0, before = pace.step;
        for (int i = 0; i < 200; i++) {
            settle(&pace, full / 1000.0 * (i % 2 ? 1.1 : 0.9), 0.002, 1);
            changes += pace.step != before;
            before = pace.step;
        }
        assert_in_range(changes, 0, 2);
    }
}

static void a_tiny_view_has_a_pixel(void **state)
{
    (void)state;
    vvi_pace pace;
    int32_t size[2];
    vvi_pace_init(&pace, 0.033);
    vvi_pace_took(&pace, 1, 10, 10);
    vvi_pace_size(size, &pace, 1, 3);
    assert_int_equal(size[0], 1);
    assert_int_equal(size[1], 1);
}

static void one_frame_is_under_way_and_the_newest_waits(void **state)
{
    (void)state;
    vvi_outbox box = {0};
    assert_int_equal(vvi_outbox_send(&box, 0), 0);
    assert_int_equal(vvi_outbox_put(&box, 1), 0);
    assert_int_equal(vvi_outbox_send(&box, 1000), 1);
    assert_int_equal(vvi_outbox_put(&box, 2), 0);
    assert_int_equal(vvi_outbox_send(&box, 2000), 0); /* the page has not said that it has the first */
    assert_int_equal(vvi_outbox_put(&box, 3), 2);
    assert_true(vvi_outbox_acknowledge(&box, 2, 3000) < 0);
    assert_true(vvi_outbox_acknowledge(&box, 0, 3000) < 0);
    assert_false(vvi_outbox_is_stuck(&box, 30, INT64_C(29900000000)));
    assert_true(vvi_outbox_is_stuck(&box, 30, INT64_C(30100000000)));
    assert_true(fabs(vvi_outbox_acknowledge(&box, 1, 5001000) - 0.005) < 1e-12);
    assert_int_equal(vvi_outbox_send(&box, 6000), 3);
    assert_false(vvi_outbox_is_stuck(&(vvi_outbox){0}, 0, INT64_MAX));
}

static void who_reads_ten_kilobytes_a_second_is_slow_but_there(void **state)
{
    (void)state;
    const int64_t second = INT64_C(1000000000);
    vvi_outbox box = {0};
    vvi_outbox_wrote(&box, 50000000); /* long ago, to a page that wants no frames */
    vvi_outbox_put(&box, 1);
    assert_int_equal(vvi_outbox_send(&box, 0), 1);
    vvi_outbox_wrote(&box, 500000);
    assert_false(vvi_outbox_is_stuck(&box, 30, 79 * second));
    assert_true(vvi_outbox_is_stuck(&box, 30, 110 * second));
    assert_true(vvi_outbox_acknowledge(&box, 1, 80 * second) > 0);
    vvi_outbox_put(&box, 2);
    assert_int_equal(vvi_outbox_send(&box, 100 * second), 2);
    vvi_outbox_wrote(&box, 1000);
    assert_true(vvi_outbox_is_stuck(&box, 30, 131 * second));
}

static void a_picture_at_rest_has_what_a_thin_line_carries_soon(void **state)
{
    (void)state;
    vvi_pace pace;
    vvi_pace_init(&pace, 0.033);
    assert_true(vvi_pace_room(&pace) == SIZE_MAX);
    vvi_pace_carried(&pace, 3000, 0.001, 0.001); /* too small to tell */
    vvi_pace_carried(&pace, 30000, 0, 0);
    assert_true(vvi_pace_room(&pace) == SIZE_MAX);
    for (int i = 0; i < 3; i++) {
        vvi_pace_carried(&pace, 100000, 10, 10);
        assert_in_range(vvi_pace_room(&pace), 49999, 50010);
    }
    vvi_pace_carried(&pace, 20000, 0.002, 0.002); /* it was the page, not the line */
    assert_true(vvi_pace_room(&pace) > 40000000);
    vvi_pace_carried(&pace, 100000, 10, 10); /* once */
    assert_true(vvi_pace_room(&pace) > 40000000);
    vvi_pace_carried(&pace, 100000, 10, 10);
    assert_in_range(vvi_pace_room(&pace), 49999, 50010);
    assert_true(vvi_pace_carries(&pace, 99999) && !vvi_pace_carries(&pace, 101000));
}

/* It gets none but small pictures, each less than what a line's speed is told by. */
static void a_line_that_is_mended_is_found_so_by_small_pictures(void **state)
{
    (void)state;
    vvi_pace pace;
    vvi_pace_init(&pace, 0.033);
    vvi_pace_carried(&pace, 128000, 16, 16);
    assert_true(vvi_pace_room(&pace) < 40001);
    for (int i = 0; i < 10; i++) {
        vvi_pace_carried(&pace, 10000, 6, 6); /* no faster */
        assert_true(vvi_pace_room(&pace) < 40001);
    }
    for (int i = 0; i < 11; i++) /* less than a second of the line, each, but one behind the other */
        assert_true(vvi_pace_carried(&pace, 3000, 0.01, 0.05) == (i == 10));
    assert_in_range(vvi_pace_room(&pace), 290000, 310000);
}

/* At rest there is one: the line may be twice as fast, which the next, of twice the bytes, shows. */
static void a_picture_alone_shows_that_a_line_may_be_twice_as_fast(void **state)
{
    (void)state;
    vvi_pace pace;
    vvi_pace_init(&pace, 0.033);
    vvi_pace_carried(&pace, 100000, 10, 10);
    assert_false(vvi_pace_carried(&pace, 4000, 0.01, 60)); /* the first bytes come at once in any case */
    assert_false(vvi_pace_carried(&pace, 9000, 0.9, 60));
    assert_true(vvi_pace_carried(&pace, 9000, 0.01, 60));
    assert_in_range(vvi_pace_room(&pace), 99990, 100010);
    assert_true(vvi_pace_carried(&pace, 15000, 0.01, 0.1));
    assert_in_range(vvi_pace_room(&pace), 199990, 200010);
}

/* 10 kB a second, and 10 kB at once after a pause, as lines are that are shared. */
static void a_line_that_begins_fast_is_not_taken_for_a_fast_one(void **state)
{
    (void)state;
    vvi_pace pace;
    vvi_pace_init(&pace, 0.033);
    vvi_pace_carried(&pace, 100000, 10, 10);
    for (int i = 0; i < 100; i++) {
        vvi_pace_carried(&pace, 3000, 0.001, 2); /* after a pause */
        vvi_pace_carried(&pace, 3000, 0.001, 0.1);
        vvi_pace_carried(&pace, 3000, 0.001, 0.1);
        for (int k = 0; k < 10; k++)
            vvi_pace_carried(&pace, 3000, 0.3, 0.3);
        assert_in_range(vvi_pace_room(&pace), 49999, 75000);
    }
}

static void a_page_that_has_much_to_do_is_no_thin_line(void **state)
{
    (void)state;
    vvi_pace pace;
    vvi_pace_init(&pace, 0.033);
    for (int i = 0; i < 20; i++)
        vvi_pace_carried(&pace, 5000, 2, 2); /* whatever comes takes two seconds */
    vvi_pace_carried(&pace, 20000, 2, 2);
    vvi_pace_carried(&pace, 100000, 2, 2); /* of a whole that is not yet known to be carried */
    assert_true(vvi_pace_carries(&pace, 900000));
    vvi_pace_carried(&pace, 800000, 10, 10); /* eight for these bytes */
    vvi_pace_carried(&pace, 800000, 10, 10);
    assert_in_range(vvi_pace_room(&pace), 490000, 510000);
    vvi_pace_init(&pace, 0.033);
    vvi_pace_carried(&pace, 2000, 12, 12); /* behind a hundred kilobytes of texts */
    vvi_pace_carried(&pace, 20000, 2, 2);
    assert_false(vvi_pace_carries(&pace, 220000));
    vvi_pace_carried(&pace, 2000, 0.2, 0.2);
    vvi_pace_carried(&pace, 20000, 2, 2);
    vvi_pace_carried(&pace, 20000, 2, 2);
    assert_in_range(vvi_pace_room(&pace), 50000, 56000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_are_as_large_as_time_allows),
        cmocka_unit_test(frames_of_immense_views_are_small),
        cmocka_unit_test(sizes_do_not_flutter),
        cmocka_unit_test(a_tiny_view_has_a_pixel),
        cmocka_unit_test(one_frame_is_under_way_and_the_newest_waits),
        cmocka_unit_test(who_reads_ten_kilobytes_a_second_is_slow_but_there),
        cmocka_unit_test(a_picture_at_rest_has_what_a_thin_line_carries_soon),
        cmocka_unit_test(a_line_that_is_mended_is_found_so_by_small_pictures),
        cmocka_unit_test(a_picture_alone_shows_that_a_line_may_be_twice_as_fast),
        cmocka_unit_test(a_line_that_begins_fast_is_not_taken_for_a_fast_one),
        cmocka_unit_test(a_page_that_has_much_to_do_is_no_thin_line),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
