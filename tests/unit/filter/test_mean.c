/* Means against adding up every window in long doubles, for every type, size and radius. */
#include "core/cpu.h"
#include "fields.h"
#include "filter/mean_kernel.h"
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

static vv_field_info info_of(const int64_t dims[3], vv_type type, int components)
{
    vv_field_info info = vv_field_info_default();
    memcpy(info.grid.dims, dims, sizeof info.grid.dims);
    info.type = type;
    info.components = components;
    strcpy(info.grid.unit, "mm");
    return info;
}

static vv_field *mean_of(const vv_field *in, const char *settings)
{
    vv_field *out;
    if (test_apply(&out, &vvi_operation_mean, in, settings, NULL) != VV_OK)
        fail_msg("%s: %s", settings ? settings : "no settings", vv_error_last()->message);
    return out;
}

/* vv_field_value() repeats the border. */
static double expected(const vv_field *in, const int64_t r[3], int64_t i, int64_t j, int64_t k, int c)
{
    const vv_type type = vv_field_get_info(in)->type;
    long double sum = 0;
    int n = 0;
    if (isnan(vv_field_value(in, i, j, k, c)))
        return NAN;
    for (int64_t z = -r[2]; z <= r[2]; z++)
        for (int64_t y = -r[1]; y <= r[1]; y++)
            for (int64_t x = -r[0]; x <= r[0]; x++) {
                const double v = vv_field_value(in, i + x, j + y, k + z, c);
                if (!isnan(v)) {
                    sum += (long double)v;
                    n++;
                }
            }
    return vv_type_is_float(type) ? (double)(sum / n) : (double)rintl(sum / n);
}

static void expect_means(const vv_field *in, const vv_field *out, const int64_t radius[3])
{
    const vv_field_info *info = vv_field_get_info(in);
    const int64_t *d = info->grid.dims;
    const double near = info->type == VV_TYPE_F32        ? 1e-4
                        : info->type == VV_TYPE_F64      ? 1e-10
                        : vv_type_bytes(info->type) == 8 ? 1e6 /* of 2^63: sums of many, in doubles */
                                                         : 0;
    int64_t r[3];
    for (int a = 0; a < 3; a++)
        r[a] = d[a] == 1 ? 0 : radius[a];
    for (int64_t k = 0; k < d[2]; k++)
        for (int64_t j = 0; j < d[1]; j++)
            for (int64_t i = 0; i < d[0]; i++)
                for (int c = 0; c < info->components; c++) {
                    const double got = vv_field_value(out, i, j, k, c), want = expected(in, r, i, j, k, c);
                    if (!(fabs(got - want) <= near) && !(isnan(got) && isnan(want)))
                        fail_msg("%s (%d %d %d) %d: %.17g, not %.17g", vv_type_name(info->type), (int)i, (int)j, (int)k,
                                 c, got, want);
                }
}

static void try(const int64_t dims[3], vv_type type, int components, const int64_t r[3], uint64_t seed)
{
    const vv_field_info info = info_of(dims, type, components);
    char settings[96];
    snprintf(settings, sizeof settings, "radius_voxels=[%d,%d,%d]", (int)r[0], (int)r[1], (int)r[2]);
    vv_field *in = test_field_random(&info, seed, NULL), *out = mean_of(in, settings);
    expect_means(in, out, r);
    vv_field_release(in);
    vv_field_release(out);
}

static void every_type_and_window_equals_a_sum(void **state)
{
    (void)state;
    static const int64_t radii[][3] = {{1, 1, 1}, {0, 2, 1}, {3, 0, 5}, {0, 0, 0}, {7, 1, 2}, {14, 6, 5}};
    const uint64_t seed = test_seed();
    for (int t = 0; t < VV_TYPE_COUNT; t++)
        for (size_t r = 0; r < sizeof radii / sizeof *radii; r++)
            try((int64_t[]){13, 5, 4}, (vv_type)t, 1 + t % 3, radii[r], seed + (uint64_t)t);
}

