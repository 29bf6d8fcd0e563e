/* Gaussian smoothing against a direct sum in double precision, and the laws that it must keep. */
#include "core/cpu.h"
#include "core/memory.h"
#include "fields.h"
#include "filter/gaussian_kernel.h"
#include "grid/field.h"
#include "jobs.h"
#include "operations.h"
#include "registry.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
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

static vv_field *smoothed(const vv_field *in, const char *settings, vv_job *job)
{
    vv_field *out;
    if (test_apply(&out, &vvi_operation_gaussian, in, settings, job) != VV_OK)
        fail_msg("%s: %s", settings ? settings : "no settings", vv_error_last()->message);
    return out;
}

static double weight(int64_t r, double sigma)
{
    return sigma == 0 ? r == 0 : exp(-0.5 * (double)(r * r) / (sigma * sigma));
}

/* All weights of the box around a sample, summed one by one; samples beyond the border are the border's; NaN and
 * infinities do not count. */
static double direct(const vv_field *f, const int64_t at[3], int c, const double sigma[3])
{
    int64_t radius[3];
    double sum = 0, weights = 0;
    for (int a = 0; a < 3; a++)
        radius[a] = vv_field_get_info(f)->grid.dims[a] == 1 ? 0 : (int64_t)(4 * sigma[a] + 0.5);
    for (int64_t k = -radius[2]; k <= radius[2]; k++)
        for (int64_t j = -radius[1]; j <= radius[1]; j++)
            for (int64_t i = -radius[0]; i <= radius[0]; i++) {
                const double w = weight(i, sigma[0]) * weight(j, sigma[1]) * weight(k, sigma[2]);
                const double v = vv_field_value(f, at[0] + i, at[1] + j, at[2] + k, c);
                if (!isfinite(v))
                    continue;
                sum += w * v;
                weights += w;
            }
    return sum / weights;
}

static void expect_direct(const vv_field *in, const vv_field *out, const double sigma[3], double tolerance)
{
    const vv_field_info *info = vv_field_get_info(in);
    const int64_t *d = info->grid.dims;
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
                    const double want = direct(in, at, c, sigma);
                    if (!(fabs(got - want) <= tolerance))
                        fail_msg("%s (%d %d %d): %.17g is not %.17g", vv_type_name(info->type), (int)i, (int)j, (int)k,
                                 got, want);
                }
}

static void every_type_equals_the_direct_sum(void **state)
{
    (void)state;
    const uint64_t seed = test_seed();
    for (int t = 0; t < VV_TYPE_COUNT; t++) {
        const vv_field_info info = info_of(7, 5, 3, (vv_type)t, 1 + t % 3);
        vv_field *in = test_field_random(&info, seed + (uint64_t)t, NULL);
        vv_field *out = smoothed(in, "sigma_voxels=[1.2,0.7,0.6]", NULL);
        const double span = vv_type_is_float(info.type) ? 2000 : vvi_type_max(info.type) - vvi_type_min(info.type);
        const double rounding = vv_type_is_float(info.type) ? 0 : 0.5001;
        const double relative = info.type == VV_TYPE_F64 || vv_type_bytes(info.type) >= 4 ? 1e-14 : 2e-7;
        expect_direct(in, out, (double[3]){1.2, 0.7, 0.6},
                      rounding + span * (info.type == VV_TYPE_F32 ? 2e-7 : relative));
        vv_field_release(in);
        vv_field_release(out);
    }
}

static void all_sizes_down_to_one_sample_equal_the_direct_sum(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{1, 1, 1}, {1, 9, 1}, {1, 1, 9}, {13, 1, 1}, {2, 3, 1}, {3, 1, 2}, {300, 2, 1}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        const vv_field_info info = info_of(sizes[s][0], sizes[s][1], sizes[s][2], VV_TYPE_F64, 1);
        vv_field *in = test_field_random(&info, s, NULL), *out = smoothed(in, "sigma_voxels=[1.5,3,2.5]", NULL);
        expect_direct(in, out, (double[3]){1.5, 3, 2.5}, 1e-10);
        vv_field_release(in);
        vv_field_release(out);
    }
}

static void a_sigma_of_zero_changes_nothing(void **state)
{
    (void)state;
    const vv_field_info info = info_of(5, 4, 3, VV_TYPE_I16, 2);
    vv_field *in = test_field_random(&info, 1, NULL), *out = smoothed(in, "sigma=0", NULL);
    assert_true(test_same_samples(in, out));
    vv_field *z = smoothed(in, "sigma_voxels=[0,0,1]", NULL);
    expect_direct(in, z, (double[3]){0, 0, 1}, 0.51);
    vv_field_release(in);
    vv_field_release(out);
    vv_field_release(z);
}

