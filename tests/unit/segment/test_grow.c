/* Parts that grow from points, where their shape is a formula. */
#include "fields.h"
#include "jobs.h"
#include "operations.h"
#include "registry.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

/* Distance from (7, 8, 9) minus 5, on a grid of spacing 0.5 from the origin. */
static vv_field *sphere(vv_type type, double scale)
{
    vv_field_info info = vv_field_info_default();
    for (int a = 0; a < 3; a++) {
        info.grid.dims[a] = 33 + a;
        *(&info.grid.index_to_world.axis[a].x + a) = 0.5;
    }
    strcpy(info.grid.unit, "mm");
    info.type = type;
    info.value_scale = scale;
    return test_field(&test_form_sphere, &info, NULL);
}

static vv_field *grown(const vv_field *in, const char *settings)
{
    vv_job *job = test_job(2, 0);
    vv_field *out;
    if (test_apply(&out, &vvi_operation_grow, in, settings, job) != VV_OK)
        fail_msg("%s: %s", settings, vv_error_last()->message);
    vv_job_release(job);
    return out;
}

static void expect_ball(const char *settings, vv_type type, double scale, double lo, double hi)
{
    vv_field *in = sphere(type, scale), *out = grown(in, settings);
    for (int64_t k = 0; k < 35; k++)
        for (int64_t j = 0; j < 34; j++)
            for (int64_t i = 0; i < 33; i++) {
                const double v = vv_field_value(in, i, j, k, 0);
                if (vv_field_value(out, i, j, k, 0) != (v >= lo && v <= hi))
                    fail_msg("%s: %d %d %d", settings, (int)i, (int)j, (int)k);
            }
    vv_field_release(in);
    vv_field_release(out);
}

static void a_ball_grows_from_its_middle(void **state)
{
    (void)state;
    expect_ball("seed=[14,16,18];range=..-1.1", VV_TYPE_F64, 1, -INFINITY, -1.1);
    expect_ball("seed=[7,8,9];space=world;range=..-1.1", VV_TYPE_F32, 1, -INFINITY, -1.1);
    expect_ball("seed=[14,16,18];range=-6..-2;connectivity=26", VV_TYPE_I16, 0.1, -6, -2);
    expect_ball("seed=[0,0,0,14,16,18];range=..-2", VV_TYPE_I8, 0.1, -6, -2);
}

/* Of one sample the deviation is 0: what has the seed's very value grows. */
static void deviations_are_those_of_the_values_around_the_seed(void **state)
{
    (void)state;
    static const double samples[9] = {9, 4, 1, 3, 2, 2, 3, 7, 1};
    vv_field_info info = vv_field_info_default();
    vv_field *in;
    info.type = VV_TYPE_F64;
    info.grid.dims[0] = 9;
    assert_int_equal(vv_field_new(&in, &info, samples, 0, NULL, NULL, NULL), VV_OK);
    static const struct {
        const char *settings, *want;
    } cases[] = {{"seed=[4,0,0];radius=0", "000011000"},
                 {"seed=[4,0,0];deviations=1.5", "000111100"},            /* 2, 2 and 3: 2.333 and 0.577 */
                 {"seed=[4,0,0];deviations=2;radius=2", "001111100"},     /* 1, 3, 2, 2 and 3: 2.2 and 0.837 */
                 {"seed=[4,0,0];deviations=3;iterations=1", "011111100"}, /* the same, times 3 */
                 {"seed=[1,0,0];deviations=0;radius=0", "010000000"}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        vv_field *out = grown(in, cases[c].settings);
        for (int i = 0; i < 9; i++)
            if (vv_field_value(out, i, 0, 0, 0) != cases[c].want[i] - '0')
                fail_msg("%s: sample %d", cases[c].settings, i);
        vv_field_release(out);
    }
    vv_field_release(in);
}

static void what_makes_no_sense_is_refused(void **state)
{
    (void)state;
    vv_field *in = sphere(VV_TYPE_F32, 1), *out;
    static const char *const wrong[] = {"",
                                        "range=1..2",
                                        "seed=[1,2]",
                                        "seed=[33,0,0]",
                                        "seed=[-1,0,0]",
                                        "seed=[14,16,18];range=5..6",
                                        "seed=[1,1,1];range=3..2",
                                        "seed=[1,1,1];range=1..2;deviations=2",
                                        "seed=[17,1,1];space=world"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(test_apply(&out, &vvi_operation_grow, in, wrong[i], NULL), VV_E_ARGUMENT);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_ball_grows_from_its_middle),
        cmocka_unit_test(deviations_are_those_of_the_values_around_the_seed),
        cmocka_unit_test(what_makes_no_sense_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
