/* Voxelize: mass and area of the paper's profile, planes met exactly, densities put together. */
#include "fields.h"
#include "operations.h"
#include "registry.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
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
enum { N = 48 };
#define AT "center=[23.13, 23.27, 23.41];radius=10;"

static vv_field *grid_of(int64_t n, vv_type type)
{
    vv_field_info info = vv_field_info_default();
    info.type = type;
    info.grid = test_cube(n, 0, (double)n - 1);
    return test_field_random(&info, 1, NULL);
}

static vv_field *made(const vv_field *in, const char *settings)
{
    vv_field *out;
    assert_int_equal(test_apply(&out, &vvi_operation_voxelize, in, settings, NULL), VV_OK);
    return out;
}

static double at(const vv_field *f, int64_t i, int64_t j, int64_t k)
{
    return vv_field_value(f, i, j, k, 0);
}

static double mass(const vv_field *f)
{
    double sum = 0;
    for (int64_t k = 0; k < N; k++)
        for (int64_t j = 0; j < N; j++)
            for (int64_t i = 0; i < N; i++)
                sum += at(f, i, j, k);
    return sum;
}

static double area(const vv_field *f)
{
    double sum = 0;
    for (int64_t k = 1; k < N - 1; k++)
        for (int64_t j = 1; j < N - 1; j++)
            for (int64_t i = 1; i < N - 1; i++) {
                const double x = at(f, i + 1, j, k) - at(f, i - 1, j, k), y = at(f, i, j + 1, k) - at(f, i, j - 1, k);
                const double z = at(f, i, j, k + 1) - at(f, i, j, k - 1);
                sum += sqrt(x * x + y * y + z * z) / 2;
            }
    return sum;
}

/* Mean of d^2 under the profile's slope: w^2 / 3 of a ramp, 2 w^2 / 15 of the hypercone. */
static void a_sphere_has_the_mass_and_area_of_its_profile(void **state)
{
    vv_field *in = grid_of(N, VV_TYPE_U8), *cone = made(in, AT "profile=\"hypercone\";width=2");
    vv_field *ramp = made(in, AT "width=2.449489742783178");
    (void)state;
    assert_near(mass(cone), 4 * PI / 3 * 1000 + 40 * PI * 8 / 15, 0.05);
    assert_near(mass(ramp), 4 * PI / 3 * 1000 + 40 * PI * 2, 0.3);
    assert_near(area(cone) / (4 * PI * (100 + 8.0 / 15)), 1, 1e-3);
    vv_field_release(ramp);
    vv_field_release(cone);
    vv_field_release(in);
}

/* Every sample is the formula, also where bricks are filled without a look. */
static void densities_are_the_profile_of_the_distance(void **state)
{
    vv_field *in = grid_of(N, VV_TYPE_F32), *out = made(in, AT "shape=\"sphere\"");
    (void)state;
    for (int64_t k = 0; k < N; k++)
        for (int64_t j = 0; j < N; j++)
            for (int64_t i = 0; i < N; i++) {
                const double x = (double)i - 23.13, y = (double)j - 23.27, z = (double)k - 23.41;
                const double p = 0.5 - (sqrt(x * x + y * y + z * z) - 10) / (2 * sqrt(6));
                assert_near(at(out, i, j, k), p < 0 ? 0 : p > 1 ? 1 : p, 1e-6);
            }
    vv_field_release(out);
    vv_field_release(in);
}

/* A slope across a face of a turned box that is much larger than the volume: values and central differences are those
 * of the ramp, to the last digits, as the default width promises. */
static void planes_have_exact_places_and_normals(void **state)
{
    /* about x, then y, then z: where its axis z then points to */
    const double a = 20 * PI / 180, b = 30 * PI / 180, c = 40 * PI / 180, x = cos(a) * sin(b), y = -sin(a);
    const double normal[3] = {cos(c) * x - sin(c) * y, sin(c) * x + cos(c) * y, cos(a) * cos(b)};
    char words[160];
    int n = 0;
    (void)state;
    snprintf(words, sizeof words, "shape=\"box\";size=[400,400,400];rotation=[20,30,40];center=[%.17g,%.17g,%.17g]",
             23 - 200 * normal[0], 23 - 200 * normal[1], 23 - 200 * normal[2]);
    vv_field *in = grid_of(N, VV_TYPE_U8), *out = made(in, words);
    for (int64_t k = 1; k < N - 1; k++)
        for (int64_t j = 1; j < N - 1; j++)
            for (int64_t i = 1; i < N - 1; i++) {
                const double g[3] = {at(out, i + 1, j, k) - at(out, i - 1, j, k),
                                     at(out, i, j + 1, k) - at(out, i, j - 1, k),
                                     at(out, i, j, k + 1) - at(out, i, j, k - 1)};
                const double d =
                    normal[0] * ((double)i - 23) + normal[1] * ((double)j - 23) + normal[2] * ((double)k - 23);
                if (fabs(d) > 1)
                    continue;
                n++;
                assert_near(at(out, i, j, k), 0.5 - d / (2 * sqrt(6)), 1e-6);
                for (int axis = 0; axis < 3; axis++)
                    assert_near(g[axis], -normal[axis] / sqrt(6), 1e-6);
            }
    assert_true(n > 500);
    vv_field_release(out);
    vv_field_release(in);
}

