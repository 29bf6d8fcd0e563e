/* Quantities with units. */
#include "core/status.h"
#include "core/units.h"
#include "fields.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static const vv_property_context millimetres = {.length_unit = "mm", .voxel = 0.25};

static void check(const char *text, vv_quantity quantity, double expected)
{
    double value = NAN;
    if (vvi_parse_quantity(&value, text, quantity, &millimetres, "x") != VV_OK)
        fail_msg("%s: %s", text, vv_error_last()->message);
    if (!(fabs(value - expected) <= 1e-15 * fabs(expected)))
        fail_msg("%s is read as %.17g, not %.17g", text, value, expected);
}

static void check_refused(const char *text, vv_quantity quantity, const vv_property_context *context, const char *said)
{
    double value = 7;
    assert_int_equal(vvi_parse_quantity(&value, text, quantity, context, "box.size"), VV_E_ARGUMENT);
    if (!strstr(vv_error_last()->message, said))
        fail_msg("'%s' is answered with: %s", text, vv_error_last()->message);
    assert_int_equal(strncmp(vv_error_last()->message, "box.size: ", 10), 0);
    assert_true(value == 7);
}

static void lengths_become_the_worlds_unit(void **state)
{
    (void)state;
    check("1.5", VV_Q_LENGTH, 1.5);
    check("1.5mm", VV_Q_LENGTH, 1.5);
    check("1.5 mm", VV_Q_LENGTH, 1.5);
    check("-2cm", VV_Q_LENGTH, -20);
    check("1m", VV_Q_LENGTH, 1000);
    check("1e3um", VV_Q_LENGTH, 1);
    check("1\xc2\xb5m", VV_Q_LENGTH, 1e-3);
    check("1\xce\xbcm", VV_Q_LENGTH, 1e-3);
    check("5nm", VV_Q_LENGTH, 5e-6);
    check("5pm", VV_Q_LENGTH, 5e-9);
    check("3A", VV_Q_LENGTH, 3e-7);
    check("3\xc3\x85", VV_Q_LENGTH, 3e-7);
    check("2km", VV_Q_LENGTH, 2e6);
    check("1in", VV_Q_LENGTH, 25.4);
    check("1ft", VV_Q_LENGTH, 304.8);
    check("3vox", VV_Q_LENGTH, 0.75);
}

static void lengths_without_a_real_unit_take_voxels_and_bare_numbers(void **state)
{
    (void)state;
    static const vv_property_context voxels = {.length_unit = "voxel", .voxel = 1}, none = {.voxel = 2};
    double value;
    assert_int_equal(vvi_parse_quantity(&value, "3vox", VV_Q_LENGTH, &voxels, "x"), VV_OK);
    assert_true(value == 3);
    assert_int_equal(vvi_parse_quantity(&value, "3vox", VV_Q_LENGTH, &none, "x"), VV_OK);
    assert_true(value == 6);
    assert_int_equal(vvi_parse_quantity(&value, "3", VV_Q_LENGTH, NULL, "x"), VV_OK);
    assert_true(value == 3);
    check_refused("3mm", VV_Q_LENGTH, &voxels, "lengths here are in voxels");
    check_refused("3mm", VV_Q_LENGTH, NULL, "lengths here are in voxels");
    check_refused("3vox", VV_Q_LENGTH, NULL, "no grid");
}

static void angles_are_degrees_outside_and_radians_inside(void **state)
{
    (void)state;
    check("180", VV_Q_ANGLE, M_PI);
    check("180deg", VV_Q_ANGLE, M_PI);
    check("90\xc2\xb0", VV_Q_ANGLE, M_PI / 2);
    check("0.5rad", VV_Q_ANGLE, 0.5);
    check("0.25turn", VV_Q_ANGLE, M_PI / 2);
}

static void times_sizes_and_ratios_have_their_units(void **state)
{
    (void)state;
    check("2", VV_Q_TIME, 2);
    check("2s", VV_Q_TIME, 2);
    check("250ms", VV_Q_TIME, 0.25);
    check("5us", VV_Q_TIME, 5e-6);
    check("2min", VV_Q_TIME, 120);
    check("1.5h", VV_Q_TIME, 5400);
    check("4096", VV_Q_BYTES, 4096);
    check("8G", VV_Q_BYTES, 8589934592.0);
    check("512M", VV_Q_BYTES, 536870912);
    check("1.5GiB", VV_Q_BYTES, 1610612736);
    check("2k", VV_Q_BYTES, 2048);
    check("1GB", VV_Q_BYTES, 1e9);
    check("1T", VV_Q_BYTES, 1099511627776.0);
    check("50%", VV_Q_RATIO, 0.5);
    check("0.5", VV_Q_RATIO, 0.5);
    check("-1e-3", VV_Q_NONE, -1e-3);
}

