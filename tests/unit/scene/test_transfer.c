/* Truth: the nodes, walked one by one in double precision. */
#include "fields.h"
#include "grid/label_color.h"
#include "scene/transfer.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static uint64_t seed, drawn;

/* cmocka's own comparison is of floats, and its macro does not bracket its arguments. */
static void assert_near(double found, double expected, double tolerance)
{
    if (!(fabs(found - expected) <= tolerance))
        fail_msg("%.17g is not %.17g", found, expected);
}

static double uniform(void)
{
    return test_random_unit(seed, drawn++);
}

static int below(int n)
{
    return (int)(uniform() * n);
}

static double alpha_over(double kappa, double length)
{
    return 1 - exp(-kappa * length);
}

static void opacity_is_per_length(void **state)
{
    const double kappa = vvi_transfer_kappa(0.5, 1);
    assert_near(alpha_over(kappa, 1), 0.5, 1e-12);
    assert_near(alpha_over(kappa, 0.5), 0.292893, 1e-6);
    assert_near(alpha_over(kappa, 2), 0.75, 1e-12);
    double through = 1;
    for (int i = 0; i < 10; i++)
        through *= 1 - alpha_over(vvi_transfer_kappa(0.1, 3), 3);
    assert_near(1 - through, 0.651322, 1e-6);
}

static void full_opacity_has_a_finite_extinction(void **state)
{
    assert_near(vvi_transfer_kappa(1, 1), 24 * log(2), 1e-9);
    assert_near(vvi_transfer_kappa(7, 0.5), 48 * log(2), 1e-9);
    assert_true(vvi_transfer_kappa(0, 1) == 0);
    assert_true(vvi_transfer_kappa(-1, 1) == 0);
    assert_true(vvi_transfer_kappa(NAN, 1) == 0);
}

static void nodes_are_exact_and_the_later_of_two_holds_at_a_jump(void **state)
{
    static const double opacity[] = {10, 0.1, 20, 0.3, 20, 0.8, 40, 0};
    static const double color[] = {0, 1, 0, 0, 30, 0, 0.5, 1};
    const vv_classification c = {.kind = VV_SEGMENT_TRANSFER,
                                 .opacity = opacity,
                                 .n_opacity = 4,
                                 .color = color,
                                 .n_color = 2,
                                 .opacity_length = 2,
                                 .opacity_scale = 1};
    const double value[] = {-1e9, 10, 15, 19.999999999, 20, 30, 40, 1e9};
    const double alpha[] = {0.1, 0.1, 0.2, 0.3, 0.8, 0.4, 0, 0};
    const double red[] = {1, 2 / 3., 0.5, 1 / 3., 1 / 3., 0, 0, 0};
    for (int i = 0; i < 8; i++) {
        double out[4];
        vvi_transfer_evaluate(out, &c, value[i]);
        assert_near(alpha_over(out[3], 2), alpha[i], 1e-9);
        assert_near(out[0], red[i], 1e-9);
        assert_near(out[1], 0.5 * (1 - red[i]), 1e-9);
        assert_near(out[2], 1 - red[i], 1e-9);
    }
}

static void not_a_number_is_clear(void **state)
{
    static const double opacity[] = {0, 1};
    const vv_classification c = {.opacity = opacity, .n_opacity = 1, .opacity_length = 1, .opacity_scale = 1};
    double out[4];
    vvi_transfer_evaluate(out, &c, NAN);
    assert_true(out[3] == 0);
}

static void scale_multiplies_extinction(void **state)
{
    static const double opacity[] = {0, 0.5};
    vv_classification c = {.opacity = opacity, .n_opacity = 1, .opacity_length = 1, .opacity_scale = 2};
    double out[4];
    vvi_transfer_evaluate(out, &c, 0);
    assert_near(alpha_over(out[3], 1), 0.75, 1e-12);
}

/* Random nodes with jumps on a grid of quarters, so that queries often meet them exactly. */
typedef struct nodes {
    double opacity[2 * 12], color[4 * 12];
    vv_classification classes;
} nodes;

static void random_nodes(nodes *out)
{
    const size_t n = 1 + (size_t)below(12);
    double value = below(20) / 4.0 - 3;
    for (size_t i = 0; i < n; i++) {
        value += below(3) ? below(6) / 4.0 : 0;
        out->opacity[2 * i] = value;
        out->opacity[2 * i + 1] = below(2) ? 0 : uniform();
        out->color[4 * i] = value;
        for (int k = 1; k < 4; k++)
            out->color[4 * i + (size_t)k] = uniform();
    }
    out->classes = (vv_classification){.kind = VV_SEGMENT_TRANSFER,
                                       .opacity = out->opacity,
                                       .n_opacity = n,
                                       .color = out->color,
                                       .n_color = n,
                                       .opacity_length = 0.5 + uniform(),
                                       .opacity_scale = 0.1 + uniform()};
}

