/* Many rays per pixel. Every pass casts one ray for each pixel, all through the same place of their pixels, so that a
 * pass is a picture shifted by less than a pixel; read at the centres of the pixels, linear between its rays, it is one
 * sample of what a tent filter of two pixels' width makes of the scene, and a picture is the mean of its passes. So
 * each ray serves the four pixels around it, which is worth two and a quarter times the rays [exact: 1 / (2/3)^2]. Not
 * those of the first pass, whose pixels are one ray each: where there are but two passes the first counts as much less.
 *
 * Pass k is shifted by m (1/g, 1/g^2) modulo 1 with g the plastic number, 1.3247..., and m = 0, 1, -1, 2, -2, ... (the
 * R2 sequence of M. Roberts 2018, walked both ways): the first pass goes through the centres, however many there are
 * they lie evenly, and after an odd number they lie as far to the left as to the right.
 */
#include "render/picture.h"
#include <math.h>

void vvi_sample_shift(double *x_out, double *y_out, int64_t pass)
{
    const double m = (double)(pass % 2 ? (pass + 1) / 2 : -(pass / 2));
    const double x = m * 0.75487766624669276, y = m * 0.56984029099805327;
    *x_out = x - floor(x);
    *y_out = y - floor(y);
}

static bool is_active(const vvi_gathered *got, int32_t i, int32_t j)
{
    return i >= 0 && j >= 0 && i < got->n_across && j < got->n_down &&
           got->active[(size_t)j * (size_t)got->n_across + (size_t)i];
}

int64_t vvi_blocks_active(const vvi_gathered *got)
{
    const size_t n = (size_t)got->n_across * (size_t)got->n_down;
    int64_t active = 0;
    for (size_t i = 0; i < n; i++)
        active += got->active[i];
    return active;
}

/* One pass on its way. */
typedef struct passing {
    const vvi_gathered *got;
    double x, y;     /* how far it is shifted: a pixel's centre lies at (x, y) between the rays of four shifted ones */
    bool everywhere; /* all blocks are active */
    bool again;      /* the rays have been counted */
    float all, half; /* 1 / number of samples with this one, in the mean of all and in that of odd passes; 0: it is none
                        of them */
} passing;

static passing begin(const vv_picture *picture)
{
    const vvi_gathered *got = &picture->got;
    passing s = {.got = got, .all = 1 / (float)(got->passes + 1)};
    vvi_sample_shift(&s.x, &s.y, got->passes);
    s.half = got->half && got->passes % 2 ? 2 / (float)(got->passes + 1) : 0;
    s.everywhere = vvi_blocks_active(got) == got->n_across * (int64_t)got->n_down;
    return s;
}

/* Rays of a pass ------------------------------------------------------------------------------------------------- */

/* The shifted picture has one column and one row more than the image: pixel (x, y) of the image lies between its pixels
 * (x, y) and (x + 1, y + 1). */
static vv_status render_part(vv_picture *picture, const passing *s, int32_t x0, int32_t y0, int32_t x1, int32_t y1,
                             vv_render_counts *counts)
{
    const vv_pass pass = vvi_picture_pass(picture, 0.5 - s->x, 0.5 - s->y, 1, (uint64_t)s->got->passes);
    const vv_tile part = {x0, y0, x1 < s->got->shifted->width ? x1 : s->got->shifted->width,
                          y1 < s->got->shifted->height ? y1 : s->got->shifted->height};
    return vvi_picture_render(picture, &pass, &part, s->got->shifted, counts);
}

/* A block that is not active is looked at from its active neighbours above and to the left of it. */
static vv_status render_edge(vv_picture *picture, const passing *s, int32_t i, int32_t j, vv_render_counts *counts)
{
    const bool left = is_active(s->got, i - 1, j), above = is_active(s->got, i, j - 1);
    const int32_t x = i * VVI_BLOCK, y = j * VVI_BLOCK;
    vv_status st = VV_OK;
    if (above)
        st = render_part(picture, s, x, y, x + VVI_BLOCK, y + 1, counts);
    else if (is_active(s->got, i - 1, j - 1) && !left)
        st = render_part(picture, s, x, y, x + 1, y + 1, counts);
    if (st == VV_OK && left)
        st = render_part(picture, s, x, y + above, x + 1, y + VVI_BLOCK, counts);
    return st;
}

