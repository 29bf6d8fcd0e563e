/* Bilateral means against a direct sum in double precision, on every type, size and instruction set. */
#include "core/cpu.h"
#include "fields.h"
#include "filter/noise.h"
#include "filter/smoothing_kernel.h"
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
    info.type = type;
    info.components = components;
    strcpy(info.grid.unit, "mm");
    return info;
}

static vv_field *bilateral_of(const vv_field *in, const char *settings)
{
    vv_field *out;
    if (test_apply(&out, &vvi_operation_bilateral, in, settings, NULL) != VV_OK)
        fail_msg("%s: %s", settings ? settings : "no settings", vv_error_last()->message);
    return out;
}

/* A step of 60 along x under noise of +-10, in the range of every type. */
static vv_field *noisy_step(const vv_field_info *info, uint64_t seed)
{
    vv_field *field;
    void *data;
    const size_t row = (size_t)(info->grid.dims[0] * info->components);
    const size_t n = row * (size_t)(info->grid.dims[1] * info->grid.dims[2]), each = vv_type_bytes(info->type);
    assert_int_equal(vv_field_new_empty(&field, &data, info, NULL), VV_OK);
    for (size_t i = 0; i < n; i++) {
        const double v = (i % row > row / 2 ? 90 : 30) + 20 * test_random_unit(seed, i);
        vvi_samples_from_f64((char *)data + i * each, &v, info->type, 1);
    }
    return field;
}

static double direct(const vv_field *f, const int64_t at[3], int c, const double sigma[3], double value_sigma)
{
    const double v = vv_field_value(f, at[0], at[1], at[2], c);
    double sum = 0, weights = 0;
    int64_t r[3];
    for (int a = 0; a < 3; a++)
        r[a] = vv_field_get_info(f)->grid.dims[a] == 1 ? 0 : (int64_t)(3 * sigma[a]);
    for (int64_t k = -r[2]; k <= r[2]; k++)
        for (int64_t j = -r[1]; j <= r[1]; j++)
            for (int64_t i = -r[0]; i <= r[0]; i++) {
                const double x = r[0] ? (double)i / sigma[0] : 0, y = r[1] ? (double)j / sigma[1] : 0,
                             z = r[2] ? (double)k / sigma[2] : 0, far = x * x + y * y + z * z;
                const double u = vv_field_value(f, at[0] + i, at[1] + j, at[2] + k, c);
                if (far > 9 || !isfinite(u))
                    continue;
                const double w = exp(-0.5 * far - 0.5 * (u - v) / value_sigma * (u - v) / value_sigma);
                sum += w * u;
                weights += w;
            }
    return sum / weights;
}

static void expect_direct(const vv_field *in, const vv_field *out, const double sigma[3], double value_sigma)
{
    const vv_field_info *info = vv_field_get_info(in);
    const int64_t *d = info->grid.dims;
    const double tolerance = (vv_type_is_float(info->type) ? 5e-5 : 0.50002) * fabs(info->value_scale);
    for (int64_t k = 0; k < d[2]; k++)
        for (int64_t j = 0; j < d[1]; j++)
            for (int64_t i = 0; i < d[0]; i++)
                for (int c = 0; c < info->components; c++) {
                    const int64_t at[3] = {i, j, k};
                    const double was = vv_field_value(in, i, j, k, c), got = vv_field_value(out, i, j, k, c);
                    if (!isfinite(was)) {
                        assert_true(isnan(was) ? isnan(got) : got == was);
                        continue;
                    }
                    const double want = direct(in, at, c, sigma, value_sigma);
                    if (!(fabs(got - want) <= tolerance))
                        fail_msg("%s (%d %d %d): %.9g is not %.9g", vv_type_name(info->type), (int)i, (int)j, (int)k,
                                 got, want);
                }
}

static void every_type_and_size_equals_a_direct_sum(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{37, 5, 4}, {1, 1, 1}, {1, 9, 2}, {2, 1, 9}, {131, 3, 1}};
    const uint64_t seed = test_seed();
    for (int t = 0; t < VV_TYPE_COUNT; t++)
        for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
            const vv_field_info info = info_of(sizes[s][0], sizes[s][1], sizes[s][2], (vv_type)t, 1 + t % 3);
            vv_field *in = noisy_step(&info, seed + s);
            vv_field *out = bilateral_of(in, "sigma_voxels=[1,0.7,0.4];value_sigma=15");
            expect_direct(in, out, (double[]){1, 0.7, 0.4}, 15);
            vv_field_release(in);
            vv_field_release(out);
        }
}