/* The definition, without the search: the last node at or below, then the line to the next. */
static double plain_alpha(const vv_classification *c, double value)
{
    size_t at = c->n_opacity;
    for (size_t i = 0; i < c->n_opacity; i++)
        if (c->opacity[2 * i] <= value)
            at = i;
    if (at == c->n_opacity)
        return c->opacity[1];
    if (at + 1 == c->n_opacity)
        return c->opacity[2 * at + 1];
    const double *a = c->opacity + 2 * at, *b = a + 2;
    return a[1] + (value - a[0]) / (b[0] - a[0]) * (b[1] - a[1]);
}

static void tables_equal_direct_evaluation_of_random_nodes(void **state)
{
    for (int round = 0; round < 200; round++) {
        nodes r;
        vvi_transfer_table table;
        random_nodes(&r);
        const double lo = -5 + 3 * uniform(), hi = lo + 0.1 + 20 * uniform();
        assert_int_equal(vvi_transfer_table_init(&table, &r.classes, lo, hi, 256, NULL), VV_OK);
        for (size_t i = 0; i < table.n; i++) {
            const double value = i + 1 == table.n ? hi : lo + (double)i * ((hi - lo) / 255);
            const double alpha = plain_alpha(&r.classes, value);
            const double kappa = -log(1 - alpha) / r.classes.opacity_length * r.classes.opacity_scale;
            assert_near(table.rgbk[4 * i + 3], kappa, 1e-6 * (1 + kappa));
            assert_near(value * table.scale + table.offset, (double)i, 1e-9);
        }
        vvi_transfer_table_finish(&table);
    }
}

static void occupancy_of_random_tables_equals_brute_force(void **state)
{
    for (int round = 0; round < 100; round++) {
        nodes r;
        vvi_transfer_table table;
        random_nodes(&r);
        assert_int_equal(vvi_transfer_table_init(&table, &r.classes, -5, 15, 81, NULL), VV_OK);
        for (int query = 0; query < 200; query++) {
            const int64_t a = below(100) - 10, b = a + below(30);
            bool any = false;
            for (int64_t i = a; i <= b; i++) {
                const int64_t row = i < 0 ? 0 : i > 80 ? 80 : i;
                any |= table.rgbk[4 * row + 3] > 0;
            }
            assert_int_equal(vvi_transfer_occupied(&table, a, b), any);
        }
        vvi_transfer_table_finish(&table);
    }
}

static void occupancy_covers_every_row_that_interpolation_touches(void **state)
{
    static const double opacity[] = {4, 0, 5, 1, 6, 0};
    const vv_classification c = {.opacity = opacity, .n_opacity = 3, .opacity_length = 1, .opacity_scale = 1};
    vvi_transfer_table table;
    assert_int_equal(vvi_transfer_table_init(&table, &c, 0, 10, 11, NULL), VV_OK);
    assert_false(vvi_transfer_occupancy(&table, 0, 4));
    assert_true(vvi_transfer_occupancy(&table, 0, 4.01));
    assert_true(vvi_transfer_occupancy(&table, 5.5, 5.6));
    assert_false(vvi_transfer_occupancy(&table, 6, 1e30));
    assert_true(vvi_transfer_occupancy(&table, -1e30, 1e30));
    vvi_transfer_table_finish(&table);
}

static void tables_may_run_downwards(void **state)
{
    static const double opacity[] = {4, 0, 5, 1};
    const vv_classification c = {.opacity = opacity, .n_opacity = 2, .opacity_length = 1, .opacity_scale = 1};
    vvi_transfer_table table;
    assert_int_equal(vvi_transfer_table_init(&table, &c, 10, 0, 11, NULL), VV_OK);
    assert_true(table.rgbk[3] > 0 && table.rgbk[4 * 10 + 3] == 0);
    assert_true(vvi_transfer_occupancy(&table, 5, 6));
    assert_false(vvi_transfer_occupancy(&table, 0, 4));
    vvi_transfer_table_finish(&table);
}

/* Dense probing finds what the exact answer must find; where the answer is no, probing must find nothing. Queries on
 * sixteenths and nodes on quarters: probing at 1/64 sees every interior. */
