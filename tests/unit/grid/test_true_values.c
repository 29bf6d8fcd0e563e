/* Values without a scale: the type is the smallest that holds them, and every sample is stored * scale + offset. */
#include "fail_alloc.h"
#include "fields.h"
#include "grid/true_values.h"
#include "jobs.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

static vv_type chosen(vv_type stored, double scale, double offset, double lo, double hi)
{
    vv_field_info info = vv_field_info_default();
    info.type = stored;
    info.value_scale = scale;
    info.value_offset = offset;
    return vvi_true_values_type(&info, lo, hi, 0);
}

static void the_smallest_type_of_integers_holds_whole_values(void **state)
{
    (void)state;
    assert_int_equal(chosen(VV_TYPE_U16, 1, -1024, 0, 255), VV_TYPE_U8);
    assert_int_equal(chosen(VV_TYPE_U16, 1, -1024, -1, 127), VV_TYPE_I8);
    assert_int_equal(chosen(VV_TYPE_U16, 1, -1024, -1, 128), VV_TYPE_I16);
    assert_int_equal(chosen(VV_TYPE_U16, 1, -1024, 0, 256), VV_TYPE_U16);
    assert_int_equal(chosen(VV_TYPE_U16, 1, -1024, -1024, 64511), VV_TYPE_I32);
    assert_int_equal(chosen(VV_TYPE_U16, 2, 0, 0, 131070), VV_TYPE_U32);
    assert_int_equal(chosen(VV_TYPE_U32, 1, -1, -1, 4294967294.), VV_TYPE_I64);
    assert_int_equal(chosen(VV_TYPE_U32, 2, 0, 0, 8589934590.), VV_TYPE_U64);
    assert_int_equal(chosen(VV_TYPE_U16, 1, 5, INFINITY, -INFINITY), VV_TYPE_U8); /* no sample */
}

static void other_values_are_f32_unless_it_joins_stored_steps(void **state)
{
    (void)state;
    assert_int_equal(chosen(VV_TYPE_I16, 0.5, 0, -16384, 16383.5), VV_TYPE_F32);
    assert_int_equal(chosen(VV_TYPE_I32, 0.5, 0, -8388608, 8388607.5), VV_TYPE_F32); /* 2^23: steps of a half */
    assert_int_equal(chosen(VV_TYPE_I32, 0.5, 0, -8388608, 16777216), VV_TYPE_F64);
    assert_int_equal(chosen(VV_TYPE_U16, 1e-4, 1e6, 1e6, 1e6 + 6.5), VV_TYPE_F64);
    assert_int_equal(chosen(VV_TYPE_F32, 1, -273.15, -73, 77), VV_TYPE_F32);
    assert_int_equal(chosen(VV_TYPE_F32, 1, 1e6, 1e6, 1e6 + 1), VV_TYPE_F64);
    assert_int_equal(chosen(VV_TYPE_F64, 2, 0, 0, 1), VV_TYPE_F64);
    assert_int_equal(chosen(VV_TYPE_I16, 1e36, 0.5, 0, 1e40), VV_TYPE_F64); /* beyond f32 */
}

static void a_format_without_a_type_has_the_next_one(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_U16;
    info.value_offset = -40000;
    const unsigned types = 1u << VV_TYPE_U8 | 1u << VV_TYPE_I16 | 1u << VV_TYPE_U16;
    assert_int_equal(vvi_true_values_type(&info, -3, 100, types), VV_TYPE_I16);
    assert_int_equal(vvi_true_values_type(&info, -40000, 100, types), VV_TYPE_F32);
    info.type = VV_TYPE_U32;
    assert_int_equal(vvi_true_values_type(&info, -40000, 4e9, types), VV_TYPE_F64);
}

static void every_sample_is_its_value(void **state)
{
    (void)state;
    const double scales[][2] = {{1, -1024}, {-3, 7}, {0.37, 2.5}, {1e-4, 1e6}};
    for (int type = 0; type < VV_TYPE_COUNT; type++)
        for (size_t k = 0; k < sizeof scales / sizeof *scales; k++) {
            vv_field_info info = vv_field_info_default();
            info.grid.dims[0] = 67; /* more samples than 16-bit patterns, odd */
            info.grid.dims[1] = 61;
            info.grid.dims[2] = 11;
            info.components = 2;
            info.meaning = VV_MEANING_VECTOR;
            info.type = (vv_type)type;
            info.value_scale = scales[k][0];
            info.value_offset = scales[k][1];
            vv_field *field = test_field_random(&info, test_seed(), NULL), *values;
            assert_non_null(field);
            assert_int_equal(vvi_true_values(&values, (const vv_field *const *)&field, 1, 0, NULL), VV_OK);
            const vv_field_info *made = vv_field_get_info(values);
            assert_false(vvi_has_scale(made));
            for (int n = 0; n < 500; n++) {
                const int64_t x = n * 7 % 67, y = n * 5 % 61, z = n % 11;
                const double want = vv_field_value(field, x, y, z, n % 2);
                const double got = vv_field_value(values, x, y, z, n % 2);
                const double error = made->type == VV_TYPE_F32 ? fabs(want) * 0x1p-24 : 0;
                if (!(fabs(got - want) <= error))
                    fail_msg("%s * %g + %g: %.17g for %.17g", vv_type_name(info.type), scales[k][0], scales[k][1], got,
                             want);
            }
            vv_field_release(values);
            vv_field_release(field);
        }
}

static vv_status of_two(void *user)
{
    vv_field *const *fields = user, *values[2];
    vv_status st = vvi_true_values(values, (const vv_field *const *)fields, 2, 0, NULL);
    for (size_t i = 0; st == VV_OK && i < 2; i++) {
        vv_brick brick;
        const vv_box box = vv_field_box(values[i]);
        const vv_status read = vv_field_brick(&brick, values[i], &box, NULL);
        if (read == VV_OK)
            vv_brick_release(&brick);
        else
            st = read;
    }
    vv_field_release(values[0]);
    vv_field_release(values[1]);
    return st;
}

static void every_failing_allocation_ends_with_nothing(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    info.value_scale = 2;
    vv_field *fields[2] = {test_field_random(&info, 1, NULL), test_field_random(&info, 2, NULL)};
    assert_true(fields[0] && fields[1]);
    assert_true(test_fail_each_alloc(of_two, fields) > 4);
    vv_field_release(fields[0]);
    vv_field_release(fields[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_smallest_type_of_integers_holds_whole_values),
        cmocka_unit_test(other_values_are_f32_unless_it_joins_stored_steps),
        cmocka_unit_test(a_format_without_a_type_has_the_next_one),
        cmocka_unit_test(every_sample_is_its_value),
        cmocka_unit_test(every_failing_allocation_ends_with_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