static void sigma_is_a_length_in_the_world_and_voxels_are_of_each_axis(void **state)
{
    (void)state;
    vv_field_info info = info_of(9, 9, 9, VV_TYPE_F64, 1);
    info.grid.index_to_world.axis[0].x = 0.5;
    info.grid.index_to_world.axis[2].z = 2;
    vv_field *in = test_field_random(&info, 1, NULL);
    vv_field *mm = smoothed(in, "sigma=1mm", NULL), *vox = smoothed(in, "sigma_voxels=[2,1,0.5]", NULL);
    assert_true(test_same_samples(mm, vox));
    vv_field *least = smoothed(in, "sigma=2vox", NULL); /* a voxel as a length is the smallest spacing */
    assert_true(test_same_samples(mm, least));
    vv_field *plain = smoothed(in, NULL, NULL), *ones = smoothed(in, "sigma_voxels=[1,1,1]", NULL);
    assert_true(test_same_samples(plain, ones));
    vv_field *all[] = {in, mm, vox, least, plain, ones};
    for (int i = 0; i < 6; i++)
        vv_field_release(all[i]);
}

static void an_impulse_becomes_a_gaussian_of_that_deviation(void **state)
{
    (void)state;
    const vv_field_info info = info_of(33, 33, 33, VV_TYPE_F64, 1);
    vv_field *in;
    void *data;
    assert_int_equal(vv_field_new_empty(&in, &data, &info, NULL), VV_OK);
    memset(data, 0, 33 * 33 * 33 * sizeof(double));
    ((double *)data)[(16 * 33 + 16) * 33 + 16] = 1;
    vv_field *out = smoothed(in, "sigma_voxels=[1,2,3]", NULL);
    double sum = 0, mean[3] = {0}, square[3] = {0};
    for (int64_t k = 0; k < 33; k++)
        for (int64_t j = 0; j < 33; j++)
            for (int64_t i = 0; i < 33; i++) {
                const double v = vv_field_value(out, i, j, k, 0);
                const double r[3] = {(double)(i - 16), (double)(j - 16), (double)(k - 16)};
                sum += v;
                for (int a = 0; a < 3; a++) {
                    mean[a] += v * r[a];
                    square[a] += v * r[a] * r[a];
                }
            }
    assert_true(fabs(sum - 1) < 1e-12);
    for (int a = 0; a < 3; a++) {
        assert_true(fabs(mean[a]) < 1e-12);
        assert_true(fabs(square[a] / ((a + 1) * (a + 1)) - 1) < 2e-3); /* cut at 4 sigma: 1.1e-3 less */
    }
    vv_field_release(in);
    vv_field_release(out);
}

static void a_constant_stays_exactly_what_it_is(void **state)
{
    (void)state;
    for (int t = 0; t < VV_TYPE_COUNT; t++) {
        vv_field_info info = info_of(19, 5, 4, (vv_type)t, 1);
        info.value_scale = 0.1; /* 42 / 0.1 is no round number in floats */
        info.value_offset = 30.3;
        vv_field *in = test_field(&test_form_constant, &info, NULL), *out = smoothed(in, "sigma=1.7", NULL);
        assert_true(test_same_samples(in, out));
        vv_field_release(in);
        vv_field_release(out);
    }
}

static void a_ramp_stays_a_ramp_away_from_the_border(void **state)
{
    (void)state;
    vv_field_info info = info_of(21, 21, 21, VV_TYPE_F64, 1);
    vv_field *in = test_field(&test_form_ramp, &info, NULL), *out = smoothed(in, "sigma=1.5", NULL);
    for (int64_t k = 6; k < 15; k++)
        for (int64_t j = 6; j < 15; j++)
            for (int64_t i = 6; i < 15; i++)
                assert_true(fabs(vv_field_value(out, i, j, k, 0) - vv_field_value(in, i, j, k, 0)) < 1e-12);
    vv_field_release(in);
    vv_field_release(out);
}

