/* Second derivatives of formulas, on straight and sheared grids; tubes, and what is no tube. */
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

static vv_field *apply(const vv_field *in, const char *settings)
{
    vv_job *job = test_job(2, 0);
    vv_field *out;
    if (test_apply(&out, &vvi_operation_vesselness, in, settings, job) != VV_OK)
        fail_msg("%s: %s", settings, vv_error_last()->message);
    vv_job_release(job);
    return out;
}

static vv_field_info sheared(vv_type type)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 13, info.grid.dims[1] = 12, info.grid.dims[2] = 11;
    info.grid.index_to_world = (vv_affine){
        .axis = {{0.7, 0.1, 0}, {0.3, 1.1, 0.2}, {-0.2, 0.4, 1.6}},
        .origin = {1, -2, 3},
    };
    info.type = type;
    strcpy(info.grid.unit, "mm");
    strcpy(info.value_unit, "HU");
    return info;
}

/* Second derivatives -6, 2 and 2 along (1, 2, 2) / 3 and across it. */
static double saddle(vv_vec3 p)
{
    const double along = (p.x + 2 * p.y + 2 * p.z) / 3;
    return 5 + 2 * p.x - p.y + (p.x * p.x + p.y * p.y + p.z * p.z - along * along) - 3 * along * along;
}

static const test_form saddle_form = {.name = "saddle", .value = saddle};

static void expect_saddle(const vv_field_info *info, double tolerance)
{
    vv_field *in = test_field(&saddle_form, info, NULL);
    vv_field *out = apply(in, "output=eigenvalues;sigma=0.5");
    static const double want[3] = {2 * 0.25, 2 * 0.25, -6 * 0.25};
    assert_string_equal(vv_field_get_info(out)->value_unit, "HU");
    for (int64_t k = 4; k < 7; k++)
        for (int64_t j = 4; j < 8; j++)
            for (int64_t i = 5; i < 8; i++)
                for (int c = 0; c < 3; c++)
                    if (!(fabs(vv_field_value(out, i, j, k, c) - want[c]) < tolerance))
                        fail_msg("%d %d %d: %d is %.9g", (int)i, (int)j, (int)k, c, vv_field_value(out, i, j, k, c));
    vv_field_release(in);
    vv_field_release(out);
}

static void derivatives_are_those_of_the_world(void **state)
{
    (void)state;
    vv_field_info info = sheared(VV_TYPE_F64);
    expect_saddle(&info, 2e-6);
    info.value_scale = -1e-6;
    info.value_offset = 70;
    info.type = VV_TYPE_I32;
    expect_saddle(&info, 2e-5);
    info = sheared(VV_TYPE_F64);
    info.grid.index_to_world.axis[0] = (vv_vec3){0, 0.5, 0}; /* axes in another order */
    info.grid.index_to_world.axis[1] = (vv_vec3){0, 0, -0.6};
    info.grid.index_to_world.axis[2] = (vv_vec3){0.8, 0, 0};
    expect_saddle(&info, 2e-6);
}

#define TUBE_SIGMA 2.0

/* Along (2, 1, 2) / 3 through (12, 12, 12). */
static double tube(vv_vec3 p)
{
    const double x = p.x - 12, y = p.y - 12, z = p.z - 12, along = (2 * x + y + 2 * z) / 3;
    return 100 * exp(-0.5 * (x * x + y * y + z * z - along * along) / (TUBE_SIGMA * TUBE_SIGMA));
}

static const test_form tube_form = {.name = "tube", .value = tube};

static vv_field *tube_field(vv_type type, const double spacing[3])
{
    vv_field_info info = vv_field_info_default();
    for (int a = 0; a < 3; a++) {
        info.grid.dims[a] = lround(24 / spacing[a]) + 1;
        *(&info.grid.index_to_world.axis[a].x + a) = spacing[a];
    }
    strcpy(info.grid.unit, "mm");
    info.type = type;
    return test_field(&tube_form, &info, NULL);
}