static void visibility_of_random_intervals_equals_dense_probing(void **state)
{
    for (int round = 0; round < 2000; round++) {
        nodes r;
        random_nodes(&r);
        const double a = below(300) / 16.0 - 5, b = a + below(40) / 16.0;
        bool seen = false;
        for (double v = a; v <= b; v += 1 / 64.)
            seen |= plain_alpha(&r.classes, v) > 0;
        assert_int_equal(vvi_transfer_visible(&r.classes, a, b), seen);
    }
}

static void threshold_is_solid_within_both_bounds(void **state)
{
    const vv_classification c = {.kind = VV_SEGMENT_THRESHOLD, .lo = 2, .hi = 5, .opacity_length = 1};
    const double value[] = {1.999, 2, 3, 5, 5.001};
    const bool solid[] = {false, true, true, true, false};
    for (int i = 0; i < 5; i++) {
        double out[4];
        vvi_transfer_evaluate(out, &c, value[i]);
        assert_int_equal(out[3] > 0, solid[i]);
        assert_true(isfinite((float)out[3]));
        assert_int_equal(vvi_transfer_visible(&c, value[i], value[i]), solid[i]);
    }
    assert_true(vvi_transfer_visible(&c, 0, 9));
    assert_false(vvi_transfer_visible(&c, 6, 9));
}

static void labels_take_their_row_or_a_color_of_their_own(void **state)
{
    static const double rows[] = {2, 1, 0, 0, 0.5, 7, 0, 1, 0, 0};
    const vv_classification c = {.kind = VV_SEGMENT_LABELS,
                                 .labels = rows,
                                 .n_labels = 2,
                                 .label_opacity = 0.25,
                                 .opacity_length = 1,
                                 .opacity_scale = 1};
    double two[4], three[4], seven[4], zero[4];
    vvi_transfer_evaluate(two, &c, 2.3);
    vvi_transfer_evaluate(three, &c, 3);
    vvi_transfer_evaluate(seven, &c, 7);
    vvi_transfer_evaluate(zero, &c, 0);
    assert_true(two[0] == 1 && two[1] == 0);
    assert_near(alpha_over(two[3], 1), 0.5, 1e-12);
    assert_near(alpha_over(three[3], 1), 0.25, 1e-12);
    assert_true(seven[3] == 0 && zero[3] == 0);
    assert_false(vvi_transfer_visible(&c, 0, 0));
    assert_false(vvi_transfer_visible(&c, 7, 7));
    assert_true(vvi_transfer_visible(&c, 7, 8));
    assert_true(vvi_transfer_visible(&c, 0, 1));
    assert_true(vvi_transfer_visible(&c, -3, 0));
}

static double cube_root_lightness(const double rgb[3]) /* Oklab's L */
{
    const double l = cbrt(0.4122214708 * rgb[0] + 0.5363325363 * rgb[1] + 0.0514459929 * rgb[2]);
    const double m = cbrt(0.2119034982 * rgb[0] + 0.6806995451 * rgb[1] + 0.1073969566 * rgb[2]);
    const double s = cbrt(0.0883024619 * rgb[0] + 0.2817188376 * rgb[1] + 0.6299787005 * rgb[2]);
    return 0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s;
}

static void automatic_label_colors_are_distinct_and_neither_dark_nor_pale(void **state)
{
    double color[24][3];
    for (int i = 0; i < 24; i++) {
        vvi_label_color(color[i], i + 1);
        const double lightness = cube_root_lightness(color[i]);
        assert_true(lightness > 0.57 && lightness < 0.83);
        for (int k = 0; k < i; k++) {
            const double d =
                hypot(hypot(color[i][0] - color[k][0], color[i][1] - color[k][1]), color[i][2] - color[k][2]);
            assert_true(d > 0.02);
        }
    }
}

static vv_field_info info_of(vv_type type)
{
    return (vv_field_info){.type = type, .components = 1, .value_scale = 1};
}

static void integers_get_a_row_for_each_stored_value(void **state)
{
    vv_field_info info = info_of(VV_TYPE_I16);
    const vv_classification c = {.kind = VV_SEGMENT_TRANSFER, .opacity_length = 1, .opacity_scale = 1};
    const vv_statistics s = {.min = -1024, .max = 3071, .count = 1};
    double lo, hi;
    size_t n;
    assert_int_equal(vvi_transfer_domain(&lo, &hi, &n, &c, &info, &s), VV_OK);
    assert_int_equal(n, 4096);
    info.type = VV_TYPE_U16;
    info.value_scale = 0.5;
    const vv_statistics full = {.min = 0, .max = 0.5 * 65535, .count = 1};
    assert_int_equal(vvi_transfer_domain(&lo, &hi, &n, &c, &info, &full), VV_OK);
    assert_int_equal(n, 65536);
    const vv_statistics one = {.min = 3, .max = 3, .count = 1};
    assert_int_equal(vvi_transfer_domain(&lo, &hi, &n, &c, &info, &one), VV_OK);
    assert_int_equal(n, 2);
}

