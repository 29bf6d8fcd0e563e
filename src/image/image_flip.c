/* FLIP: Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom & Fairchild 2020, "FLIP: A Difference Evaluator for
 * Alternating Images", the version for display-ready images; the metric follows its sections in order. */
#include "core/job.h"
#include "core/memory.h"
#include "image/image_planes.h"

#include <math.h>

#define PPD 67.0 /* pixels a degree of a common desktop */
#define PI 3.14159265358979323846
/* Exponents and bends of the perceptual metric. */
#define QC 0.7
#define PC 0.4
#define PT 0.95
#define QF 0.5

typedef struct triple {
    double v[3];
} triple;

/* Colour spaces ------------------------------------------------------------------------------------------------- */

static const double rgb_to_xyz[3][3] = {
    {0.41238656325299225, 0.35759149092062531, 0.18045049120356364},
    {0.21263682167732384, 0.71518298184125073, 0.07218019648142547},
    {0.01933062015248398, 0.11919716364020844, 0.95037258700543538},
};
static const double xyz_to_rgb[3][3] = {
    {3.2410032329763583, -1.5373989694887849, -0.49861588199636281},
    {-0.96922425220251629, 1.8759299836951757, 0.041554226340084706},
    {0.055639419851975458, -0.2040112061239099, 1.0571489771875332},
};

static triple multiply(const double m[3][3], triple a)
{
    triple out;
    for (int r = 0; r < 3; r++)
        out.v[r] = m[r][0] * a.v[0] + m[r][1] * a.v[1] + m[r][2] * a.v[2];
    return out;
}

/* The white of the display: RGB (1, 1, 1). */
static triple white(void)
{
    return multiply(rgb_to_xyz, (triple){{1, 1, 1}});
}

/* The opponent space in which the eye's sensitivity to contrast is applied. */
static triple xyz_to_ycxcz(triple xyz)
{
    const triple w = white();
    const double x = xyz.v[0] / w.v[0], y = xyz.v[1] / w.v[1], z = xyz.v[2] / w.v[2];
    return (triple){{116 * y - 16, 500 * (x - y), 200 * (y - z)}};
}

static triple ycxcz_to_xyz(triple c)
{
    const triple w = white();
    const double y = (c.v[0] + 16) / 116;
    return (triple){{(y + c.v[1] / 500) * w.v[0], y * w.v[1], (y - c.v[2] / 200) * w.v[2]}};
}

static double lab_curve(double t)
{
    const double d = 6.0 / 29;
    return t > d * d * d ? cbrt(t) : t / (3 * d * d) + 4.0 / 29;
}

/* CIELAB with the Hunt effect: colours of dark things differ less. */
static triple rgb_to_hunt_lab(triple rgb)
{
    const triple w = white(), xyz = multiply(rgb_to_xyz, rgb);
    const double x = lab_curve(xyz.v[0] / w.v[0]), y = lab_curve(xyz.v[1] / w.v[1]), z = lab_curve(xyz.v[2] / w.v[2]);
    const double l = 116 * y - 16;
    return (triple){{l, 500 * (x - y) * 0.01 * l, 200 * (y - z) * 0.01 * l}};
}

static double hyab(triple a, triple b)
{
    return fabs(a.v[0] - b.v[0]) + hypot(a.v[1] - b.v[1], a.v[2] - b.v[2]);
}

/* Colour error of one pixel, in [0, 1]: the largest possible is that between pure green and pure blue. */
static double color_error(triple a, triple b)
{
    const triple green = rgb_to_hunt_lab((triple){{0, 1, 0}}), blue = rgb_to_hunt_lab((triple){{0, 0, 1}});
    const double most = pow(hyab(green, blue), QC), bend = PC * most;
    const double error = pow(hyab(a, b), QC);
    return error < bend ? error * PT / bend : PT + (error - bend) / (most - bend) * (1 - PT);
}

/* Filters ------------------------------------------------------------------------------------------------------- */

/* Contrast sensitivity as a sum of Gaussians a sqrt(pi / b) exp(-pi^2 d^2 / b), d in degrees: black-white, red-green,
 * blue-yellow. */
typedef struct sensitivity {
    double a[2], b[2];
} sensitivity;

