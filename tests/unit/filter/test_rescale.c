/* Rescale: the map of values, types, clamping and kept values. */
#include "fail_alloc.h"
#include "fields.h"
#include "grid/field.h"
#include "jobs.h"
#include "operations.h"
#include "registry.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static vv_field *row_of(const double *values, int64_t n, vv_type type, double scale, double offset)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = n;
    info.type = type;
    info.value_scale = scale;
    info.value_offset = offset;
    strcpy(info.value_unit, "HU");
    vv_field *field;
    void *data;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    vvi_samples_from_f64(data, values, type, (size_t)n);
    return field;
}

static vv_field *rescaled(const vv_field *in, const char *settings)
{
    vv_field *out;
    if (test_apply(&out, &vvi_operation_rescale, in, settings, NULL) != VV_OK)
        fail_msg("%s: %s", settings, vv_error_last()->message);
    return out;
}

static void expect(const vv_field *f, int64_t i, double want)
{
    const double got = vv_field_value(f, i, 0, 0, 0);
    if (!(fabs(got - want) <= 1e-9 * fmax(1, fabs(want))))
        fail_msg("sample %d is %.17g, not %.17g", (int)i, got, want);
}

static void the_range_of_the_data_becomes_the_range_of_the_type(void **state)
{
    (void)state;
    static const double v[] = {-100, 0, 100, 300};
    for (int t = 0; t < VV_TYPE_COUNT; t++) {
        char settings[40];
        vv_field *in = row_of(v, 4, VV_TYPE_I16, 1, 0);
        strcat(strcpy(settings, "type="), vv_type_name((vv_type)t));
        vv_field *out = rescaled(in, settings);
        assert_int_equal(vv_field_get_info(out)->type, t);
        const bool real = vv_type_is_float((vv_type)t);
        expect(out, 0, real ? 0 : vvi_type_min((vv_type)t));
        expect(out, 3, real ? 1 : vvi_type_max((vv_type)t));
        assert_string_equal(vv_field_get_info(out)->value_unit, "");
        vv_field_release(in);
        vv_field_release(out);
    }
}

static void values_map_linearly_round_and_clamp(void **state)
{
    (void)state;
    static const double v[] = {-50, 0, 10, 33, 100, 200};
    for (int t = 0; t < 2; t++) { /* through a table, and one by one */
        vv_field *in = row_of(v, 6, t ? VV_TYPE_F32 : VV_TYPE_I16, 1, 0);
        vv_field *out = rescaled(in, "type=u8;from=[0,100];to=[10,20]");
        static const double want[] = {10, 10, 11, 13, 20, 20};
        for (int i = 0; i < 6; i++)
            expect(out, i, want[i]);
        vv_field *open = rescaled(in, "type=f64;from=[0,100];to=[10,20];clamp=false");
        for (int i = 0; i < 6; i++)
            expect(open, i, 10 + v[i] / 10);
        vv_field *turned = rescaled(in, "type=f32;from=[100,0];to=[0,1]");
        expect(turned, 1, 1);
        expect(turned, 5, 0);
        vv_field_release(in);
        vv_field_release(out);
        vv_field_release(open);
        vv_field_release(turned);
    }
}

static void the_range_is_of_values_not_of_stored_numbers(void **state)
{
    (void)state;
    static const double stored[] = {0, 512, 1024, 2048};
    vv_field *in = row_of(stored, 4, VV_TYPE_U16, 2, -1024); /* values -1024, 0, 1024, 3072 */
    vv_field *out = rescaled(in, "type=f64;from=[0,1024];to=[0,1]");
    expect(out, 0, 0);
    expect(out, 1, 0);
    expect(out, 2, 1);
    vv_field *kept = rescaled(in, "type=u8;keep_values=true");
    for (int i = 0; i < 4; i++)
        assert_true(fabs(vv_field_value(kept, i, 0, 0, 0) - vv_field_value(in, i, 0, 0, 0)) <= 4096.0 / 255 / 2 + 1e-9);
    expect(kept, 0, -1024);
    expect(kept, 3, 3072);
    assert_string_equal(vv_field_get_info(kept)->value_unit, "HU");
    vv_field_release(in);
    vv_field_release(out);
    vv_field_release(kept);
}

static void percentiles_cut_off_outliers(void **state)
{
    (void)state;
    double v[1001];
    for (int i = 0; i < 1000; i++)
        v[i] = i;
    v[1000] = 60000;
    vv_field *in = row_of(v, 1001, VV_TYPE_F32, 1, 0), *out = rescaled(in, "type=f32;percentile=[10,90]");
    expect(out, 0, 0);
    expect(out, 999, 1);
    expect(out, 500, 0.5); /* 100 to 900, whatever the outlier is */
    vv_field_release(in);
    vv_field_release(out);
}

