/* Basins of formulas: where they meet is known. */
#include "fields.h"
#include "grid/field.h"
#include "jobs.h"
#include "operations.h"
#include "registry.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static vv_field *line(vv_type type, const double *values, int n, double scale)
{
    vv_field_info info = vv_field_info_default();
    vv_field *out;
    void *data;
    info.type = type;
    info.grid.dims[0] = n;
    info.value_scale = scale;
    assert_int_equal(vv_field_new_empty(&out, &data, &info, NULL), VV_OK);
    for (int i = 0; i < n; i++) {
        const double stored = values[i] / scale;
        vvi_samples_from_f64((char *)data + (size_t)i * vv_type_bytes(type), &stored, type, 1);
    }
    return out;
}

static void expect_line(const vv_field *in, const char *settings, const char *want)
{
    vv_job *job = test_job(2, 0);
    vv_field *out;
    if (test_apply(&out, &vvi_operation_watershed, in, settings, job) != VV_OK)
        fail_msg("%s: %s", settings, vv_error_last()->message);
    for (int i = 0; want[i]; i++)
        if (vv_field_value(out, i, 0, 0, 0) != want[i] - '0')
            fail_msg("%s: type %d scale %g: sample %d is %g, not %c", settings, (int)vv_field_get_info(in)->type,
                     vv_field_get_info(in)->value_scale, i, vv_field_value(out, i, 0, 0, 0), want[i]);
    vv_field_release(out);
    vv_job_release(job);
}

/* Minima of 1, 3 and 0, between passes at 4 and 8: the one in the middle is 1 deep. */
static void basins_of_a_line_are_as_deep_as_their_pass_is_high(void **state)
{
    (void)state;
    static const double values[] = {5, 1, 1, 4, 3, 8, 2, 0, 6, 9};
    static const vv_type types[] = {VV_TYPE_I16, VV_TYPE_F32, VV_TYPE_F64};
    static const double scales[] = {1, 0.5, -1, -0.25};
    for (int t = 0; t < 3; t++)
        for (int s = 0; s < 4; s++) {
            vv_field *in = line(types[t], values, 10, scales[s]);
            expect_line(in, "", "2222311111");
            expect_line(in, "depth=1", "2222311111");
            expect_line(in, "depth=1.5", "1111122222");
            expect_line(in, "depth=100", "1111111111");
            expect_line(in, "depth=1.5;lines=true", "1111102222");
            expect_line(in, "range=..5;depth=1.5", "1111102200");
            vv_field_release(in);
        }
}

/* Two hills of one height that a plane is as far from: the border of their basins is that plane. */
static double hills(vv_vec3 p)
{
    const double y = p.y - 5, z = p.z - 4, a = p.x - 4, b = p.x - 16;
    return exp(-(a * a + y * y + z * z) / 8) + exp(-(b * b + y * y + z * z) / 8);
}

static void basins_of_two_hills_meet_in_the_plane_between_them(void **state)
{
    (void)state;
    static const test_form form = {.name = "hills", .value = hills};
    vv_field_info info = vv_field_info_default();
    vv_job *job = test_job(2, 0);
    vv_field *out, *in;
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = 21, info.grid.dims[1] = 11, info.grid.dims[2] = 9;
    in = test_field(&form, &info, NULL);
    assert_int_equal(test_apply(&out, &vvi_operation_watershed, in, "bright=true;lines=true;depth=0.01", job), VV_OK);
    for (int64_t k = 0; k < 9; k++)
        for (int64_t j = 0; j < 11; j++)
            for (int64_t i = 0; i < 21; i++)
                assert_int_equal(vv_field_value(out, i, j, k, 0), i < 10 ? 1 : i > 10 ? 2 : 0);
    vv_field_release(out);
    vv_field_release(in);
    vv_job_release(job);
}

enum { N_RANKS = 5 * 6 * 7 };

