/* What a histogram says of the object, and the border of the background. Histograms are made by hand. */
#include "fields.h"
#include "grid/value_sides.h"
#include "jobs.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Whole numbers from `first` on, count[i] times each, n of them. */
static vv_statistics counted(const double *count, int n, double first)
{
    vv_statistics s = {.n_bins = n, .histogram_lo = first - 0.5, .histogram_hi = first + n - 0.5};
    static const double percents[5] = {0.1, 1, 50, 99, 99.9};
    double below = 0;
    int q = 0;
    s.min = INFINITY;
    for (int i = 0; i < n; i++) {
        s.histogram[i] = (uint64_t)count[i];
        s.count += s.histogram[i];
        s.min = s.histogram[i] ? fmin(s.min, first + i) : s.min;
        s.max = s.histogram[i] ? first + i : s.max;
    }
    for (int i = 0; i < n; i++)
        for (below += (double)s.histogram[i]; q < 5 && below >= percents[q] / 100 * (double)s.count; q++)
            s.percentile[q] = first + i;
    return s;
}

static double bell(double x, double middle, double width, double height)
{
    return floor(height * exp(-0.5 * (x - middle) * (x - middle) / (width * width)));
}

/* An object that is a hill, in a background that is a peak. */
static void make_scene(double count[256], double background, double object)
{
    for (int i = 0; i < 256; i++)
        count[i] = bell(i, background, 2, 40000) + bell(i, object, 20, 1000);
}

static vvi_border border_at(int bin)
{
    vvi_border border = {.n = 1000};
    border.count[bin] = 960;
    border.count[128] += 40;
    return border;
}

static void a_bright_background_is_known_by_the_border(void **state)
{
    double count[256];
    make_scene(count, 240, 100);
    const vv_statistics s = counted(count, 256, 0);
    const vvi_border border = border_at(240), of_object = border_at(100);
    vvi_value_fit fit;
    vvi_fit_values(&fit, &s, NULL);
    assert_true(fit.high_peak && !fit.falls && fit.share == 1);
    vvi_fit_values(&fit, &s, &border);
    assert_true(fit.falls && fit.hi > 200 && fit.hi < 239);
    assert_true(fit.lo > 30 && fit.lo < 80 && fabs(fit.median - 100.5) < 3);
    assert_true(fit.share > 0.1 && fit.share < 0.25);
    vvi_fit_values(&fit, &s, &of_object); /* what fills the border is not the peak */
    assert_false(fit.falls && fit.hi > 200);
}

static void a_mirrored_histogram_has_the_mirrored_fit(void **state)
{
    double count[256], mirrored[256];
    make_scene(count, 15, 155);
    for (int i = 0; i < 256; i++)
        mirrored[i] = count[255 - i];
    const vv_statistics a = counted(count, 256, 0), b = counted(mirrored, 256, 0);
    const vvi_border border = border_at(240);
    vvi_value_fit up, down;
    vvi_fit_values(&up, &a, NULL);
    vvi_fit_values(&down, &b, &border);
    assert_true(!up.falls && down.falls);
    assert_true(fabs(255 - down.hi - up.lo) <= 4 && fabs(255 - down.lo - up.hi) <= 4);
    assert_true(fabs(down.share - up.share) < 0.02);
}

/* More above it than below: the object is above, though the peak lies in the upper half. */
static void a_background_in_the_middle_has_the_object_on_the_fuller_side(void **state)
{
    double count[256];
    for (int i = 0; i < 256; i++)
        count[i] = bell(i, 170, 3, 40000) + bell(i, 240, 5, 8000) + 10;
    const vv_statistics s = counted(count, 256, 0);
    const vvi_border border = border_at(170);
    vvi_value_fit fit;
    vvi_fit_values(&fit, &s, &border);
    assert_true(!fit.falls && fit.lo > 172 && fit.lo < 215 && fit.hi > 240);
}

/* The border is like all the rest, so nothing stands in anything. */
static void a_field_that_fills_its_box_has_no_background(void **state)
{
    double count[256];
    make_scene(count, 200, 60);
    const vv_statistics s = counted(count, 256, 0);
    vvi_border border = {.n = 0};
    for (int i = 0; i < 256; i++) {
        border.count[i] = (uint64_t)(count[i] / 100);
        border.n += border.count[i];
    }
    vvi_value_fit fit;
    vvi_fit_values(&fit, &s, &border);
    assert_true(!fit.falls && fit.share == 1 && fit.lo < 2);
}

static void dead_pixels_below_all_others_are_no_values(void **state)
{
    double count[1024] = {0};
    for (int i = 900; i < 1024; i++)
        count[i] = bell(i, 905, 2, 200000) + bell(i, 980, 10, 10000);
    const vv_statistics clean = counted(count + 900, 124, 900);
    count[0] = 250; /* 0.02 % */
    const vv_statistics dead = counted(count, 1024, 0);
    vvi_value_fit a, b;
    vvi_fit_values(&a, &clean, NULL);
    vvi_fit_values(&b, &dead, NULL);
    assert_true(b.lo > 908 && b.lo < 940 && b.split > 915 && b.split < 970);
    assert_true(fabs(a.lo - b.lo) <= 4 && fabs(a.hi - b.hi) <= 4);
    count[0] = 2e5; /* too many for that */
    const vv_statistics masked = counted(count, 1024, 0);
    assert_true(vvi_fit_bottom(&masked) == -0.5 && fabs(vvi_fit_bottom(&dead) - clean.min) < 1);
}

