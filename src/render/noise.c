/* Which pixels are not known well enough yet.
 *
 * The error of a pixel is estimated by half of what lies between the mean of its odd and that of its even passes: two
 * pictures of the same scene that share no ray. (A standard error from the spread of single passes would be far too
 * large: they lie evenly, so their mean is much better than that of as many random ones.) After one pass there are no
 * two pictures yet; what differs from its neighbours by more than the bound may have an edge in it.
 *
 * Light is judged as a display shows it, near to its square root; below a thousandth the curve is straight.
 */
#include "render/picture.h"
#include <math.h>

static float shown(float light)
{
    return sqrtf(fmaxf(light, 0) + 0.0015f); /* as steep at black as sRGB */
}

/* Over the background: where it is bright, less of a change is seen. */
static void shown_pixel(float out[4], const vv_picture *picture, const float light[4])
{
    for (int c = 0; c < 4; c++)
        out[c] = shown(light[c] + (1 - light[3]) * picture->scene->background[c]);
}

static float contrast(const vv_picture *picture, int32_t x, int32_t y)
{
    const vv_image *image = picture->got.image;
    const int32_t width = image->width, height = image->height;
    float here[4], there[4], most = 0;
    shown_pixel(here, picture, image->rgba + 4 * ((size_t)y * (size_t)width + (size_t)x));
    for (int32_t j = y > 0 ? y - 1 : 0; j <= y + 1 && j < height; j++) {
        for (int32_t i = x > 0 ? x - 1 : 0; i <= x + 1 && i < width; i++) {
            shown_pixel(there, picture, image->rgba + 4 * ((size_t)j * (size_t)width + (size_t)i));
            for (int c = 0; c < 4; c++)
                most = fmaxf(most, fabsf(there[c] - here[c]));
        }
    }
    return most;
}

static float noise(const vv_picture *picture, int32_t x, int32_t y)
{
    const vvi_gathered *got = &picture->got;
    const size_t at = 4 * ((size_t)y * (size_t)got->image->width + (size_t)x);
    const int64_t odd = got->passes / 2;
    const float n = (float)got->passes, n_odd = (float)odd;
    float even[4], a[4], b[4], most = 0;
    for (size_t c = 0; c < 4; c++)
        even[c] = (n * got->image->rgba[at + c] - n_odd * got->half[at + c]) / (n - n_odd);
    shown_pixel(a, picture, got->half + at);
    shown_pixel(b, picture, even);
    for (int c = 0; c < 4; c++)
        most = fmaxf(most, fabsf(a[c] - b[c]) / 2);
    return most;
}

/* Whether a pixel of a block is not known as well as `bound`. */
static bool is_noisy(const vv_picture *picture, const vv_tile *tile, int32_t i, int32_t j, float bound)
{
    for (int32_t k = 0; k < VVI_BLOCK * VVI_BLOCK; k++) {
        const int32_t x = i + k % VVI_BLOCK, y = j + k / VVI_BLOCK;
        if (x < tile->x1 && y < tile->y1 &&
            (picture->got.passes == 1 ? contrast(picture, x, y) : noise(picture, x, y)) > bound)
            return true;
    }
    return false;
}

/* Bits of the blocks of a tile that stay active. */
static vv_status check_tile(vv_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                            vv_render_counts *counts)
{
    const vvi_gathered *got = &picture->got;
    for (int32_t j = tile->y0; j < tile->y1; j += VVI_BLOCK) {
        for (int32_t i = tile->x0; i < tile->x1; i += VVI_BLOCK) {
            uint8_t *active = &got->active[(size_t)(j / VVI_BLOCK) * (size_t)got->n_across + (size_t)(i / VVI_BLOCK)];
            *active = *active && is_noisy(picture, tile, i, j, (float)picture->scene->noise);
        }
    }
    return VV_OK;
}

static vv_status look_for_noise(vv_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                                vv_render_counts *counts)
{
    const double *bound = user;
    for (int32_t j = tile->y0; j < tile->y1; j += VVI_BLOCK)
        for (int32_t i = tile->x0; i < tile->x1; i += VVI_BLOCK)
            counts->covered += is_noisy(picture, tile, i, j, (float)*bound);
    return VV_OK;
}

static vv_status each_tile(vv_picture *picture, const vvi_tiles *tiles)
{
    vvi_tiles all = *tiles;
    all.width = picture->got.image->width;
    all.height = picture->got.image->height;
    all.quiet = true;
    return vvi_picture_loop(picture, &all);
}

vv_status vvi_noise_check(vv_picture *picture)
{
    return each_tile(picture, &(vvi_tiles){.tile = check_tile});
}

vv_status vvi_noise_is_below(bool *out, vv_picture *picture, double bound)
{
    const vv_render_counts before = picture->got.counts;
    *out = false;
    if (picture->got.passes < 3 || !picture->got.half)
        return VV_OK;
    const vv_status st = each_tile(picture, &(vvi_tiles){.tile = look_for_noise, .user = &bound});
    *out = picture->got.counts.covered == before.covered;
    picture->got.counts = before;
    return st;
}