static const sensitivity sensitivities[3] = {
    {{1, 0}, {0.0047, 1e-5}},
    {{1, 0}, {0.0053, 1e-5}},
    {{34.1, 13.5}, {0.04, 0.025}},
};

static void gaussian_of(vvi_kernel *out, double b)
{
    *out = (vvi_kernel){.radius = (int)ceil(3 * sqrt(0.04 / (2 * PI * PI)) * PPD)}; /* of the widest, for all */
    for (int r = -out->radius; r <= out->radius; r++)
        out->w[out->radius + r] = exp(-PI * PI * (r / PPD) * (r / PPD) / b);
}

static double kernel_sum(const vvi_kernel *k)
{
    double sum = 0;
    for (int r = 0; r <= 2 * k->radius; r++)
        sum += k->w[r];
    return sum;
}

/* Each Gaussian is separable; their sum is not, so they are applied one by one and added. */
static vv_status apply_sensitivity(vvi_plane *plane, const sensitivity *s, vv_job *job)
{
    vvi_kernel kernel[2];
    double weight[2], total = 0;
    for (int g = 0; g < 2; g++) {
        gaussian_of(&kernel[g], s->b[g]);
        const double sum = kernel_sum(&kernel[g]);
        weight[g] = s->a[g] * sqrt(PI / s->b[g]);
        total += weight[g] * sum * sum;
    }
    const size_t n = (size_t)plane->width * (size_t)plane->height;
    vvi_plane second = {0};
    vv_status st = VV_OK;
    if (weight[1] != 0 && (st = vvi_plane_new(&second, plane->width, plane->height, job)) == VV_OK)
        st = vvi_plane_filter(&second, plane, &kernel[1], &kernel[1], job);
    if (st == VV_OK)
        st = vvi_plane_filter(plane, plane, &kernel[0], &kernel[0], job);
    for (size_t i = 0; st == VV_OK && i < n; i++)
        plane->v[i] = (weight[0] * plane->v[i] + (second.v ? weight[1] * second.v[i] : 0)) / total;
    vvi_plane_free(&second);
    return st;
}

/* Edges: first derivative of a Gaussian; points: second. Positive weights sum to 1, negative to -1. */
static void feature_kernels(vvi_kernel *smooth, vvi_kernel *edge, vvi_kernel *point)
{
    const double sigma = 0.5 * 0.082 * PPD;
    const int radius = (int)ceil(3 * sigma);
    *smooth = *edge = *point = (vvi_kernel){.radius = radius};
    for (int r = -radius; r <= radius; r++) {
        const double g = exp(-r * r / (2 * sigma * sigma));
        smooth->w[radius + r] = g;
        edge->w[radius + r] = -r * g;
        point->w[radius + r] = (r * r / (sigma * sigma) - 1) * g;
    }
    const double sum = kernel_sum(smooth);
    for (int r = 0; r <= 2 * radius; r++)
        smooth->w[r] /= sum;
    for (int f = 0; f < 2; f++) {
        vvi_kernel *k = f ? point : edge;
        double plus = 0, minus = 0;
        for (int r = 0; r <= 2 * radius; r++)
            *(k->w[r] > 0 ? &plus : &minus) += fabs(k->w[r]);
        for (int r = 0; r <= 2 * radius; r++)
            k->w[r] /= k->w[r] > 0 ? plus : minus;
    }
}

/* Strength of a feature at each pixel: the length of its responses along x and y. */
static vv_status feature(vvi_plane *out, const vvi_plane *y, const vvi_kernel *smooth, const vvi_kernel *derivative,
                         vv_job *job)
{
    vvi_plane other = {0};
    vv_status st;
    if ((st = vvi_plane_new(&other, y->width, y->height, job)) == VV_OK &&
        (st = vvi_plane_filter(out, y, derivative, smooth, job)) == VV_OK)
        st = vvi_plane_filter(&other, y, smooth, derivative, job);
    const size_t n = (size_t)y->width * (size_t)y->height;
    for (size_t i = 0; st == VV_OK && i < n; i++)
        out->v[i] = hypot(out->v[i], other.v[i]);
    vvi_plane_free(&other);
    return st;
}

/* One image --------------------------------------------------------------------------------------------------- */

enum { PLANE_L, PLANE_A, PLANE_B, PLANE_EDGE, PLANE_POINT, N_PLANES };

