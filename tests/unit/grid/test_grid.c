/* Where grids lie, and how boxes are cut for parallel loops. */
#include "core/vec.h"
#include "fields.h"
#include "grid/field.h"
#include "grid/same_grid.h"
#include "grid/slabs.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static vv_grid oblique(void)
{
    vv_grid g = vv_field_info_default().grid;
    g.dims[0] = 5, g.dims[1] = 1, g.dims[2] = 9;
    g.index_to_world.axis[0] = (vv_vec3){3, 4, 0};
    g.index_to_world.axis[1] = (vv_vec3){-0.3, 0.4, 0};
    g.index_to_world.axis[2] = (vv_vec3){0, 0.6, 0.8};
    g.index_to_world.origin = (vv_vec3){1, 2, 3};
    return g;
}

static void spacing_is_the_length_of_a_step(void **state)
{
    (void)state;
    const vv_grid g = oblique();
    assert_true(fabs(vv_grid_spacing(&g, 0) - 5) < 1e-15);
    assert_true(fabs(vv_grid_spacing(&g, 1) - 0.5) < 1e-15);
    assert_true(fabs(vv_grid_spacing(&g, 2) - 1) < 1e-15);
}

static void the_voxel_ignores_axes_of_one_sample_unless_all_are(void **state)
{
    (void)state;
    vv_grid g = oblique();
    assert_true(fabs(vv_grid_voxel(&g) - 1) < 1e-15);
    g.dims[0] = g.dims[2] = 1;
    assert_true(fabs(vv_grid_voxel(&g) - 0.5) < 1e-15);
}

static void bounds_hold_every_sample_and_touch_the_outermost(void **state)
{
    (void)state;
    const vv_grid g = oblique();
    const vv_bounds b = vv_grid_bounds(&g);
    double lo = INFINITY, hi = -INFINITY;
    for (int k = 0; k < 9; k++)
        for (int i = 0; i < 5; i++) {
            const vv_vec3 p = vv_affine_point(g.index_to_world, (vv_vec3){i, 0, k});
            lo = fmin(lo, p.y);
            hi = fmax(hi, p.y);
            assert_true(p.x >= b.lo.x && p.x <= b.hi.x && p.z >= b.lo.z && p.z <= b.hi.z);
        }
    assert_true(b.lo.y == lo && b.hi.y == hi);
}

static void a_crop_keeps_world_positions(void **state)
{
    (void)state;
    const vv_grid g = oblique();
    const vv_box box = {{1, 0, 3}, {3, 1, 4}};
    const vv_grid c = vv_grid_crop(&g, &box);
    assert_true(c.dims[0] == 3 && c.dims[1] == 1 && c.dims[2] == 4);
    const vv_vec3 p = vv_affine_point(c.index_to_world, (vv_vec3){2, 0, 1});
    const vv_vec3 q = vv_affine_point(g.index_to_world, (vv_vec3){3, 0, 4});
    assert_true(fabs(p.x - q.x) + fabs(p.y - q.y) + fabs(p.z - q.z) < 1e-14);
}

/* A grid as scanners make it: oblique, anatomical, in millimetres. */
static vv_grid scan(void)
{
    vv_grid g = oblique();
    g.dims[0] = 256, g.dims[1] = 255, g.dims[2] = 40;
    g.index_to_world.axis[0] = (vv_vec3){0.48828125 * 0.8, 0.48828125 * 0.6, 0};
    g.index_to_world.axis[1] = (vv_vec3){-0.48828125 * 0.6, 0.48828125 * 0.8, 0};
    g.index_to_world.axis[2] = (vv_vec3){0, 0, 3};
    g.space = VV_SPACE_RAS;
    snprintf(g.unit, sizeof g.unit, "mm");
    return g;
}

static void assert_apart(const vv_grid *a, const vv_grid *b, const char *word)
{
    assert_int_equal(vvi_grid_alike(a, b, "mask"), VV_E_ARGUMENT);
    if (!strstr(vv_error_last()->message, word) || !strstr(vv_error_last()->message, "the mask: expected "))
        fail_msg("'%s' does not say '%s'", vv_error_last()->message, word);
}

