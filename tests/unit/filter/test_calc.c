/* Formulas of volumes against the same reckoned sample by sample, for every type, with scales, channels and places. */
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

static vv_field_info info_of(int64_t x, int64_t y, int64_t z, vv_type type, int components)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = x, info.grid.dims[1] = y, info.grid.dims[2] = z;
    info.grid.index_to_world = (vv_affine){{{0.5, 0, 0.1}, {0, 2, 0}, {-0.1, 0, 3}}, {10, -20, 30}};
    info.type = type;
    info.components = components;
    strcpy(info.grid.unit, "mm");
    strcpy(info.value_unit, "HU");
    return info;
}

static vv_status calc(vv_field **out, const vv_field *const *inputs, size_t n, const char *settings, vv_job *job)
{
    vv_object *params = test_params(&vvi_operation_calc, settings, &vv_field_get_info(inputs[0])->grid);
    *out = NULL;
    if (!params)
        return vv_error_last()->status;
    const vv_status st = vv_operation_run(out, &vvi_operation_calc, inputs, n, params, job);
    vv_object_release(params);
    return st;
}

static vv_field *result_of(const vv_field *const *inputs, size_t n, const char *settings, vv_job *job)
{
    vv_field *out;
    if (calc(&out, inputs, n, settings, job) != VV_OK)
        fail_msg("%s: %s", settings, vv_error_last()->message);
    return out;
}

static void refused(const vv_field *const *inputs, size_t n, const char *settings, const char *said, vv_job *job)
{
    vv_field *out;
    if (calc(&out, inputs, n, settings, job) == VV_OK)
        fail_msg("%s is taken", settings);
    if (!strstr(vv_error_last()->message, said))
        fail_msg("%s is answered with: %s", settings, vv_error_last()->message);
}

static void all_types_are_taken_as_values_with_their_scale(void **state)
{
    vv_job *job = test_job(2, 0);
    for (vv_type type = 0; type < VV_TYPE_COUNT; type++) {
        vv_field_info ia = info_of(521, 3, 2, type, 1), ib = info_of(521, 3, 2, VV_TYPE_I16, 1);
        ia.value_scale = 0.5;
        ia.value_offset = -3;
        vv_field *in[2] = {test_field_random(&ia, 1, job), test_field_random(&ib, 2, job)};
        vv_field *out = result_of((const vv_field *const *)in, 2, "formula=\"a - 0.25*b\";type=f64;unit=mm", job);
        const vv_field_info *info = vv_field_get_info(out);
        assert_int_equal(info->type, VV_TYPE_F64);
        assert_string_equal(info->value_unit, "mm");
        assert_true(info->value_scale == 1 && info->value_offset == 0);
        for (int64_t n = 0; n < 521 * 6; n++) {
            const int64_t i = n % 521, j = n / 521 % 3, k = n / 1563;
            const double want = vv_field_value(in[0], i, j, k, 0) - 0.25 * vv_field_value(in[1], i, j, k, 0);
            assert_true(vv_field_value(out, i, j, k, 0) == want);
        }
        vv_field_release(out);
        vv_field_release(in[0]);
        vv_field_release(in[1]);
    }
    vv_job_release(job);
}

static void channels_go_each_by_itself_and_one_with_each(void **state)
{
    vv_job *job = test_job(3, 0);
    const vv_field_info ia = info_of(300, 2, 1, VV_TYPE_F32, 3), ib = info_of(300, 2, 1, VV_TYPE_U8, 1);
    vv_field *in[2] = {test_field_random(&ia, 3, job), test_field_random(&ib, 4, job)};
    vv_field *out = result_of((const vv_field *const *)in, 2, "formula=\"v * (m > 100) + i\";names=\"v,m\"", job);
    assert_int_equal(vv_field_get_info(out)->components, 3);
    for (int64_t n = 0; n < 1800; n++) {
        const int64_t i = n / 3 % 300, j = n / 900;
        const int c = (int)(n % 3);
        const double m = vv_field_value(in[1], i, j, 0, 0);
        const float want = (float)(vv_field_value(in[0], i, j, 0, c) * (m > 100) + (double)i);
        assert_true(vv_field_value(out, i, j, 0, c) == (double)want);
    }
    vv_field_release(out);
    vv_field_release(in[0]);
    vv_field_release(in[1]);
    vv_job_release(job);
}

static void places_are_those_of_the_whole_grid_in_any_box(void **state)
{
    vv_job *job = test_job(2, 0);
    const vv_field_info info = info_of(7, 6, 5, VV_TYPE_U8, 1);
    vv_field *in = test_field_random(&info, 5, job), *part;
    static const char *const formulas[] = {"x", "y", "z", "i", "j", "k"};
    const vv_box box = {{2, 1, 3}, {4, 3, 2}};
    for (int f = 0; f < 6; f++) {
        char settings[64];
        snprintf(settings, sizeof settings, "formula=\"%s\";type=f64", formulas[f]);
        vv_field *whole = result_of((const vv_field *const *)&in, 1, settings, job);
        vv_object *params = test_params(&vvi_operation_calc, settings, &info.grid);
        const vv_field *inputs[] = {in};
        assert_int_equal(vvi_operation_calc.run_box(&part, inputs, 1, params, &box, job), VV_OK);
        for (int64_t n = 0; n < 210; n++) {
            const vv_vec3 at = {(double)(n % 7), (double)(n / 7 % 6), (double)(n / 42)};
            const vv_vec3 p = vv_affine_point(info.grid.index_to_world, at);
            const double want[] = {p.x, p.y, p.z, at.x, at.y, at.z};
            assert_true(fabs(vv_field_value(whole, n % 7, n / 7 % 6, n / 42, 0) - want[f]) < 1e-13);
        }
        for (int64_t n = 0; n < 24; n++) {
            const int64_t i = n % 4, j = n / 4 % 3, k = n / 12;
            assert_true(vv_field_value(part, i, j, k, 0) == vv_field_value(whole, i + 2, j + 1, k + 3, 0));
        }
        vv_field_release(part);
        vv_field_release(whole);
        vv_object_release(params);
    }
    vv_field_release(in);
    vv_job_release(job);
}