static void what_is_no_quantity_is_refused_with_the_units_there_are(void **state)
{
    (void)state;
    check_refused("", VV_Q_LENGTH, &millimetres, "is not a length");
    check_refused("mm", VV_Q_LENGTH, &millimetres, "mm, um");
    check_refused("inf", VV_Q_LENGTH, &millimetres, "is not a length");
    check_refused("1e999", VV_Q_LENGTH, &millimetres, "is not a length");
    check_refused("nan", VV_Q_NONE, &millimetres, "is not a number");
    check_refused("1.5 parsec", VV_Q_LENGTH, &millimetres, "unknown unit 'parsec'");
    check_refused("30mm", VV_Q_ANGLE, &millimetres, "deg, rad, turn");
    check_refused("30deg", VV_Q_LENGTH, &millimetres, "unknown unit 'deg'");
    check_refused("3mm", VV_Q_NONE, &millimetres, "no unit");
    check_refused("5%", VV_Q_NONE, &millimetres, "no unit");
    check_refused("3vox", VV_Q_TIME, &millimetres, "s, ms, us, min, h");
    check_refused("1,5mm", VV_Q_LENGTH, &millimetres,
                  "'1,5mm' is a list; expected one value, a length; decimals follow a point");
    check_refused("-1G", VV_Q_BYTES, &millimetres, "negative");
    check_refused("1e308km", VV_Q_LENGTH, &millimetres, "too large");
}

static void real_units_know_their_metres(void **state)
{
    (void)state;
    assert_true(vvi_length_unit_metres("mm") == 1e-3);
    assert_true(vvi_length_unit_metres("m") == 1);
    assert_true(vvi_length_unit_metres("in") == 0.0254);
    assert_true(vvi_length_unit_metres("vox") == 0);
    assert_true(vvi_length_unit_metres("") == 0);
    assert_true(vvi_length_unit_metres(NULL) == 0);
}

static void check_bytes(uint64_t bytes, const char *expected)
{
    char s[32];
    vvi_print_bytes(s, bytes);
    assert_string_equal(s, expected);
}

static void byte_sizes_are_written_for_people(void **state)
{
    (void)state;
    check_bytes(0, "0 bytes");
    check_bytes(1, "1 byte");
    check_bytes(1023, "1023 bytes");
    check_bytes(1024, "1.0 KiB");
    check_bytes(1536, "1.5 KiB");
    check_bytes(1048575, "1.0 MiB"); /* not 1024.0 KiB */
    check_bytes(UINT64_C(2) << 30, "2.0 GiB");
    check_bytes(UINT64_MAX, "16.0 EiB");
}

static void a_number_with_a_unit_scales_like_the_number(void **state)
{
    (void)state;
    static const char *const units[] = {"m", "cm", "mm", "um", "nm", "pm", "A", "km", "in", "ft"};
    const uint64_t seed = test_seed();
    for (uint64_t i = 0; i < 2000; i++) {
        const char *unit = units[test_random(seed, i) % (sizeof units / sizeof *units)];
        const double number = test_random_unit(seed + 1, i) * 1e6 - 5e5;
        char digits[32], text[64];
        vvi_print_number(digits, number);
        snprintf(text, sizeof text, "%s%s", digits, unit);
        check(text, VV_Q_LENGTH, number * (vvi_length_unit_metres(unit) / 1e-3));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lengths_become_the_worlds_unit),
        cmocka_unit_test(lengths_without_a_real_unit_take_voxels_and_bare_numbers),
        cmocka_unit_test(angles_are_degrees_outside_and_radians_inside),
        cmocka_unit_test(times_sizes_and_ratios_have_their_units),
        cmocka_unit_test(what_is_no_quantity_is_refused_with_the_units_there_are),
        cmocka_unit_test(real_units_know_their_metres),
        cmocka_unit_test(byte_sizes_are_written_for_people),
        cmocka_unit_test(a_number_with_a_unit_scales_like_the_number),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