static void float_tables_spend_their_rows_between_the_nodes(void **state)
{
    static const double opacity[] = {0, 0, 1, 1};
    const vv_field_info info = info_of(VV_TYPE_F32);
    const vv_classification c = {
        .kind = VV_SEGMENT_TRANSFER, .opacity = opacity, .n_opacity = 2, .opacity_length = 1, .opacity_scale = 1};
    const vv_statistics hot = {.min = -7, .max = 1e9, .count = 2};
    double lo, hi;
    size_t n;
    assert_int_equal(vvi_transfer_domain(&lo, &hi, &n, &c, &info, &hot), VV_OK);
    assert_int_equal(n, VVI_TRANSFER_ROWS);
    assert_true(lo <= 0 && lo > -0.01 && hi >= 1 && hi < 1.01);
    static const vv_type types[] = {VV_TYPE_F32, VV_TYPE_F64, VV_TYPE_I32};
    static const double fills[][2] = {{-1e6, 30}, {-1e30, 30}, {0, 1e20}, {-3e38, 3e38}, {-2147483648.0, 30}};
    for (size_t i = 0; i < 15; i++) {
        const vv_field_info filled = info_of(types[i % 3]);
        const vv_statistics s = {.min = fills[i / 3][0], .max = fills[i / 3][1], .count = 2};
        assert_int_equal(vvi_transfer_domain(&lo, &hi, &n, &c, &filled, &s), VV_OK);
        assert_int_equal(n, VVI_TRANSFER_ROWS);
        assert_true(lo <= 0 && lo > -0.01 && hi >= 1 && hi < 1.01);
    }
    const vv_statistics above = {.min = 5, .max = 6, .count = 2};
    assert_int_equal(vvi_transfer_domain(&lo, &hi, &n, &c, &info, &above), VV_OK);
    assert_true(lo == 5 && hi < 5.02); /* all as in the last node */
}

/* What the nearest row says of values between the stored ones, against the nodes: nodes anywhere, close or far apart.
 */
static void rows_follow_nodes_that_lie_close(void **state)
{
    static const struct {
        vv_type type;
        double from, to, scale, offset, most;
    } cases[] = {{VV_TYPE_U16, 2000.3, 2010.3, 1, 0, 2e-4},     {VV_TYPE_U16, 1000, 1100, 1, 0, 2e-4},
                 {VV_TYPE_I16, -705.25, -704.75, 1, 0, 1.1e-3}, {VV_TYPE_U16, 12.7, 3907.1, 1, 0, 2e-4},
                 {VV_TYPE_U8, 100.5, 103, 1, 0, 2.5e-4},        {VV_TYPE_I32, 2000, 2010, 1, 0, 2e-4},
                 {VV_TYPE_I16, 0.013, 0.0155, 0.001, -3, 3e-4}, {VV_TYPE_F32, 2000.3, 2010.3, 1, 0, 2e-4}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const double from = cases[i].from, to = cases[i].to;
        const double color[] = {from, 0, 0, 0, to, 1, 1, 1};
        const vv_classification c = {.color = color, .n_color = 2, .opacity_length = 1, .opacity_scale = 1};
        vv_field_info info = info_of(cases[i].type);
        info.value_scale = cases[i].scale;
        info.value_offset = cases[i].offset;
        const bool narrow = info.type == VV_TYPE_U8;
        const vv_statistics s = {.min = (narrow ? 0 : -1000) * info.value_scale + info.value_offset,
                                 .max = (narrow ? 255 : 4000) * info.value_scale + info.value_offset,
                                 .count = 9};
        double lo, hi;
        size_t n;
        vvi_transfer_table table;
        assert_int_equal(vvi_transfer_domain(&lo, &hi, &n, &c, &info, &s), VV_OK);
        n = vvi_transfer_finer(n, lo, hi, &info);
        assert_int_equal(vvi_transfer_table_init(&table, &c, lo, hi, n, NULL), VV_OK);
        assert_true(n <= 2 * VVI_TRANSFER_ROWS);
        for (int k = 0; k < 2000; k++) {
            double want[4];
            const double v = from + (to - from) * (3 * uniform() - 1);
            const double place = fmin(fmax(v * table.scale + table.offset + 0.5, 0), (double)(n - 1));
            vvi_transfer_evaluate(want, &c, v);
            assert_near((double)table.rgbk[4 * (size_t)place], want[0], cases[i].most);
        }
        vvi_transfer_table_finish(&table);
    }
}

