/* Resample and reorient: against the formulas they sample, and the world that must not move. */
#include "fields.h"
#include "filter/resample_weights.h"
#include "operations.h"
#include "registry.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static vv_vec3 world(const vv_field *f, int64_t i, int64_t j, int64_t k)
{
    return vv_affine_point(vv_field_get_info(f)->grid.index_to_world, (vv_vec3){(double)i, (double)j, (double)k});
}

static double form_error(const vv_field *field, const test_form *form, int64_t margin)
{
    const int64_t *d = vv_field_get_info(field)->grid.dims;
    double most = 0;
    for (int64_t k = margin; k < d[2] - margin; k++)
        for (int64_t j = margin; j < d[1] - margin; j++)
            for (int64_t i = margin; i < d[0] - margin; i++)
                most = fmax(most, fabs(vv_field_value(field, i, j, k, 0) - form->value(world(field, i, j, k))));
    return most;
}

static vv_field_info oblique(void)
{
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F64;
    info.grid.dims[0] = 17, info.grid.dims[1] = 12, info.grid.dims[2] = 9;
    info.grid.index_to_world.axis[0] = (vv_vec3){0.5, 0.25, 0};
    info.grid.index_to_world.axis[1] = (vv_vec3){-0.25, 0.5, 0};
    info.grid.index_to_world.axis[2] = (vv_vec3){0.25, 0, 2};
    info.grid.index_to_world.origin = (vv_vec3){3, -2, 5};
    return info;
}

/* Inside, linear interpolation and symmetric means give a linear function back, whatever the spacing. */
static void a_linear_function_stays_one(void **state)
{
    (void)state;
    static const char *const settings[] = {"dims=[34,24,18]",
                                           "dims=[8,6,4]",
                                           "dims=[17,12,9]",
                                           "dims=[23,5,30]",
                                           "dims=[23,5,30];interpolation=\"cubic\"",
                                           "dims=[40,30,20];interpolation=\"cubic\""};
    const vv_field_info info = oblique();
    vv_field *in = test_field(&test_form_ramp, &info, NULL), *out;
    for (size_t s = 0; s < sizeof settings / sizeof *settings; s++) {
        assert_int_equal(test_apply(&out, &vvi_operation_resample, in, settings[s], NULL), VV_OK);
        const int64_t margin = s == 1 ? 2 : s >= 4 ? 5 : s == 3 ? 2 : 1;
        assert_true(form_error(out, &test_form_ramp, margin) < 1e-9);
        vv_field_release(out);
    }
    vv_field_release(in);
}

/* Weights of a ramp up to the outermost samples, fewer or more of them. */
static void a_ramp_stays_one_up_to_the_ends(void **state)
{
    (void)state;
    for (int fewer = 0; fewer < 2; fewer++) {
        const int64_t n_old = 30, n = fewer ? 10 : 117;
        const double start = fewer ? .75 : 0, step = fewer ? 3 : .25;
        vvi_resample_axis a;
        assert_int_equal(vvi_resample_axis_make(&a, VVI_RESAMPLE_CUBIC, n_old, n, start, step, NULL), VV_OK);
        for (int64_t i = 0; i < n; i++) {
            double sum = 0;
            for (int k = 0; k < a.count[i]; k++)
                sum += a.w[i * a.most + k] * (double)(a.first[i] + k);
            assert_true(fabs(sum - (start + (double)i * step)) < (fewer ? .05 : 1e-12));
        }
        vvi_resample_axis_free(&a);
    }
}