static void what_is_missing_does_not_count_and_stays(void **state)
{
    (void)state;
    for (int wide = 0; wide < 2; wide++) {
        const vv_field_info info = info_of(19, 7, 5, wide ? VV_TYPE_F64 : VV_TYPE_F32, 1);
        vv_field *in;
        void *data;
        assert_int_equal(vv_field_new_empty(&in, &data, &info, NULL), VV_OK);
        for (size_t i = 0; i < 19 * 7 * 5; i++) {
            const uint64_t random = test_random(3, i);
            const double v = random % 5   ? (double)(random / 8 % 100)
                             : random % 2 ? NAN
                             : random % 4 ? INFINITY
                                          : -INFINITY;
            vvi_samples_from_f64((char *)data + i * vv_type_bytes(info.type), &v, info.type, 1);
        }
        vv_field *out = bilateral_of(in, "value_sigma=40");
        expect_direct(in, out, (double[]){1, 1, 1}, 40);
        vv_field_release(in);
        vv_field_release(out);
    }
}

static void lengths_and_values_are_those_of_the_world(void **state)
{
    (void)state;
    vv_field_info info = info_of(23, 9, 7, VV_TYPE_I16, 1);
    info.grid.index_to_world.axis[0].x = 0.5;
    info.grid.index_to_world.axis[2].z = 2;
    info.value_scale = -0.25;
    info.value_offset = 1000;
    vv_field *in = noisy_step(&info, 9), *out = bilateral_of(in, "sigma=1mm;value_sigma=4");
    expect_direct(in, out, (double[]){2, 1, 0.5}, 4);
    vv_field *none = bilateral_of(in, "value_sigma=0"), *nowhere = bilateral_of(in, "sigma=0");
    assert_true(test_same_samples(in, none));
    assert_true(test_same_samples(in, nowhere));
    vv_field *all[] = {in, out, none, nowhere};
    for (int i = 0; i < 4; i++)
        vv_field_release(all[i]);
}

/* Of uniform noise the median size of differences is nearly that of a normal distribution of the same deviation. */
static void noise_is_found_beside_edges_and_empty_background(void **state)
{
    (void)state;
    const vv_field_info info = info_of(240, 25, 20, VV_TYPE_F32, 1);
    vv_field *in, *out;
    void *data;
    double noise;
    assert_int_equal(vv_field_new_empty(&in, &data, &info, NULL), VV_OK);
    for (size_t i = 0; i < 240 * 25 * 20; i++) {
        double normal = -6;
        for (uint64_t s = 0; s < 12; s++)
            normal += test_random_unit(5, 12 * i + s);
        ((float *)data)[i] = i % 240 < 80 ? 0 : (float)((i % 240 < 160 ? 100 : 900) + 7 * normal);
    }
    assert_int_equal(vvi_noise(&noise, in, 0, NULL), VV_OK);
    if (!(fabs(noise - 7) < 0.35))
        fail_msg("%g is not 7", noise);
    out = bilateral_of(in, NULL);
    expect_direct(in, out, (double[]){1, 1, 1}, 2 * noise);
    vv_field_release(in);
    vv_field_release(out);
}

static void every_instruction_set_gives_nearly_the_same(void **state)
{
    (void)state;
    enum { N = 45 };
    static float row[3 * N + 2 * VVI_SMOOTHING_GUARD], want[N + VVI_SMOOTHING_GUARD], got[N + VVI_SMOOTHING_GUARD];
    int64_t offset[] = {-N, -1, 0, 1, N};
    float weight[] = {-1, -0.5f, 0, -0.5f, -1};
    const vvi_bilateral_taps taps = {5, offset, weight};
    for (size_t i = 0; i < sizeof row / sizeof *row; i++)
        row[i] = (float)test_random_unit(1, i);
    vvi_smoothing_kernels_for(0)->bilateral[0](want, row + N, &taps, 0.3, N);
    for (size_t b = 0; vvi_smoothing_kernels_nth(b); b++) {
        const vvi_smoothing_kernels *kernels = vvi_smoothing_kernels_nth(b);
        if (kernels->needs & ~vvi_cpu_detect())
            continue;
        kernels->bilateral[0](got, row + N, &taps, 0.3, N);
        for (int i = 0; i < N; i++)
            assert_true(fabsf(got[i] - want[i]) < 1e-6f);
    }
}

static void what_makes_no_sense_is_refused(void **state)
{
    (void)state;
    vv_field_info info = info_of(40, 40, 40, VV_TYPE_U8, 1);
    vv_field *in = test_field_random(&info, 1, NULL), *out;
    static const char *const wrong[] = {"sigma_voxels=[8,8,8]", "sigma_voxels=[-1,1,1]", "sigma=1;sigma_voxels=[1,1,1]",
                                        "value_sigma=-1"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(test_apply(&out, &vvi_operation_bilateral, in, wrong[i], NULL), VV_E_ARGUMENT);
    vv_field_release(in);
    info.meaning = VV_MEANING_LABEL;
    in = test_field_random(&info, 1, NULL);
    assert_int_equal(test_apply(&out, &vvi_operation_bilateral, in, NULL, NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_and_size_equals_a_direct_sum),
        cmocka_unit_test(what_is_missing_does_not_count_and_stays),
        cmocka_unit_test(lengths_and_values_are_those_of_the_world),
        cmocka_unit_test(noise_is_found_beside_edges_and_empty_background),
        cmocka_unit_test(every_instruction_set_gives_nearly_the_same),
        cmocka_unit_test(what_makes_no_sense_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