/* A sample of the type whose rank among the samples is given: the smallest and the largest are the type's own. */
static void put_ranked(void *data, size_t i, uint64_t rank, vv_type type)
{
    const uint64_t between = UINT64_MAX / (N_RANKS - 1) * rank;
    switch (type) {
    case VV_TYPE_U64:
        ((uint64_t *)data)[i] = between;
        break;
    case VV_TYPE_I64:
        ((int64_t *)data)[i] = (int64_t)(between ^ (uint64_t)1 << 63);
        break;
    case VV_TYPE_F64:
        ((double *)data)[i] = ((double)rank - N_RANKS / 2) * 1e300;
        break;
    default:
        ((int16_t *)data)[i] = (int16_t)rank;
        break;
    }
}

static vv_field *ranked(const uint64_t *rank, vv_type type)
{
    vv_field_info info = vv_field_info_default();
    vv_field *out;
    void *data;
    info.type = type;
    info.grid.dims[0] = 5, info.grid.dims[1] = 6, info.grid.dims[2] = 7;
    assert_int_equal(vv_field_new_empty(&out, &data, &info, NULL), VV_OK);
    for (size_t i = 0; i < N_RANKS; i++)
        put_ranked(data, i, rank[i], type);
    return out;
}

/* Basins without a depth know only which samples are higher: what spans all 64 bits has those of its ranks. */
static void basins_hang_on_the_order_of_samples_alone(void **state)
{
    (void)state;
    static const vv_type types[] = {VV_TYPE_U64, VV_TYPE_I64, VV_TYPE_F64};
    uint64_t rank[N_RANKS], random = 1;
    vv_job *job = test_job(2, 0);
    for (size_t i = 0; i < N_RANKS; i++) {
        random = random * 6364136223846793005u + 1442695040888963407u;
        const size_t other = (size_t)(random >> 33) % (i + 1);
        rank[i] = rank[other];
        rank[other] = i;
    }
    for (int bright = 0; bright < 2; bright++) {
        const char *settings = bright ? "bright=true" : "";
        vv_field *of_ranks = ranked(rank, VV_TYPE_I16), *want;
        assert_int_equal(test_apply(&want, &vvi_operation_watershed, of_ranks, settings, job), VV_OK);
        assert_true(vv_field_value(want, 4, 5, 6, 0) >= 1);
        for (int t = 0; t < 3; t++) {
            vv_field *in = ranked(rank, types[t]), *got;
            assert_int_equal(test_apply(&got, &vvi_operation_watershed, in, settings, job), VV_OK);
            for (int64_t i = 0; i < N_RANKS; i++)
                assert_int_equal(vv_field_value(got, i % 5, i / 5 % 6, i / 30, 0),
                                 vv_field_value(want, i % 5, i / 5 % 6, i / 30, 0));
            vv_field_release(got);
            vv_field_release(in);
        }
        vv_field_release(want);
        vv_field_release(of_ranks);
    }
    vv_job_release(job);
}

static void what_makes_no_sense_is_refused(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    vv_field *out, *in;
    info.grid.dims[0] = info.grid.dims[1] = 4;
    in = test_field(&test_form_constant, &info, NULL);
    assert_int_equal(test_apply(&out, &vvi_operation_watershed, in, "depth=-1", NULL), VV_E_ARGUMENT);
    assert_int_equal(test_apply(&out, &vvi_operation_watershed, in, "range=3..2", NULL), VV_E_ARGUMENT);
    vv_field_release(in);
    info.meaning = VV_MEANING_LABEL;
    in = test_field(&test_form_constant, &info, NULL);
    assert_int_equal(test_apply(&out, &vvi_operation_watershed, in, "", NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
    info.meaning = VV_MEANING_SCALAR;
    info.components = 3;
    in = test_field(&test_form_constant, &info, NULL);
    assert_int_equal(test_apply(&out, &vvi_operation_watershed, in, "", NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(basins_of_a_line_are_as_deep_as_their_pass_is_high),
        cmocka_unit_test(basins_of_two_hills_meet_in_the_plane_between_them),
        cmocka_unit_test(basins_hang_on_the_order_of_samples_alone),
        cmocka_unit_test(what_makes_no_sense_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
