/* Profiles: their formulas, the table, what is integrated over them. */
#include "modeling/profile.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

/* cmocka's own compares floats. */
#define assert_near(value, expected, error)                                                                            \
    do {                                                                                                               \
        const double near_a = (value), near_b = (expected);                                                            \
        if (!(fabs(near_a - near_b) <= (error)))                                                                       \
            fail_msg("%s: %.17g, expected %.17g", #value, near_a, near_b);                                             \
    } while (0)

static void profiles_fall_from_1_to_0_and_are_symmetric(void **state)
{
    (void)state;
    for (int kind = 0; kind < VVI_PROFILES; kind++) {
        double before = 1;
        assert_near(vvi_profile_at(kind, -7), 1, 1e-15);
        assert_near(vvi_profile_at(kind, 7), 0, 1e-15);
        assert_near(vvi_profile_at(kind, 0), 0.5, 1e-15);
        for (int i = -64; i <= 64; i++) {
            const double s = i / 64.0, p = vvi_profile_at(kind, s);
            assert_true(p <= before);
            assert_near(p + vvi_profile_at(kind, -s), 1, 1e-15);
            before = p;
        }
    }
}

/* The kernel's ball cut by a plane: 3 / pi (1 - r) over what lies behind it, slice by slice. */
static double cone_behind(double s)
{
    enum { N = 400 };
    double sum = 0;
    for (int i = 0; i < N; i++) {
        const double z = s + (1 - s) * (i + 0.5) / N;
        for (int j = 0; j < N; j++) {
            const double most = sqrt(1 - z * z), rho = most * (j + 0.5) / N, r = sqrt(z * z + rho * rho);
            sum += 6 * (1 - r) * rho * most / N * (1 - s) / N;
        }
    }
    return sum;
}

static void the_hypercone_is_its_kernel_over_a_half_space(void **state)
{
    static const double exact[][2] = {{0, 0.5}, {0.25, 0.263671875}, {0.5, 0.09375}, {0.75, 0.013671875}, {1, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof exact / sizeof *exact; i++) {
        assert_near(vvi_profile_at(VVI_PROFILE_HYPERCONE, exact[i][0]), exact[i][1], 1e-15);
        assert_near(cone_behind(exact[i][0]), exact[i][1], 2e-5);
    }
}

static void the_table_is_the_formula(void **state)
{
    (void)state;
    for (int kind = 0; kind < VVI_PROFILES; kind++) {
        vvi_profile profile;
        vvi_profile_init(&profile, (vvi_profile_kind)kind, 2.5);
        for (int i = -811; i <= 811; i++) {
            const double d = 0.0037 * i;
            float density;
            vvi_profile_densities(&density, &d, 1, &profile);
            assert_near((double)density, vvi_profile_at((vvi_profile_kind)kind, d / 2.5), 4e-6);
        }
    }
}

static void what_is_no_number_or_without_end_is_outside_or_inside(void **state)
{
    const double d[] = {NAN, INFINITY, -INFINITY};
    vvi_profile profile;
    float density[3];
    (void)state;
    vvi_profile_init(&profile, VVI_PROFILE_LINEAR, 1);
    vvi_profile_densities(density, d, 3, &profile);
    assert_true(density[0] == 0 && density[1] == 0 && density[2] == 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(profiles_fall_from_1_to_0_and_are_symmetric),
        cmocka_unit_test(the_hypercone_is_its_kernel_over_a_half_space),
        cmocka_unit_test(the_table_is_the_formula),
        cmocka_unit_test(what_is_no_number_or_without_end_is_outside_or_inside),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
