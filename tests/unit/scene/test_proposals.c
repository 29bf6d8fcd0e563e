/* Transfer functions that are worked out from the data: of histograms made by hand, and of volumes made by formulas. */
#include "fields.h"
#include "jobs.h"
#include "scene/presets.h"
#include "scene/transfer.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/sys/scene.h>

#include <cmocka.h>

static const char *const names[] = {"fitted", "boundaries", "outside", "dense", "bands"};
enum { N_NAMES = sizeof names / sizeof *names };

static double bell(double x, double middle, double width, double height)
{
    return floor(height * exp(-0.5 * (x - middle) * (x - middle) / (width * width)));
}

/* Opacity at a value. */
static double opacity_at(const double (*rows)[2], size_t n, double value)
{
    if (!n || value < rows[0][0])
        return n ? rows[0][1] : 0;
    for (size_t i = 0; i + 1 < n; i++)
        if (value <= rows[i + 1][0] && rows[i + 1][0] > rows[i][0])
            return rows[i][1] + (value - rows[i][0]) / (rows[i + 1][0] - rows[i][0]) * (rows[i + 1][1] - rows[i][1]);
    return rows[n - 1][1];
}

/* Otsu, three classes --------------------------------------------------------------------------------------------- */

static double within(const double *count, int from, int to)
{
    double n = 0, sum = 0, squares = 0;
    for (int b = from; b < to; b++) {
        n += count[b];
        sum += count[b] * b;
    }
    for (int b = from; b < to && n > 0; b++)
        squares += count[b] * (b - sum / n) * (b - sum / n);
    return squares;
}

static void three_classes_have_the_least_variance_within(void **state)
{
    const uint64_t seed = test_seed();
    for (int trial = 0; trial < 20; trial++) {
        double count[64], place[2], least = INFINITY;
        for (int b = 0; b < 64; b++)
            count[b] = bell(b, 8, 3, 4000) + bell(b, 30 + trial / 4.0, 6, 900) + bell(b, 52, 4, 700) +
                       floor(40 * test_random_unit(seed, (uint64_t)(64 * trial + b)));
        assert_true(vvi_otsu_three(place, count, 64));
        for (int i = 1; i < 64; i++)
            for (int k = i + 1; k < 64; k++)
                least = fmin(least, within(count, 0, i) + within(count, i, k) + within(count, k, 64));
        const int i = (int)place[0], k = (int)place[1];
        const double found = within(count, 0, i) + within(count, i, k) + within(count, k, 64);
        assert_true(found <= least * (1 + 1e-9));
        assert_true(place[0] > 8 && place[0] < 35 && place[1] > 35 && place[1] < 52);
    }
}

static void few_values_have_places_between_them(void **state)
{
    double one[9] = {0}, two[9] = {0}, three[9] = {0}, place[2];
    one[4] = 10;
    two[1] = 5, two[7] = 1;
    three[0] = 5, three[4] = 1, three[8] = 2;
    assert_false(vvi_otsu_three(place, one, 9));
    assert_true(vvi_otsu_three(place, two, 9));
    assert_true(place[0] == 4.5 && place[1] == 4.5); /* halfway across the gap */
    assert_true(vvi_otsu_three(place, three, 9));
    assert_true(place[0] == 2.5 && place[1] == 6.5);
}

/* Volumes --------------------------------------------------------------------------------------------------------- */

/* Materials of 0, 100 and 250 with boundaries at distances 30 and 16 from the middle, blurred over 2.5 and 2. */
static double shells(vv_vec3 p)
{
    const double r = sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    return 50 * erfc((r - 30) / (2.5 * M_SQRT2)) + 75 * erfc((r - 16) / (2 * M_SQRT2));
}
static double ball(vv_vec3 p)
{
    const double r = sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    return 100 * erfc((r - 24) / (3 * M_SQRT2)); /* 0 to 200 */
}
static double ball_and_nan(vv_vec3 p)
{
    return p.x > 36 ? (double)NAN : ball(p);
}
static double constant(vv_vec3 p)
{
    return 7 + 0 * p.x;
}
static double nowhere(vv_vec3 p)
{
    return (double)NAN * p.x;
}
static double step(vv_vec3 p)
{
    return p.x * p.x + p.y * p.y + p.z * p.z < 400 ? 1 : 0;
}

typedef struct setup {
    vv_job *job;
    vv_object *world;
    vv_scene *scene;
} setup;

static void begin(setup *s, double (*value)(vv_vec3 p), const vv_field_info *info)
{
    const test_form form = {"form", value, NULL};
    vv_world *world = NULL;
    *s = (setup){.job = test_job(2, 0)};
    vv_field *field = test_field(&form, info, s->job);
    assert_non_null(field);
    assert_int_equal(vv_world_for_field(&world, "a", field, s->job), VV_OK);
    vv_field_release(field);
    s->world = &world->base;
}

static void end(setup *s)
{
    vv_scene_release(s->scene);
    vv_object_release(s->world);
    vv_job_release(s->job);
}