/* Tissue on the slope of noise: the peak has not sunk where the object begins. */
static void the_valley_ends_a_background_that_sinks_late(void **state)
{
    double count[256];
    for (int i = 0; i < 256; i++)
        count[i] = bell(i, 8, 3, 15000) + bell(i, 60, 25, 3000) + bell(i, 100, 20, 800) + 5;
    const vv_statistics s = counted(count, 256, 0);
    vvi_value_fit fit;
    vvi_fit_values(&fit, &s, NULL);
    assert_true(fit.lo > 12 && fit.lo < 35 && fit.share > 0.5);
}

/* Nearly all is zero, the rest lies beyond a threshold: more of it far out on one side, little on the other. */
static void thresholded_maps_have_both_tails(void **state)
{
    double count[201] = {0};
    vvi_value_fit fit;
    count[100] = 260000;
    for (int i = 130; i <= 190; i++)
        count[i] = 10;
    for (int i = 25; i < 45; i++)
        count[i] = 4;
    vv_statistics s = counted(count, 201, -100);
    assert_true(s.percentile[0] == 0); /* fewer than a thousandth */
    assert_true(vvi_fit_two_sided(&fit, &s));
    assert_true(fit.lo > 0 && fit.lo < 30 && fit.hi > 80 && fit.hi < 92 && fit.share < 0.01);
    for (int i = 0; i < 100; i++)
        count[i] = 0;
    s = counted(count, 201, -100);
    assert_false(vvi_fit_two_sided(&fit, &s)); /* no lower side: like any amount */
    for (int i = 1; i < 100; i++) {            /* air, and what lies between: a tail that has its hill far out */
        count[i] = 100 + bell(i, 20, 4, 9000);
        count[100 + i] = i < 60 ? 300 : 0;
    }
    s = counted(count, 201, -100);
    assert_false(vvi_fit_two_sided(&fit, &s));
}

static void values_below_zero_alone_are_the_lower_half(void **state)
{
    double count[101];
    vvi_value_fit fit;
    for (int i = 0; i < 101; i++)
        count[i] = bell(i, 100, 2, 90000) + floor(500 * exp((i - 100) / 30.0));
    vv_statistics s = counted(count, 101, -100);
    assert_true(vvi_fit_two_sided(&fit, &s) && fit.lo > 2 && fit.lo < 30 && fit.hi > 60 && fit.hi <= 100.5);
    for (int i = 0; i < 101; i++)
        count[i] = bell(i, 10, 2, 90000) + 500; /* decibels: silence is far below zero */
    s = counted(count, 101, -100);
    assert_false(vvi_fit_two_sided(&fit, &s));
}

static void a_range_that_is_set_is_seen_to_its_end(void **state)
{
    double count[201];
    vvi_value_fit fit;
    for (int i = 0; i < 201; i++)
        count[i] = bell(i, 100, 25, 10000);
    const vv_statistics s = counted(count, 201, -100);
    assert_true(vvi_fit_magnitudes(&fit, &s, 40));
    assert_true(fit.lo == 0 && fit.hi == 40 && fit.share == 1);
}

/* A ball of low values in a box of high ones, with one corner of NaN. */
static void the_border_is_read_where_the_peak_lies_high(void **state)
{
    enum { N = 24 };
    vv_job *job = test_job(1, 0);
    vv_field_info info = vv_field_info_default();
    float *v = malloc(sizeof *v * N * N * N);
    info.type = VV_TYPE_F32;
    for (int i = 0; i < N * N * N; i++) {
        const double x = i % N - 11.5, y = i / N % N - 11.5, z = i / N / N - 11.5, r = sqrt(x * x + y * y + z * z);
        v[i] = i == 0 ? NAN : (float)(90 - 80 * fmax(0, 1 - r / 10));
    }
    for (int i = 0; i < 3; i++)
        info.grid.dims[i] = N;
    vv_field *field;
    vv_statistics s;
    vvi_value_fit fit;
    assert_int_equal(vv_field_new(&field, &info, v, 0, NULL, NULL, NULL), VV_OK);
    assert_int_equal(vv_field_statistics(&s, field, 0, job), VV_OK);
    assert_int_equal(vvi_fit_field(&fit, field, 0, &s, job), VV_OK);
    assert_true(fit.falls && fit.hi > 80 && fit.hi <= 90 && fit.lo < 40);
    vv_field_release(field);
    free(v);
    vv_job_release(job);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_bright_background_is_known_by_the_border),
        cmocka_unit_test(a_mirrored_histogram_has_the_mirrored_fit),
        cmocka_unit_test(a_background_in_the_middle_has_the_object_on_the_fuller_side),
        cmocka_unit_test(a_field_that_fills_its_box_has_no_background),
        cmocka_unit_test(dead_pixels_below_all_others_are_no_values),
        cmocka_unit_test(the_valley_ends_a_background_that_sinks_late),
        cmocka_unit_test(thresholded_maps_have_both_tails),
        cmocka_unit_test(values_below_zero_alone_are_the_lower_half),
        cmocka_unit_test(a_range_that_is_set_is_seen_to_its_end),
        cmocka_unit_test(the_border_is_read_where_the_peak_lies_high),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
