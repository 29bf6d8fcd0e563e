/* Which pixels are not known well enough yet.
 *
 * The error of a pixel is estimated by half of what lies between the mean of its odd and that of its even passes: two
 * pictures of the same scene that share no ray. (A standard error from the spread of single passes would be far too
 * large: they lie evenly, so their mean is much better than that of as many random ones.) After one pass there are no
 * two pictures yet; what differs from its neighbours by more than the bound may have an edge in it.
 *
 * Light is judged as a display shows it, near to its square root; below a thousandth the curve is straight.
 */
#include "render/pixel_rays.h"
#include <math.h>

static float shown(float light)
{
    return sqrtf(fmaxf(light, 0) + 0.0015f); /* as steep at black as sRGB */
}

/* Over the background: where it is bright, less of a change is seen. */
static void shown_pixel(float out[4], const vvi_picture *picture, const float light[4])
{
    for (int c = 0; c < 4; c++)
        out[c] = shown(light[c] + (1 - light[3]) * picture->scene->background[c]);
}

static float contrast(const vvi_picture *picture, const vvi_samples *s, int32_t x, int32_t y)
{
    const int32_t width = s->image->width, height = s->image->height;
    float here[4], there[4], most = 0;
    shown_pixel(here, picture, s->mean + 4 * ((size_t)y * (size_t)width + (size_t)x));
    for (int32_t j = y > 0 ? y - 1 : 0; j <= y + 1 && j < height; j++) {
        for (int32_t i = x > 0 ? x - 1 : 0; i <= x + 1 && i < width; i++) {
            shown_pixel(there, picture, s->mean + 4 * ((size_t)j * (size_t)width + (size_t)i));
            for (int c = 0; c < 4; c++)
                most = fmaxf(most, fabsf(there[c] - here[c]));
        }
    }
    return most;
}

static float noise(const vvi_picture *picture, const vvi_samples *s, int32_t x, int32_t y)
{
    const size_t at = 4 * ((size_t)y * (size_t)s->image->width + (size_t)x);
    const int64_t odd = picture->passes / 2;
    const float n = (float)picture->passes, n_odd = (float)odd;
    float even[4], a[4], b[4], most = 0;
    for (size_t c = 0; c < 4; c++)
        even[c] = (n * s->mean[at + c] - n_odd * s->half[at + c]) / (n - n_odd);
    shown_pixel(a, picture, s->half + at);
    shown_pixel(b, picture, even);
    for (int c = 0; c < 4; c++)
        most = fmaxf(most, fabsf(a[c] - b[c]) / 2);
    return most;
}

/* Bits of the blocks of a tile that stay active. */
static vv_status check_tile(vvi_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                            vv_render_counts *counts)
{
    const vvi_samples *s = user;
    const float bound = (float)picture->scene->noise;
    for (int32_t j = tile->y0; j < tile->y1; j += VVI_BLOCK) {
        for (int32_t i = tile->x0; i < tile->x1; i += VVI_BLOCK) {
            uint8_t *active = &s->active[(size_t)(j / VVI_BLOCK) * (size_t)s->n_across + (size_t)(i / VVI_BLOCK)];
            bool wanted = false;
            for (int32_t k = 0; *active && !wanted && k < VVI_BLOCK * VVI_BLOCK; k++) {
                const int32_t x = i + k % VVI_BLOCK, y = j + k / VVI_BLOCK;
                if (x < tile->x1 && y < tile->y1)
                    wanted = (picture->passes == 1 ? contrast(picture, s, x, y) : noise(picture, s, x, y)) > bound;
            }
            *active = wanted;
        }
    }
    return VV_OK;
}

vv_status vvi_noise_check(vvi_picture *picture, vvi_samples *samples)
{
    const vvi_tiles tiles = {.width = samples->image->width,
                             .height = samples->image->height,
                             .tile = check_tile,
                             .user = samples,
                             .quiet = true};
    const vv_status st = vvi_picture_loop(picture, &tiles);
    const size_t n = (size_t)samples->n_across * (size_t)samples->n_down;
    samples->n_active = 0;
    for (size_t i = 0; i < n; i++)
        samples->n_active += samples->active[i];
    return st;
}
