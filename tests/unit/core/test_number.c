/* Numbers read and written without the locale. */
#include "core/units.h"
#include "fields.h"
#include "locales.h"

#include <float.h>
#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static uint64_t bits_of(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static double from_bits(uint64_t bits)
{
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void check_round_trip(double value)
{
    char s[32];
    double back = NAN;
    vvi_print_number(s, value);
    assert_true(strlen(s) < 32);
    assert_true(vvi_parse_number(&back, s));
    if (bits_of(back) != bits_of(value))
        fail_msg("%a is printed as %s and read back as %a", value, s, back);
}

static void random_doubles_read_back_equal(void **state)
{
    (void)state;
    const uint64_t seed = test_seed();
    for (uint64_t i = 0; i < 100000; i++) {
        const double any = from_bits(test_random(seed, i)); /* all exponents alike */
        if (isfinite(any))
            check_round_trip(any);
        check_round_trip((test_random_unit(seed + 1, i) - 0.5) * 1000);
    }
}

static void extreme_doubles_read_back_equal(void **state)
{
    (void)state;
    static const double extremes[] = {0.0,     -0.0,  DBL_MIN, DBL_MAX, DBL_TRUE_MIN,   DBL_EPSILON,
                                      0.1,     1e22,  1e23,    1e-5,    123456789012.0, 5e-324,
                                      1.0 / 3, -1e15, 1e16,    M_PI,    1e-300};
    for (size_t i = 0; i < sizeof extremes / sizeof *extremes; i++) {
        check_round_trip(extremes[i]);
        check_round_trip(-extremes[i]);
        if (extremes[i] < DBL_MAX)
            check_round_trip(nextafter(extremes[i], INFINITY));
        check_round_trip(nextafter(extremes[i], -INFINITY));
    }
    for (int e = -1074; e < 1024; e++)
        check_round_trip(ldexp(1, e));
}

static void check_printed(double value, const char *expected)
{
    char s[32];
    vvi_print_number(s, value);
    assert_string_equal(s, expected);
}

static void numbers_are_printed_in_their_shortest_form(void **state)
{
    (void)state;
    check_printed(0.1, "0.1");
    check_printed(0.0, "0");
    check_printed(-0.0, "-0.0");
    check_printed(1, "1");
    check_printed(-2.5, "-2.5");
    check_printed(1e-300, "1e-300");
    check_printed(1e300, "1e300");
    check_printed(1e-5, "1e-5");
    check_printed(5e-324, "5e-324");
    check_printed(1e16, "1e16");
    check_printed(1234567, "1234567");
    check_printed(1.0 / 3, "0.3333333333333333");
    check_printed(0.1 + 0.2, "0.30000000000000004");
    check_printed(DBL_MAX, "1.7976931348623157e308");
    check_printed(-1.5e-7, "-1.5e-7");
    char text[32];
    vvi_print_unsigned_zero(text, -0.0);
    assert_string_equal(text, "0");
}

static void no_decimal_of_up_to_15_digits_grows_when_it_is_printed(void **state)
{
    (void)state;
    const uint64_t seed = test_seed();
    for (uint64_t i = 0; i < 20000; i++) {
        char typed[32], s[32];
        const uint64_t digits = test_random(seed, i) % UINT64_C(1000000000000000);
        snprintf(typed, sizeof typed, "%llue-%d", (unsigned long long)digits, (int)(test_random(seed + 1, i) % 12));
        double value;
        assert_true(vvi_parse_number(&value, typed));
        vvi_print_number(s, value);
        size_t n = 0;
        const char *first = s;
        while (*first == '0' || *first == '.') /* "0.00123" has three */
            first++;
        for (const char *at = first; *at && *at != 'e'; at++)
            n += *at != '.';
        assert_true(n <= 15);
    }
}

static void what_is_no_number_is_never_written_as_one(void **state)
{
    (void)state;
    check_printed(NAN, "null");
    check_printed(INFINITY, "null");
    check_printed(-INFINITY, "null");
}

static void only_whole_texts_are_numbers(void **state)
{
    (void)state;
    static const char *const bad[] = {"",     " ",   "x", "1x", "1 2",   "1,5", "nan", "NAN",
                                      "-nan", "--1", ".", "e5", "1e5.5", "+-1", "0x5", "-0X1p3"};
    double value = 7;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_false(vvi_parse_number(&value, bad[i]));
    assert_true(value == 7); /* untouched */
    assert_true(vvi_parse_number(&value, "-1.5e3") && value == -1500);
    assert_true(vvi_parse_number(&value, "inf") && value == INFINITY);
    assert_true(vvi_parse_number(&value, "-infinity") && value == -INFINITY);
    assert_true(vvi_parse_number(&value, "+.5") && value == 0.5);
    assert_true(vvi_parse_number(&value, "5.") && value == 5);
}

static void scanning_stops_where_the_number_ends(void **state)
{
    (void)state;
    double value;
    const char *text = "1.5mm", *end;
    assert_true(vvi_scan_number(&value, text, &end));
    assert_true(value == 1.5);
    assert_string_equal(end, "mm");
    assert_true(vvi_scan_number(&value, "  3 4", &end));
    assert_true(value == 3);
    assert_string_equal(end, " 4");
    text = "0x10"; /* a size */
    assert_true(vvi_scan_number(&value, text, &end) && value == 0 && end == text + 1);
    text = "mm";
    assert_false(vvi_scan_number(&value, text, &end));
    assert_ptr_equal(end, text);
    text = "nan";
    assert_false(vvi_scan_number(&value, text, &end));
    assert_ptr_equal(end, text);
}

static void a_locale_with_a_comma_changes_nothing(void **state)
{
    (void)state;
    if (!test_comma_locale()) {
        print_message("no locale with a decimal comma is installed, and localedef makes none: not tested\n");
        skip();
    }
    char s[32];
    snprintf(s, sizeof s, "%g", 1.5);
    assert_string_equal(s, "1,5"); /* the locale does what it should */
    double value;
    check_printed(1.5, "1.5");
    assert_true(vvi_parse_number(&value, "2.5") && value == 2.5);
    assert_false(vvi_parse_number(&value, "2,5"));
    for (uint64_t i = 0; i < 1000; i++)
        check_round_trip(test_random_unit(3, i));
    vvi_print_bytes(s, 1536);
    assert_string_equal(s, "1.5 KiB");
    snprintf(s, sizeof s, "%g", 1.5);
    assert_string_equal(s, "1,5"); /* and it is still in force */
    setlocale(LC_ALL, "C");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_doubles_read_back_equal),
        cmocka_unit_test(extreme_doubles_read_back_equal),
        cmocka_unit_test(numbers_are_printed_in_their_shortest_form),
        cmocka_unit_test(no_decimal_of_up_to_15_digits_grows_when_it_is_printed),
        cmocka_unit_test(what_is_no_number_is_never_written_as_one),
        cmocka_unit_test(only_whole_texts_are_numbers),
        cmocka_unit_test(scanning_stops_where_the_number_ends),
        cmocka_unit_test(a_locale_with_a_comma_changes_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