static void missing_samples_stay_missing_and_do_not_spread(void **state)
{
    (void)state;
    for (int t = VV_TYPE_F32; t <= VV_TYPE_F64; t++) {
        const vv_field_info info = info_of(8, 7, 6, (vv_type)t, 2);
        vv_field *random = test_field_random(&info, 4, NULL), *in;
        void *data;
        double v[8 * 7 * 6 * 2];
        for (int i = 0; i < 8 * 7 * 6 * 2; i++)
            v[i] = vv_field_value(random, i / 2 % 8, i / 16 % 7, i / 112, i % 2);
        v[17] = v[18] = v[300] = NAN;
        v[400] = INFINITY;
        v[401] = -INFINITY;
        assert_int_equal(vv_field_new_empty(&in, &data, &info, NULL), VV_OK);
        vvi_samples_from_f64(data, v, info.type, sizeof v / sizeof *v);
        vv_field *out = smoothed(in, "sigma=0.8", NULL);
        expect_direct(in, out, (double[3]){0.8, 0.8, 0.8}, t == VV_TYPE_F32 ? 1e-3 : 1e-10);
        vv_field_release(random);
        vv_field_release(in);
        vv_field_release(out);
    }
}

static void thread_count_changes_no_byte(void **state)
{
    (void)state;
    static const vv_type types[] = {VV_TYPE_U8, VV_TYPE_F32, VV_TYPE_I32};
    for (int t = 0; t < 3; t++) {
        const vv_field_info info = info_of(37, 29, 31, types[t], 1);
        vv_field *in = test_field_random(&info, 4, NULL), *first = smoothed(in, "sigma=2", NULL);
        for (int threads = 1; threads <= 3; threads++) {
            vv_job *job = test_job(threads, 0);
            vv_field *out = smoothed(in, "sigma=2", job);
            assert_true(test_same_samples(first, out));
            vv_field_release(out);
            vv_job_release(job);
        }
        vv_field_release(in);
        vv_field_release(first);
    }
}

/* Larger than a tile along each axis in turn; what is missing is in some of the tiles. */
static void tiles_change_nothing(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{259, 3, 2}, {3, 71, 5}, {5, 2, 61}, {13, 34, 17}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (int odd = 0; odd < 2; odd++) {
            const vv_field_info info = info_of(sizes[s][0], sizes[s][1], sizes[s][2], VV_TYPE_F32, 1 + s % 2);
            const size_t n = (size_t)(sizes[s][0] * sizes[s][1] * sizes[s][2] * info.components);
            vv_field *random = test_field_random(&info, s, NULL), *in;
            void *data;
            vv_brick brick;
            const vv_box all = vv_field_box(random);
            assert_int_equal(vv_field_brick(&brick, random, &all, NULL), VV_OK);
            assert_int_equal(vv_field_new_empty(&in, &data, &info, NULL), VV_OK);
            memcpy(data, brick.data, n * sizeof(float));
            vv_brick_release(&brick);
            if (odd)
                ((float *)data)[n / 3] = NAN, ((float *)data)[n - 1] = INFINITY;
            const vv_field *inputs[] = {in};
            vv_field *out = test_apply_all_ways(&vvi_operation_gaussian, inputs, 1, "sigma_voxels=[0.8,0.7,1.2]");
            expect_direct(in, out, (double[3]){0.8, 0.7, 1.2}, 1e-3);
            vv_field_release(random);
            vv_field_release(in);
            vv_field_release(out);
        }
}

static void every_instruction_set_gives_the_same(void **state)
{
    (void)state;
    enum { MOST = 200, RADIUS = 9 };
    static double room[MOST + 2 * RADIUS + VVI_GAUSSIAN_GUARD], want[2][MOST + VVI_GAUSSIAN_GUARD],
        got[2][MOST + VVI_GAUSSIAN_GUARD];
    static char bytes[2][MOST * 8 + VVI_GAUSSIAN_GUARD];
    static const int64_t sizes[] = {1, 15, 16, 17, 63, 64, 65, 127, 199};
    double w[RADIUS + 1];
    const void *rows[2 * RADIUS + 1];
    const vvi_gaussian_kernels *base = vvi_gaussian_kernels_for(0);
    for (int64_t r = 0; r <= RADIUS; r++)
        w[r] = test_random_unit(1, (uint64_t)r);
    for (size_t b = 0; vvi_gaussian_kernels_nth(b); b++) {
        const vvi_gaussian_kernels *kernels = vvi_gaussian_kernels_nth(b);
        if (kernels->needs & ~vvi_cpu_detect())
            continue;
        for (size_t i = 0; i < sizeof sizes / sizeof *sizes * 2 * (RADIUS + 1); i++) {
            const int wide = i % 2;
            const int64_t n = sizes[i / 2 % (sizeof sizes / sizeof *sizes)], radius = (int64_t)i % (RADIUS + 1);
            const vvi_gaussian_weights weights = {radius, w};
            for (size_t k = 0; k < sizeof room / sizeof *room; k++)
                if (wide)
                    room[k] = test_random_unit(i, k) - 0.5;
                else
                    ((float *)(void *)room)[k] = (float)(300 * test_random_unit(i, k) - 20);
            for (int64_t r = 0; r <= 2 * radius; r++)
                rows[r] = wide ? (const void *)(room + r) : (const void *)((float *)(void *)room + r);
            base->sum[wide](want[0], rows, &weights, n);
            kernels->sum[wide](got[0], rows, &weights, n);
            assert_memory_equal(got[0], want[0], (size_t)n * (wide ? 8 : 4));
            for (int t = 0; t < VV_TYPE_COUNT; t++) {
                base->load[wide](want[0], (const char *)room, (vv_type)t, n);
                kernels->load[wide](got[0], (const char *)room, (vv_type)t, n);
                const bool all = base->finite[wide](want[0], want[1], n);
                assert_true(kernels->finite[wide](got[0], got[1], n) == all);
                assert_memory_equal(got[0], want[0], (size_t)n * (wide ? 8 : 4));
                assert_memory_equal(got[1], want[1], (size_t)n * (wide ? 8 : 4));
                if (wide || (vv_type_bytes((vv_type)t) > 2 && t != VV_TYPE_F32))
                    continue;
                base->store(bytes[0], (const float *)(const void *)room, (vv_type)t, n);
                kernels->store(bytes[1], (const float *)(const void *)room, (vv_type)t, n);
                assert_memory_equal(bytes[1], bytes[0], sizeof bytes[0]);
            }
        }
    }
}