static void the_middle_stays_and_the_spacing_is_the_one_asked_for(void **state)
{
    (void)state;
    const vv_field_info info = oblique();
    vv_field *in = test_field(&test_form_ramp, &info, NULL), *out;
    assert_int_equal(test_apply(&out, &vvi_operation_resample, in, "spacing=\"0.7,0.9,1\"", NULL), VV_OK);
    const vv_grid *g = &vv_field_get_info(out)->grid;
    static const double expected[3] = {0.7, 0.9, 1};
    vv_vec3 middle[2];
    for (int a = 0; a < 3; a++)
        assert_true(fabs(vv_grid_spacing(g, a) - expected[a]) < 1e-12);
    for (int f = 0; f < 2; f++) {
        const vv_grid *of = &vv_field_get_info(f ? out : in)->grid;
        middle[f] =
            vv_affine_point(of->index_to_world, (vv_vec3){(double)(of->dims[0] - 1) / 2, (double)(of->dims[1] - 1) / 2,
                                                          (double)(of->dims[2] - 1) / 2});
    }
    assert_true(hypot(hypot(middle[0].x - middle[1].x, middle[0].y - middle[1].y), middle[0].z - middle[1].z) < 1e-12);
    vv_field_release(in);
    vv_field_release(out);
}

/* Halving the spacing of a smooth field: linear errs by a quarter each time, Keys' cubic by an eighth. */
static void errors_fall_with_their_orders(void **state)
{
    (void)state;
    for (int cubic = 0; cubic < 2; cubic++) {
        double error[2];
        for (int fine = 0; fine < 2; fine++) {
            const int64_t n = fine ? 65 : 33;
            vv_field *in = test_field_cube(&test_form_sphere, n, 10, 13, NULL), *out;
            char settings[80];
            snprintf(settings, sizeof settings, "dims=[%d,%d,%d];interpolation=\"%s\"", (int)(2 * n), (int)(2 * n),
                     (int)(2 * n), cubic ? "cubic" : "linear");
            vv_field_info info = *vv_field_get_info(in);
            info.type = VV_TYPE_F64;
            vv_field *wide = test_field(&test_form_sphere, &info, NULL);
            assert_int_equal(test_apply(&out, &vvi_operation_resample, wide, settings, NULL), VV_OK);
            error[fine] = form_error(out, &test_form_sphere, 8);
            vv_field_release(in);
            vv_field_release(wide);
            vv_field_release(out);
        }
        const double order = log2(error[0] / error[1]);
        if (!(cubic ? order > 2.6 : order > 1.8 && order < 2.2))
            fail_msg("%s: order %g (errors %g, %g)", cubic ? "cubic" : "linear", order, error[0], error[1]);
    }
}

/* Fewer samples: each is a mean, so the mean of all stays and a checkerboard becomes grey. */
static void shrinking_averages(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = 32;
    vv_field *in, *out;
    uint8_t *data;
    assert_int_equal(vv_field_new_empty(&in, (void **)&data, &info, NULL), VV_OK);
    for (int i = 0; i < 32 * 32 * 32; i++)
        data[i] = (i + i / 32 + i / 1024) % 2 ? 200 : 0;
    assert_int_equal(test_apply(&out, &vvi_operation_resample, in, "dims=[8,8,8]", NULL), VV_OK);
    for (int64_t i = 1; i < 7; i++)
        assert_true(fabs(vv_field_value(out, i, 3, 4, 0) - 100) <= 1);
    vv_field_release(out);
    vv_field_release(in);
}

/* A grid turned about z, y and x, with another spacing, around the middle of `of`. */
static vv_grid turned(const vv_grid *of)
{
    vv_grid g = *of;
    g.dims[0] = 29, g.dims[1] = 31, g.dims[2] = 23;
    g.index_to_world.axis[0] = (vv_vec3){0.15, 0.2, -0.1}; /* so near that kernels are not widened */
    g.index_to_world.axis[1] = (vv_vec3){-0.25, 0.1, 0.15};
    g.index_to_world.axis[2] = (vv_vec3){0.2, -0.1, 0.75};
    const vv_vec3 middle = vv_affine_point(of->index_to_world, (vv_vec3){8, 5.5, 4});
    g.index_to_world.origin = (vv_vec3){0, 0, 0};
    const vv_vec3 half = vv_affine_point(g.index_to_world, (vv_vec3){14, 15, 11});
    g.index_to_world.origin = (vv_vec3){middle.x - half.x, middle.y - half.y, middle.z - half.z};
    return g;
}