static void a_constant_field_and_missing_samples_have_a_defined_end(void **state)
{
    (void)state;
    static const double same[] = {7, 7, 7}, odd[] = {0, NAN, 10};
    vv_field *in = row_of(same, 3, VV_TYPE_F32, 1, 0), *out = rescaled(in, "type=u8");
    expect(out, 1, 0);
    vv_field_release(out);
    out = rescaled(in, "type=u8;keep_values=true");
    expect(out, 1, 7);
    vv_field_release(in);
    vv_field_release(out);
    in = row_of(odd, 3, VV_TYPE_F64, 1, 0);
    out = rescaled(in, "type=f32");
    assert_true(isnan(vv_field_value(out, 1, 0, 0, 0)));
    expect(out, 2, 1);
    vv_field_release(out);
    out = rescaled(in, "type=u8");
    expect(out, 1, 0);
    vv_field_release(in);
    vv_field_release(out);
}

static void the_identity_keeps_every_number_of_every_integer_type(void **state)
{
    (void)state;
    static const double v[] = {0, 1, 2, 100, 127};
    for (int t = 0; t < VV_TYPE_COUNT; t++) {
        vv_field *in = row_of(v, 5, (vv_type)t, 1, 0);
        vv_field *out = rescaled(in, "from=[0,127];to=[0,127]");
        assert_true(test_same_samples(in, out));
        assert_string_equal(vv_field_get_info(out)->value_unit, "HU");
        vv_field_release(in);
        vv_field_release(out);
    }
}

static void contradictions_are_refused(void **state)
{
    (void)state;
    static const double v[] = {0, 1};
    vv_field *in = row_of(v, 2, VV_TYPE_U8, 1, 0), *out;
    static const char *const wrong[] = {
        "from=[0,1];percentile=[1,99]", "from=[3,3]",         "from=[1]", "to=[1,2,3]",
        "percentile=[50,40]",           "percentile=[-1,40]", "type=u7",  "to=[5,5];keep_values=true"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        if (test_apply(&out, &vvi_operation_rescale, in, wrong[i], NULL) != VV_E_ARGUMENT)
            fail_msg("%s is taken", wrong[i]);
    vv_field_release(in);
}

static void labels_are_not_rescaled(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    info.meaning = VV_MEANING_LABEL;
    vv_field *in = test_field_random(&info, 1, NULL), *out;
    assert_int_equal(test_apply(&out, &vvi_operation_rescale, in, NULL, NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
}

static void thread_count_changes_no_byte(void **state)
{
    (void)state;
    for (int t = 0; t < VV_TYPE_COUNT; t++) {
        vv_field_info info = vv_field_info_default();
        info.type = (vv_type)t;
        info.components = 1 + t % 2;
        info.grid.dims[0] = 97, info.grid.dims[1] = 89, info.grid.dims[2] = 83;
        vv_field *in = test_field_random(&info, 9, NULL), *first, *out;
        assert_int_equal(test_apply(&first, &vvi_operation_rescale, in, "type=u16", NULL), VV_OK);
        for (int threads = 2; threads <= 3; threads++) {
            vv_job *job = test_job(threads, 0);
            assert_int_equal(test_apply(&out, &vvi_operation_rescale, in, "type=u16", job), VV_OK);
            assert_true(test_same_samples(first, out));
            vv_field_release(out);
            vv_job_release(job);
        }
        vv_field_release(in);
        vv_field_release(first);
    }
}

static vv_status act(void *user)
{
    vv_field *out;
    const vv_status st = test_apply(&out, &vvi_operation_rescale, user, "type=u16", NULL);
    vv_field_release(out);
    return st;
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_I16;
    info.grid.dims[0] = 9;
    vv_field *in = test_field_random(&info, 5, NULL);
    assert_true(test_fail_each_alloc(act, in) >= 4);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_range_of_the_data_becomes_the_range_of_the_type),
        cmocka_unit_test(values_map_linearly_round_and_clamp),
        cmocka_unit_test(the_range_is_of_values_not_of_stored_numbers),
        cmocka_unit_test(percentiles_cut_off_outliers),
        cmocka_unit_test(a_constant_field_and_missing_samples_have_a_defined_end),
        cmocka_unit_test(the_identity_keeps_every_number_of_every_integer_type),
        cmocka_unit_test(contradictions_are_refused),
        cmocka_unit_test(labels_are_not_rescaled),
        cmocka_unit_test(thread_count_changes_no_byte),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
