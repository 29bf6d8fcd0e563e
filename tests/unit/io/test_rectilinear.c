/* Resampling of uneven grids: a linear function comes out as it was, any other as direct interpolation has it. */
#include "fields.h"
#include "io/rectilinear.h"
#include "io_test.h"

static const int64_t n_samples[3] = {6, 4, 5};
static const double x_at[] = {0, 1, 1.5, 4, 4.25, 9}, y_at[] = {3, 2, 0, -5}, z_at[] = {10, 10.5, 12, 13, 20};
static const double *const places[3] = {x_at, y_at, z_at};

static vvi_axes *make_axes(void)
{
    vvi_axes *axes;
    io_ok(vvi_axes_new(&axes, places, n_samples, "test", NULL));
    return axes;
}

static double linear(double x, double y, double z)
{
    return 3 + 2 * x - y + 0.5 * z;
}

static double noise(double x, double y, double z)
{
    return test_random_unit(7, (uint64_t)((x + 20) * 4096 + (y + 20) * 256 + (z + 20) * 16));
}

/* The samples of a function at the uneven places. */
static vv_field *stored_field(double (*value)(double, double, double), const vv_box *box)
{
    vv_field_info info = vv_field_info_default();
    void *data;
    vv_field *field;
    memcpy(info.grid.dims, box->n, sizeof box->n);
    info.type = VV_TYPE_F64;
    io_ok(vv_field_new_empty(&field, &data, &info, NULL));
    double *out = data;
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++)
            for (int64_t i = 0; i < box->n[0]; i++)
                *out++ = value(x_at[box->lo[0] + i], y_at[box->lo[1] + j], z_at[box->lo[2] + k]);
    return field;
}

/* Weights of the neighbours of a place along an axis, found the slow way. */
static void weigh(double w[6], int axis, double x)
{
    const double *at = places[axis];
    const int64_t n = n_samples[axis];
    memset(w, 0, 6 * sizeof *w);
    for (int64_t i = 0; i + 1 < n; i++) {
        const double t = (x - at[i]) / (at[i + 1] - at[i]);
        if (t >= -1e-12 && t <= 1 + 1e-12) {
            w[i] = 1 - t;
            w[i + 1] = t;
            return;
        }
    }
    fail_msg("%g is outside", x);
}

static double interpolate(double (*value)(double, double, double), vv_vec3 p)
{
    double w[3][6], sum = 0;
    weigh(w[0], 0, p.x);
    weigh(w[1], 1, p.y);
    weigh(w[2], 2, p.z);
    for (int k = 0; k < 5; k++)
        for (int j = 0; j < 4; j++)
            for (int i = 0; i < 6; i++)
                sum += w[0][i] * w[1][j] * w[2][k] * value(x_at[i], y_at[j], z_at[k]);
    return sum;
}

static void check_function(double (*value)(double, double, double), bool is_linear, const vv_box *region)
{
    vvi_axes *axes = make_axes();
    vv_field_info info = vv_field_info_default();
    vv_field *out;
    info.type = VV_TYPE_F64;
    vvi_axes_place(&info, axes);
    const vv_box needs = vvi_axes_needs(axes, region);
    vv_field *stored = stored_field(value, &needs);
    io_ok(vvi_axes_sample(&out, &info, axes, region, stored, &needs, NULL));
    const vv_grid *grid = &vv_field_get_info(out)->grid;
    for (int64_t k = 0; k < grid->dims[2]; k++)
        for (int64_t j = 0; j < grid->dims[1]; j++)
            for (int64_t i = 0; i < grid->dims[0]; i++) {
                const vv_vec3 p = vv_affine_point(grid->index_to_world, (vv_vec3){(double)i, (double)j, (double)k});
                const double want = is_linear ? value(p.x, p.y, p.z) : interpolate(value, p);
                assert_float_equal(vv_field_value(out, i, j, k, 0), want, 1e-9);
            }
    vv_field_release(out);
    vv_field_release(stored);
    vvi_axes_free(axes);
}

static void a_linear_function_is_reproduced(void **state)
{
    check_function(linear, true, NULL);
}

static void any_function_is_what_direct_interpolation_gives(void **state)
{
    check_function(noise, false, NULL);
}

static void a_box_needs_its_own_samples_only(void **state)
{
    const vv_box box = {{3, 2, 5}, {4, 3, 2}};
    vvi_axes *axes = make_axes();
    const vv_box needs = vvi_axes_needs(axes, &box);
    assert_true(needs.n[0] < n_samples[0] && needs.n[2] < n_samples[2]);
    vvi_axes_free(axes);
    check_function(noise, false, &box);
}

static void samples_are_as_dense_as_the_limits_allow(void **state)
{
    vvi_axes *axes = make_axes();
    double all = 1;
    for (int a = 0; a < 3; a++) {
        assert_true(axes->dims[a] >= n_samples[a] && axes->dims[a] <= VVI_AXIS_GROWTH * n_samples[a]);
        all *= (double)axes->dims[a] / (double)n_samples[a];
    }
    assert_true(all <= VVI_SAMPLES_GROWTH && all > VVI_SAMPLES_GROWTH * 0.5);
    vvi_axes_free(axes);
}

static void even_axes_stay_as_they_are(void **state)
{
    static const double even[] = {1, 1.5, 2.0001, 2.5}, one[] = {7};
    const double *const at[3] = {even, one, even};
    const int64_t n[3] = {4, 1, 4};
    vvi_axes *axes;
    io_ok(vvi_axes_new(&axes, at, n, "test", NULL));
    assert_true(vvi_axes_even(axes));
    assert_memory_equal(axes->dims, n, sizeof n);
    assert_float_equal(axes->step[1], 0.5, 1e-12);
    vvi_axes_free(axes);
}

static void coordinates_that_turn_or_stand_still_are_refused(void **state)
{
    static const double turns[] = {0, 1, 0.5}, stands[] = {0, 1, 1}, none[] = {0, NAN, 2};
    const double *const bad[] = {turns, stands, none};
    const int64_t n[3] = {3, 3, 3};
    for (int i = 0; i < 3; i++) {
        const double *const at[3] = {x_at, bad[i], z_at};
        vvi_axes *axes;
        assert_int_equal(vvi_axes_new(&axes, at, n, "test", NULL), VV_E_FORMAT);
        assert_non_null(strstr(vv_error_last()->message, "along y"));
        assert_null(axes);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_linear_function_is_reproduced),
        cmocka_unit_test(any_function_is_what_direct_interpolation_gives),
        cmocka_unit_test(a_box_needs_its_own_samples_only),
        cmocka_unit_test(samples_are_as_dense_as_the_limits_allow),
        cmocka_unit_test(even_axes_stay_as_they_are),
        cmocka_unit_test(coordinates_that_turn_or_stand_still_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