static bool is_inside(vv_vec3 at, const int64_t *d)
{
    const double most = 0.5 + 1e-6; /* what rounding may bring in */
    return at.x >= -most && at.y >= -most && at.z >= -most && at.x <= (double)d[0] - 1 + most &&
           at.y <= (double)d[1] - 1 + most && at.z <= (double)d[2] - 1 + most;
}

static bool is_between(vv_vec3 at, const int64_t *d)
{
    return at.x >= 0 && at.y >= 0 && at.z >= 0 && at.x <= (double)d[0] - 1 && at.y <= (double)d[1] - 1 &&
           at.z <= (double)d[2] - 1;
}

/* Between samples a linear function stays one, wherever the other grid lies; outside is the fill. */
static void onto_another_grid_a_linear_function_stays_one(void **state)
{
    const vv_field_info info = oblique();
    vv_affine back;
    assert_true(vv_affine_invert(&back, info.grid.index_to_world));
    vv_field *in = test_field(&test_form_ramp, &info, NULL);
    for (int way = 0; way < 3; way++) {
        vv_field_info to = vv_field_info_default();
        to.grid = turned(&info.grid);
        if (way) { /* along the axes, mirrored in x, and beyond in y */
            to.grid = info.grid;
            to.grid.index_to_world.axis[0] = (vv_vec3){-0.4, -0.2, 0};
            to.grid.index_to_world.axis[2] = (vv_vec3){0.2, 0, 1.6};
            to.grid.index_to_world.origin = vv_affine_point(info.grid.index_to_world, (vv_vec3){12.2, -2.1, 0.3});
        }
        vv_field *onto = test_field_random(&to, 1, NULL);
        const vv_field *inputs[] = {in, onto};
        const char *settings = way == 2 ? "fill=-7" : "";
        vv_field *out = test_apply_all_ways(&vvi_operation_resample, inputs, 2, settings);
        int64_t between = 0, outside = 0;
        assert_memory_equal(&vv_field_get_info(out)->grid, &to.grid, sizeof to.grid);
        for (int64_t n = 0; n < to.grid.dims[0] * to.grid.dims[1] * to.grid.dims[2]; n++) {
            const int64_t i = n % to.grid.dims[0], j = n / to.grid.dims[0] % to.grid.dims[1],
                          k = n / to.grid.dims[0] / to.grid.dims[1];
            const vv_vec3 at = vv_affine_point(back, world(out, i, j, k));
            const double found = vv_field_value(out, i, j, k, 0);
            between += is_between(at, info.grid.dims);
            outside += !is_inside(at, info.grid.dims);
            if (is_between(at, info.grid.dims))
                assert_true(fabs(found - test_form_ramp.value(world(out, i, j, k))) < 1e-9);
            else if (!is_inside(at, info.grid.dims))
                assert_true(way == 2 ? found == -7 : isnan(found));
            else
                assert_true(isfinite(found));
        }
        assert_true(between > 500 && outside > 100);
        vv_field_release(out);
        vv_field_release(onto);
    }
    vv_field_release(in);
}

/* Every type and kernel, in whatever order of axes: onto the own grid nothing changes, onto the turned one labels are
 * those of the nearest sample. */