static void any_number_of_threads_gives_the_same_bytes(void **state)
{
    const vv_field_info info = info_of(301, 57, 33, VV_TYPE_F32, 1);
    vv_job *one = test_job(1, 0), *three = test_job(3, 0);
    vv_field *in[2] = {test_field_random(&info, 6, one), test_field_random(&info, 7, one)};
    const char *settings = "formula=\"exp(sin(a) * x) + hypot(b, y) ^ 0.3\"";
    vv_field *a = result_of((const vv_field *const *)in, 2, settings, one);
    vv_field *b = result_of((const vv_field *const *)in, 2, settings, three);
    assert_true(test_same_samples(a, b));
    vv_field_release(a);
    vv_field_release(b);
    vv_field_release(in[0]);
    vv_field_release(in[1]);
    vv_job_release(one);
    vv_job_release(three);
}

static void what_does_not_go_is_refused_in_words(void **state)
{
    vv_job *job = test_job(1, 0);
    const vv_field_info info = info_of(5, 4, 3, VV_TYPE_U8, 1), longer = info_of(6, 4, 3, VV_TYPE_U8, 1);
    vv_field_info moved = info, three = info_of(5, 4, 3, VV_TYPE_U8, 3), two = info_of(5, 4, 3, VV_TYPE_U8, 2);
    moved.grid.index_to_world.origin.x += 1;
    vv_field *in = test_field_random(&info, 1, job), *other = test_field_random(&longer, 1, job);
    vv_field *off = test_field_random(&moved, 1, job), *v3 = test_field_random(&three, 1, job);
    vv_field *v2 = test_field_random(&two, 1, job);
    const vv_field *inputs[] = {in, in};
    refused(inputs, 1, "", "calc: the formula is empty", job);
    refused(inputs, 1, "formula=\"a +\"", "calc: column 4: expected a number", job);
    refused(inputs, 1, "formula=\"a + ct\";names=\"cd\"", "calc: column 1: nothing is called 'a'", job);
    refused(inputs, 2, "formula=\"a\"", "calc: the formula does not use 'b'", job);
    refused(inputs, 2, "formula=\"u+u\";names=\"u,u\"", "two volumes are called 'u'", job);
    refused(inputs, 2, "formula=\"u\";names=\"u\"", "names: expected 2", job);
    refused(inputs, 1, "formula=\"u\";names=\"u,v\"", "names: expected 1", job);
    refused(inputs, 1, "formula=\"x\";names=\"x\"", "'x' is the place", job);
    refused(inputs, 1, "formula=\"exp\";names=\"exp\"", "means something else", job);
    refused(inputs, 1, "formula=\"a - 300\";type=u8", "but u8 holds 0 to 255", job);
    refused(inputs, 1, "formula=\"1 / 0\";type=i16", "gives inf at sample 0, 0, 0", job);
    const vv_field *unlike[] = {in, other}, *apart[] = {in, off}, *channels[] = {v3, v2};
    refused(unlike, 2, "formula=\"a+b\"", "expected 5 x 4 x 3 samples", job);
    refused(apart, 2, "formula=\"a+b\"", "expected the first sample at", job);
    refused(channels, 2, "formula=\"a+b\"", "channels", job);
    vv_field_release(in);
    vv_field_release(other);
    vv_field_release(off);
    vv_field_release(v3);
    vv_field_release(v2);
    vv_job_release(job);
}

/* What names a place has no table of its values. */
static void values_that_are_worked_out_once_are_those_of_every_sample(void **state)
{
    static const char *const to[] = {"u8", "i16", "f32", "f64"};
    vv_job *job = test_job(2, 0);
    for (vv_type type = VV_TYPE_U8; type <= VV_TYPE_I16; type++) {
        vv_field_info info =
            info_of(vv_type_bytes(type) == 1 ? 7 : 521, 253, 2, type, vv_type_bytes(type) == 1 ? 3 : 1);
        info.value_scale = 0.25;
        info.value_offset = -2;
        vv_field *in = test_field_random(&info, 5, job);
        for (size_t t = 0; t < sizeof to / sizeof *to; t++) {
            char once[96], each[96];
            snprintf(once, sizeof once, "formula=\"clamp(sqrt(a) + 0.3*a, 0, 99)\";type=%s", to[t]);
            snprintf(each, sizeof each, "formula=\"clamp(sqrt(a) + 0.3*a, 0, 99) + 0*i\";type=%s", to[t]);
            vv_field *got = result_of((const vv_field *const *)&in, 1, once, job);
            vv_field *want = result_of((const vv_field *const *)&in, 1, each, job);
            assert_true(test_same_samples(got, want));
            vv_field_release(got);
            vv_field_release(want);
        }
        refused((const vv_field *const *)&in, 1, "formula=\"a*1000\";type=i16", "the formula gives", job);
        vv_field_release(in);
    }
    vv_job_release(job);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_types_are_taken_as_values_with_their_scale),
        cmocka_unit_test(values_that_are_worked_out_once_are_those_of_every_sample),
        cmocka_unit_test(channels_go_each_by_itself_and_one_with_each),
        cmocka_unit_test(places_are_those_of_the_whole_grid_in_any_box),
        cmocka_unit_test(any_number_of_threads_gives_the_same_bytes),
        cmocka_unit_test(what_does_not_go_is_refused_in_words),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
