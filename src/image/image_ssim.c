/* Structural similarity: Wang, Bovik, Sheikh & Simoncelli 2004, with their 11 x 11 Gaussian window of deviation 1.5,
 * K1 = 0.01, K2 = 0.03, over every window that lies inside the image. Luma after ITU-R BT.601. */
#include "core/job.h"
#include "core/memory.h"
#include "image/image_planes.h"

#include <math.h>

#define RADIUS 5

enum { MEAN_A, MEAN_B, SQUARE_A, SQUARE_B, PRODUCT, N_PLANES };

static double luma(const uint8_t *code)
{
    return 0.299 * code[0] + 0.587 * code[1] + 0.114 * code[2];
}

static void window(vvi_kernel *out)
{
    double sum = 0;
    out->radius = RADIUS;
    for (int r = -RADIUS; r <= RADIUS; r++)
        sum += out->w[RADIUS + r] = exp(-r * r / (2 * 1.5 * 1.5));
    for (int r = 0; r <= 2 * RADIUS; r++)
        out->w[r] /= sum;
}

static void fill(vvi_plane planes[N_PLANES], const uint8_t *a, const uint8_t *b)
{
    const size_t n = (size_t)planes[0].width * (size_t)planes[0].height;
    for (size_t i = 0; i < n; i++) {
        const double la = luma(a + 3 * i), lb = luma(b + 3 * i);
        planes[MEAN_A].v[i] = la;
        planes[MEAN_B].v[i] = lb;
        planes[SQUARE_A].v[i] = la * la;
        planes[SQUARE_B].v[i] = lb * lb;
        planes[PRODUCT].v[i] = la * lb;
    }
}

static double similarity(const vvi_plane planes[N_PLANES], size_t i)
{
    const double c1 = 0.01 * 255 * 0.01 * 255, c2 = 0.03 * 255 * 0.03 * 255;
    const double ma = planes[MEAN_A].v[i], mb = planes[MEAN_B].v[i];
    const double va = planes[SQUARE_A].v[i] - ma * ma, vb = planes[SQUARE_B].v[i] - mb * mb;
    const double cov = planes[PRODUCT].v[i] - ma * mb;
    return (2 * ma * mb + c1) * (2 * cov + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
}

/* An image smaller than the window has the window around its middle, repeated at the border. */
static void inside(int32_t *lo, int32_t *end, int32_t n)
{
    *lo = n > 2 * RADIUS ? RADIUS : n / 2;
    *end = n > 2 * RADIUS ? n - RADIUS : n / 2 + 1;
}

static double mean_similarity(const vvi_plane planes[N_PLANES])
{
    int32_t x0, x1, y0, y1;
    double sum = 0;
    inside(&x0, &x1, planes[0].width);
    inside(&y0, &y1, planes[0].height);
    for (int32_t y = y0; y < y1; y++)
        for (int32_t x = x0; x < x1; x++)
            sum += similarity(planes, (size_t)y * (size_t)planes[0].width + (size_t)x);
    return sum / ((double)(x1 - x0) * (y1 - y0));
}

vv_status vvi_image_ssim(double *out, const uint8_t *a, const uint8_t *b, int32_t width, int32_t height, vv_job *job)
{
    vvi_plane planes[N_PLANES] = {0};
    vvi_kernel kernel;
    vv_status st = VV_OK;
    window(&kernel);
    for (int p = 0; p < N_PLANES && st == VV_OK; p++)
        st = vvi_plane_new(&planes[p], width, height, job);
    if (st == VV_OK)
        fill(planes, a, b);
    for (int p = 0; p < N_PLANES && st == VV_OK; p++)
        st = vvi_plane_filter(&planes[p], &planes[p], &kernel, &kernel, job);
    if (st == VV_OK)
        *out = mean_similarity(planes);
    for (int p = 0; p < N_PLANES; p++)
        vvi_plane_free(&planes[p]);
    return st;
}
