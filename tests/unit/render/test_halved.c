/* A volume with fewer samples: against its definition, and in pictures. */
#include "fields.h"
#include "grid/field.h"
#include "ray_scene.h"
#include "render/common/half_volume.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/image.h>

#include <cmocka.h>

static vv_field *field_of(vv_type type, const int64_t n[3], double (*value)(int64_t x, int64_t y, int64_t z))
{
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    char *data;
    info.type = type;
    for (int a = 0; a < 3; a++)
        info.grid.dims[a] = n[a];
    info.grid.index_to_world.axis[0] = (vv_vec3){0.5, 0, 0};
    info.grid.index_to_world.axis[1] = (vv_vec3){0, 0, 2};
    info.grid.index_to_world.axis[2] = (vv_vec3){0, -3, 0};
    info.grid.index_to_world.origin = (vv_vec3){10, 20, 30};
    assert_int_equal(vv_field_new_empty(&field, (void **)&data, &info, NULL), VV_OK);
    for (int64_t z = 0; z < n[2]; z++)
        for (int64_t y = 0; y < n[1]; y++)
            for (int64_t x = 0; x < n[0]; x++, data += vv_type_bytes(type)) {
                const double v = value(x, y, z);
                vvi_samples_from_f64(data, &v, type, 1);
            }
    return field;
}

static double number_of(const vv_field *field, int64_t x, int64_t y, int64_t z)
{
    const vv_box box = {.lo = {x, y, z}, .n = {1, 1, 1}};
    const vv_field_info *info = vv_field_get_info(field);
    vv_brick brick;
    double v;
    assert_int_equal(vv_field_brick(&brick, field, &box, NULL), VV_OK);
    vvi_samples_to_f64(&v, brick.data, brick.type, 1);
    vv_brick_release(&brick);
    return v * info->value_scale + info->value_offset;
}

static double scattered(int64_t x, int64_t y, int64_t z)
{
    return (double)((uint64_t)(x * 73856093 ^ y * 19349663 ^ z * 83492791) % 251);
}

static double scattered_with_holes(int64_t x, int64_t y, int64_t z)
{
    const double v = scattered(x, y, z) - 100;
    return v > 60 || (x < 4 && y < 4 && z < 4) ? NAN : v;
}

/* The definition, sample by sample: out of those of its eight that are there and are numbers. */
static double expected(const vv_field *field, const int64_t n[3], const int64_t at[3], vvi_halving halving)
{
    double sum = 0, least = INFINITY, most = -INFINITY;
    int numbers = 0;
    for (int c = 0; c < 8; c++) {
        int64_t p[3];
        bool there = true;
        for (int a = 0; a < 3; a++) {
            const int second = c >> a & 1;
            p[a] = n[a] > 8 ? 2 * at[a] + second : at[a];
            there &= p[a] < n[a] && (n[a] > 8 || !second);
        }
        const double v = there ? number_of(field, p[0], p[1], p[2]) : NAN;
        if (isnan(v))
            continue;
        sum += v;
        least = fmin(least, v);
        most = fmax(most, v);
        numbers++;
    }
    if (!numbers)
        return NAN;
    return halving == VVI_HALVE_MEAN ? sum / numbers : halving == VVI_HALVE_LARGEST ? most : least;
}

static void check(vv_type type, const int64_t n[3], double (*value)(int64_t, int64_t, int64_t), vvi_halving halving,
                  double tolerance)
{
    vv_field *field = field_of(type, n, value);
    vv_actor actor = {.field = field, .index_to_world = vv_field_get_info(field)->grid.index_to_world}, half;
    assert_int_equal(vvi_actor_halve(&half, &actor, 1, halving, NULL), VV_OK);
    const int64_t *m = vv_field_get_info(half.field)->grid.dims;
    for (int a = 0; a < 3; a++)
        assert_int_equal(m[a], n[a] > 8 ? (n[a] + 1) / 2 : n[a]);
    for (int64_t z = 0; z < m[2]; z++)
        for (int64_t y = 0; y < m[1]; y++)
            for (int64_t x = 0; x < m[0]; x++) {
                const double want = expected(field, n, (int64_t[3]){x, y, z}, halving);
                const double got = number_of(half.field, x, y, z);
                assert_true(isnan(want) ? isnan(got) : fabs(got - want) <= tolerance);
            }
    vv_field_release((vv_field *)half.field);
    vv_field_release(field);
}

static void samples_are_what_is_said_of_eight(void **state)
{
    (void)state;
    static const vv_type types[] = {VV_TYPE_U8, VV_TYPE_U16, VV_TYPE_I16, VV_TYPE_F32, VV_TYPE_I8, VV_TYPE_F64};
    static const int64_t sizes[][3] = {{16, 10, 12}, {17, 11, 13}, {9, 8, 1}, {1, 1, 23}, {31, 9, 7}};
    for (size_t t = 0; t < sizeof types / sizeof *types; t++)
        for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
            for (int h = VVI_HALVE_MEAN; h <= VVI_HALVE_SMALLEST; h++)
                check(types[t], sizes[s], scattered, (vvi_halving)h, vv_type_is_float(types[t]) ? 1e-4 : 0.5);
}

static void what_is_no_number_is_passed_over(void **state)
{
    (void)state;
    for (int h = VVI_HALVE_MEAN; h <= VVI_HALVE_SMALLEST; h++)
        check(VV_TYPE_F32, (const int64_t[3]){17, 16, 19}, scattered_with_holes, (vvi_halving)h, 1e-4);
}

