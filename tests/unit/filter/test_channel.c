/* Channel: picked components, in the order asked for. */
#include "fail_alloc.h"
#include "fields.h"
#include "operations.h"
#include "registry.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static vv_field_info info_of(vv_type type, int components, vv_meaning meaning)
{
    vv_field_info info = vv_field_info_default();
    info.type = type;
    info.components = components;
    info.meaning = meaning;
    info.grid.dims[0] = 7, info.grid.dims[1] = 3, info.grid.dims[2] = 5;
    return info;
}

static void assert_picked(const vv_field *out, const vv_field *in, const int *picks, int n)
{
    assert_int_equal(vv_field_get_info(out)->components, n);
    for (int64_t k = 0; k < 5; k++)
        for (int64_t j = 0; j < 3; j++)
            for (int64_t i = 0; i < 7; i++)
                for (int c = 0; c < n; c++)
                    assert_true(vv_field_value(out, i, j, k, c) == vv_field_value(in, i, j, k, picks[c]));
}

static void components_of_every_type_are_picked_in_the_order_asked_for(void **state)
{
    (void)state;
    for (int t = 0; t < VV_TYPE_COUNT; t++) {
        const vv_field_info info = info_of((vv_type)t, 4, VV_MEANING_SCALAR);
        vv_field *in = test_field_random(&info, 3, NULL), *out;
        assert_int_equal(test_apply(&out, &vvi_operation_channel, in, "components=\"3,0,3\"", NULL), VV_OK);
        assert_picked(out, in, (const int[]){3, 0, 3}, 3);
        vv_field_release(out);
        assert_int_equal(test_apply(&out, &vvi_operation_channel, in, NULL, NULL), VV_OK);
        assert_picked(out, in, (const int[]){0}, 1);
        vv_field_release(out);
        vv_field_release(in);
    }
}

static void parts_of_colours_and_vectors_are_numbers(void **state)
{
    (void)state;
    static const struct {
        vv_meaning from;
        int components;
        const char *picks;
        vv_meaning to;
    } cases[] = {
        {VV_MEANING_RGB, 3, "components=\"1\"", VV_MEANING_SCALAR},
        {VV_MEANING_RGB, 3, "components=\"0,1,2\"", VV_MEANING_RGB},
        {VV_MEANING_RGB, 3, "components=\"2,1,0\"", VV_MEANING_SCALAR},
        {VV_MEANING_RGBA, 4, "components=\"0,1,2\"", VV_MEANING_RGB},
        {VV_MEANING_VECTOR, 3, "components=\"0,1\"", VV_MEANING_SCALAR},
        {VV_MEANING_LABEL, 1, "components=\"0\"", VV_MEANING_LABEL},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const vv_field_info info = info_of(VV_TYPE_U8, cases[i].components, cases[i].from);
        vv_field *in = test_field_random(&info, 3, NULL), *out;
        assert_int_equal(test_apply(&out, &vvi_operation_channel, in, cases[i].picks, NULL), VV_OK);
        assert_int_equal(vv_field_get_info(out)->meaning, cases[i].to);
        vv_field_release(in);
        vv_field_release(out);
    }
}

static void what_is_no_component_is_refused(void **state)
{
    (void)state;
    static const char *const wrong[] = {"3", "-1", "1,,2", "", "0,", "1.5", "red", "12345678901234567890"};
    const vv_field_info info = info_of(VV_TYPE_U8, 3, VV_MEANING_SCALAR);
    vv_field *in = test_field_random(&info, 3, NULL), *out;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char settings[64] = "components=\"";
        strcat(strcat(settings, wrong[i]), "\"");
        assert_int_equal(test_apply(&out, &vvi_operation_channel, in, settings, NULL), VV_E_ARGUMENT);
        assert_non_null(strstr(vv_error_last()->message, "0 to 2"));
    }
    vv_field_release(in);
}

static vv_status act(void *user)
{
    vv_field *out;
    const vv_status st = test_apply(&out, &vvi_operation_channel, user, "components=\"1\"", NULL);
    vv_field_release(out);
    return st;
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    const vv_field_info info = info_of(VV_TYPE_U8, 2, VV_MEANING_SCALAR);
    vv_field *in = test_field_random(&info, 5, NULL);
    assert_true(test_fail_each_alloc(act, in) >= 3);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(components_of_every_type_are_picked_in_the_order_asked_for),
        cmocka_unit_test(parts_of_colours_and_vectors_are_numbers),
        cmocka_unit_test(what_is_no_component_is_refused),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