static void all_sizes_equal_a_sum(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{1, 1, 1},   {1, 9, 1},   {1, 1, 9},  {2, 3, 1},
                                       {131, 3, 2}, {257, 2, 1}, {3, 29, 31}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        try(sizes[s], VV_TYPE_U8, 1, (int64_t[]){1, 1, 1}, s);
        try(sizes[s], VV_TYPE_F32, 1, (int64_t[]){2, 1, 3}, s);
    }
}

static void nan_do_not_count_and_stay(void **state)
{
    (void)state;
    for (int wide = 0; wide < 2; wide++) {
        const vv_field_info info = info_of((int64_t[]){17, 9, 5}, wide ? VV_TYPE_F64 : VV_TYPE_F32, 2);
        vv_field *in;
        void *data;
        assert_int_equal(vv_field_new_empty(&in, &data, &info, NULL), VV_OK);
        for (size_t i = 0; i < 2 * 17 * 9 * 5; i++) {
            const double v = test_random(3, i) % 3 ? (double)(test_random(4, i) % 100) : NAN;
            if (wide)
                ((double *)data)[i] = v;
            else
                ((float *)data)[i] = (float)v;
        }
        vv_field *out = mean_of(in, NULL);
        expect_means(in, out, (int64_t[]){1, 1, 1});
        vv_field_release(in);
        vv_field_release(out);
    }
}

/* What is large leaves no trace where it is not in the box. */
/* Larger than a tile along each axis in turn, and NaN that come late: the sums before them are of ones. */
static void tiles_change_nothing(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{259, 3, 2}, {3, 71, 5}, {5, 2, 61}, {13, 34, 17}};
    static const int64_t radii[][3] = {{2, 1, 0}, {1, 3, 1}, {0, 1, 5}, {3, 0, 4}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes * 2; s++) {
        const int64_t *dims = sizes[s / 2], *r = radii[s / 2];
        const vv_field_info info = info_of(dims, s % 2 ? VV_TYPE_F32 : VV_TYPE_U8, 1);
        const size_t n = (size_t)(dims[0] * dims[1] * dims[2]);
        char settings[96];
        vv_field *in;
        void *data;
        assert_int_equal(vv_field_new_empty(&in, &data, &info, NULL), VV_OK);
        for (size_t i = 0; i < n; i++)
            if (s % 2)
                ((float *)data)[i] = i > n / 2 && test_random(s, i) % 50 == 0 ? NAN : (float)test_random_unit(s, i);
            else
                ((uint8_t *)data)[i] = (uint8_t)test_random(s, i);
        snprintf(settings, sizeof settings, "radius_voxels=[%d,%d,%d]", (int)r[0], (int)r[1], (int)r[2]);
        const vv_field *inputs[] = {in};
        vv_field *out = test_apply_all_ways(&vvi_operation_mean, inputs, 1, settings);
        expect_means(in, out, r);
        vv_field_release(in);
        vv_field_release(out);
    }
}

static void large_numbers_stay_where_they_are(void **state)
{
    (void)state;
    const vv_field_info info = info_of((int64_t[]){40, 1, 1}, VV_TYPE_F64, 1);
    vv_field *in;
    void *data;
    assert_int_equal(vv_field_new_empty(&in, &data, &info, NULL), VV_OK);
    for (int i = 0; i < 40; i++)
        ((double *)data)[i] = i == 5 ? 1e300 : i == 9 ? INFINITY : 1;
    vv_field *out = mean_of(in, "radius_voxels=[2,0,0]");
    for (int i = 12; i < 40; i++)
        assert_true(vv_field_value(out, i, 0, 0, 0) == 1);
    assert_true(isinf(vv_field_value(out, 8, 0, 0, 0)));
    vv_field_release(in);
    vv_field_release(out);
}