/* Both outer rows on each side lie outside, and what the jump is at is not moved by more than floats move it. */
static void a_jump_at_an_end_node_lies_inside_the_table(void **state)
{
    static const double jumps[][2] = {{0.5, 0.5}, {0, 0}, {-3, 7}, {1e6, 1e6}, {0.5, 0.502}, {-1e-3, -1e-3}};
    static const vv_type types[] = {VV_TYPE_F32, VV_TYPE_F64, VV_TYPE_I32, VV_TYPE_U32};
    const vv_statistics s = {.min = -2e6, .max = 3e6, .count = 9};
    for (size_t t = 0; t < 4; t++)
        for (size_t i = 0; i < sizeof jumps / sizeof *jumps; i++) {
            const double a = jumps[i][0], b = jumps[i][1];
            const double opacity[] = {a, 0, a, 0.4, b, 0.4, b, 0.1};
            const vv_classification c = {.opacity = opacity, .n_opacity = 4, .opacity_length = 1, .opacity_scale = 1};
            const vv_field_info info = info_of(types[t]);
            double lo, hi;
            size_t n;
            vvi_transfer_table table;
            assert_int_equal(vvi_transfer_domain(&lo, &hi, &n, &c, &info, &s), VV_OK);
            assert_int_equal(vvi_transfer_table_init(&table, &c, lo, hi, n, NULL), VV_OK);
            const double row = (hi - lo) / (double)(n - 1);
            assert_true(lo + 1.999 * row < a && hi - 1.999 * row > b);
            assert_true(table.rgbk[3] == 0 && table.rgbk[7] == 0);
            assert_near(alpha_over(table.rgbk[4 * n - 1], 1), 0.1, 1e-6);
            assert_near(alpha_over(table.rgbk[4 * n - 5], 1), 0.1, 1e-6);
            assert_true(row <= fmax((b - a) / 4000, fmax(fmax(fabs(a), fabs(b)) * 0x1p-20, 1e-8)));
            vvi_transfer_table_finish(&table);
        }
}

static void labels_too_far_apart_are_refused(void **state)
{
    const vv_field_info info = info_of(VV_TYPE_F64);
    const vv_classification c = {.kind = VV_SEGMENT_LABELS};
    const vv_statistics far = {.min = 0, .max = 1e300, .count = 2}, near = {.min = 0.2, .max = 29.9, .count = 2};
    double lo, hi;
    size_t n;
    assert_int_equal(vvi_transfer_domain(&lo, &hi, &n, &c, &info, &far), VV_E_LIMIT);
    assert_int_equal(vvi_transfer_domain(&lo, &hi, &n, &c, &info, &near), VV_OK);
    assert_true(lo == 0 && hi == 30 && n == 31);
}

int main(void)
{
    seed = test_seed();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(opacity_is_per_length),
        cmocka_unit_test(full_opacity_has_a_finite_extinction),
        cmocka_unit_test(nodes_are_exact_and_the_later_of_two_holds_at_a_jump),
        cmocka_unit_test(not_a_number_is_clear),
        cmocka_unit_test(scale_multiplies_extinction),
        cmocka_unit_test(tables_equal_direct_evaluation_of_random_nodes),
        cmocka_unit_test(occupancy_of_random_tables_equals_brute_force),
        cmocka_unit_test(occupancy_covers_every_row_that_interpolation_touches),
        cmocka_unit_test(tables_may_run_downwards),
        cmocka_unit_test(visibility_of_random_intervals_equals_dense_probing),
        cmocka_unit_test(threshold_is_solid_within_both_bounds),
        cmocka_unit_test(labels_take_their_row_or_a_color_of_their_own),
        cmocka_unit_test(automatic_label_colors_are_distinct_and_neither_dark_nor_pale),
        cmocka_unit_test(integers_get_a_row_for_each_stored_value),
        cmocka_unit_test(float_tables_spend_their_rows_between_the_nodes),
        cmocka_unit_test(rows_follow_nodes_that_lie_close),
        cmocka_unit_test(a_jump_at_an_end_node_lies_inside_the_table),
        cmocka_unit_test(labels_too_far_apart_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
