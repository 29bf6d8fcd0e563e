/* Labels of values by comparing each value as a double, for every type, scale and kind of range. */
#include "fields.h"
#include "grid/field.h"
#include "jobs.h"
#include "operations.h"
#include "registry.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static vv_field_info info_of(int64_t x, int64_t y, int64_t z, vv_type type)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = x, info.grid.dims[1] = y, info.grid.dims[2] = z;
    info.type = type;
    return info;
}

static void try(const vv_field_info *info, double lo, double hi, uint64_t seed, vv_job *job)
{
    char settings[96];
    vv_field *in = test_field_random(info, seed, NULL), *out;
    snprintf(settings, sizeof settings, "range=\"%.17g..%.17g\"", lo, hi);
    if (test_apply(&out, &vvi_operation_threshold, in, settings, job) != VV_OK)
        fail_msg("%s: %s", settings, vv_error_last()->message);
    for (int64_t k = 0; k < info->grid.dims[2]; k++)
        for (int64_t j = 0; j < info->grid.dims[1]; j++)
            for (int64_t i = 0; i < info->grid.dims[0]; i++) {
                const double v = vv_field_value(in, i, j, k, 0);
                if (vv_field_value(out, i, j, k, 0) != (v >= lo && v <= hi))
                    fail_msg("%s %s: %.17g", vv_type_name(info->type), settings, v);
            }
    vv_field_release(in);
    vv_field_release(out);
}

static void samples_are_inside_where_their_values_are(void **state)
{
    (void)state;
    vv_job *job = test_job(3, 0);
    for (int t = 0; t < VV_TYPE_COUNT; t++)
        for (int way = 0; way < 4; way++) {
            vv_field_info info = info_of(137, 5, way, (vv_type)t);
            info.grid.dims[2] = way % 2 ? 1 : 3;
            info.value_scale = way == 1 ? 0.25 : way == 2 ? -2 : 1;
            info.value_offset = way == 3 ? 7 : 0;
            const bool real = vv_type_is_float(info.type);
            const double from = real ? -500 : vvi_type_min(info.type), to = real ? 600 : vvi_type_max(info.type);
            const double a = (from * 0.6137 + to * 0.3863) * info.value_scale,
                         b = (from * 0.1009 + to * 0.8991) * info.value_scale;
            try(&info, fmin(a, b), fmax(a, b), test_seed() + (uint64_t)t, job);
            try(&info, -INFINITY, fmax(a, b), test_seed(), job);
            try(&info, fmin(a, b), INFINITY, test_seed(), job);
            try(&info, 1e30, 1e31, test_seed(), job);
        }
    vv_job_release(job);
}

static const float odd[8] = {NAN, -INFINITY, -1, -0.0F, 0.0F, 1, 2, INFINITY};

static void expect_odd(const char *settings, const char *want)
{
    const vv_field_info info = info_of(8, 1, 1, VV_TYPE_F32);
    vv_field *in, *out;
    assert_int_equal(vv_field_new(&in, &info, odd, 0, NULL, NULL, NULL), VV_OK);
    if (test_apply(&out, &vvi_operation_threshold, in, settings, NULL) != VV_OK)
        fail_msg("%s: %s", settings, vv_error_last()->message);
    for (int i = 0; i < 8; i++)
        if (vv_field_value(out, i, 0, 0, 0) != want[i] - '0')
            fail_msg("%s: sample %d", settings, i);
    vv_field_release(in);
    vv_field_release(out);
}

static void nan_is_nowhere_and_infinity_in_open_ranges(void **state)
{
    (void)state;
    expect_odd("range=0..1", "00011100");
    expect_odd("range=..0", "01111000");
    expect_odd("range=0..", "00011111");
    expect_odd("range=-1..", "00111111");
    expect_odd("range=2", "00000010");
    expect_odd("method=mean", "00000111"); /* of -1, 0, 0, 1 and 2 */
    expect_odd("method=hysteresis;range=-1..1;strong=1..1", "00111100");
}