static void set(setup *s, const char *property, const char *json)
{
    char path[128];
    snprintf(path, sizeof path, "volumes.a.segmentation.%s", property);
    if (vv_path_set(&s->world, path, json, NULL) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
}

static const vv_classification *resolve(setup *s, const char *preset)
{
    char text[64];
    snprintf(text, sizeof text, "\"%s\"", preset);
    set(s, "transfer.preset", text);
    vv_scene_release(s->scene);
    s->scene = NULL;
    if (vv_scene_resolve(&s->scene, (vv_world *)(void *)s->world, NULL, s->job) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    return &s->scene->actors[0].classes;
}

/* n^3 over [-40, 40]^3. */
static vv_field_info cube(int64_t n, vv_type type)
{
    vv_field_info info = vv_field_info_default();
    info.grid = test_cube(n, -40, 40);
    info.type = type;
    return info;
}

static double peak_value(const vv_classification *c, size_t *index_out)
{
    size_t best = 0;
    for (size_t i = 1; i < c->n_opacity; i++)
        best = c->opacity[2 * i + 1] > c->opacity[2 * best + 1] ? i : best;
    *index_out = best;
    return c->opacity[2 * best];
}

static void a_blurred_boundary_is_opaque_at_its_middle_value(void **state)
{
    const vv_type types[] = {VV_TYPE_F32, VV_TYPE_U8, VV_TYPE_I16, VV_TYPE_F64};
    for (size_t t = 0; t < 4; t++) {
        setup s;
        size_t i;
        const vv_field_info info = cube(81, types[t]);
        begin(&s, ball, &info);
        const vv_classification *c = resolve(&s, "boundaries");
        assert_int_equal(c->n_opacity, 3);
        assert_true(fabs(peak_value(c, &i) - 100) < 4);
        assert_int_equal(i, 1);
        /* nodes stand one width from the middle: 200 (Phi(1) - 1/2) away */
        const double away = 100 * erf(M_SQRT1_2);
        assert_true(fabs(c->opacity[0] - (100 - away)) < 9 && fabs(c->opacity[4] - (100 + away)) < 9);
        assert_true(c->opacity[1] == 0 && c->opacity[5] == 0);
        /* an optical depth of 2.5 over a width of 3: opacity is for a length of 1, the spacing */
        assert_true(fabs(c->opacity[3] + expm1(-2.5 / 3)) < 0.06);
        assert_true(c->opacity_length == 1);
        end(&s);
    }
}

static void two_boundaries_are_told_apart_and_the_outer_one_is_thinner(void **state)
{
    setup s;
    const vv_field_info info = cube(81, VV_TYPE_F32);
    begin(&s, shells, &info);
    const vv_classification *c = resolve(&s, "boundaries");
    assert_int_equal(c->n_opacity, 6);
    assert_true(fabs(c->opacity[2] - 50) < 6 && fabs(c->opacity[8] - 175) < 8);
    assert_true(c->opacity[3] > 0.05 && c->opacity[9] > 2 * c->opacity[3]);
    end(&s);
}

/* Twice as fine a grid of the same body: the same opacity for a length, half the length. */
static void proposals_do_not_depend_on_the_sampling(void **state)
{
    for (size_t k = 1; k < N_NAMES; k++) {
        setup coarse, fine;
        const vv_field_info info = cube(41, VV_TYPE_F32), twice = cube(81, VV_TYPE_F32);
        begin(&coarse, ball, &info);
        begin(&fine, ball, &twice);
        const vv_classification *a = resolve(&coarse, names[k]), *b = resolve(&fine, names[k]);
        assert_true(fabs(a->opacity_length - 2 * b->opacity_length) < 1e-9);
        for (double v = 150; v <= 190; v += 10) { /* inside, where noise of the histogram moves no edge */
            const double ka = -log1p(-opacity_at((const double(*)[2])(const void *)a->opacity, a->n_opacity, v));
            const double kb = -log1p(-opacity_at((const double(*)[2])(const void *)b->opacity, b->n_opacity, v));
            if (k > 1 && k < 4)
                assert_true(fabs(ka / a->opacity_length - kb / b->opacity_length) <
                            0.1 * ka / a->opacity_length + 1e-9);
        }
        end(&coarse);
        end(&fine);
    }
}

static void the_outside_is_closed_and_the_dense_lies_within(void **state)
{
    setup s;
    const vv_field_info info = cube(81, VV_TYPE_F32);
    begin(&s, shells, &info);
    const vv_classification *c = resolve(&s, "outside");
    const double(*rows)[2] = (const double(*)[2])(const void *)c->opacity;
    assert_true(opacity_at(rows, c->n_opacity, 5) == 0);
    assert_true(opacity_at(rows, c->n_opacity, 100) > 0.5 && opacity_at(rows, c->n_opacity, 250) > 0.5);
    c = resolve(&s, "dense");
    rows = (const double(*)[2])(const void *)c->opacity;
    assert_true(opacity_at(rows, c->n_opacity, 5) == 0);
    assert_true(opacity_at(rows, c->n_opacity, 100) > 0 && opacity_at(rows, c->n_opacity, 100) < 0.05);
    assert_true(opacity_at(rows, c->n_opacity, 250) > 0.5);
    end(&s);
}

static void bands_part_materials_and_leave_the_background(void **state)
{
    setup s;
    const vv_field_info info = cube(81, VV_TYPE_F32);
    begin(&s, shells, &info);
    const vv_classification *c = resolve(&s, "bands");
    const double(*rows)[2] = (const double(*)[2])(const void *)c->opacity;
    assert_true(opacity_at(rows, c->n_opacity, 0) == 0);
    assert_true(opacity_at(rows, c->n_opacity, 100) > 0 && opacity_at(rows, c->n_opacity, 249) > 0);
    /* colours at the two materials differ */
    assert_int_equal(c->n_color % 2, 0);
    assert_true(c->n_color >= 4);
    const double *first = c->color, *last = c->color + 4 * (c->n_color - 1);
    assert_true(fabs(first[1] - last[1]) + fabs(first[2] - last[2]) + fabs(first[3] - last[3]) > 0.1);
    end(&s);
}

static void only_the_range_that_was_set_is_looked_at(void **state)
{
    setup s;
    size_t i;
    const vv_field_info info = cube(81, VV_TYPE_F32);
    begin(&s, shells, &info);
    set(&s, "transfer.range_lo", "120");
    const vv_classification *c = resolve(&s, "boundaries");
    assert_true(fabs(peak_value(c, &i) - 175) < 10);
    assert_true(c->opacity[0] >= 120);
    end(&s);
}

/* Rows ascend, opacities and colours are numbers from 0 to 1. */
static void check_rows(const vv_classification *c)
{
    assert_true(c->n_opacity > 0 && c->n_color > 0 && c->opacity_length > 0);
    for (size_t i = 0; i < c->n_opacity; i++) {
        assert_true(isfinite(c->opacity[2 * i]) && c->opacity[2 * i + 1] >= 0 && c->opacity[2 * i + 1] <= 1);
        assert_true(i == 0 || c->opacity[2 * i] >= c->opacity[2 * i - 2]);
    }
    for (size_t i = 0; i < c->n_color; i++)
        for (int k = 1; k < 4; k++)
            assert_true(c->color[4 * i + (size_t)k] >= 0 && c->color[4 * i + (size_t)k] <= 1);
}

static void every_proposal_is_sensible_for_odd_data(void **state)
{
    double (*const forms[])(vv_vec3) = {ball, ball_and_nan, constant, nowhere, step, shells};
    static const int64_t sizes[][3] = {{1, 1, 1}, {2, 2, 2}, {7, 1, 1}, {9, 9, 1}, {13, 11, 17}};
    const vv_type types[] = {VV_TYPE_F32, VV_TYPE_U8, VV_TYPE_U16};
    for (size_t f = 0; f < 6; f++)
        for (size_t z = 0; z < 5; z++)
            for (size_t t = 0; t < 3; t++)
                for (size_t k = 0; k < N_NAMES; k++) {
                    setup s;
                    vv_field_info info = cube(17, types[t]);
                    memcpy(info.grid.dims, sizes[z], sizeof info.grid.dims);
                    if (t > 0 && (f == 1 || f == 3))
                        continue; /* integers have no NaN */
                    begin(&s, forms[f], &info);
                    check_rows(resolve(&s, names[k]));
                    end(&s);
                }
}

static void where_there_is_nothing_to_be_found_the_fitted_one_is_taken(void **state)
{
    setup s;
    const vv_field_info info = cube(17, VV_TYPE_F32);
    begin(&s, constant, &info);
    const vv_classification *c = resolve(&s, "fitted");
    const double row[2] = {c->opacity[0], c->opacity[1]};
    c = resolve(&s, "boundaries");
    assert_true(c->n_opacity == 1 && c->opacity[0] == row[0] && c->opacity[1] == row[1]);
    end(&s);
}

static void labels_shown_by_their_numbers_have_proposals_too(void **state)
{
    setup s;
    vv_field_info info = cube(21, VV_TYPE_U8);
    info.meaning = VV_MEANING_LABEL;
    begin(&s, shells, &info);
    set(&s, "kind", "\"transfer\"");
    for (size_t k = 0; k < N_NAMES; k++)
        check_rows(resolve(&s, names[k]));
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(three_classes_have_the_least_variance_within),
        cmocka_unit_test(few_values_have_places_between_them),
        cmocka_unit_test(a_blurred_boundary_is_opaque_at_its_middle_value),
        cmocka_unit_test(two_boundaries_are_told_apart_and_the_outer_one_is_thinner),
        cmocka_unit_test(proposals_do_not_depend_on_the_sampling),
        cmocka_unit_test(the_outside_is_closed_and_the_dense_lies_within),
        cmocka_unit_test(bands_part_materials_and_leave_the_background),
        cmocka_unit_test(only_the_range_that_was_set_is_looked_at),
        cmocka_unit_test(every_proposal_is_sensible_for_odd_data),
        cmocka_unit_test(where_there_is_nothing_to_be_found_the_fitted_one_is_taken),
        cmocka_unit_test(labels_shown_by_their_numbers_have_proposals_too),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