/* Smoothed with t, the tube of width s is one of width sqrt(s^2 + t^2), and s^2 / (s^2 + t^2) times as high. */
static void a_tube_has_the_eigenvalues_of_its_formula_at_every_scale(void **state)
{
    (void)state;
    static const double spacings[][3] = {{0.5, 0.5, 0.5}, {0.5, 0.6, 0.75}};
    for (int n = 0; n < 2; n++) {
        vv_field *in = tube_field(VV_TYPE_F32, spacings[n]);
        for (int t = 1; t <= 3; t++) {
            char settings[64];
            snprintf(settings, sizeof settings, "output=eigenvalues;sigma=%d", t);
            vv_field *out = apply(in, settings);
            const double s2 = TUBE_SIGMA * TUBE_SIGMA, t2 = t * t, want = -100 * s2 * t2 / ((s2 + t2) * (s2 + t2));
            const int64_t i = lround(12 / spacings[n][0]), j = lround(12 / spacings[n][1]),
                          k = lround(12 / spacings[n][2]);
            assert_true(fabs(vv_field_value(out, i, j, k, 0)) < 0.05 * fabs(want));
            for (int c = 1; c < 3; c++)
                if (!(fabs(vv_field_value(out, i, j, k, c) - want) < 0.03 * fabs(want)))
                    fail_msg("sigma %d: %g is not %g", t, vv_field_value(out, i, j, k, c), want);
            vv_field_release(out);
        }
        vv_field_release(in);
    }
}

/* The greatest response of a Gaussian tube is where t^2 / (s^2 + t^2)^2 is greatest: at its own width. */
static void the_scale_of_a_tube_is_its_width(void **state)
{
    (void)state;
    static const double spacing[3] = {0.5, 0.5, 0.5};
    vv_field *in = tube_field(VV_TYPE_U8, spacing);
    vv_field *scale = apply(in, "output=scale;sigma=1;sigma_most=4;scales=5");
    vv_field *bright = apply(in, "sigma=1;sigma_most=4;scales=5;c=17.7"),
             *dark = apply(in, "sigma=2;scales=1;dark=true");
    assert_true(fabs(vv_field_value(scale, 24, 24, 24, 0) - 2) < 1e-6);
    assert_string_equal(vv_field_get_info(scale)->value_unit, "mm");
    assert_true(vv_field_value(bright, 24, 24, 24, 0) > 0.7);
    assert_true(vv_field_value(bright, 2, 24, 40, 0) < 1e-3);
    assert_true(vv_field_value(dark, 24, 24, 24, 0) == 0);
    vv_field *all[] = {in, scale, bright, dark};
    for (int i = 0; i < 4; i++)
        vv_field_release(all[i]);
}

static void constant_fields_and_missing_samples_have_no_vessels(void **state)
{
    (void)state;
    vv_field_info info = sheared(VV_TYPE_F32);
    vv_field *same = test_field(&test_form_constant, &info, NULL), *out = apply(same, NULL);
    for (int64_t i = 0; i < 13; i++)
        assert_true(vv_field_value(out, i, i % 12, i % 11, 0) == 0);
    vv_field_release(out);
    vv_field_release(same);
    float samples[5 * 5 * 5];
    for (int i = 0; i < 125; i++)
        samples[i] = (float)(i % 7);
    samples[62] = NAN;
    samples[3] = INFINITY;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = 5;
    assert_int_equal(vv_field_new(&same, &info, samples, 0, NULL, NULL, NULL), VV_OK);
    out = apply(same, "scales=2");
    for (int i = 0; i < 125; i++)
        assert_int_equal(isnan(vv_field_value(out, i % 5, i / 5 % 5, i / 25, 0)), i == 62 || i == 3);
    vv_field_release(out);
    vv_field_release(same);
}

static void what_makes_no_sense_is_refused(void **state)
{
    (void)state;
    vv_field_info info = sheared(VV_TYPE_U8);
    vv_field *out, *in = test_field(&test_form_constant, &info, NULL);
    static const char *const wrong[] = {"sigma=0", "sigma=2;sigma_most=1", "sigma=1e9", "scales=0", "c=0", "alpha=0"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(test_apply(&out, &vvi_operation_vesselness, in, wrong[i], NULL), VV_E_ARGUMENT);
    vv_field_release(in);
    info.grid.dims[0] = info.grid.dims[2] = 1;
    in = test_field(&test_form_constant, &info, NULL);
    assert_int_equal(test_apply(&out, &vvi_operation_vesselness, in, "", NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
    info.meaning = VV_MEANING_LABEL;
    info.grid.dims[2] = 3;
    in = test_field(&test_form_constant, &info, NULL);
    assert_int_equal(test_apply(&out, &vvi_operation_vesselness, in, "", NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
    info.meaning = VV_MEANING_SCALAR;
    info.components = 2;
    in = test_field(&test_form_constant, &info, NULL);
    assert_int_equal(test_apply(&out, &vvi_operation_vesselness, in, "output=eigenvalues", NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(derivatives_are_those_of_the_world),
        cmocka_unit_test(a_tube_has_the_eigenvalues_of_its_formula_at_every_scale),
        cmocka_unit_test(the_scale_of_a_tube_is_its_width),
        cmocka_unit_test(constant_fields_and_missing_samples_have_no_vessels),
        cmocka_unit_test(what_makes_no_sense_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