static void a_scale_in_decimals_means_what_is_typed(void **state)
{
    (void)state;
    vv_field_info info = info_of(10, 1, 1, VV_TYPE_U8);
    const uint8_t samples[10] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
    vv_field *in, *out;
    info.value_scale = 0.1;
    assert_int_equal(vv_field_new(&in, &info, samples, 0, NULL, NULL, NULL), VV_OK);
    assert_int_equal(test_apply(&out, &vvi_operation_threshold, in, "range=0.3..0.7", NULL), VV_OK);
    for (int i = 0; i < 10; i++)
        assert_true(vv_field_value(out, i, 0, 0, 0) == (i >= 3 && i <= 7));
    vv_field_release(in);
    vv_field_release(out);
}

static void any_box_is_a_part_of_the_whole(void **state)
{
    (void)state;
    static const char *const settings[] = {"range=-10..300", "method=otsu", "method=multi-otsu;classes=5"};
    const vv_field_info info = info_of(23, 11, 13, VV_TYPE_F32);
    const vv_box box = {{5, 3, 4}, {7, 6, 5}};
    vv_field *in = test_field_random(&info, 7, NULL);
    for (int s = 0; s < 3; s++) {
        vv_field *whole, *part;
        const vv_field *inputs[] = {in};
        vv_object *params = test_params(&vvi_operation_threshold, settings[s], &info.grid);
        assert_int_equal(test_apply(&whole, &vvi_operation_threshold, in, settings[s], NULL), VV_OK);
        assert_int_equal(vvi_operation_threshold.run_box(&part, inputs, 1, params, &box, NULL), VV_OK);
        for (int64_t at = 0; at < 7 * 6 * 5; at++)
            assert_true(vv_field_value(part, at % 7, at / 7 % 6, at / 42, 0) ==
                        vv_field_value(whole, 5 + at % 7, 3 + at / 7 % 6, 4 + at / 42, 0));
        vv_field_release(whole);
        vv_field_release(part);
        vv_object_release(params);
    }
    vv_field_release(in);
}

static void what_makes_no_sense_is_refused(void **state)
{
    (void)state;
    vv_field_info info = info_of(9, 4, 4, VV_TYPE_U8);
    vv_field *in = test_field_random(&info, 1, NULL), *out;
    static const char *const wrong[] = {"",
                                        "range=3..1",
                                        "range=..",
                                        "range=one",
                                        "method=hysteresis;range=1..9",
                                        "method=hysteresis;range=1..9;strong=8..10",
                                        "method=multi-otsu;classes=33"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(test_apply(&out, &vvi_operation_threshold, in, wrong[i], NULL), VV_E_ARGUMENT);
    vv_field_release(in);
    info.components = 3;
    in = test_field_random(&info, 1, NULL);
    assert_int_equal(test_apply(&out, &vvi_operation_threshold, in, "range=1..", NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
    info.components = 1;
    info.meaning = VV_MEANING_LABEL;
    in = test_field_random(&info, 1, NULL);
    assert_int_equal(test_apply(&out, &vvi_operation_threshold, in, "method=otsu", NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
    in = test_field(&test_form_constant, &info, NULL);
    info.meaning = VV_MEANING_SCALAR;
    vv_field *same;
    assert_int_equal(vvi_field_relabel(&same, in, &info), VV_OK);
    assert_int_equal(test_apply(&out, &vvi_operation_threshold, same, "method=otsu", NULL), VV_E_ARGUMENT);
    vv_field_release(same);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_are_inside_where_their_values_are),
        cmocka_unit_test(nan_is_nowhere_and_infinity_in_open_ranges),
        cmocka_unit_test(a_scale_in_decimals_means_what_is_typed),
        cmocka_unit_test(any_box_is_a_part_of_the_whole),
        cmocka_unit_test(what_makes_no_sense_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