static void any_box_is_a_part_of_the_whole(void **state)
{
    (void)state;
    static const vv_box boxes[] = {{{0, 0, 0}, {23, 11, 4}}, {{5, 3, 4}, {7, 6, 5}}, {{22, 10, 12}, {1, 1, 1}}};
    const vv_field_info info = info_of((int64_t[]){23, 11, 13}, VV_TYPE_F32, 2);
    const char *settings = "radius_voxels=[3,2,5]";
    vv_field *in = test_field_random(&info, 7, NULL), *whole = mean_of(in, settings);
    vv_object *params = test_params(&vvi_operation_mean, settings, &info.grid);
    for (size_t b = 0; b < sizeof boxes / sizeof *boxes; b++) {
        vv_field *part;
        const vv_field *inputs[] = {in};
        assert_int_equal(vvi_operation_mean.run_box(&part, inputs, 1, params, &boxes[b], NULL), VV_OK);
        for (int64_t k = 0; k < boxes[b].n[2]; k++)
            for (int64_t j = 0; j < boxes[b].n[1]; j++)
                for (int64_t i = 0; i < boxes[b].n[0]; i++)
                    for (int c = 0; c < 2; c++)
                        assert_true(vv_field_value(part, i, j, k, c) == vv_field_value(whole, i + boxes[b].lo[0],
                                                                                       j + boxes[b].lo[1],
                                                                                       k + boxes[b].lo[2], c));
        vv_field_release(part);
    }
    vv_object_release(params);
    vv_field_release(whole);
    vv_field_release(in);
}

static void every_instruction_set_gives_the_same(void **state)
{
    (void)state;
    static uint64_t rows[3][300 + VVI_MEAN_GUARD / 8], want[300], got[300];
    for (int r = 0; r < 3; r++)
        for (size_t i = 0; i < sizeof rows[r] / sizeof *rows[r]; i++) {
            const double v = test_random_unit((uint64_t)r, i);
            memcpy(&rows[r][i], &v, sizeof v);
        }
    for (size_t b = 0; vvi_mean_kernels_nth(b); b++)
        for (int number = 0; number < VVI_MEAN_NUMBERS; number++)
            for (int n = 2; n <= 3; n++) {
                const vvi_mean_kernels *kernels = vvi_mean_kernels_nth(b);
                if (kernels->needs & ~vvi_cpu_detect())
                    continue;
                memset(want, 0, sizeof want);
                memset(got, 0, sizeof got);
                vvi_mean_kernels_for(0)->join[number](want, rows[0], rows[1], n == 3 ? rows[2] : NULL, 297);
                kernels->join[number](got, rows[0], rows[1], n == 3 ? rows[2] : NULL, 297);
                assert_memory_equal(got, want, sizeof want);
            }
}

static void what_makes_no_sense_is_refused(void **state)
{
    (void)state;
    vv_field_info info = info_of((int64_t[]){4, 4, 4}, VV_TYPE_U8, 1);
    vv_field *in = test_field_random(&info, 1, NULL), *out;
    assert_int_equal(test_apply(&out, &vvi_operation_mean, in, "radius_voxels=[100,100,100]", NULL), VV_E_ARGUMENT);
    vv_field_release(in);
    info.meaning = VV_MEANING_LABEL;
    in = test_field_random(&info, 1, NULL);
    assert_int_equal(test_apply(&out, &vvi_operation_mean, in, NULL, NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_and_window_equals_a_sum), cmocka_unit_test(all_sizes_equal_a_sum),
        cmocka_unit_test(nan_do_not_count_and_stay),          cmocka_unit_test(tiles_change_nothing),
        cmocka_unit_test(large_numbers_stay_where_they_are),  cmocka_unit_test(any_box_is_a_part_of_the_whole),
        cmocka_unit_test(what_makes_no_sense_is_refused),     cmocka_unit_test(every_instruction_set_gives_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