static void onto_the_same_places_nothing_changes(void **state)
{
    static const char *const kernels[] = {"linear", "nearest", "cubic", "lanczos"};
    for (vv_type type = 0; type < VV_TYPE_COUNT; type++)
        for (int n = 0; n < 4; n++) {
            vv_field_info info = oblique(), other = oblique();
            char settings[40];
            info.type = type == VV_TYPE_U64 ? VV_TYPE_U32 : type == VV_TYPE_I64 ? VV_TYPE_I32 : type;
            info.components = 2;
            info.value_scale = 0.5;
            other.grid.index_to_world.axis[1] = info.grid.index_to_world.axis[2]; /* y and z exchanged */
            other.grid.index_to_world.axis[2] = info.grid.index_to_world.axis[1];
            other.grid.dims[1] = info.grid.dims[2];
            other.grid.dims[2] = info.grid.dims[1];
            vv_field *in = test_field_random(&info, 4, NULL), *onto = test_field_random(&other, 4, NULL);
            const vv_field *same[] = {in, in}, *exchanged[] = {in, onto};
            snprintf(settings, sizeof settings, "interpolation=\"%s\"", kernels[n]);
            vv_field *out = test_apply_all_ways(&vvi_operation_resample, same, 2, settings);
            if (!test_same_samples(in, out))
                fail_msg("%s, %s", vv_type_name(info.type), kernels[n]);
            vv_field_release(out);
            out = test_apply_all_ways(&vvi_operation_resample, exchanged, 2, settings);
            for (int64_t at = 0; at < 17 * 12 * 9; at++)
                for (int c = 0; c < 2; c++) {
                    const double was = vv_field_value(in, at % 17, at / 17 % 12, at / 204, c);
                    assert_true(fabs(vv_field_value(out, at % 17, at / 204, at / 17 % 12, c) - was) <=
                                1e-9 * fabs(was));
                }
            vv_field_release(out);
            vv_field_release(in);
            vv_field_release(onto);
        }
}

/* Kernels that are as wide as asked for, by their formulas: the weights of a place in the middle. */
static void lanczos_is_the_windowed_sinc(void **state)
{
    const double pi = acos(-1), start[2] = {10.3, 9.7}, step[2] = {0.5, 2.5};
    for (int n = 0; n < 2; n++) {
        vvi_resample_axis a;
        assert_int_equal(vvi_resample_axis_make(&a, VVI_RESAMPLE_LANCZOS, 40, 5, start[n], step[n], NULL), VV_OK);
        for (int64_t i = 0; i < 5; i++) {
            const double at = start[n] + (double)i * step[n], width = fmax(step[n], 1);
            double want[40], sum = 0;
            for (int k = 0; k < 40; k++) {
                const double x = pi * (k - at) / width;
                want[k] = fabs(x) >= 3 * pi ? 0 : fabs(x) < 1e-9 ? 1 : sin(x) / x * sin(x / 3) / (x / 3);
                sum += want[k];
            }
            for (int k = 0; k < 40; k++) {
                const int64_t t = k - a.first[i];
                const double found = t >= 0 && t < a.count[i] ? a.w[i * a.most + t] : 0;
                assert_true(fabs(found - want[k] / sum) < 1e-12);
            }
        }
        vvi_resample_axis_free(&a);
    }
}

static void what_cannot_be_placed_is_refused(void **state)
{
    vv_field_info info = oblique(), mm = oblique();
    strcpy(mm.grid.unit, "mm");
    vv_field *in = test_field_random(&info, 3, NULL), *placed = test_field_random(&mm, 3, NULL), *out;
    mm.grid.space = VV_SPACE_RAS;
    vv_field *anatomical = test_field_random(&mm, 3, NULL);
    const vv_field *const pairs[3][2] = {{in, placed}, {placed, anatomical}, {in, in}};
    static const char *const settings[] = {"", "", "dims=[3,3,3]"}, *const said[] = {"has no spacing", "anatomical",
                                                                                     "omit"};
    for (int n = 0; n < 3; n++) {
        vv_object *params = test_params(&vvi_operation_resample, settings[n], &info.grid);
        assert_int_equal(vv_operation_run(&out, &vvi_operation_resample, pairs[n], 2, params, NULL), VV_E_ARGUMENT);
        assert_non_null(strstr(vv_error_last()->message, said[n]));
        vv_object_release(params);
    }
    assert_int_equal(test_apply(&out, &vvi_operation_resample, in, "fill=3", NULL), VV_E_ARGUMENT);
    vv_field_release(in);
    vv_field_release(placed);
    vv_field_release(anatomical);
}

