/* Affine maps. */
#include "fields.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>
#include <volvis/vec.h>

#include <cmocka.h>

static vv_vec3 random_vector(uint64_t *at)
{
    const vv_vec3 v = {test_random_unit(11, *at) * 2 - 1, test_random_unit(11, *at + 1) * 2 - 1,
                       test_random_unit(11, *at + 2) * 2 - 1};
    *at += 3;
    return v;
}

static vv_affine random_map(uint64_t *at)
{
    vv_affine a;
    do {
        for (int i = 0; i < 3; i++)
            a.axis[i] = random_vector(at);
    } while (fabs(vv_affine_determinant(a)) < 0.05);
    a.origin = random_vector(at);
    return a;
}

static void check_near(vv_vec3 a, vv_vec3 b, double allowed)
{
    if (!(fabs(a.x - b.x) <= allowed && fabs(a.y - b.y) <= allowed && fabs(a.z - b.z) <= allowed))
        fail_msg("(%.17g %.17g %.17g) is not (%.17g %.17g %.17g)", a.x, a.y, a.z, b.x, b.y, b.z);
}

static void the_identity_maps_every_point_to_itself(void **state)
{
    (void)state;
    const vv_vec3 p = {1.5, -2, 1e300};
    check_near(vv_affine_point(vv_affine_identity(), p), p, 0);
    check_near(vv_affine_vector(vv_affine_identity(), p), p, 0);
    assert_true(vv_affine_determinant(vv_affine_identity()) == 1);
}

static void points_are_moved_by_the_origin_and_directions_are_not(void **state)
{
    (void)state;
    const vv_affine a = {.axis = {{2, 0, 0}, {0, 3, 1}, {0, 0, 4}}, .origin = {10, 20, 30}};
    check_near(vv_affine_point(a, (vv_vec3){1, 1, 1}), (vv_vec3){12, 23, 35}, 0);
    check_near(vv_affine_vector(a, (vv_vec3){1, 1, 1}), (vv_vec3){2, 3, 5}, 0);
}

static void composing_is_mapping_twice(void **state)
{
    (void)state;
    uint64_t at = 0;
    for (int i = 0; i < 1000; i++) {
        const vv_affine a = random_map(&at), b = random_map(&at), ab = vv_affine_compose(a, b);
        const vv_vec3 p = random_vector(&at);
        check_near(vv_affine_point(ab, p), vv_affine_point(a, vv_affine_point(b, p)), 1e-14);
        check_near(vv_affine_vector(ab, p), vv_affine_vector(a, vv_affine_vector(b, p)), 1e-14);
        assert_true(fabs(vv_affine_determinant(ab) - vv_affine_determinant(a) * vv_affine_determinant(b)) < 1e-13);
    }
}

static void the_inverse_undoes_the_map(void **state)
{
    (void)state;
    uint64_t at = 1 << 20;
    for (int i = 0; i < 1000; i++) {
        const vv_affine a = random_map(&at);
        const vv_vec3 p = random_vector(&at);
        vv_affine inverse;
        assert_true(vv_affine_invert(&inverse, a));
        check_near(vv_affine_point(inverse, vv_affine_point(a, p)), p, 1e-11);
        check_near(vv_affine_point(a, vv_affine_point(inverse, p)), p, 1e-11);
    }
}

static void the_inverse_of_a_power_of_two_grid_is_exact(void **state)
{
    (void)state;
    const vv_affine a = {.axis = {{0, 0.5, 0}, {0, 0, -4}, {2, 0, 0}}, .origin = {1, 2, 3}};
    vv_affine inverse;
    assert_true(vv_affine_invert(&inverse, a));
    check_near(vv_affine_point(inverse, (vv_vec3){1, 2.5, 3}), (vv_vec3){1, 0, 0}, 0);
    check_near(vv_affine_point(inverse, (vv_vec3){3, 2, -1}), (vv_vec3){0, 1, 1}, 0);
    assert_true(vv_affine_determinant(a) == -4); /* mirrored */
}

static void any_unit_of_length_can_be_inverted(void **state)
{
    (void)state;
    static const double spacings[] = {1e-12, 1e-100, 1e26, 1e100};
    for (size_t i = 0; i < sizeof spacings / sizeof *spacings; i++) {
        const double s = spacings[i];
        const vv_affine a = {.axis = {{s, 0, 0}, {0, 2 * s, 0}, {0, s, 3 * s}}, .origin = {s, s, s}};
        vv_affine inverse;
        assert_true(vv_affine_invert(&inverse, a));
        check_near(vv_affine_point(inverse, vv_affine_point(a, (vv_vec3){1, 2, 3})), (vv_vec3){1, 2, 3}, 1e-14);
    }
}

static void a_singular_map_has_no_inverse_and_out_is_untouched(void **state)
{
    (void)state;
    static const vv_affine singular[] = {
        {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 0}}},        {.axis = {{1, 0, 0}, {0, 1, 0}, {1, 1, 0}}},
        {.axis = {{1, 2, 3}, {2, 4, 6}, {0, 0, 1}}},        {.axis = {{NAN, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
        {.axis = {{1, 0, 0}, {0, INFINITY, 0}, {0, 0, 1}}}, {.axis = {{INFINITY, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
        {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, NAN}}},
    };
    for (size_t i = 0; i < sizeof singular / sizeof *singular; i++) {
        vv_affine out = vv_affine_identity();
        const vv_affine before = out;
        assert_false(vv_affine_invert(&out, singular[i]));
        assert_memory_equal(&out, &before, sizeof out);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_identity_maps_every_point_to_itself),
        cmocka_unit_test(points_are_moved_by_the_origin_and_directions_are_not),
        cmocka_unit_test(composing_is_mapping_twice),
        cmocka_unit_test(the_inverse_undoes_the_map),
        cmocka_unit_test(the_inverse_of_a_power_of_two_grid_is_exact),
        cmocka_unit_test(any_unit_of_length_can_be_inverted),
        cmocka_unit_test(a_singular_map_has_no_inverse_and_out_is_untouched),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