typedef struct seen {
    vvi_plane plane[N_PLANES];
} seen;

static void to_opponent(seen *s, const uint8_t *codes, size_t n)
{
    double linear[256];
    for (int c = 0; c < 256; c++)
        linear[c] = vv_srgb_decode(c / 255.0);
    for (size_t i = 0; i < n; i++) {
        const triple rgb = {{linear[codes[3 * i]], linear[codes[3 * i + 1]], linear[codes[3 * i + 2]]}};
        const triple c = xyz_to_ycxcz(multiply(rgb_to_xyz, rgb));
        for (int p = 0; p < 3; p++)
            s->plane[p].v[i] = c.v[p];
    }
}

static vv_status find_features(seen *s, size_t n, vv_job *job)
{
    vvi_kernel smooth, edge, point;
    vvi_plane y = {0};
    vv_status st = vvi_plane_new(&y, s->plane[0].width, s->plane[0].height, job);
    if (st != VV_OK)
        return st;
    feature_kernels(&smooth, &edge, &point);
    for (size_t i = 0; i < n; i++)
        y.v[i] = (s->plane[0].v[i] + 16) / 116; /* luminance in [0, 1] */
    if ((st = feature(&s->plane[PLANE_EDGE], &y, &smooth, &edge, job)) == VV_OK)
        st = feature(&s->plane[PLANE_POINT], &y, &smooth, &point, job);
    vvi_plane_free(&y);
    return st;
}

static double clamp01(double v)
{
    return v < 0 ? 0 : v > 1 ? 1 : v;
}

static void to_lab(seen *s, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const triple c = {{s->plane[0].v[i], s->plane[1].v[i], s->plane[2].v[i]}};
        triple rgb = multiply(xyz_to_rgb, ycxcz_to_xyz(c));
        for (int k = 0; k < 3; k++)
            rgb.v[k] = clamp01(rgb.v[k]);
        const triple lab = rgb_to_hunt_lab(rgb);
        for (int p = 0; p < 3; p++)
            s->plane[p].v[i] = lab.v[p];
    }
}

static vv_status look(seen *s, const uint8_t *codes, int32_t width, int32_t height, vv_job *job)
{
    const size_t n = (size_t)width * (size_t)height;
    vv_status st = VV_OK;
    for (int p = 0; p < N_PLANES && st == VV_OK; p++)
        st = vvi_plane_new(&s->plane[p], width, height, job);
    if (st != VV_OK)
        return st;
    to_opponent(s, codes, n);
    st = find_features(s, n, job);
    for (int p = 0; p < 3 && st == VV_OK; p++)
        st = apply_sensitivity(&s->plane[p], &sensitivities[p], job);
    if (st == VV_OK)
        to_lab(s, n);
    return st;
}

static triple lab_at(const seen *s, size_t i)
{
    return (triple){{s->plane[PLANE_L].v[i], s->plane[PLANE_A].v[i], s->plane[PLANE_B].v[i]}};
}

static double pixel_error(const seen *a, const seen *b, size_t i)
{
    const double color = color_error(lab_at(a, i), lab_at(b, i));
    const double edge = fabs(a->plane[PLANE_EDGE].v[i] - b->plane[PLANE_EDGE].v[i]);
    const double point = fabs(a->plane[PLANE_POINT].v[i] - b->plane[PLANE_POINT].v[i]);
    const double features = pow(fmax(edge, point) / sqrt(2), QF);
    return pow(color, 1 - features);
}

vv_status vvi_image_flip(double *out, const uint8_t *a, const uint8_t *b, int32_t width, int32_t height, vv_job *job)
{
    seen sa = {0}, sb = {0};
    const size_t n = (size_t)width * (size_t)height;
    vv_status st;
    if ((st = look(&sa, a, width, height, job)) == VV_OK && (st = look(&sb, b, width, height, job)) == VV_OK) {
        double sum = 0;
        for (size_t i = 0; i < n; i++)
            sum += pixel_error(&sa, &sb, i);
        *out = sum / (double)n;
    }
    for (int p = 0; p < N_PLANES; p++) {
        vvi_plane_free(&sa.plane[p]);
        vvi_plane_free(&sb.plane[p]);
    }
    return st;
}