static void labels_keep_their_names(void **state)
{
    (void)state;
    vv_field_info info = oblique();
    info.type = VV_TYPE_U16;
    info.meaning = VV_MEANING_LABEL;
    vv_field *in = test_field_random(&info, 3, NULL), *out;
    assert_int_equal(test_apply(&out, &vvi_operation_resample, in, "dims=[40,11,20]", NULL), VV_OK);
    for (int64_t i = 0; i < 40; i++) {
        bool there = false;
        const double v = vv_field_value(out, i, 5, 7, 0);
        for (int64_t k = 0; k < 17 * 12 * 9 && !there; k++)
            there = vv_field_value(in, k % 17, k / 17 % 12, k / 204, 0) == v;
        assert_true(there);
    }
    vv_field_release(out);
    assert_int_equal(test_apply(&out, &vvi_operation_resample, in, "interpolation=\"linear\"", NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
}

static void every_order_of_axes_keeps_every_sample_in_place(void **state)
{
    (void)state;
    static const char *const axes[6] = {"xyz", "xzy", "yxz", "yzx", "zxy", "zyx"};
    vv_field_info info = oblique();
    info.components = 3;
    info.type = VV_TYPE_I16;
    vv_field *in = test_field_random(&info, 9, NULL), *out;
    for (int o = 0; o < 48; o++) {
        char to[8] = "", settings[24];
        for (int a = 0; a < 3; a++)
            snprintf(to + strlen(to), sizeof to - strlen(to), "%s%c", o >> a & 1 ? "-" : "", axes[o / 8][a]);
        snprintf(settings, sizeof settings, "order=\"%s\"", to);
        assert_int_equal(test_apply(&out, &vvi_operation_reorient, in, settings, NULL), VV_OK);
        vv_affine back;
        assert_true(vv_affine_invert(&back, info.grid.index_to_world));
        const int64_t *d = vv_field_get_info(out)->grid.dims;
        for (int64_t k = 0; k < d[2]; k += 2)
            for (int64_t j = 0; j < d[1]; j++)
                for (int64_t i = 0; i < d[0]; i += 3) {
                    const vv_vec3 at = vv_affine_point(back, world(out, i, j, k));
                    for (int c = 0; c < 3; c++)
                        assert_true(vv_field_value(out, i, j, k, c) ==
                                    vv_field_value(in, lround(at.x), lround(at.y), lround(at.z), c));
                }
        vv_field_release(out);
    }
    vv_field_release(in);
}

static void letters_name_the_direction_of_increase(void **state)
{
    (void)state;
    static const char *const letters[] = {"RAS", "LPI", "SRA", "AIL", "PSR"};
    vv_field_info info = oblique();
    info.grid.space = VV_SPACE_RAS;
    vv_field *in = test_field_random(&info, 9, NULL), *out;
    for (size_t i = 0; i < sizeof letters / sizeof *letters; i++) {
        char settings[24], found[16];
        snprintf(settings, sizeof settings, "order=\"%s\"", letters[i]);
        assert_int_equal(test_apply(&out, &vvi_operation_reorient, in, settings, NULL), VV_OK);
        vv_grid_orientation(found, &vv_field_get_info(out)->grid);
        assert_string_equal(found, letters[i]);
        vv_field_release(out);
    }
    assert_int_equal(test_apply(&out, &vvi_operation_reorient, in, "order=\"RRS\"", NULL), VV_E_ARGUMENT);
    assert_int_equal(test_apply(&out, &vvi_operation_reorient, in, "order=\"xxz\"", NULL), VV_E_ARGUMENT);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_linear_function_stays_one),
        cmocka_unit_test(a_ramp_stays_one_up_to_the_ends),
        cmocka_unit_test(the_middle_stays_and_the_spacing_is_the_one_asked_for),
        cmocka_unit_test(errors_fall_with_their_orders),
        cmocka_unit_test(shrinking_averages),
        cmocka_unit_test(onto_another_grid_a_linear_function_stays_one),
        cmocka_unit_test(onto_the_same_places_nothing_changes),
        cmocka_unit_test(lanczos_is_the_windowed_sinc),
        cmocka_unit_test(what_cannot_be_placed_is_refused),
        cmocka_unit_test(labels_keep_their_names),
        cmocka_unit_test(every_order_of_axes_keeps_every_sample_in_place),
        cmocka_unit_test(letters_name_the_direction_of_increase),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
