/* Limits on what comes from outside: defaults, names, values, callers that know fewer. */
#include "core/limits.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <volvis/status.h>

#include <cmocka.h>

static void every_limit_has_a_name_and_can_be_set_to_what_it_is(void **state)
{
    (void)state;
    vv_limits limits;
    const char *name, *doc;
    uint64_t value, found;
    char text[32];
    size_t n = 0;
    vv_limits_init(&limits, sizeof limits);
    assert_memory_equal(&limits, &vvi_limits_default, sizeof limits);
    for (; vv_limits_get(&limits, n, &name, &doc, &value); n++) {
        assert_true(strlen(doc) > 5);
        snprintf(text, sizeof text, "%llu", (unsigned long long)value);
        assert_int_equal(vv_limits_set(&limits, name, text), VV_OK);
        vv_limits_get(&limits, n, &name, &doc, &found);
        assert_int_equal(found, value);
    }
    assert_int_equal((n + 1) * sizeof(uint64_t), sizeof limits); /* every member but the size has a name */
    assert_memory_equal(&limits, &vvi_limits_default, sizeof limits);
}

static void values_are_whole_numbers_or_bytes(void **state)
{
    (void)state;
    static const char *const wrong[][2] = {{"dim", "0"},   {"dim", "-1"},         {"dim", "1.5"},       {"dim", "nan"},
                                           {"dim", ""},    {"dim", "1e300"},      {"dim", "8 apples"},  {"dim", "64X"},
                                           {"files", "x"}, {"header_bytes", "1"}, {"nesting", "100000"}};
    vv_limits limits;
    vv_limits_init(&limits, sizeof limits);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        assert_int_equal(vv_limits_set(&limits, wrong[i][0], wrong[i][1]), VV_E_ARGUMENT);
        assert_non_null(strstr(vv_error_last()->message, wrong[i][0]));
    }
    assert_memory_equal(&limits, &vvi_limits_default, sizeof limits);
    assert_int_equal(vv_limits_set(&limits, "header_bytes", "1M"), VV_OK);
    assert_int_equal(limits.header_bytes, 1 << 20);
    assert_int_equal(vv_limits_set(&limits, "voxels", "3K"), VV_OK); /* counts are decimal */
    assert_true(limits.voxels == 3000);
    assert_int_equal(vv_limits_set(&limits, "file", "5"), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "did you mean 'files'?"));
}

static vv_status make(vv_runtime **out, const vv_limits *limits)
{
    vv_runtime_options options;
    vv_runtime_options_init(&options, sizeof options);
    options.limits = limits;
    return vv_runtime_new(out, &options);
}

static void a_runtime_has_its_own(void **state)
{
    (void)state;
    vv_limits limits;
    vv_runtime *runtime;
    vv_job *job;
    vv_limits_init(&limits, sizeof limits);
    limits.voxels = 17;
    assert_int_equal(make(&runtime, &limits), VV_OK);
    limits.voxels = 18;
    assert_int_equal(vv_job_new(&job, runtime, NULL, NULL), VV_OK);
    assert_int_equal(vvi_job_limits(job)->voxels, 17);
    assert_int_equal(vvi_job_limits(NULL)->voxels, (uint64_t)1 << 40);
    vv_job_release(job);
    vv_runtime_release(runtime);
    limits.nesting = 0;
    assert_int_equal(make(&runtime, &limits), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "nesting"));
    limits.size = 0;
    assert_int_equal(make(&runtime, &limits), VV_E_ARGUMENT);
}

static void callers_that_know_fewer_get_the_defaults_of_the_rest(void **state)
{
    (void)state;
    vv_limits limits;
    const char *name, *doc;
    uint64_t value;
    size_t n = 0;
    memset(&limits, 0xa5, sizeof limits);
    vv_limits_init(&limits, offsetof(vv_limits, files));
    assert_int_equal(limits.files, 0xa5a5a5a5a5a5a5a5);
    while (vv_limits_get(&limits, n, &name, &doc, &value))
        n++;
    assert_int_equal(n, 5);
    assert_int_equal(vv_limits_set(&limits, "files", "3"), VV_E_ARGUMENT);
    assert_int_equal(vv_limits_set(&limits, "dim", "3"), VV_OK);
    vv_runtime *runtime;
    vv_job *job;
    assert_int_equal(make(&runtime, &limits), VV_OK);
    assert_int_equal(vv_job_new(&job, runtime, NULL, NULL), VV_OK);
    assert_int_equal(vvi_job_limits(job)->dim, 3);
    assert_int_equal(vvi_job_limits(job)->files, 65536);
    vv_job_release(job);
    vv_runtime_release(runtime);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_limit_has_a_name_and_can_be_set_to_what_it_is),
        cmocka_unit_test(values_are_whole_numbers_or_bytes),
        cmocka_unit_test(a_runtime_has_its_own),
        cmocka_unit_test(callers_that_know_fewer_get_the_defaults_of_the_rest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
