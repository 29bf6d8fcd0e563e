/* Named transfer functions and the one that is fitted to a histogram. Histograms are made by hand. */
#include "scene/presets.h"
#include "scene/transfer_fit.h"
#include "scene/two_sided.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Statistics of whole numbers 0 .. n-1 that occur count[i] times. */
static vv_statistics counted(const double *count, int n)
{
    vv_statistics s = {.n_bins = n, .histogram_lo = -0.5, .histogram_hi = n - 0.5};
    static const double percents[5] = {0.1, 1, 50, 99, 99.9};
    s.min = n;
    for (int i = 0; i < n; i++) {
        s.histogram[i] = (uint64_t)count[i];
        s.count += s.histogram[i];
        if (s.histogram[i]) {
            s.min = fmin(s.min, i);
            s.max = i;
        }
    }
    double below = 0;
    int q = 0;
    for (int i = 0; i < n; i++)
        for (below += (double)s.histogram[i]; q < 5 && below >= percents[q] / 100 * (double)s.count; q++)
            s.percentile[q] = i;
    return s;
}

static double bell(double x, double middle, double width, double height)
{
    return floor(height * exp(-0.5 * (x - middle) * (x - middle) / (width * width)));
}

static void every_preset_ascends_and_stays_in_range(void **state)
{
    size_t n_transfer = 0, n = 0;
    for (; vv_preset_nth(n); n++) {
        const vv_preset *row = vv_preset_nth(n);
        assert_true(strlen(row->name) > 0 && strlen(row->doc) > 0);
        for (size_t k = 0; k < n; k++)
            assert_false(strcmp(row->name, vv_preset_nth(k)->name) == 0 &&
                         strcmp(row->kind, vv_preset_nth(k)->kind) == 0);
        if (strcmp(row->kind, "proposal") == 0) { /* test_proposals.c */
            assert_non_null(vvi_preset_find(row->name, "x"));
            continue;
        }
        if (strcmp(row->kind, "transfer") != 0) {
            vv_color c;
            assert_string_equal(row->kind, "colormap");
            assert_true(vv_colormap_sample(&c, row->name, 0.5));
            continue;
        }
        n_transfer++;
        const vvi_preset *p = vvi_preset_find(row->name, "x");
        assert_non_null(p);
        bool any = false;
        for (size_t i = 0; i < p->n_opacity; i++) {
            assert_true(i == 0 || p->opacity[i][0] >= p->opacity[i - 1][0]);
            assert_true(p->opacity[i][1] >= 0 && p->opacity[i][1] <= 1);
            assert_true(row->value_unit || (p->opacity[i][0] >= 0 && p->opacity[i][0] <= 1));
            any |= p->opacity[i][1] > 0;
        }
        assert_true(any);
        assert_true((p->color != NULL) != (p->colormap != NULL));
        for (size_t i = 0; i < p->n_color; i++)
            for (int c = 1; c < 4; c++)
                assert_true(p->color[i][c] >= 0 && p->color[i][c] <= 1);
    }
    assert_true(n_transfer >= 8 && n >= n_transfer + 9);
}

static void an_unknown_preset_is_answered_with_the_nearest(void **state)
{
    assert_null(vvi_preset_find("bonee", "volumes.a.segmentation.transfer.preset"));
    assert_int_equal(vv_error_last()->status, VV_E_NOT_FOUND);
    assert_non_null(strstr(vv_error_last()->message, "'bone'"));
}

static vv_field_info info_of(vv_type type, const char *unit)
{
    vv_field_info info = {.type = type, .components = 1, .value_scale = 1};
    strcpy(info.value_unit, unit);
    return info;
}

static void hounsfield_presets_stay_where_the_data_are_hounsfield(void **state)
{
    const vvi_preset *bone = vvi_preset_find("bone", "x");
    const vv_statistics ct = {.min = -1024, .max = 2976, .count = 1, .n_bins = 1};
    const vv_field_info plain = info_of(VV_TYPE_I16, ""), hu = info_of(VV_TYPE_U8, "HU");
    vvi_preset_map m = vvi_preset_place(bone, &plain, &ct, -200, 900);
    assert_true(m.scale == 1 && m.offset == 0 && !m.guessed);
    const vv_statistics narrow = {.min = 0, .max = 200, .count = 1, .n_bins = 1};
    m = vvi_preset_place(bone, &hu, &narrow, 0, 200);
    assert_true(m.scale == 1 && m.offset == 0 && !m.guessed);
}

