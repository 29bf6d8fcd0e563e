/* The worked example of docs/adding-an-operation.md does what the page says. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
/* cmocka wants those first */
#include "operation_negative.h"
#include <cmocka.h>
#include <string.h>
#include <volvis/volvis.h>

static vv_job *new_job(int threads)
{
    vv_runtime_options options;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = threads;
    vv_runtime *runtime;
    vv_job *job;
    assert_int_equal(vv_runtime_new(&runtime, &options), VV_OK);
    assert_int_equal(vv_job_new(&job, runtime, NULL, NULL), VV_OK);
    vv_runtime_release(runtime);
    return job;
}

static vv_field *new_field(const vv_field_info *info, const void *samples, vv_job *job)
{
    vv_field *field;
    assert_int_equal(vv_field_new(&field, info, samples, 0, NULL, NULL, job), VV_OK);
    return field;
}

static vv_field *negative_of(const vv_field *field, const char *white, vv_job *job)
{
    const vv_property_context context = {0};
    vv_object *params;
    vv_field *out;
    assert_int_equal(vv_object_new(&params, operation_negative.params, &context), VV_OK);
    if (white)
        assert_int_equal(vv_path_set(&params, "white", white, &context), VV_OK);
    assert_int_equal(vv_operation_run(&out, &operation_negative, (const vv_field *const[]){field}, 1, params, job),
                     VV_OK);
    vv_object_release(params);
    return out;
}

static void a_byte_becomes_255_minus_itself(void **state)
{
    uint8_t samples[3 * 5 * 7];
    for (size_t i = 0; i < sizeof samples; i++)
        samples[i] = (uint8_t)(i * 2);
    vv_field_info info = vv_field_info_default();
    memcpy(info.grid.dims, (int64_t[3]){3, 5, 7}, sizeof info.grid.dims);
    for (int threads = 1; threads <= 3; threads++) {
        vv_job *job = new_job(threads);
        vv_field *field = new_field(&info, samples, job), *out = negative_of(field, NULL, job);
        for (int64_t i = 0; i < 3 * 5 * 7; i++)
            assert_true(vv_field_value(out, i % 3, i / 3 % 5, i / 15, 0) == 255 - samples[i]);
        vv_field_release(out);
        vv_field_release(field);
        vv_job_release(job);
    }
}

static void values_are_negated_and_not_what_is_stored(void **state)
{
    static const int16_t samples[4] = {-100, 0, 7, 300};
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_I16;
    info.grid.dims[0] = 4;
    info.value_scale = 0.5;
    info.value_offset = 10;
    vv_job *job = new_job(1);
    vv_field *field = new_field(&info, samples, job), *out = negative_of(field, "100", job);
    for (int i = 0; i < 4; i++)
        assert_true(vv_field_value(out, i, 0, 0, 0) == 100 - (samples[i] * 0.5 + 10));
    vv_field_release(out);
    vv_field_release(field);
    vv_job_release(job);
}

static void an_unknown_parameter_is_answered_with_the_real_one(void **state)
{
    const vv_property_context context = {0};
    vv_object *params;
    assert_int_equal(vv_object_new(&params, operation_negative.params, &context), VV_OK);
    assert_int_equal(vv_path_set(&params, "wite", "1", &context), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "white"));
    vv_object_release(params);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_byte_becomes_255_minus_itself),
        cmocka_unit_test(values_are_negated_and_not_what_is_stored),
        cmocka_unit_test(an_unknown_parameter_is_answered_with_the_real_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
