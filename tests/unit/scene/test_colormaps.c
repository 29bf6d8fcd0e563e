/* Judged in CIELAB and, for evenness, in CAM02-UCS. */
#include "scene/colormaps.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define STEPS 64

/* cmocka's own comparison is of floats, and its macro does not bracket its arguments. */
static void assert_near(double found, double expected, double tolerance)
{
    if (!(fabs(found - expected) <= tolerance))
        fail_msg("%.17g is not %.17g", found, expected);
}

static double cube(double t)
{
    return t > 216 / 24389. ? cbrt(t) : (24389 / 27. * t + 16) / 116;
}

static void cielab(double lab[3], const double rgb[3])
{
    const double x = 0.4124564 * rgb[0] + 0.3575761 * rgb[1] + 0.1804375 * rgb[2];
    const double y = 0.2126729 * rgb[0] + 0.7151522 * rgb[1] + 0.0721750 * rgb[2];
    const double z = 0.0193339 * rgb[0] + 0.1191920 * rgb[1] + 0.9503041 * rgb[2];
    const double fx = cube(x / 0.95047), fy = cube(y), fz = cube(z / 1.08883);
    lab[0] = 116 * fy - 16;
    lab[1] = 500 * (fx - fy);
    lab[2] = 200 * (fy - fz);
}

/* Sharma, Wu, Dalal 2005. */
static double ciede2000(const double p[3], const double q[3])
{
    const double deg = M_PI / 180;
    const double c_bar = (hypot(p[1], p[2]) + hypot(q[1], q[2])) / 2;
    const double g = 0.5 * (1 - sqrt(pow(c_bar, 7) / (pow(c_bar, 7) + pow(25, 7))));
    const double a1 = (1 + g) * p[1], a2 = (1 + g) * q[1];
    const double c1 = hypot(a1, p[2]), c2 = hypot(a2, q[2]);
    const double h1 = atan2(p[2], a1), h2 = atan2(q[2], a2);
    double dh = h2 - h1;
    if (dh > M_PI)
        dh -= 2 * M_PI;
    if (dh < -M_PI)
        dh += 2 * M_PI;
    if (c1 * c2 == 0)
        dh = 0;
    const double dl = q[0] - p[0], dc = c2 - c1, dbig = 2 * sqrt(c1 * c2) * sin(dh / 2);
    const double l = (p[0] + q[0]) / 2, c = (c1 + c2) / 2, h = h1 + dh / 2;
    const double t =
        1 - 0.17 * cos(h - 30 * deg) + 0.24 * cos(2 * h) + 0.32 * cos(3 * h + 6 * deg) - 0.20 * cos(4 * h - 63 * deg);
    double hd = fmod(h / deg + 720, 360);
    const double rot = 30 * exp(-pow((hd - 275) / 25, 2));
    const double rc = 2 * sqrt(pow(c, 7) / (pow(c, 7) + pow(25, 7)));
    const double sl = 1 + 0.015 * (l - 50) * (l - 50) / sqrt(20 + (l - 50) * (l - 50));
    const double sc = 1 + 0.045 * c, sh = 1 + 0.015 * c * t;
    const double rt = -sin(2 * rot * deg) * rc;
    return sqrt(pow(dl / sl, 2) + pow(dc / sc, 2) + pow(dbig / sh, 2) + rt * dc / sc * dbig / sh);
}

static void the_difference_formula_gives_published_values(void **state)
{
    const double a[3] = {50, 2.6772, -79.7751}, b[3] = {50, 0, -82.7485};
    const double c[3] = {60.2574, -34.0099, 36.2677}, d[3] = {60.4626, -34.1751, 39.4387};
    assert_near(ciede2000(a, b), 2.0425, 1e-4);
    assert_near(ciede2000(c, d), 1.2644, 1e-4);
}

static void lab_along(double lab[STEPS + 1][3], const char *name)
{
    for (int i = 0; i <= STEPS; i++) {
        vv_color c;
        assert_true(vv_colormap_sample(&c, name, (double)i / STEPS));
        cielab(lab[i], (double[]){c.r, c.g, c.b});
    }
}

static const char *const sequential[] = {"viridis", "magma", "inferno", "plasma", "cividis",
                                         "gray",    "bone",  "hot",     "ice",    "tissue"};
#define N_SEQUENTIAL (sizeof sequential / sizeof sequential[0])

/* Mikhailov 2019: sRGB as a polynomial of the place. The table is linear in Oklab between 65 of them. */
static void turbo_is_its_published_formula(void **state)
{
    static const double rows[3][6] = {
        {0.13572138, 4.61539260, -42.66032258, 132.13108234, -152.94239396, 59.28637943},
        {0.09140261, 2.19418839, 4.84296658, -14.18503333, 4.27729857, 2.82956604},
        {0.10667330, 12.64194608, -60.58204836, 110.36276771, -89.90310912, 27.34824973},
    };
    for (int i = 0; i <= 20; i++) {
        const double at = i / 20.0;
        vv_color c;
        assert_true(vv_colormap_sample(&c, "turbo", at));
        const double got[3] = {c.r, c.g, c.b};
        for (int k = 0; k < 3; k++) {
            double expected = 0;
            for (int p = 5; p >= 0; p--)
                expected = expected * at + rows[k][p];
            assert_near(vv_srgb_encode(got[k]), fmin(fmax(expected, 0), 1), 0.02);
        }
    }
}

