/* Crop: which samples are kept, and that they stay where they are. */
#include "core/memory.h"
#include "fields.h"
#include "jobs.h"
#include "operations.h"
#include "registry.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static vv_field_info info_of(vv_type type, int components)
{
    vv_field_info info = vv_field_info_default();
    info.type = type;
    info.components = components;
    info.grid.dims[0] = 11, info.grid.dims[1] = 7, info.grid.dims[2] = 5;
    info.grid.index_to_world.axis[0] = (vv_vec3){2, 0, 0};
    info.grid.index_to_world.axis[1] = (vv_vec3){0, -0.5, 0};
    info.grid.index_to_world.axis[2] = (vv_vec3){0, 1, 3};
    info.grid.index_to_world.origin = (vv_vec3){10, 20, 30};
    strcpy(info.grid.unit, "mm");
    return info;
}

static vv_vec3 world(const vv_field *f, int64_t i, int64_t j, int64_t k)
{
    return vv_affine_point(vv_field_get_info(f)->grid.index_to_world, (vv_vec3){(double)i, (double)j, (double)k});
}

static void samples_and_places_are_those_of_the_box_for_every_type(void **state)
{
    (void)state;
    const uint64_t seed = test_seed();
    for (int t = 0; t < VV_TYPE_COUNT; t++) {
        const vv_field_info info = info_of((vv_type)t, 1 + t % 4);
        vv_field *in = test_field_random(&info, seed, NULL), *out;
        assert_int_equal(test_apply(&out, &vvi_operation_crop, in, "x=\"3:9\";y=\"1:7\";z=\":4\"", NULL), VV_OK);
        const int64_t *d = vv_field_get_info(out)->grid.dims;
        assert_true(d[0] == 6 && d[1] == 6 && d[2] == 4);
        for (int64_t k = 0; k < d[2]; k++)
            for (int64_t j = 0; j < d[1]; j++)
                for (int64_t i = 0; i < d[0]; i++) {
                    for (int c = 0; c < info.components; c++)
                        assert_true(vv_field_value(out, i, j, k, c) == vv_field_value(in, i + 3, j + 1, k, c));
                    const vv_vec3 a = world(out, i, j, k), b = world(in, i + 3, j + 1, k);
                    assert_true(hypot(hypot(a.x - b.x, a.y - b.y), a.z - b.z) < 1e-12);
                }
        vv_field_release(in);
        vv_field_release(out);
    }
}

static void expect_dims(const char *settings, int64_t x, int64_t y, int64_t z)
{
    const vv_field_info info = info_of(VV_TYPE_U8, 1);
    vv_field *in = test_field_random(&info, 1, NULL), *out;
    assert_int_equal(test_apply(&out, &vvi_operation_crop, in, settings, NULL), VV_OK);
    const int64_t *d = vv_field_get_info(out)->grid.dims;
    if (d[0] != x || d[1] != y || d[2] != z)
        fail_msg("%s gives %d x %d x %d", settings, (int)d[0], (int)d[1], (int)d[2]);
    vv_field_release(in);
    vv_field_release(out);
}

static void ends_may_be_left_out_counted_from_the_end_or_be_lengths(void **state)
{
    (void)state;
    expect_dims(NULL, 11, 7, 5);
    expect_dims("x=\":\"", 11, 7, 5);
    expect_dims("x=\"2:\"", 9, 7, 5);
    expect_dims("x=\"-3:\";y=\":-2\"", 3, 5, 5);
    expect_dims("x=\"4mm:10mm\"", 4, 7, 5);    /* samples 2, 3, 4, 5 lie at 4, 6, 8, 10 mm */
    expect_dims("x=\"4.1mm:9.9mm\"", 2, 7, 5); /* 6 and 8 */
    expect_dims("x=\"0.5cm:100mm\"", 8, 7, 5); /* 6 mm to the end, at 20 */
    expect_dims("y=\"1vox:3vox\"", 11, 3, 5);  /* as lengths: both ends stay */
    expect_dims("z=\"0:1\"", 11, 7, 1);
}

static void wrong_ranges_are_refused_with_a_sentence(void **state)
{
    (void)state;
    const vv_field_info info = info_of(VV_TYPE_U8, 1);
    vv_field *in = test_field_random(&info, 1, NULL), *out;
    static const char *const wrong[] = {
        "x=\"5\"",   "x=\"5:5\"",   "x=\"5:4\"",  "x=\"0:12\"",      "x=\"-12:\"",        "x=\"1:2:3\"",
        "x=\"a:b\"", "x=\"1.5:3\"", "x=\"3lb:\"", "x=\"30mm:40mm\"", "x=\"1e300:1e301\"", "x=\"nan:\"",
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        if (test_apply(&out, &vvi_operation_crop, in, wrong[i], NULL) != VV_E_ARGUMENT)
            fail_msg("%s is taken", wrong[i]);
        assert_true(strlen(vv_error_last()->message) > 10);
    }
    vv_field_release(in);
}

static void thread_count_changes_no_byte_and_failing_allocations_leak_nothing(void **state)
{
    (void)state;
    const vv_field_info info = info_of(VV_TYPE_I16, 3);
    vv_field *in = test_field_random(&info, 1, NULL), *first, *out;
    assert_int_equal(test_apply(&first, &vvi_operation_crop, in, "x=\"1:10\"", NULL), VV_OK);
    for (int threads = 1; threads <= 3; threads++) {
        vv_job *job = test_job(threads, 0);
        assert_int_equal(test_apply(&out, &vvi_operation_crop, in, "x=\"1:10\"", job), VV_OK);
        assert_true(test_same_samples(first, out));
        vv_field_release(out);
        vv_job_release(job);
    }
    vv_object *params = test_params(&vvi_operation_crop, "x=\"1:10\"", &info.grid);
    const vv_field *input = in;
    vv_status st = VV_E_MEMORY;
    for (int n = 1; st != VV_OK && n < 50; n++) {
        vvi_alloc_fail_after(n);
        st = vv_operation_run(&out, &vvi_operation_crop, &input, 1, params, NULL);
        vvi_alloc_fail_after(0);
        vv_field_release(out);
        assert_true(st == VV_OK || st == VV_E_MEMORY);
    }
    assert_int_equal(st, VV_OK);
    vv_object_release(params);
    vv_field_release(first);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_and_places_are_those_of_the_box_for_every_type),
        cmocka_unit_test(ends_may_be_left_out_counted_from_the_end_or_be_lengths),
        cmocka_unit_test(wrong_ranges_are_refused_with_a_sentence),
        cmocka_unit_test(thread_count_changes_no_byte_and_failing_allocations_leak_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
