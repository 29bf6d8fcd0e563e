/* Sets of triangles: against a list of all of them. */
#include "fail_alloc.h"
#include "filter/corner_set.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

/* A different triangle for each number, whose corners are often those of others. */
static void corners_of(uint32_t out[3], uint32_t i)
{
    out[0] = i % 7;
    out[1] = i / 7 % 11;
    out[2] = i / 77;
}

static void it_has_what_was_added_and_nothing_else(void **state)
{
    (void)state;
    enum { N = 3000 };
    vvi_corner_set set;
    uint32_t c[3];
    assert_int_equal(vvi_corner_set_init(&set, N, NULL), VV_OK);
    for (int twice = 0; twice < 2; twice++)
        for (uint32_t i = 0; i < N; i += 3) {
            corners_of(c, i);
            vvi_corner_set_add(&set, c);
        }
    assert_int_equal(set.n, N / 3);
    for (uint32_t i = 0; i < N; i++) {
        corners_of(c, i);
        assert_int_equal(vvi_corner_set_has(&set, c), i % 3 == 0);
    }
    vvi_corner_set_clear(&set);
    assert_int_equal(set.n, 0);
    corners_of(c, 0);
    assert_false(vvi_corner_set_has(&set, c));
    vvi_corner_set_finish(&set);
}

static void corners_in_another_order_are_another_triangle(void **state)
{
    (void)state;
    vvi_corner_set set;
    assert_int_equal(vvi_corner_set_init(&set, 1, NULL), VV_OK);
    vvi_corner_set_add(&set, (uint32_t[]){1, 2, 3});
    assert_true(vvi_corner_set_has(&set, (uint32_t[]){1, 2, 3}));
    assert_false(vvi_corner_set_has(&set, (uint32_t[]){2, 3, 1}));
    assert_false(vvi_corner_set_has(&set, (uint32_t[]){1, 3, 2}));
    vvi_corner_set_finish(&set);
}

/* What finds no room is left out: asking for it ends. */
static void a_full_one_takes_no_more(void **state)
{
    (void)state;
    vvi_corner_set set;
    uint32_t c[3];
    size_t n = 0;
    assert_int_equal(vvi_corner_set_init(&set, 10, NULL), VV_OK);
    for (uint32_t i = 0; i < 1000; i++) {
        corners_of(c, i);
        vvi_corner_set_add(&set, c);
    }
    for (uint32_t i = 0; i < 1000; i++) {
        corners_of(c, i);
        n += vvi_corner_set_has(&set, c);
    }
    assert_true(set.n >= 10 && n == set.n);
    vvi_corner_set_finish(&set);
}

static vv_status make(void *user)
{
    (void)user;
    vvi_corner_set set = {0};
    const vv_status st = vvi_corner_set_init(&set, 100, NULL);
    vvi_corner_set_finish(&set);
    return st;
}

static void short_memory_is_an_error(void **state)
{
    (void)state;
    assert_int_equal(test_fail_each_alloc(make, NULL), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_has_what_was_added_and_nothing_else),
        cmocka_unit_test(corners_in_another_order_are_another_triangle),
        cmocka_unit_test(a_full_one_takes_no_more),
        cmocka_unit_test(short_memory_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