static void raw_ct_numbers_are_shifted(void **state)
{
    double count[1024] = {0};
    for (int i = 0; i < 1024; i++) /* bins of 4 */
        count[i] = bell(i, 10, 8, 5000) + bell(i, 260, 10, 3000) + 2;
    vv_statistics s = counted(count, 1024);
    s.histogram_lo *= 4;
    s.histogram_hi *= 4;
    s.max *= 4;
    const vv_field_info info = info_of(VV_TYPE_U16, "");
    const vvi_preset_map m = vvi_preset_place(vvi_preset_find("skin", "x"), &info, &s, 300, 3000);
    assert_true(m.scale == 1 && m.offset == 1024 && !m.guessed);
}

static void other_data_get_hounsfield_presets_stretched_and_told(void **state)
{
    const vv_statistics s = {.min = 0, .max = 255, .count = 1, .n_bins = 1};
    const vv_field_info info = info_of(VV_TYPE_U8, "");
    const vvi_preset_map m = vvi_preset_place(vvi_preset_find("bone", "x"), &info, &s, 5, 205);
    assert_true(m.guessed);
    assert_true(fabs(-1000 * m.scale + m.offset - 5) < 1e-9);
    assert_true(fabs(1500 * m.scale + m.offset - 205) < 1e-9);
    const vvi_preset_map n = vvi_preset_place(vvi_preset_find("ramp", "x"), &info, &s, 5, 205);
    assert_true(!n.guessed && n.offset == 5 && n.scale == 200);
}

static void background_ends_where_its_peak_has_sunk(void **state)
{
    double count[256];
    for (int i = 0; i < 256; i++)
        count[i] = bell(i, 12, 4, 100000) + bell(i, 120, 25, 4000);
    const vv_statistics s = counted(count, 256);
    vvi_value_fit fit;
    vvi_fit_values(&fit, &s, NULL);
    assert_true(fit.lo > 20 && fit.lo < 50);
    assert_true(fit.hi > 150 && fit.hi < 220);
    assert_true(fit.split > 30 && fit.split < 100);
    assert_true(fit.share > 0.2 && fit.share < 0.35);
}

static void a_thin_object_in_an_empty_box_is_found(void **state)
{
    double count[256] = {1e7}; /* 0.1 % is not */
    for (int i = 20; i < 256; i++)
        count[i] = 40;
    const vv_statistics s = counted(count, 256);
    vvi_value_fit fit;
    vvi_fit_values(&fit, &s, NULL);
    assert_true(fit.lo > 0 && fit.lo <= 20);
    assert_true(fit.hi > 240 && fit.split > 5 && fit.split < 200);
    assert_true(fit.share < 0.002);
}

/* Bins of 1 about zero. */
static vv_statistics about_zero(const double count[201])
{
    vv_statistics s = counted(count, 201);
    s.histogram_lo -= 100;
    s.histogram_hi -= 100;
    s.min -= 100;
    s.max -= 100;
    for (int q = 0; q < 5; q++)
        s.percentile[q] -= 100;
    return s;
}

static void values_about_zero_have_two_tails(void **state)
{
    double count[201];
    vvi_value_fit fit;
    for (int i = 0; i < 201; i++)
        count[i] = bell(i, 100, 4, 100000) + 2000 * exp(-fabs(i - 100.0) / 30.0);
    vv_statistics s = about_zero(count);
    assert_true(vvi_fit_two_sided(&fit, &s));
    assert_true(fit.lo > 6 && fit.lo < 30 && fit.hi > 80 && fit.hi <= 100);
    for (int i = 0; i < 95; i++)
        count[i] = 0; /* nothing below but noise */
    s = about_zero(count);
    assert_false(vvi_fit_two_sided(&fit, &s));
}

static void air_in_ct_is_no_tail(void **state)
{
    double count[201];
    vvi_value_fit fit;
    for (int i = 0; i < 201; i++) /* air at -90, more tissue than air at 2, bone beyond */
        count[i] = bell(i, 10, 2, 30000) + bell(i, 102, 3, 100000) + 1000 * exp(-fabs(i - 100.0) / 30.0);
    const vv_statistics s = about_zero(count);
    assert_false(vvi_fit_two_sided(&fit, &s));
}