/* Between samples, as renderers take them. */
static double trilinear(const vv_field *f, double x, double y, double z)
{
    const int64_t i = (int64_t)x, j = (int64_t)y, k = (int64_t)z;
    double sum = 0;
    for (int c = 0; c < 8; c++) {
        const int a = c & 1, b = c >> 1 & 1, d = c >> 2;
        const double u = x - (double)i, v = y - (double)j, w = z - (double)k;
        sum += (a ? u : 1 - u) * (b ? v : 1 - v) * (d ? w : 1 - w) * at(f, i + a, j + b, k + d);
    }
    return sum;
}

/* Interpolation cuts corners: on average by 1 / (6 R) voxels of a sphere of R. */
static void spheres_are_smaller_by_a_sixth_of_their_curvature(void **state)
{
    const uint64_t seed = test_seed();
    (void)state;
    for (int radius = 10; radius <= 20; radius += 10) {
        char words[100];
        snprintf(words, sizeof words, "center=[23.13,23.27,23.41];radius=%d", radius);
        vv_field *in = grid_of(N, VV_TYPE_U8), *out = made(in, words);
        double sum = 0;
        enum { RAYS = 4000 };
        for (uint64_t i = 0; i < RAYS; i++) {
            const double z = 2 * test_random_unit(seed, 2 * i) - 1, turn = 2 * PI * test_random_unit(seed, 2 * i + 1);
            const double x = sqrt(1 - z * z) * cos(turn), y = sqrt(1 - z * z) * sin(turn);
            double lo = radius - 1, hi = radius + 1;
            for (int step = 0; step < 40; step++) {
                const double r = (lo + hi) / 2;
                const bool inside = trilinear(out, 23.13 + r * x, 23.27 + r * y, 23.41 + r * z) > 0.5;
                *(inside ? &lo : &hi) = r;
            }
            sum += lo - radius;
        }
        assert_near(sum / RAYS * -6 * radius, 1, 0.15);
        vv_field_release(out);
        vv_field_release(in);
    }
}

/* Sets, sample by sample, against their formulas; and the same samples whatever box and number of threads. */
static void densities_are_put_together_by_their_formulas(void **state)
{
    static const char *const names[] = {"union", "intersection", "difference", "xor"};
    vv_field *in = grid_of(N, VV_TYPE_U8), *a = made(in, AT), *b = made(in, "shape=\"box\";size=[9,30,12]");
    (void)state;
    for (int with = 0; with < 4; with++)
        for (int products = 0; products < 2; products++) {
            char words[120];
            snprintf(words, sizeof words, "shape=\"box\";size=[9,30,12];with=\"%s\";set=\"%s\"", names[with],
                     products ? "products" : "extremes");
            vv_field *out = test_apply_all_ways(&vvi_operation_voxelize, (const vv_field *const[]){a}, 1, words);
            for (int64_t i = 0; i < N * N * N; i++) {
                const int64_t x = i % N, y = i / N % N, z = i / N / N;
                const double p = at(a, x, y, z), q = at(b, x, y, z);
                const double extremes[] = {fmax(p, q), fmin(p, q), fmin(p, 1 - q),
                                           fmax(fmin(p, 1 - q), fmin(1 - p, q))};
                const double product[] = {p + q - p * q, p * q, p * (1 - q), p + q - 2 * p * q};
                assert_near(at(out, x, y, z), products ? product[with] : extremes[with], 3e-7);
            }
            vv_field_release(out);
        }
    vv_field_release(b);
    vv_field_release(a);
    vv_field_release(in);
}

static double largest(const vv_field *f)
{
    double most = 0;
    for (int64_t i = 0; i < N * N * N; i++)
        most = fmax(most, at(f, i % N, i / N % N, i / N / N));
    return most;
}

/* What is taken from itself leaves a skin of one half, or of a quarter; with itself it is the same to the bit. */
static void a_solid_and_itself(void **state)
{
    vv_field *in = grid_of(N, VV_TYPE_U8), *a = made(in, AT), *both = made(a, AT "with=\"union\"");
    vv_field *skin = made(a, AT "with=\"difference\""), *thin = made(a, AT "with=\"difference\";set=\"products\"");
    (void)state;
    assert_true(test_same_samples(a, both));
    assert_near(largest(skin), 0.5, 0.01);
    assert_near(largest(thin), 0.25, 0.001);
    vv_field_release(thin);
    vv_field_release(skin);
    vv_field_release(both);
    vv_field_release(a);
    vv_field_release(in);
}

static void labels_are_no_densities(void **state)
{
    vv_field_info info = vv_field_info_default();
    vv_field *out;
    info.type = VV_TYPE_U8;
    info.meaning = VV_MEANING_LABEL;
    info.grid = test_cube(8, 0, 7);
    vv_field *in = test_field_random(&info, 1, NULL);
    (void)state;
    assert_int_equal(test_apply(&out, &vvi_operation_voxelize, in, "with=\"union\"", NULL), VV_E_UNSUPPORTED);
    assert_int_equal(test_apply(&out, &vvi_operation_voxelize, in, "width=0", NULL), VV_E_ARGUMENT);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sphere_has_the_mass_and_area_of_its_profile),
        cmocka_unit_test(densities_are_the_profile_of_the_distance),
        cmocka_unit_test(planes_have_exact_places_and_normals),
        cmocka_unit_test(spheres_are_smaller_by_a_sixth_of_their_curvature),
        cmocka_unit_test(densities_are_put_together_by_their_formulas),
        cmocka_unit_test(a_solid_and_itself),
        cmocka_unit_test(labels_are_no_densities),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
