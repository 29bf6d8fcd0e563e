/* Distances of primitives: against the nearest of many places on their surfaces, which know nothing of the formulas. */
#include "fields.h"
#include "modeling/primitives.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

/* cmocka's own compares floats. */
#define assert_near(value, expected, error)                                                                            \
    do {                                                                                                               \
        const double near_a = (value), near_b = (expected);                                                            \
        if (!(fabs(near_a - near_b) <= (error)))                                                                       \
            fail_msg("%s: %.17g, expected %.17g", #value, near_a, near_b);                                             \
    } while (0)

#define PI 3.14159265358979323846
enum { N = 300, PLACES = 36 };

/* A place of the surface by two numbers from 0 to 1, part 0, 1 or 2 of it; false: it has no such part. */
typedef bool surface(double out[3], int part, double u, double v, const vvi_lengths *l);

static void turned(double out[3], double rho, double z, double v)
{
    out[0] = rho * cos(2 * PI * v), out[1] = rho * sin(2 * PI * v), out[2] = z;
}

static bool of_sphere(double out[3], int part, double u, double v, const vvi_lengths *l)
{
    turned(out, l->radius * sin(PI * u), l->radius * cos(PI * u), v);
    return part == 0;
}

static bool of_ellipsoid(double out[3], int part, double u, double v, const vvi_lengths *l)
{
    turned(out, sin(PI * u), cos(PI * u), v);
    for (int a = 0; a < 3; a++)
        out[a] *= l->size[a] / 2;
    return part == 0;
}

/* A pair of faces a part, one for each half of v. */
static bool of_box(double out[3], int part, double u, double v, const vvi_lengths *l)
{
    const int b = (part + 1) % 3, c = (part + 2) % 3;
    out[part] = v < 0.5 ? l->size[part] / 2 : -l->size[part] / 2;
    out[b] = l->size[b] * (u - 0.5);
    out[c] = l->size[c] * (fmod(2 * v, 1) - 0.5);
    return true;
}

static bool of_cone(double out[3], int part, double u, double v, const vvi_lengths *l)
{
    if (part == 0)
        turned(out, l->radius * u, -l->height / 2, v);
    else if (part == 1)
        turned(out, l->top * u, l->height / 2, v);
    else
        turned(out, l->radius + (l->top - l->radius) * u, l->height * (u - 0.5), v);
    return true;
}

static bool of_cylinder(double out[3], int part, double u, double v, const vvi_lengths *l)
{
    vvi_lengths same = *l;
    same.top = l->radius;
    return of_cone(out, part, u, v, &same);
}

static bool of_capsule(double out[3], int part, double u, double v, const vvi_lengths *l)
{
    const double z = part == 1 ? l->height / 2 : -l->height / 2;
    if (part == 2)
        turned(out, l->radius, l->height * (u - 0.5), v);
    else
        turned(out, l->radius * sin(PI * u / 2), z + (part == 1 ? 1 : -1) * l->radius * cos(PI * u / 2), v);
    return true;
}

static bool of_torus(double out[3], int part, double u, double v, const vvi_lengths *l)
{
    turned(out, l->radius + l->tube * cos(2 * PI * u), l->tube * sin(2 * PI * u), v);
    return part == 0;
}

static surface *const surfaces[VVI_SHAPES] = {of_sphere, of_ellipsoid, of_box,  of_cylinder,
                                              of_cone,   of_capsule,   of_torus};
static const vvi_lengths lengths = {.radius = 3, .top = 1, .tube = 1.2, .height = 5, .size = {7, 4, 5}};

static double searched(int shape, const double p[3], const vvi_lengths *l)
{
    double least = INFINITY, on[3];
    for (int part = 0; part < 3; part++)
        for (int i = 0; i <= N; i++)
            for (int j = 0; j <= N; j++) {
                if (!surfaces[shape](on, part, (double)i / N, (double)j / N, l))
                    continue;
                const double x = on[0] - p[0], y = on[1] - p[1], z = on[2] - p[2];
                least = fmin(least, x * x + y * y + z * z);
            }
    return sqrt(least);
}

static double distance(int shape, const double p[3], const vvi_lengths *l)
{
    double d;
    vvi_primitives[shape].distances(&d, &(vvi_places){&p[0], &p[1], &p[2], 1}, l);
    return d;
}

static void distances_are_those_to_the_nearest_place_of_the_surface(void **state)
{
    const uint64_t seed = test_seed();
    (void)state;
    for (int shape = 0; shape < VVI_SHAPES; shape++)
        for (uint64_t i = 0; i < PLACES; i++) {
            double p[3];
            for (uint64_t a = 0; a < 3; a++)
                p[a] = 10 * test_random_unit(seed, 3 * i + a) - 5;
            if (i % 6 == 0)
                p[i / 6 % 3] = 0; /* planes of symmetry */
            const double d = distance(shape, p, &lengths), close = searched(shape, p, &lengths);
            if (!(fabs(fabs(d) - close) < 0.05))
                fail_msg("%s at %g %g %g: %g, searched %g", vvi_primitives[shape].name, p[0], p[1], p[2], d, close);
        }
}

/* The volume inside, by counting, with the exact one. */
static void inside_is_what_the_volume_says(void **state)
{
    const vvi_lengths *l = &lengths;
    const double r = l->radius, h = l->height;
    const double exact[VVI_SHAPES] = {4 * PI / 3 * r * r * r,
                                      PI / 6 * 7 * 4 * 5,
                                      7 * 4 * 5,
                                      PI * r * r * h,
                                      PI * h / 3 * (r * r + r * l->top + l->top * l->top),
                                      PI * r * r * h + 4 * PI / 3 * r * r * r,
                                      2 * PI * PI * r * l->tube * l->tube};
    enum { SIDE = 120 };
    (void)state;
    for (int shape = 0; shape < VVI_SHAPES; shape++) {
        double n = 0;
        for (int k = 0; k < SIDE; k++)
            for (int j = 0; j < SIDE; j++)
                for (int i = 0; i < SIDE; i++) {
                    const double p[3] = {12 * (i + 0.5) / SIDE - 6, 12 * (j + 0.5) / SIDE - 6,
                                         12 * (k + 0.5) / SIDE - 6};
                    n += distance(shape, p, l) < 0;
                }
        assert_near(n * 0.001 / exact[shape], 1, 0.01);
    }
}

static void a_rounded_box_is_a_smaller_one_that_has_grown(void **state)
{
    vvi_lengths rounded = lengths, smaller = lengths;
    const uint64_t seed = test_seed();
    (void)state;
    rounded.rounding = 1.5;
    for (int a = 0; a < 3; a++)
        smaller.size[a] -= 3;
    for (uint64_t i = 0; i < 1000; i++) {
        double p[3];
        for (uint64_t a = 0; a < 3; a++)
            p[a] = 10 * test_random_unit(seed, 3 * i + a) - 5;
        assert_near(distance(VVI_BOX, p, &rounded), distance(VVI_BOX, p, &smaller) - 1.5, 1e-12);
    }
}

/* Of equal axes an ellipsoid is a sphere; at its middle, and on its axes, the search has no direction to go. */
static void ellipsoids_have_no_bad_places(void **state)
{
    static const vvi_lengths ball = {.radius = 2, .size = {4, 4, 4}}, egg = {.size = {4, 4, 10}},
                             thin = {.size = {9, 6, 1e-3}};
    const double middle[3] = {0, 0, 0}, up[3] = {0, 0, 7}, inside[3] = {0, 0, 4.9}, far[3] = {1e6, -1e6, 1e6};
    const uint64_t seed = test_seed();
    (void)state;
    for (uint64_t i = 0; i < 1000; i++) {
        double p[3];
        for (uint64_t a = 0; a < 3; a++)
            p[a] = 10 * test_random_unit(seed, 3 * i + a) - 5;
        assert_near(distance(VVI_ELLIPSOID, p, &ball), distance(VVI_SPHERE, p, &ball), 1e-12);
    }
    assert_near(distance(VVI_ELLIPSOID, middle, &ball), -2, 1e-12);
    assert_near(distance(VVI_ELLIPSOID, middle, &egg), -2, 1e-12);
    assert_near(distance(VVI_ELLIPSOID, middle, &thin), -5e-4, 1e-12);
    assert_near(distance(VVI_ELLIPSOID, up, &egg), 2, 1e-12);
    assert_near(distance(VVI_ELLIPSOID, inside, &egg), -0.1, 1e-12);
    assert_near(distance(VVI_ELLIPSOID, far, &ball), 1e6 * sqrt(3) - 2, 1e-6);
}

static void impossible_lengths_are_refused_in_a_sentence(void **state)
{
    vvi_lengths l = lengths;
    (void)state;
    l.radius = 0;
    assert_int_equal(vvi_primitive_check(&vvi_primitives[VVI_SPHERE], &l, "solid"), VV_E_ARGUMENT);
    assert_string_equal(vv_error_last()->message, "solid: radius of a sphere is 0, and must be above 0");
    assert_int_equal(vvi_primitive_check(&vvi_primitives[VVI_BOX], &l, "solid"), VV_OK);
    l.rounding = 2.1;
    assert_int_equal(vvi_primitive_check(&vvi_primitives[VVI_BOX], &l, "solid"), VV_E_ARGUMENT);
    l.radius = 1;
    assert_int_equal(vvi_primitive_check(&vvi_primitives[VVI_TORUS], &l, "solid"), VV_E_ARGUMENT);
    l.height = INFINITY;
    assert_int_equal(vvi_primitive_check(&vvi_primitives[VVI_CONE], &l, "solid"), VV_E_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(distances_are_those_to_the_nearest_place_of_the_surface),
        cmocka_unit_test(inside_is_what_the_volume_says),
        cmocka_unit_test(a_rounded_box_is_a_smaller_one_that_has_grown),
        cmocka_unit_test(ellipsoids_have_no_bad_places),
        cmocka_unit_test(impossible_lengths_are_refused_in_a_sentence),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