static vv_status render_blocks(vv_picture *picture, const passing *s, const vv_tile *tile, vv_render_counts *counts)
{
    for (int32_t j = tile->y0 / VVI_BLOCK; j * VVI_BLOCK < tile->y1; j++) {
        for (int32_t i = tile->x0 / VVI_BLOCK; i * VVI_BLOCK < tile->x1; i++) {
            int32_t end = i;
            while (end * VVI_BLOCK < tile->x1 && is_active(s->got, end, j))
                end++;
            const vv_status st = end > i ? render_part(picture, s, i * VVI_BLOCK, j * VVI_BLOCK, end * VVI_BLOCK,
                                                       (j + 1) * VVI_BLOCK, counts)
                                         : render_edge(picture, s, i, j, counts);
            if (st != VV_OK)
                return st;
            i = end > i ? end - 1 : i;
        }
    }
    return VV_OK;
}

static vv_status render_tile(vv_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                             vv_render_counts *counts)
{
    const passing *s = user;
    if (s->everywhere)
        return render_part(picture, s, tile->x0, tile->y0, tile->x1, tile->y1, counts);
    return render_blocks(picture, s, tile, counts);
}

/* The mean of passes --------------------------------------------------------------------------------------------- */

static void add_pixel(const passing *s, int32_t x, int32_t y)
{
    const vvi_gathered *got = s->got;
    const size_t row = (size_t)got->shifted->width, width = (size_t)got->image->width;
    const float *p = got->shifted->rgba + 4 * ((size_t)y * row + (size_t)x), *q = p + 4 * row;
    const float fx = (float)s->x, fy = (float)s->y;
    const size_t at = (size_t)y * width + (size_t)x;
    float *mean = got->image->rgba + 4 * at;
    for (size_t c = 0; c < 4; c++) {
        const float above = p[c] + fx * (p[c + 4] - p[c]), below = q[c] + fx * (q[c + 4] - q[c]);
        const float sample = above + fy * (below - above);
        mean[c] += (sample - mean[c]) * s->all;
        if (s->half > 0)
            got->half[4 * at + c] += (sample - got->half[4 * at + c]) * s->half;
    }
    if (got->image->samples && !s->again)
        got->image->samples[at]++;
}

static void add_block(const passing *s, const vv_tile *tile, int32_t i, int32_t j)
{
    for (int32_t y = j; y < j + VVI_BLOCK && y < tile->y1; y++)
        for (int32_t x = i; x < i + VVI_BLOCK && x < tile->x1; x++)
            add_pixel(s, x, y);
}

static vv_status add_tile(vv_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                          vv_render_counts *counts)
{
    const passing *s = user;
    for (int32_t j = tile->y0; j < tile->y1; j += VVI_BLOCK)
        for (int32_t i = tile->x0; i < tile->x1; i += VVI_BLOCK)
            if (is_active(s->got, i / VVI_BLOCK, j / VVI_BLOCK))
                add_block(s, tile, i, j);
    return VV_OK;
}

vv_status vvi_pass_cast(bool *whole_out, vv_picture *picture)
{
    passing s = begin(picture);
    const vv_image *shifted = picture->got.shifted;
    const vvi_tiles tiles = {.width = shifted->width, .height = shifted->height, .tile = render_tile, .user = &s};
    return vvi_picture_go_on(whole_out, picture, &tiles);
}

static vv_status add(bool *whole_out, vv_picture *picture, passing s)
{
    const vv_image *image = picture->got.image;
    const vvi_tiles tiles = {
        .width = image->width, .height = image->height, .tile = add_tile, .user = &s, .quiet = true};
    return vvi_picture_go_on(whole_out, picture, &tiles);
}

vv_status vvi_pass_add(bool *whole_out, vv_picture *picture)
{
    return add(whole_out, picture, begin(picture));
}

/* (first + second) / 2 becomes (4 first + 9 second) / 13. */
vv_status vvi_pass_weigh(bool *whole_out, vv_picture *picture)
{
    passing s = {.got = &picture->got, .all = 5.0f / 13, .again = true};
    vvi_sample_shift(&s.x, &s.y, picture->got.passes - 1);
    return add(whole_out, picture, s);
}