static void grids_are_alike_up_to_rounding_units_and_what_is_not_known(void **state)
{
    (void)state;
    const vv_grid g = scan();
    vv_grid other = g;
    assert_int_equal(vvi_grid_alike(&g, &other, "mask"), VV_OK);
    double *const numbers = &other.index_to_world.axis[0].x;
    for (int i = 0; i < 12; i++)
        numbers[i] = (double)(float)numbers[i] * (1 + 1e-6);
    assert_int_equal(vvi_grid_alike(&g, &other, "mask"), VV_OK);
    for (int i = 0; i < 12; i++)
        numbers[i] *= 1e-3;
    assert_apart(&g, &other, "expected a spacing");
    snprintf(other.unit, sizeof other.unit, "m");
    assert_int_equal(vvi_grid_alike(&g, &other, "mask"), VV_OK);
    other = vv_field_info_default().grid; /* no spacing at all */
    memcpy(other.dims, g.dims, sizeof g.dims);
    assert_int_equal(vvi_grid_alike(&g, &other, "mask"), VV_OK);
    assert_int_equal(vvi_grid_alike(&other, &g, "mask"), VV_OK);
    for (int a = 0; a < 3; a++) /* a spacing, but no place among anatomical axes */
        (&other.index_to_world.axis[a].x)[a] = vv_grid_spacing(&g, a);
    snprintf(other.unit, sizeof other.unit, "units");
    assert_int_equal(vvi_grid_alike(&g, &other, "mask"), VV_OK);
    other.index_to_world.axis[2].z = 2.5;
    assert_apart(&g, &other, "2.5 units");
}

static void samples_of_a_grid_are_found_in_another_order_and_unit(void **state)
{
    (void)state;
    const vv_grid g = scan();
    vv_grid other = g; /* z backwards first, then x, then y backwards; in metres; more on all sides but one */
    vvi_grid_fit fit;
    vv_vec3 *axis = other.index_to_world.axis;
    const vv_vec3 *from = g.index_to_world.axis;
    axis[0] = (vv_vec3){-from[2].x, -from[2].y, -from[2].z};
    axis[1] = from[0];
    axis[2] = (vv_vec3){-from[1].x, -from[1].y, -from[1].z};
    other.index_to_world.origin = vv_affine_point(g.index_to_world, (vv_vec3){-3, 250, 44});
    other.dims[0] = 50, other.dims[1] = 300, other.dims[2] = 260;
    for (int i = 0; i < 12; i++)
        (&axis[0].x)[i] *= 1e-3;
    snprintf(other.unit, sizeof other.unit, "m");
    assert_true(vvi_grid_fits(&fit, &g, &other));
    assert_true(fit.axis[0] == 1 && fit.axis[1] == 2 && fit.axis[2] == 0);
    assert_true(fit.sign[0] == 1 && fit.sign[1] == -1 && fit.sign[2] == -1);
    assert_true(fit.first[0] == 3 && fit.first[1] == 250 && fit.first[2] == 44);
    const vv_box box = vvi_grid_covered(&g, &other, &fit);
    assert_true(box.lo[0] == 0 && box.lo[1] == 0 && box.lo[2] == 0);
    assert_true(box.n[0] == 256 && box.n[1] == 251 && box.n[2] == 40);
    vv_grid half = other;
    half.index_to_world.origin.x += 0.00024;
    assert_false(vvi_grid_fits(&fit, &g, &half));
    half = other;
    half.index_to_world.axis[0] = vvi_scaled(half.index_to_world.axis[0], 1.01);
    assert_false(vvi_grid_fits(&fit, &g, &half));
}

static void grids_that_lie_elsewhere_are_told_by_what_differs(void **state)
{
    (void)state;
    const vv_grid g = scan();
    vv_grid other = g;
    other.dims[2]++;
    assert_apart(&g, &other, "256 x 255 x 41");
    other = g;
    other.index_to_world.axis[2].z = 3.1;
    assert_apart(&g, &other, "3.1 mm");
    other = g;
    other.index_to_world.axis[0] = (vv_vec3){-g.index_to_world.axis[0].x, -g.index_to_world.axis[0].y, 0};
    assert_apart(&g, &other, "LAS");
    other = g;
    other.index_to_world.origin.y += 0.2;
    assert_apart(&g, &other, "first sample");
    other = g;
    const double c = 0.9998476951563913, s = 0.01745240643728351; /* a degree about z */
    for (int a = 0; a < 2; a++) {
        const vv_vec3 v = g.index_to_world.axis[a];
        other.index_to_world.axis[a] = (vv_vec3){c * v.x - s * v.y, s * v.x + c * v.y, v.z};
    }
    assert_apart(&g, &other, "rotated by 1 degrees");
}

