/* Which name is meant, and the sentence where there is none. */
#include "core/names.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>
#include <volvis/property.h>

static const char *const modes[] = {"maximum", "minimum", "mean"};

static void letter_case_is_no_matter_where_it_alone_differs(void **state)
{
    static const char *const two[] = {"Ab", "aB", "c"};
    (void)state;
    assert_int_equal(vvi_name_find("mean", modes, 3), 2);
    assert_int_equal(vvi_name_find("MeaN", modes, 3), 2);
    assert_int_equal(vvi_name_find("median", modes, 3), 3);
    assert_int_equal(vvi_name_find("aB", two, 3), 1);
    assert_int_equal(vvi_name_find("AB", two, 3), 3);
    assert_int_equal(vvi_name_find("C", two, 3), 2);
}

static void expect_end(const char *typed, const vvi_known *known, const char *want)
{
    vvi_text text = {0};
    vvi_known_add(&text, typed, known);
    assert_string_equal(text.s, want);
    vvi_text_free(&text);
}

static void the_nearest_is_told_and_all_are_listed(void **state)
{
    (void)state;
    expect_end("maximun", &(vvi_known){modes, 3, NULL, NULL},
               "; did you mean 'maximum'? There are maximum, minimum and mean");
    expect_end("nothing", &(vvi_known){modes, 3, "volvis help", NULL}, "; there are maximum, minimum and mean");
    expect_end("nothing", &(vvi_known){modes, 1, NULL, NULL}, "; there is maximum");
    expect_end("nothing", &(vvi_known){modes, 0, NULL, NULL}, "; there are none");
}

static void aliases_stand_behind_their_names_and_may_be_the_nearest(void **state)
{
    static const char *const aliases[] = {"mip", "maximum", "average", "mean", "middle", "mean", NULL};
    (void)state;
    expect_end("nothing", &(vvi_known){modes, 3, NULL, aliases},
               "; there are maximum (or mip), minimum and mean (or average or middle)");
    expect_end("avrage", &(vvi_known){modes, 3, NULL, aliases},
               "; did you mean 'average'? There are maximum (or mip), minimum and mean (or average or middle)");
}

static void of_many_it_says_where_they_are_listed(void **state)
{
    enum { MANY = VVI_KNOWN_LISTED + 1 };
    char name[MANY][8];
    const char *names[MANY];
    vvi_text text = {0};
    (void)state;
    for (int i = 0; i < MANY; i++) {
        snprintf(name[i], sizeof name[i], "name%d", i);
        names[i] = name[i];
    }
    expect_end("xyz", &(vvi_known){names, MANY, "volvis list", NULL}, "; 'volvis list' lists them");
    expect_end("nam7", &(vvi_known){names, MANY, "volvis list", NULL},
               "; did you mean 'name7'? 'volvis list' lists them");
    vvi_known_add(&text, "xyz", &(vvi_known){names, MANY, NULL, NULL});
    assert_non_null(strstr(text.s, "; there are name0, name1, "));
    assert_non_null(strstr(text.s, "name23 and 25 more"));
    vvi_text_free(&text);
}

static void the_failure_has_file_place_and_both(void **state)
{
    (void)state;
    assert_int_equal(
        vvi_fail_name(VV_E_FORMAT, "a.vvh", "3", "meen", &(vvi_known){modes, 3, NULL, NULL}, "no mode '%s'", "meen"),
        VV_E_FORMAT);
    assert_string_equal(vv_error_last()->message,
                        "a.vvh:3: no mode 'meen'; did you mean 'mean'? There are maximum, minimum and mean");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(letter_case_is_no_matter_where_it_alone_differs),
        cmocka_unit_test(the_nearest_is_told_and_all_are_listed),
        cmocka_unit_test(aliases_stand_behind_their_names_and_may_be_the_nearest),
        cmocka_unit_test(of_many_it_says_where_they_are_listed),
        cmocka_unit_test(the_failure_has_file_place_and_both),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
