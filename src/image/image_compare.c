/* How two images differ. */
#include "core/memory.h"
#include "image/image_planes.h"

#include <math.h>
#include <stdlib.h>

static void compare_codes(vv_image_difference *out, const uint8_t *a, const uint8_t *b, size_t n)
{
    uint64_t squares = 0, n_different = 0;
    int most = 0;
    for (size_t i = 0; i < n; i++) {
        int here = 0;
        for (size_t c = 3 * i; c < 3 * i + 3; c++) {
            const int d = abs(a[c] - b[c]);
            squares += (uint64_t)(d * d);
            here = d > here ? d : here;
        }
        n_different += here > 0;
        most = here > most ? here : most;
    }
    const double mean = (double)squares / (3 * (double)n);
    out->psnr = squares == 0 ? INFINITY : 10 * log10(255.0 * 255.0 / mean);
    out->max_difference = most / 255.0;
    out->n_different = n_different;
}

vv_status vv_image_compare(vv_image_difference *out, const vv_image *a, const vv_image *b, vv_job *job)
{
    *out = (vv_image_difference){0};
    if (a->width != b->width || a->height != b->height)
        return vv_fail(VV_E_ARGUMENT, "the images are %d x %d and %d x %d pixels; only equal sizes can be compared",
                       a->width, a->height, b->width, b->height);
    uint8_t *ca = NULL, *cb = NULL;
    vv_status st;
    if ((st = vvi_image_codes(&ca, a, job)) == VV_OK && (st = vvi_image_codes(&cb, b, job)) == VV_OK) {
        compare_codes(out, ca, cb, (size_t)a->width * (size_t)a->height);
        if ((st = vvi_image_ssim(&out->ssim, ca, cb, a->width, a->height, job)) == VV_OK)
            st = vvi_image_flip(&out->flip_mean, ca, cb, a->width, a->height, job);
    }
    vvi_free(ca);
    vvi_free(cb);
    return st;
}
