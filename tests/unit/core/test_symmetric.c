/* Eigenvalues and vectors of matrices that are made of known ones. */
#include "core/symmetric.h"
#include "core/vec.h"
#include "fields.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static vv_vec3 random_direction(uint64_t seed, uint64_t index)
{
    vv_vec3 v = {test_random_unit(seed, index) - 0.5, test_random_unit(seed, index + 1) - 0.5,
                 test_random_unit(seed, index + 2) - 0.5};
    vvi_unit(&v);
    return v;
}

static void make(double m[VVI_SYMMETRIC], const double value[3], const vv_vec3 vector[3])
{
    memset(m, 0, VVI_SYMMETRIC * sizeof *m);
    for (int i = 0; i < 3; i++) {
        const vv_vec3 v = vector[i];
        const double of[VVI_SYMMETRIC] = {v.x * v.x, v.y * v.y, v.z * v.z, v.x * v.y, v.x * v.z, v.y * v.z};
        for (int e = 0; e < VVI_SYMMETRIC; e++)
            m[e] += value[i] * of[e];
    }
}

static void expect(const double want[3], const double m[VVI_SYMMETRIC], double scale)
{
    double value[3], alone[3], again[VVI_SYMMETRIC];
    vv_vec3 vector[3];
    vvi_symmetric_eigen(value, vector, m);
    vvi_symmetric_values(alone, m);
    assert_memory_equal(value, alone, sizeof value);
    for (int i = 0; i < 3; i++) {
        if (!(fabs(value[i] - want[i]) <= 4e-15 * scale))
            fail_msg("%g %g %g: value %d is off by %g", want[0], want[1], want[2], i, (value[i] - want[i]) / scale);
        assert_true(fabs(vvi_dot(vector[i], vector[i]) - 1) < 1e-14);
        assert_true(fabs(vvi_dot(vector[i], vector[(i + 1) % 3])) < 1e-14);
    }
    make(again, value, vector);
    for (int e = 0; e < VVI_SYMMETRIC; e++)
        assert_true(fabs(again[e] - m[e]) <= 2e-14 * scale);
}

static void known_values_are_found_also_where_some_are_equal(void **state)
{
    (void)state;
    static const double values[][3] = {{-3, 1, 2},     {0, 0, 0},        {0, 0, 1},         {-1, 0, 0}, {5, 5, 5},
                                       {-2, -2, 7},    {-2, 7, 7},       {1, 1 + 1e-9, 2},  {-1, 0, 1}, {0, 1e-12, 1},
                                       {-1, -1e-8, 0}, {3, 3, 3 + 1e-7}, {-1e-3, 1e-3, 1e3}};
    static const double scales[] = {1, 1e-30, 1e30, 1e-200, 1e200};
    const uint64_t seed = test_seed();
    for (size_t v = 0; v < sizeof values / sizeof *values; v++)
        for (uint64_t r = 0; r < 500; r++) {
            const double scale = scales[r % 5];
            const double want[3] = {scale * values[v][0], scale * values[v][1], scale * values[v][2]};
            vv_vec3 frame[3] = {random_direction(seed, 10 * r + 1000 * v), random_direction(seed, 10 * r + 5)};
            double m[VVI_SYMMETRIC];
            frame[2] = vvi_cross(frame[0], frame[1]);
            assert_true(vvi_unit(&frame[2]));
            frame[1] = vvi_cross(frame[2], frame[0]);
            make(m, want, frame);
            expect(want, m, fmax(fabs(want[0]), fabs(want[2])));
        }
}

static void diagonal_ones_are_as_they_stand(void **state)
{
    (void)state;
    for (int order = 0; order < 6; order++) {
        static const int at[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
        const double want[3] = {-4, 0.5, 9};
        double m[VVI_SYMMETRIC] = {0};
        for (int i = 0; i < 3; i++)
            m[at[order][i]] = want[i];
        expect(want, m, 9);
    }
}

static void what_is_not_finite_has_none(void **state)
{
    (void)state;
    for (int e = 0; e < VVI_SYMMETRIC; e++) {
        double m[VVI_SYMMETRIC] = {1, 2, 3, 4, 5, 6}, value[3];
        m[e] = e % 2 ? NAN : INFINITY;
        vvi_symmetric_values(value, m);
        assert_true(isnan(value[0]) && isnan(value[1]) && isnan(value[2]));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_values_are_found_also_where_some_are_equal),
        cmocka_unit_test(diagonal_ones_are_as_they_stand),
        cmocka_unit_test(what_is_not_finite_has_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