/* All 48 ways that three axes can run, written down by their definition: the letter of the direction of increase. */
static void all_48_orientations_get_their_letters(void **state)
{
    (void)state;
    static const int axes[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    for (int p = 0; p < 6; p++)
        for (int s = 0; s < 8; s++) {
            vv_grid g = vv_field_info_default().grid;
            char ras[4] = {0}, plain[7] = {0}, got[16];
            for (int a = 0; a < 3; a++) {
                double v[3] = {0.2, -0.1, 0.15}; /* a little oblique */
                v[axes[p][a]] = s >> a & 1 ? -2 : 2;
                g.index_to_world.axis[a] = (vv_vec3){v[0], v[1], v[2]};
                ras[a] = (s >> a & 1 ? "LPI" : "RAS")[axes[p][a]];
                plain[2 * a] = s >> a & 1 ? '-' : '+';
                plain[2 * a + 1] = "xyz"[axes[p][a]];
            }
            g.space = VV_SPACE_RAS;
            vv_grid_orientation(got, &g);
            assert_string_equal(got, ras);
            g.space = VV_SPACE_PLAIN;
            vv_grid_orientation(got, &g);
            assert_string_equal(got, plain);
        }
}

static void an_oblique_grid_never_gets_a_letter_twice(void **state)
{
    (void)state;
    vv_grid g = vv_field_info_default().grid;
    g.space = VV_SPACE_RAS;
    g.index_to_world.axis[0] = (vv_vec3){0.9, 0.8, 0};
    g.index_to_world.axis[1] = (vv_vec3){0.9, -0.1, 0}; /* both lean most to x */
    g.index_to_world.axis[2] = (vv_vec3){0, 0, 1};
    char got[16];
    vv_grid_orientation(got, &g);
    assert_string_equal(got, "ARS");
}

static void slabs_cover_a_box_once_in_x_fastest_order(void **state)
{
    (void)state;
    static const int64_t most[] = {1, 3, 7, 35, 36, 100, 1000000};
    const vv_box box = {{2, 3, 4}, {7, 5, 3}};
    for (size_t m = 0; m < sizeof most / sizeof *most; m++) {
        const vvi_slabs s = vvi_slabs_of(&box, most[m]);
        int64_t expected = 0; /* the number in the box of the next sample */
        for (size_t i = 0; i < s.n; i++) {
            const vv_box item = vvi_slabs_item(&s, i);
            assert_true(item.n[0] * item.n[1] * item.n[2] <= most[m]);
            for (int64_t k = 0; k < item.n[2]; k++)
                for (int64_t j = 0; j < item.n[1]; j++) {
                    assert_int_equal(vvi_slabs_row(&s, &item, j, k), expected);
                    for (int64_t x = 0; x < item.n[0]; x++, expected++)
                        assert_int_equal(expected,
                                         ((item.lo[2] - 4 + k) * 5 + item.lo[1] - 3 + j) * 7 + item.lo[0] - 2 + x);
                }
        }
        assert_int_equal(expected, 7 * 5 * 3);
    }
    const vv_box empty = {{0, 0, 0}, {3, 0, 3}};
    assert_int_equal(vvi_slabs_of(&empty, 10).n, 0);
}

static void gradients_of_the_closed_forms_are_those_of_their_values(void **state)
{
    (void)state;
    const uint64_t seed = test_seed();
    const double h = 1e-5;
    for (size_t f = 0; test_forms[f]; f++)
        for (uint64_t i = 0; i < 50; i++) {
            const vv_vec3 p = {test_random_unit(seed, 3 * i), test_random_unit(seed, 3 * i + 1),
                               test_random_unit(seed, 3 * i + 2)};
            const vv_vec3 g = test_forms[f]->gradient(p);
            const double dx = (test_forms[f]->value((vv_vec3){p.x + h, p.y, p.z}) -
                               test_forms[f]->value((vv_vec3){p.x - h, p.y, p.z})) /
                              (2 * h);
            const double dy = (test_forms[f]->value((vv_vec3){p.x, p.y + h, p.z}) -
                               test_forms[f]->value((vv_vec3){p.x, p.y - h, p.z})) /
                              (2 * h);
            const double dz = (test_forms[f]->value((vv_vec3){p.x, p.y, p.z + h}) -
                               test_forms[f]->value((vv_vec3){p.x, p.y, p.z - h})) /
                              (2 * h);
            if (fabs(dx - g.x) + fabs(dy - g.y) + fabs(dz - g.z) > 1e-5)
                fail_msg("the gradient of %s is wrong at %g %g %g", test_forms[f]->name, p.x, p.y, p.z);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spacing_is_the_length_of_a_step),
        cmocka_unit_test(the_voxel_ignores_axes_of_one_sample_unless_all_are),
        cmocka_unit_test(bounds_hold_every_sample_and_touch_the_outermost),
        cmocka_unit_test(a_crop_keeps_world_positions),
        cmocka_unit_test(grids_are_alike_up_to_rounding_units_and_what_is_not_known),
        cmocka_unit_test(samples_of_a_grid_are_found_in_another_order_and_unit),
        cmocka_unit_test(grids_that_lie_elsewhere_are_told_by_what_differs),
        cmocka_unit_test(all_48_orientations_get_their_letters),
        cmocka_unit_test(an_oblique_grid_never_gets_a_letter_twice),
        cmocka_unit_test(slabs_cover_a_box_once_in_x_fastest_order),
        cmocka_unit_test(gradients_of_the_closed_forms_are_those_of_their_values),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
