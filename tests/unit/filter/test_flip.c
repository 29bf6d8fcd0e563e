/* Flip: order reversed, world unchanged; or mirrored. */
#include "fail_alloc.h"
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
    info.grid.dims[0] = 5, info.grid.dims[1] = 3, info.grid.dims[2] = 4;
    info.grid.index_to_world.axis[0] = (vv_vec3){2, 0.5, 0};
    info.grid.index_to_world.axis[1] = (vv_vec3){0, -0.5, 0};
    info.grid.index_to_world.axis[2] = (vv_vec3){0, 1, 3};
    info.grid.index_to_world.origin = (vv_vec3){10, 20, 30};
    return info;
}

static vv_vec3 world(const vv_field *f, int64_t i, int64_t j, int64_t k)
{
    return vv_affine_point(vv_field_get_info(f)->grid.index_to_world, (vv_vec3){(double)i, (double)j, (double)k});
}

static void every_sample_keeps_its_place_in_the_world(void **state)
{
    (void)state;
    static const char *const axes[] = {"x", "y", "z", "xy", "zx", "y,z", "xyz"};
    for (int t = 0; t < VV_TYPE_COUNT; t++)
        for (size_t a = 0; a < sizeof axes / sizeof *axes; a++) {
            const vv_field_info info = info_of((vv_type)t, 1 + t % 3);
            vv_field *in = test_field_random(&info, 3, NULL), *out;
            char settings[40] = "axes=\"";
            strcat(strcat(settings, axes[a]), "\"");
            assert_int_equal(test_apply(&out, &vvi_operation_flip, in, settings, NULL), VV_OK);
            const bool x = strchr(axes[a], 'x'), y = strchr(axes[a], 'y'), z = strchr(axes[a], 'z');
            for (int64_t k = 0; k < 4; k++)
                for (int64_t j = 0; j < 3; j++)
                    for (int64_t i = 0; i < 5; i++) {
                        const int64_t fi = x ? 4 - i : i, fj = y ? 2 - j : j, fk = z ? 3 - k : k;
                        for (int c = 0; c < info.components; c++)
                            assert_true(vv_field_value(out, fi, fj, fk, c) == vv_field_value(in, i, j, k, c));
                        const vv_vec3 p = world(in, i, j, k), q = world(out, fi, fj, fk);
                        assert_true(hypot(hypot(p.x - q.x, p.y - q.y), p.z - q.z) < 1e-12);
                    }
            vv_field_release(in);
            vv_field_release(out);
        }
}

static void flipping_twice_gives_the_same_field(void **state)
{
    (void)state;
    const vv_field_info info = info_of(VV_TYPE_U16, 1);
    vv_field *in = test_field_random(&info, 3, NULL), *once, *twice;
    assert_int_equal(test_apply(&once, &vvi_operation_flip, in, "axes=\"xz\"", NULL), VV_OK);
    assert_int_equal(test_apply(&twice, &vvi_operation_flip, once, "axes=\"xz\"", NULL), VV_OK);
    assert_false(test_same_samples(in, once));
    assert_true(test_same_samples(in, twice));
    assert_memory_equal(&vv_field_get_info(twice)->grid, &info.grid, sizeof info.grid);
    vv_field_release(in);
    vv_field_release(once);
    vv_field_release(twice);
}

static void mirroring_keeps_the_grid_and_turns_vectors(void **state)
{
    (void)state;
    vv_field_info info = info_of(VV_TYPE_F64, 3);
    info.meaning = VV_MEANING_VECTOR;
    info.grid.index_to_world = vv_affine_identity();
    info.grid.index_to_world.axis[0] = (vv_vec3){0, 2, 0}; /* index x runs along world y */
    info.grid.index_to_world.axis[1] = (vv_vec3){-1, 0, 0};
    vv_field *in = test_field_random(&info, 3, NULL), *out;
    assert_int_equal(test_apply(&out, &vvi_operation_flip, in, "axes=\"x\";mirror=true", NULL), VV_OK);
    assert_memory_equal(&vv_field_get_info(out)->grid, &info.grid, sizeof info.grid);
    static const double sign[3] = {1, -1, 1};
    for (int64_t i = 0; i < 5; i++)
        for (int c = 0; c < 3; c++)
            assert_true(fabs(vv_field_value(out, 4 - i, 1, 2, c) - sign[c] * vv_field_value(in, i, 1, 2, c)) < 1e-9);
    vv_field_release(in);
    vv_field_release(out);
}