/* What they are is no matter of the fullest bin: a hole at zero, a peak beside it, none at all. */
static void values_alike_on_both_sides_are_about_zero(void **state)
{
    double hill[201], wave[201], shifted[201];
    for (int i = 0; i < 201; i++) {
        hill[i] = bell(i, 100, 30, 10000);
        wave[i] = 1000 / sqrt(1.0001 - (i - 100.0) * (i - 100.0) / 10000);
        shifted[i] = bell(i, 125, 25, 10000);
    }
    hill[100] = hill[100] / 2; /* rounded down, and not to zero */
    hill[108] *= 2;
    const double *const about[] = {hill, wave};
    vvi_value_fit fit;
    for (int k = 0; k < 2; k++) {
        const vv_statistics s = about_zero(about[k]);
        assert_true(vvi_fit_two_sided(&fit, &s));
        assert_true(fit.lo >= 0 && fit.lo < 0.5 * fit.hi && fit.hi > 60 && fit.hi <= 100);
    }
    const vv_statistics s = about_zero(shifted);
    assert_false(vvi_fit_two_sided(&fit, &s));
}

/* Density over noise: one tail is nearly twice as long as the other. */
static void density_over_noise_is_one_sided(void **state)
{
    double count[201];
    vvi_value_fit fit;
    for (int i = 0; i < 201; i++)
        count[i] = i < 96 ? bell(i, 96, 15, 10000) : bell(i, 96, 32, 10000);
    const vv_statistics s = about_zero(count);
    assert_false(vvi_fit_two_sided(&fit, &s));
}

static void a_scale_has_no_middle_at_its_zero(void **state)
{
    double count[201];
    vvi_value_fit fit;
    for (int i = 0; i < 201; i++)
        count[i] = bell(i, 100, 30, 10000);
    vv_statistics s = about_zero(count);
    const vv_field_info plain = info_of(VV_TYPE_I16, ""), mm = info_of(VV_TYPE_F32, "mm/s");
    const char *const scales[] = {"HU", "degC", "celsius"};
    assert_true(vvi_two_sided(&fit, &plain, &s) && vvi_two_sided(&fit, &mm, &s));
    for (int i = 0; i < 3; i++) {
        const vv_field_info info = info_of(VV_TYPE_F32, scales[i]);
        assert_false(vvi_two_sided(&fit, &info, &s));
    }
    s.min = -1024; /* as scanners begin */
    s.max = 1600;
    assert_false(vvi_two_sided(&fit, &plain, &s));
    assert_true(vvi_two_sided(&fit, &mm, &s));
}

static void one_hot_sample_does_not_hide_the_rest(void **state)
{
    double count[1024] = {0};
    for (int i = 0; i < 1023; i++)
        count[i] = bell(i, 8, 3, 100000) + bell(i, 60, 10, 20000);
    count[1023] = 1;
    const vv_statistics s = counted(count, 1024);
    vvi_value_fit fit;
    vvi_fit_values(&fit, &s, NULL);
    assert_true(fit.lo > 12 && fit.lo < 40);
    assert_true(fit.hi > 70 && fit.hi < 120);
    assert_true(fit.split > 15 && fit.split < 55);
}

static void data_without_a_background_are_all_object(void **state)
{
    double flat[256], high[256];
    for (int i = 0; i < 256; i++) {
        flat[i] = 1000;
        high[i] = bell(i, 200, 20, 1000) + 1;
    }
    const vv_statistics a = counted(flat, 256), b = counted(high, 256);
    vvi_value_fit fit;
    vvi_fit_values(&fit, &a, NULL);
    assert_true(fit.lo == 0 && fit.hi > 250 && fit.share == 1);
    vvi_fit_values(&fit, &b, NULL);
    assert_true(fit.lo == 0 && fit.hi > 230);
}

static void two_values_are_split_between_them(void **state)
{
    double mask[2] = {700, 300}, mostly[2] = {100, 900}, apart[256] = {900};
    apart[255] = 10;
    const vv_statistics all[] = {counted(mask, 2), counted(mostly, 2), counted(apart, 256)};
    for (int i = 0; i < 3; i++) {
        vvi_value_fit fit;
        vvi_fit_values(&fit, &all[i], NULL);
        assert_true(fit.split > 0 && fit.split < all[i].max);
        assert_true(fit.lo < fit.hi && fit.hi == all[i].max);
    }
}

static void constant_and_empty_fields_are_known_as_such(void **state)
{
    const vv_statistics none = {0};
    const vv_statistics seven = {
        .count = 5, .min = 7, .max = 7, .n_bins = 1, .histogram = {5}, .histogram_lo = 7, .histogram_hi = 7};
    double rows[2 * VVI_FIT_NODES];
    vvi_value_fit fit;
    vvi_fit_values(&fit, &none, NULL);
    assert_true(fit.empty);
    assert_int_equal(vvi_fit_opacity(rows, &fit, 0, 0, 10, 1), 1);
    assert_true(rows[1] == 0);
    vvi_fit_values(&fit, &seven, NULL);
    assert_true(fit.constant && fit.lo == 7 && fit.hi == 7);
    assert_int_equal(vvi_fit_opacity(rows, &fit, 7, 7, 10, 1), 1);
    assert_true(rows[1] > 0.05 && rows[1] < 0.5);
}

