/* Splines and sharpened histograms, where the result is known. */
#include "fields.h"
#include "filter/sharpen.h"
#include "filter/spline_field.h"
#include "jobs.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

enum { N = 13, KNOTS = 4 + 3 };

static void weights_of_knots_are_one_and_follow_lines(void **state)
{
    (void)state;
    for (int64_t spans = 1; spans < 9; spans++)
        for (int i = 0; i <= 50; i++) {
            const vvi_knot k = vvi_knot_at(i / 50.0, spans);
            double sum = 0, place = 0;
            assert_true(k.first >= 0 && k.first + 4 <= spans + 3);
            for (int a = 0; a < 4; a++) {
                assert_true(k.weight[a] >= 0);
                sum += k.weight[a];
                place += k.weight[a] * (k.first + a - 1); /* knot 1 lies at 0 */
            }
            assert_true(fabs(sum - 1) < 1e-14 && fabs(place - i / 50.0 * (double)spans) < 1e-12);
        }
}

static void fit_all(vvi_lattice *lattice, const double *v, int threads)
{
    static vvi_knot knots[N];
    vvi_spline_samples samples = {{N, N, N}, {knots, knots, knots}, v};
    vv_job *job = test_job(threads, 0);
    for (int i = 0; i < N; i++)
        knots[i] = vvi_knot_at(i / (N - 1.0), 4);
    assert_int_equal(vvi_lattice_fit(lattice, &samples, job), VV_OK);
    vv_job_release(job);
}

static double value(const double *c, int i, int j, int k)
{
    double row[KNOTS];
    const vvi_lattice lattice = {{4, 4, 4}, (double *)(uintptr_t)c};
    const vvi_knot x = vvi_knot_at(i / (N - 1.0), 4), y = vvi_knot_at(j / (N - 1.0), 4),
                   z = vvi_knot_at(k / (N - 1.0), 4);
    vvi_lattice_row(row, &lattice, &y, &z);
    return vvi_lattice_value(row, &x);
}

/* One fit is a smooth version of the samples; fits of what is left come to them. */
static void fits_of_a_smooth_field_come_to_it_also_where_samples_are_missing(void **state)
{
    (void)state;
    static double v[N * N * N], rest[N * N * N], c[KNOTS * KNOTS * KNOTS], again[KNOTS * KNOTS * KNOTS];
    vvi_lattice lattice = {{4, 4, 4}, c}, other = {{4, 4, 4}, again};
    for (int n = 0; n < N * N * N; n++) {
        const int i = n % N, j = n / N % N, k = n / N / N;
        const double x = i / 12.0, y = j / 12.0, z = k / 12.0;
        v[n] = n % 7 == 3 ? NAN : 0.5 * sin(2 * x) - y * z + 0.3 * x * z;
    }
    for (int round = 0; round < 60; round++) {
        for (int n = 0; n < N * N * N; n++)
            rest[n] = v[n] - value(c, n % N, n / N % N, n / N / N);
        if (round == 0) {
            fit_all(&other, rest, 3);
            fit_all(&lattice, rest, 1);
            assert_memory_equal(c, again, sizeof c);
        } else
            fit_all(&lattice, rest, 2);
    }
    double most = 0, squares = 0;
    for (int n = 0; n < N * N * N; n++) {
        const double off = isnan(v[n]) ? 0 : value(c, n % N, n / N % N, n / N / N) - v[n];
        most = fmax(most, fabs(off));
        squares += off * off / (N * N * N);
    }
    if (!(most < 0.1 && sqrt(squares) < 0.01))
        fail_msg("off by %g at most, %g on average", most, sqrt(squares));
}

/* Two tissues that a field has blurred: what lies between is expected nearer to one of them. */
static void sharpening_moves_values_to_the_peaks(void **state)
{
    (void)state;
    enum { COUNT = 40000 };
    static double v[COUNT];
    vvi_sharpened s;
    for (int i = 0; i < COUNT; i++) {
        double gauss = -6;
        for (uint64_t u = 0; u < 12; u++)
            gauss += test_random_unit(5, (uint64_t)i * 12 + u);
        v[i] = i % 10 == 0 ? NAN : (i % 2 ? 1 : 2) + 0.1 * gauss;
    }
    assert_true(vvi_sharpen(&s, v, COUNT, 0.15, 0.01));
    assert_true(fabs(vvi_sharpened_value(&s, 1) - 1) < 0.02 && fabs(vvi_sharpened_value(&s, 2) - 2) < 0.02);
    assert_true(vvi_sharpened_value(&s, 1.2) < 1.19 && vvi_sharpened_value(&s, 1.8) > 1.81);
    for (int i = 0; i < 10; i++)
        v[i] = 3;
    assert_false(vvi_sharpen(&s, v, 10, 0.15, 0.01));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(weights_of_knots_are_one_and_follow_lines),
        cmocka_unit_test(fits_of_a_smooth_field_come_to_it_also_where_samples_are_missing),
        cmocka_unit_test(sharpening_moves_values_to_the_peaks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