static void thread_count_changes_no_byte(void **state)
{
    (void)state;
    vv_field_info info = info_of(VV_TYPE_U8, 3);
    info.grid.dims[0] = 131, info.grid.dims[1] = 67, info.grid.dims[2] = 71;
    vv_field *in = test_field_random(&info, 3, NULL), *first, *out;
    assert_int_equal(test_apply(&first, &vvi_operation_flip, in, "axes=\"xyz\"", NULL), VV_OK);
    for (int threads = 1; threads <= 3; threads++) {
        vv_job *job = test_job(threads, 0);
        assert_int_equal(test_apply(&out, &vvi_operation_flip, in, "axes=\"xyz\"", job), VV_OK);
        assert_true(test_same_samples(first, out));
        vv_field_release(out);
        vv_job_release(job);
    }
    vv_field_release(in);
    vv_field_release(first);
}

/* Bytes go eight at a time, and what is left one by one. */
static void rows_of_any_length_are_reversed(void **state)
{
    (void)state;
    static const int64_t sizes[] = {1, 7, 8, 9, 15, 16, 17, 31};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (int wide = 0; wide < 2; wide++) {
            vv_field_info info = info_of(wide ? VV_TYPE_U16 : VV_TYPE_U8, 1);
            info.grid.dims[0] = sizes[s];
            vv_field *in = test_field_random(&info, s, NULL), *out;
            assert_int_equal(test_apply(&out, &vvi_operation_flip, in, "axes=\"x\"", NULL), VV_OK);
            for (int64_t j = 0; j < info.grid.dims[1]; j++)
                for (int64_t i = 0; i < sizes[s]; i++)
                    assert_true(vv_field_value(out, i, j, 1, 0) == vv_field_value(in, sizes[s] - 1 - i, j, 1, 0));
            vv_field_release(in);
            vv_field_release(out);
        }
}

static void unknown_axes_are_refused(void **state)
{
    (void)state;
    const vv_field_info info = info_of(VV_TYPE_U8, 1);
    vv_field *in = test_field_random(&info, 3, NULL), *out;
    assert_int_equal(test_apply(&out, &vvi_operation_flip, in, "axes=\"w\"", NULL), VV_E_ARGUMENT);
    assert_int_equal(test_apply(&out, &vvi_operation_flip, in, "axes=\"xx\"", NULL), VV_E_ARGUMENT);
    assert_int_equal(test_apply(&out, &vvi_operation_flip, in, "axes=\"\"", NULL), VV_E_ARGUMENT);
    vv_field_release(in);
}

static vv_status act(void *user)
{
    vv_field *out;
    const vv_status st = test_apply(&out, &vvi_operation_flip, user, "axes=\"xz\"", NULL);
    vv_field_release(out);
    return st;
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_U8;
    info.grid.dims[0] = 9;
    vv_field *in = test_field_random(&info, 5, NULL);
    assert_true(test_fail_each_alloc(act, in) >= 4);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_sample_keeps_its_place_in_the_world),
        cmocka_unit_test(flipping_twice_gives_the_same_field),
        cmocka_unit_test(mirroring_keeps_the_grid_and_turns_vectors),
        cmocka_unit_test(thread_count_changes_no_byte),
        cmocka_unit_test(rows_of_any_length_are_reversed),
        cmocka_unit_test(unknown_axes_are_refused),
        cmocka_unit_test(every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
