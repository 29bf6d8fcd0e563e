/* Statistics against plain sums and sorting. */
#include "core/cache.h"
#include "fail_alloc.h"
#include "fields.h"
#include "grid/field.h"
#include "jobs.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static vv_statistics statistics(const vv_field *field, int component, vv_job *job)
{
    vv_statistics s;
    assert_int_equal(vv_field_statistics(&s, field, component, job), VV_OK);
    return s;
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Every finite value of a component, sorted. */
static size_t sorted(double *out, const vv_field *f, int c)
{
    const int64_t *d = vv_field_get_info(f)->grid.dims;
    size_t n = 0;
    for (int64_t k = 0; k < d[2]; k++)
        for (int64_t j = 0; j < d[1]; j++)
            for (int64_t i = 0; i < d[0]; i++) {
                const double v = vv_field_value(f, i, j, k, c);
                if (isfinite(v))
                    out[n++] = v;
            }
    qsort(out, n, sizeof *out, by_size);
    return n;
}

static void check_histogram(const vv_statistics *s, const double *v, size_t n, bool whole)
{
    uint64_t sum = 0;
    const double width = (s->histogram_hi - s->histogram_lo) / s->n_bins;
    size_t i = 0;
    for (int b = 0; b < s->n_bins; b++) {
        size_t in_bin = 0;
        const double end = s->histogram_lo + (b + 1) * width;
        const double slack = whole ? 0 : 1e-9 * (s->histogram_hi - s->histogram_lo);
        while (i < n && (b + 1 == s->n_bins || v[i] < end - slack))
            in_bin++, i++;
        if (whole) /* real values may lie on an edge up to rounding */
            assert_int_equal(s->histogram[b], in_bin);
        sum += s->histogram[b];
    }
    assert_int_equal(sum, n);
}

static void check(const vv_field *f, int c, vv_job *job)
{
    static double v[40000];
    static const double percents[5] = {0.1, 1, 50, 99, 99.9};
    const vv_field_info *info = vv_field_get_info(f);
    const vv_statistics s = statistics(f, c, job);
    const size_t n = sorted(v, f, c);
    assert_int_equal(s.count, n);
    assert_true(s.min == v[0] && s.max == v[n - 1]);
    long double sum = 0, squares = 0;
    for (size_t i = 0; i < n; i++)
        sum += v[i];
    const long double mean = sum / (long double)n;
    for (size_t i = 0; i < n; i++)
        squares += (v[i] - mean) * (v[i] - mean);
    const double deviation = (double)sqrtl(squares / (long double)n);
    const double span = fmax(fabs(s.min), fabs(s.max));
    assert_true(fabs(s.mean - (double)mean) <= 1e-13 * span);
    assert_true(fabs(s.deviation - deviation) <= 1e-13 * span);
    const bool exact = vv_type_bytes(info->type) <= 2;
    const double bin = s.max > s.min ? (s.max - s.min) / 1000 : 0;
    for (int p = 0; p < 5 && info->value_scale > 0; p++) {
        const double at = percents[p] / 100 * (double)(n - 1), part = at - floor(at);
        const double low = v[(size_t)at], high = v[(size_t)ceil(at)];
        const double want = low == high ? low : low * (1 - part) + high * part;
        assert_true(fabs(s.percentile[p] - want) <= (exact ? 1e-13 * span : bin));
    }
    check_histogram(&s, v, n, exact);
}

static void every_type_equals_plain_sums_and_sorting(void **state)
{
    (void)state;
    const uint64_t seed = test_seed();
    static const int64_t dims[][3] = {{1, 1, 1}, {3, 1, 2}, {17, 13, 11}, {31, 37, 29}};
    for (int t = 0; t < VV_TYPE_COUNT; t++)
        for (int d = 0; d < 4; d++) {
            vv_field_info info = vv_field_info_default();
            memcpy(info.grid.dims, dims[d], sizeof dims[d]);
            info.type = (vv_type)t;
            info.components = 1 + (t + d) % 3;
            vv_field *f = test_field_random(&info, seed + (uint64_t)t, NULL);
            for (int c = 0; c < info.components; c++)
                check(f, c, NULL);
            vv_field_release(f);
        }
}

static void integers_of_few_values_have_one_bin_each(void **state)
{
    (void)state;
    static const int16_t data[8] = {-3, -3, 5, 0, 5, 5, 1, -3};
    static const int32_t wide[8] = {-3, -3, 5, 0, 5, 5, 1, -3};
    for (int t = 0; t < 2; t++) {
        vv_field_info info = vv_field_info_default();
        info.type = t ? VV_TYPE_I32 : VV_TYPE_I16;
        info.grid.dims[0] = 8;
        vv_field *f;
        assert_int_equal(vv_field_new(&f, &info, t ? (const void *)wide : data, 0, NULL, NULL, NULL), VV_OK);
        const vv_statistics s = statistics(f, 0, NULL);
        assert_int_equal(s.n_bins, 9);
        assert_true(s.histogram_lo == -3.5 && s.histogram_hi == 5.5);
        assert_true(s.histogram[0] == 3 && s.histogram[3] == 1 && s.histogram[4] == 1 && s.histogram[8] == 3);
        assert_true(s.percentile[2] == 0.5 && s.percentile[0] == -3 && s.percentile[4] == 5);
        vv_field_release(f);
    }
}

static void bins_of_many_integers_hold_equally_many_of_them(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_U16;
    info.grid.dims[0] = 5000; /* 0 .. 4999, each once */
    vv_field *f;
    uint16_t *data;
    void *memory;
    assert_int_equal(vv_field_new_empty(&f, &memory, &info, NULL), VV_OK);
    data = memory;
    for (int i = 0; i < 5000; i++)
        data[i] = (uint16_t)i;
    const vv_statistics s = statistics(f, 0, NULL);
    assert_int_equal(s.n_bins, 1000);
    for (int b = 0; b < s.n_bins; b++)
        assert_int_equal(s.histogram[b], 5);
    vv_field_release(f);
}

static void nan_and_infinity_are_counted_and_left_out(void **state)
{
    (void)state;
    for (int t = VV_TYPE_F32; t <= VV_TYPE_F64; t++) {
        static const double v[7] = {NAN, 1, INFINITY, 3, -INFINITY, -NAN, 2};
        vv_field_info info = vv_field_info_default();
        info.type = (vv_type)t;
        info.grid.dims[2] = 7;
        vv_field *f;
        void *data;
        assert_int_equal(vv_field_new_empty(&f, &data, &info, NULL), VV_OK);
        vvi_samples_from_f64(data, v, info.type, 7);
        const vv_statistics s = statistics(f, 0, NULL);
        assert_true(s.nan_count == 2 && s.infinite_count == 2 && s.count == 3);
        assert_true(s.min == 1 && s.max == 3 && s.mean == 2);
        assert_true(fabs(s.deviation - sqrt(2.0 / 3)) < 1e-15);
        vv_field_release(f);
    }
}

static void a_field_without_a_finite_sample_gives_zeros(void **state)
{
    (void)state;
    static const float v[2] = {NAN, INFINITY};
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = 2;
    vv_field *f;
    assert_int_equal(vv_field_new(&f, &info, v, 0, NULL, NULL, NULL), VV_OK);
    const vv_statistics s = statistics(f, 0, NULL);
    assert_true(s.count == 0 && s.min == 0 && s.max == 0 && s.mean == 0 && s.n_bins == 0);
    vv_field_release(f);
}

static void numbers_are_values_also_when_the_scale_is_negative(void **state)
{
    (void)state;
    for (int t = 0; t < VV_TYPE_COUNT; t++) {
        vv_field_info info = vv_field_info_default();
        info.type = (vv_type)t;
        info.grid.dims[0] = 101;
        info.value_scale = -0.5;
        info.value_offset = 7;
        vv_field *f;
        void *data;
        assert_int_equal(vv_field_new_empty(&f, &data, &info, NULL), VV_OK);
        for (int i = 0; i < 101; i++) {
            const double v = i == 0 ? 127 : i == 1 ? 120 : 100; /* values -56.5, -53, 43 times 99 */
            vvi_samples_from_f64((char *)data + (size_t)i * vv_type_bytes(info.type), &v, info.type, 1);
        }
        const vv_statistics s = statistics(f, 0, NULL);
        assert_true(s.min == -56.5 && s.max == -43);
        assert_true(fabs(s.percentile[0] + 56.15) < 0.02 && fabs(s.percentile[2] + 43) < 0.02);
        assert_true(s.histogram_lo < s.histogram_hi);
        assert_true(s.histogram[0] == 1 && s.histogram[s.n_bins - 1] == 99);
        vv_field_release(f);
    }
}

static void the_largest_doubles_do_not_overflow(void **state)
{
    (void)state;
    static const double v[4] = {DBL_MAX, -DBL_MAX, DBL_MAX, -DBL_MAX};
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F64;
    info.grid.dims[0] = 4;
    vv_field *f;
    assert_int_equal(vv_field_new(&f, &info, v, 0, NULL, NULL, NULL), VV_OK);
    const vv_statistics s = statistics(f, 0, NULL);
    assert_true(s.min == -DBL_MAX && s.max == DBL_MAX && s.mean == 0);
    assert_true(fabs(s.deviation / DBL_MAX - 1) < 1e-15);
    assert_true(s.histogram[0] == 2 && s.histogram[s.n_bins - 1] == 2);
    vv_field_release(f);
}

static void thread_count_changes_nothing(void **state)
{
    (void)state;
    static const vv_type types[] = {VV_TYPE_U8, VV_TYPE_I16, VV_TYPE_I32, VV_TYPE_F32, VV_TYPE_F64};
    for (int t = 0; t < 5; t++) {
        vv_field_info info = vv_field_info_default();
        info.type = types[t];
        info.grid.dims[0] = 127, info.grid.dims[1] = 131, info.grid.dims[2] = 137; /* several items */
        vv_field *f = test_field_random(&info, 3, NULL);
        const vv_statistics alone = statistics(f, 0, NULL);
        for (int threads = 1; threads <= 3; threads++) {
            vv_job *job = test_job(threads, 0);
            const vv_statistics s = statistics(f, 0, job);
            assert_memory_equal(&s, &alone, sizeof s);
            vv_job_release(job);
        }
        vv_field_release(f);
    }
}

static void they_are_kept_in_the_cache_of_the_job(void **state)
{
    (void)state;
    vv_job *job = test_job(1, 0);
    vv_field *f = test_field_cube(&test_form_ramp, 5, 0, 4, job);
    statistics(f, 0, job);
    vvi_cache_counts before, after;
    vvi_cache_get_counts(&before, vv_job_runtime(job));
    statistics(f, 0, job);
    vvi_cache_get_counts(&after, vv_job_runtime(job));
    assert_int_equal(after.hits, before.hits + 1);
    assert_int_equal(after.misses, before.misses);
    vv_field_release(f);
    vvi_cache_get_counts(&after, vv_job_runtime(job));
    assert_int_equal(after.entries, before.entries - 1);
    vv_job_release(job);
}

static void a_component_that_is_not_there_is_refused(void **state)
{
    (void)state;
    vv_field *f = test_field_cube(&test_form_ramp, 2, 0, 1, NULL);
    vv_statistics s;
    assert_int_equal(vv_field_statistics(&s, f, 1, NULL), VV_E_ARGUMENT);
    assert_int_equal(vv_field_statistics(&s, f, -1, NULL), VV_E_ARGUMENT);
    vv_field_release(f);
}

static vv_status act(void *user)
{
    vv_statistics s;
    return vv_field_statistics(&s, user, 0, NULL);
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    static const vv_type types[] = {VV_TYPE_U8, VV_TYPE_U16, VV_TYPE_F32};
    for (int t = 0; t < 3; t++) {
        vv_field_info info = vv_field_info_default();
        info.type = types[t];
        vv_field *f = test_field_random(&info, 3, NULL);
        assert_true(test_fail_each_alloc(act, f) >= 2);
        vv_field_release(f);
    }
}

static void a_cancelled_job_stops(void **state)
{
    (void)state;
    vv_job *job = test_job(2, 0);
    vv_field *f = test_field_cube(&test_form_ramp, 5, 0, 4, job);
    vv_job_cancel(job);
    vv_statistics s;
    assert_int_equal(vv_field_statistics(&s, f, 0, job), VV_E_CANCELLED);
    vv_field_release(f);
    vv_job_release(job);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_equals_plain_sums_and_sorting),
        cmocka_unit_test(integers_of_few_values_have_one_bin_each),
        cmocka_unit_test(bins_of_many_integers_hold_equally_many_of_them),
        cmocka_unit_test(nan_and_infinity_are_counted_and_left_out),
        cmocka_unit_test(a_field_without_a_finite_sample_gives_zeros),
        cmocka_unit_test(numbers_are_values_also_when_the_scale_is_negative),
        cmocka_unit_test(the_largest_doubles_do_not_overflow),
        cmocka_unit_test(thread_count_changes_nothing),
        cmocka_unit_test(they_are_kept_in_the_cache_of_the_job),
        cmocka_unit_test(a_component_that_is_not_there_is_refused),
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(a_cancelled_job_stops),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