static void automatic_opacity_rises_and_does_not_depend_on_the_sampling(void **state)
{
    const vvi_value_fit fit = {.lo = 10, .hi = 20, .share = 0.2};
    double coarse[2 * VVI_FIT_NODES], fine[2 * VVI_FIT_NODES];
    assert_int_equal(vvi_fit_opacity(coarse, &fit, 10, 20, 100, 2), VVI_FIT_NODES);
    assert_int_equal(vvi_fit_opacity(fine, &fit, 10, 20, 100, 1), VVI_FIT_NODES);
    assert_true(coarse[0] == 10 && coarse[1] == 0 && coarse[2 * VVI_FIT_NODES - 2] == 20);
    for (int i = 1; i < VVI_FIT_NODES; i++) {
        assert_true(coarse[2 * i] > coarse[2 * i - 2] && coarse[2 * i + 1] > coarse[2 * i - 1]);
        assert_true(fabs(pow(1 - fine[2 * i + 1], 2) - (1 - coarse[2 * i + 1])) < 1e-12);
    }
}

/* Share of the largest optical depth that values at two fifths of the way up have. */
static double rise_of(const vvi_value_fit *fit)
{
    double rows[2 * VVI_FIT_NODES];
    assert_int_equal(vvi_fit_opacity(rows, fit, 10, 20, 100, 1), VVI_FIT_NODES);
    assert_true(fabs(rows[4] - 14) < 1e-12);
    return log1p(-rows[5]) / log1p(-rows[2 * VVI_FIT_NODES - 1]);
}

static void faint_values_hide_nothing_where_most_are_faint(void **state)
{
    vvi_value_fit fit = {.lo = 10, .hi = 20, .share = 0.2, .median = 15};
    assert_true(fabs(rise_of(&fit) - pow(0.4, 1.5)) < 1e-9);
    fit.median = 12.4;
    assert_true(fabs(rise_of(&fit) - pow(0.4, 2)) < 1e-9);
    fit.median = 11;
    assert_true(fabs(rise_of(&fit) - pow(0.4, 2.5)) < 1e-9);
    fit.share = 1;
    assert_true(fabs(rise_of(&fit) - pow(0.4, 3)) < 1e-9);
    double count[256]; /* an exponential tail that starts at the background, and a bell far from it */
    for (int i = 0; i < 256; i++)
        count[i] = bell(i, 10, 3, 100000) + 1000 * exp(-i / 30.0);
    vv_statistics s = counted(count, 256);
    vvi_fit_values(&fit, &s, NULL);
    assert_true((fit.median - fit.lo) / (fit.hi - fit.lo) < 0.2);
    for (int i = 0; i < 256; i++)
        count[i] = bell(i, 10, 3, 100000) + bell(i, 120, 25, 4000);
    s = counted(count, 256);
    vvi_fit_values(&fit, &s, NULL);
    assert_true(fabs(fit.median - 120.5) < 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_preset_ascends_and_stays_in_range),
        cmocka_unit_test(an_unknown_preset_is_answered_with_the_nearest),
        cmocka_unit_test(hounsfield_presets_stay_where_the_data_are_hounsfield),
        cmocka_unit_test(raw_ct_numbers_are_shifted),
        cmocka_unit_test(other_data_get_hounsfield_presets_stretched_and_told),
        cmocka_unit_test(background_ends_where_its_peak_has_sunk),
        cmocka_unit_test(a_thin_object_in_an_empty_box_is_found),
        cmocka_unit_test(values_about_zero_have_two_tails),
        cmocka_unit_test(air_in_ct_is_no_tail),
        cmocka_unit_test(values_alike_on_both_sides_are_about_zero),
        cmocka_unit_test(density_over_noise_is_one_sided),
        cmocka_unit_test(a_scale_has_no_middle_at_its_zero),
        cmocka_unit_test(one_hot_sample_does_not_hide_the_rest),
        cmocka_unit_test(data_without_a_background_are_all_object),
        cmocka_unit_test(two_values_are_split_between_them),
        cmocka_unit_test(constant_and_empty_fields_are_known_as_such),
        cmocka_unit_test(automatic_opacity_rises_and_does_not_depend_on_the_sampling),
        cmocka_unit_test(faint_values_hide_nothing_where_most_are_faint),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