static void wrong_sigmas_and_labels_are_refused(void **state)
{
    (void)state;
    vv_field_info info = info_of(4, 4, 4, VV_TYPE_U8, 1);
    vv_field *in = test_field_random(&info, 4, NULL), *out;
    static const char *const wrong[] = {"sigma=-1", "sigma=1e6", "sigma_voxels=[1,-1,0]",
                                        "sigma=1;sigma_voxels=[1,1,1]", "sigma=5lb"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        if (test_apply(&out, &vvi_operation_gaussian, in, wrong[i], NULL) != VV_E_ARGUMENT)
            fail_msg("%s is taken", wrong[i]);
    vv_field_release(in);
    info.meaning = VV_MEANING_LABEL;
    in = test_field_random(&info, 4, NULL);
    assert_int_equal(test_apply(&out, &vvi_operation_gaussian, in, NULL, NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    for (int odd = 0; odd < 2; odd++) {
        const vv_field_info info = info_of(3, 3, 3, odd ? VV_TYPE_F32 : VV_TYPE_U8, 1);
        vv_field *in = test_field_random(&info, 4, NULL), *out;
        const vv_field *input = in;
        vv_object *params = test_params(&vvi_operation_gaussian, "sigma=1", &info.grid);
        vv_status st = VV_E_MEMORY;
        int n = 1;
        for (; st != VV_OK && n < 50; n++) {
            vvi_alloc_fail_after(n);
            st = vv_operation_run(&out, &vvi_operation_gaussian, &input, 1, params, NULL);
            vvi_alloc_fail_after(0);
            vv_field_release(out);
            assert_true(st == VV_OK || st == VV_E_MEMORY);
        }
        assert_int_equal(st, VV_OK);
        assert_true(n > 6);
        vv_object_release(params);
        vv_field_release(in);
    }
}

static void a_cancelled_job_gives_no_field(void **state)
{
    (void)state;
    const vv_field_info info = info_of(16, 16, 16, VV_TYPE_U8, 1);
    vv_field *in = test_field_random(&info, 4, NULL), *out;
    vv_job *job = test_job(2, 0);
    vv_job_cancel(job);
    assert_int_equal(test_apply(&out, &vvi_operation_gaussian, in, "sigma=1", job), VV_E_CANCELLED);
    vv_job_release(job);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_equals_the_direct_sum),
        cmocka_unit_test(all_sizes_down_to_one_sample_equal_the_direct_sum),
        cmocka_unit_test(a_sigma_of_zero_changes_nothing),
        cmocka_unit_test(sigma_is_a_length_in_the_world_and_voxels_are_of_each_axis),
        cmocka_unit_test(an_impulse_becomes_a_gaussian_of_that_deviation),
        cmocka_unit_test(a_constant_stays_exactly_what_it_is),
        cmocka_unit_test(a_ramp_stays_a_ramp_away_from_the_border),
        cmocka_unit_test(missing_samples_stay_missing_and_do_not_spread),
        cmocka_unit_test(thread_count_changes_no_byte),
        cmocka_unit_test(tiles_change_nothing),
        cmocka_unit_test(every_instruction_set_gives_the_same),
        cmocka_unit_test(wrong_sigmas_and_labels_are_refused),
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(a_cancelled_job_gives_no_field),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