static double slope(int64_t x, int64_t y, int64_t z)
{
    return 3 + 0.5 * (double)x - 2 * (double)y + 0.25 * (double)z;
}

/* A linear function stays itself at the places that the new samples have in the World, twice as well. */
static void samples_stand_where_their_means_are(void **state)
{
    (void)state;
    const int64_t n[3] = {64, 40, 36};
    vv_field *field = field_of(VV_TYPE_F32, n, slope);
    vv_actor actor = {.field = field, .index_to_world = vv_field_get_info(field)->grid.index_to_world}, half;
    vv_affine to_index;
    assert_true(vv_affine_invert(&to_index, actor.index_to_world));
    for (int times = 0; times <= 2; times++) {
        assert_int_equal(vvi_actor_halve(&half, &actor, times, VVI_HALVE_MEAN, NULL), VV_OK);
        const int64_t *m = vv_field_get_info(half.field)->grid.dims;
        for (int64_t i = 0; i < 9; i++) {
            const int64_t half_of = i / 2;
            const vv_vec3 at = vv_affine_point(
                to_index, vv_affine_point(half.index_to_world, (vv_vec3){(double)i, (double)(8 - i), (double)half_of}));
            const double want = 3 + 0.5 * at.x - 2 * at.y + 0.25 * at.z;
            assert_true(fabs(number_of(half.field, i, 8 - i, half_of) - want) < 1e-4);
        }
        assert_int_equal(m[0], 64 >> times);
        vv_field_release((vv_field *)half.field);
    }
    vv_field_release(field);
}

static void largest_finite_numbers_have_a_mean(void **state)
{
    (void)state;
    const int64_t n[3] = {10, 10, 10};
    vv_field *field = field_of(VV_TYPE_F32, n, slope);
    const vv_box box = vv_field_box(field);
    vv_brick brick;
    assert_int_equal(vv_field_brick(&brick, field, &box, NULL), VV_OK);
    for (int i = 0; i < 1000; i++)
        ((float *)brick.data)[i] = 3e38f;
    vv_brick_release(&brick);
    vv_actor actor = {.field = field}, half;
    assert_int_equal(vvi_actor_halve(&half, &actor, 1, VVI_HALVE_MEAN, NULL), VV_OK);
    assert_true(fabs(number_of(half.field, 2, 2, 2) / 3e38 - 1) < 1e-6);
    vv_field_release((vv_field *)half.field);
    vv_field_release(field);
}

static void halvings_end_where_enough_is_left_out(void **state)
{
    (void)state;
    vv_field *field = field_of(VV_TYPE_U8, (const int64_t[3]){40, 40, 4}, scattered);
    assert_int_equal(vvi_halvings_to(field, 6400), 0);
    assert_int_equal(vvi_halvings_to(field, 6399), 1);
    assert_int_equal(vvi_halvings_to(field, 400), 2);
    assert_int_equal(vvi_halvings_to(field, 1), 3); /* 5 x 5 x 4 is what can be had */
    vv_field_release(field);
}

/* Pictures -------------------------------------------------------------------------------------------------------- */

static double ball(int64_t x, int64_t y, int64_t z)
{
    const double d = hypot(hypot((double)x - 31.5, (double)y - 31.5), (double)z - 31.5);
    return 200 / (1 + exp((d - 20) / 3));
}

/* What is smooth looks as with all samples, in its place and as large. */
static void a_smooth_ball_looks_alike(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    vv_field *field = field_of(VV_TYPE_U8, (const int64_t[3]){64, 64, 64}, ball);
    vv_field *plain;
    vv_image *pictures[2];
    info = *vv_field_get_info(field);
    info.grid.index_to_world = vv_affine_identity();
    assert_int_equal(vvi_field_relabel(&plain, field, &info), VV_OK);
    for (int halvings = 0; halvings < 2; halvings++) {
        test_ray_scene s;
        test_ray_scene_init(&s, plain, 64);
        test_ray_scene_opacity(&s, (const double[]){20, 0, 200, 0.1}, 2);
        vv_object *params = &s.params->base;
        assert_int_equal(vv_path_set(&params, "halvings", halvings ? "1" : "0", NULL), VV_OK);
        s.params = (vvi_raycast_params *)params;
        s.scene.params = params;
        pictures[halvings] = test_ray_picture(&s, NULL, 2);
        test_ray_scene_finish(&s);
    }
    double sum = 0, most = 0;
    const size_t n = (size_t)4 * 64 * 64;
    for (size_t i = 0; i < n; i++) {
        const double d = (double)pictures[0]->rgba[i] - (double)pictures[1]->rgba[i];
        sum += d * d;
        most = fmax(most, (double)pictures[0]->rgba[i]);
    }
    assert_true(most > 0.5 && sum > 0); /* there is something to see, and it is not the same */
    assert_true(10 * log10(most * most * (double)n / sum) > 40);
    vv_image_release(pictures[0]);
    vv_image_release(pictures[1]);
    vv_field_release(plain);
    vv_field_release(field);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_are_what_is_said_of_eight),     cmocka_unit_test(what_is_no_number_is_passed_over),
        cmocka_unit_test(samples_stand_where_their_means_are),   cmocka_unit_test(largest_finite_numbers_have_a_mean),
        cmocka_unit_test(halvings_end_where_enough_is_left_out), cmocka_unit_test(a_smooth_ball_looks_alike),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