static void other_spellings_are_the_same_map(void **state)
{
    vv_color gray, grey;
    assert_true(vv_colormap_sample(&gray, "gray", 0.3) && vv_colormap_sample(&grey, "grey", 0.3));
    assert_near(gray.r, grey.r, 0);
}

static void lightness_of_sequential_maps_rises_throughout(void **state)
{
    for (size_t m = 0; m < N_SEQUENTIAL; m++) {
        double lab[STEPS + 1][3];
        lab_along(lab, sequential[m]);
        for (int i = 0; i < STEPS; i++)
            assert_true(lab[i + 1][0] > lab[i][0]);
        assert_true(lab[STEPS][0] - lab[0][0] > 50);
    }
}

static void multiply(double out[3], const double m[3][3], const double v[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
}

/* CIECAM02 (Moroney 2002) for an sRGB display: D65, adapting luminance 64 lux / pi / 5, gray background of 20 %. */
typedef struct appearance {
    double fl, nbb, z, white, adapt[3];
} appearance;

static void cone_responses(double out[3], const appearance *a, const double rgb[3])
{
    static const double to_xyz[3][3] = {{41.24, 35.76, 18.05}, {21.26, 71.52, 7.22}, {1.93, 11.92, 95.05}};
    static const double cat02[3][3] = {{0.7328, 0.4296, -0.1624}, {-0.7036, 1.6975, 0.0061}, {0.0030, 0.0136, 0.9834}};
    static const double cat02_to_cones[3][3] = {/* Hunt-Pointer-Estevez after the inverse of CAT02 */
                                                {0.7409792, 0.2180250, 0.0410058},
                                                {0.2853532, 0.6242014, 0.0904454},
                                                {-0.0096280, -0.0056980, 1.0153260}};
    double xyz[3], lms[3];
    multiply(xyz, to_xyz, rgb);
    multiply(lms, cat02, xyz);
    for (int i = 0; i < 3; i++)
        lms[i] *= a->adapt[i];
    multiply(out, cat02_to_cones, lms);
    for (int i = 0; i < 3; i++) {
        const double t = pow(a->fl * fabs(out[i]) / 100, 0.42);
        out[i] = copysign(400 * t / (t + 27.13), out[i]) + 0.1;
    }
}

static double achromatic(const appearance *a, const double r[3])
{
    return (2 * r[0] + r[1] + r[2] / 20 - 0.305) * a->nbb;
}

static appearance srgb_display(void)
{
    appearance a = {.nbb = 0.725 * pow(5, 0.2), .z = 1.48 + sqrt(0.2), .adapt = {1, 1, 1}};
    const double la = 64 / M_PI / 5, k = 1 / (5 * la + 1), d = 1 - exp((-la - 42) / 92) / 3.6;
    const double white_lms[3] = {94.92756, 103.53724, 108.72015}; /* CAT02 of D65 */
    double r[3];
    a.fl = 0.2 * pow(k, 4) * 5 * la + 0.1 * pow(1 - pow(k, 4), 2) * cbrt(5 * la);
    for (int i = 0; i < 3; i++)
        a.adapt[i] = 100 * d / white_lms[i] + 1 - d;
    cone_responses(r, &a, (double[]){1, 1, 1});
    a.white = achromatic(&a, r);
    return a;
}

/* CAM02-UCS: Luo, Cui, Li 2006. */
static void cam02_ucs(double out[3], const appearance *a, const double rgb[3])
{
    double r[3];
    cone_responses(r, a, rgb);
    const double red = r[0] - 12 * r[1] / 11 + r[2] / 11, yellow = (r[0] + r[1] - 2 * r[2]) / 9;
    const double h = atan2(yellow, red);
    const double j = 100 * pow(fmax(achromatic(a, r), 0) / a->white, 0.69 * a->z);
    const double t =
        50000 / 13. * a->nbb * (cos(h + 2) + 3.8) / 4 * hypot(red, yellow) / (r[0] + r[1] + 21 * r[2] / 20);
    const double m = pow(t, 0.9) * sqrt(j / 100) * pow(1.64 - pow(0.29, 0.2), 0.73) * pow(a->fl, 0.25);
    const double chroma = log1p(0.0228 * m) / 0.0228;
    out[0] = 1.7 * j / (1 + 0.007 * j);
    out[1] = chroma * cos(h);
    out[2] = chroma * sin(h);
}

/* Ratio of the longest to the shortest of 64 equal parts, less the two next to the dark end: at black CIECAM02 has no
 * slope to be even in. */
static double unevenness(const char *name)
{
    const appearance display = srgb_display();
    double last[3] = {0}, least = INFINITY, most = 0;
    for (int i = 0; i <= STEPS; i++) {
        vv_color c;
        double p[3];
        assert_true(vv_colormap_sample(&c, name, (double)i / STEPS));
        cam02_ucs(p, &display, (double[]){c.r, c.g, c.b});
        const double part = hypot(hypot(p[0] - last[0], p[1] - last[1]), p[2] - last[2]);
        if (i > 2) {
            least = fmin(least, part);
            most = fmax(most, part);
        }
        memcpy(last, p, sizeof p);
    }
    return most / least;
}

static void perceptual_speed_is_nearly_constant(void **state)
{
    for (size_t m = 0; vvi_colormap_row(m); m++) {
        const char *name = vvi_colormap_row(m)->name;
        const double even = unevenness(name);
        print_message("%-9s longest / shortest part: %.3f\n", name, even);
        assert_true(even < 1.25 || strcmp(name, "turbo") == 0); /* which is as it was published */
    }
}

static void the_diverging_map_is_lightest_and_gray_in_the_middle(void **state)
{
    double lab[STEPS + 1][3];
    lab_along(lab, "coolwarm");
    for (int i = 0; i < STEPS; i++)
        assert_int_equal(lab[i + 1][0] > lab[i][0], i < STEPS / 2);
    assert_true(hypot(lab[STEPS / 2][1], lab[STEPS / 2][2]) < 6);
}

/* Deuteranopia after Vienot, Brettel, Mollon 1999 and after Machado, Oliveira, Fernandes 2009 (severity 1). */
static void cividis_looks_nearly_the_same_without_green_cones(void **state)
{
    static const double machado[3][3] = {
        {0.367322, 0.860646, -0.227968}, {0.280085, 0.672501, 0.047413}, {-0.011820, 0.042940, 0.968881}};
    static const double vienot[3][3] = {{0.29275, 0.70725, 0}, {0.29275, 0.70725, 0}, {-0.02234, 0.02234, 1}};
    double worst[2] = {0}, viridis = 0;
    for (int i = 0; i <= STEPS; i++) {
        const char *const names[] = {"cividis", "cividis", "viridis"};
        for (int m = 0; m < 3; m++) {
            const double(*sim)[3] = m == 0 ? vienot : machado;
            double seen[3], lab_a[3], lab_b[3];
            vv_color c;
            assert_true(vv_colormap_sample(&c, names[m], (double)i / STEPS));
            for (int k = 0; k < 3; k++)
                seen[k] = fmin(fmax(sim[k][0] * c.r + sim[k][1] * c.g + sim[k][2] * c.b, 0), 1);
            cielab(lab_a, (double[]){c.r, c.g, c.b});
            cielab(lab_b, seen);
            double *keep = m < 2 ? &worst[m] : &viridis;
            *keep = fmax(*keep, ciede2000(lab_a, lab_b));
        }
    }
    print_message("largest change: %.2f (Vienot), %.2f (Machado); viridis %.2f\n", worst[0], worst[1], viridis);
    assert_true(worst[0] < 2);
    assert_true(worst[1] < 8);
    assert_true(viridis > 2 * worst[1]);
}

static void ends_are_clamped_and_unknown_maps_refused(void **state)
{
    vv_color a, b;
    assert_true(vv_colormap_sample(&a, "viridis", -3) && vv_colormap_sample(&b, "viridis", 0));
    assert_memory_equal(&a, &b, sizeof a);
    assert_true(vv_colormap_sample(&a, "viridis", 4) && vv_colormap_sample(&b, "viridis", 1));
    assert_memory_equal(&a, &b, sizeof a);
    assert_true(vv_colormap_sample(&a, "viridis", NAN));
    assert_true(a.r >= 0 && a.r <= 1);
    assert_false(vv_colormap_sample(&a, "rainbow", 0));
    assert_false(vv_colormap_sample(&a, "", 0));
}

static void known_colors_are_met(void **state)
{
    vv_color c;
    assert_true(vv_colormap_sample(&c, "gray", 1));
    assert_near(c.r, 1, 1e-3);
    assert_true(vv_colormap_sample(&c, "viridis", 0)); /* #440154 */
    assert_near(c.r, 0.0578, 2e-3);
    assert_near(c.g, 0.0003, 2e-3);
    assert_near(c.b, 0.0887, 2e-3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_difference_formula_gives_published_values),
        cmocka_unit_test(lightness_of_sequential_maps_rises_throughout),
        cmocka_unit_test(perceptual_speed_is_nearly_constant),
        cmocka_unit_test(the_diverging_map_is_lightest_and_gray_in_the_middle),
        cmocka_unit_test(cividis_looks_nearly_the_same_without_green_cones),
        cmocka_unit_test(ends_are_clamped_and_unknown_maps_refused),
        cmocka_unit_test(known_colors_are_met),
        cmocka_unit_test(turbo_is_its_published_formula),
        cmocka_unit_test(other_spellings_are_the_same_map),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
