/* Many rays per pixel. Every pass casts one ray for each pixel, all through the same place of their pixels, so that a
 * pass is a picture shifted by less than a pixel; read at the centres of the pixels, linear between its rays, it is one
 * sample of what a tent filter of two pixels' width makes of the scene, and a picture is the mean of its passes. So
 * each ray serves the four pixels around it, which is worth two and a quarter times the rays [exact: 1 / (2/3)^2].
 *
 * Pass k is shifted by m (1/g, 1/g^2) modulo 1 with g the plastic number, 1.3247..., and m = 0, 1, -1, 2, -2, ... (the
 * R2 sequence of M. Roberts 2018, walked both ways): the first pass goes through the centres, however many there are
 * they lie evenly, and after an odd number they lie as far to the left as to the right.
 */
#include "render/pixel_rays.h"
#include "core/memory.h"
#include "core/status.h"
#include "scene/resolve.h"
#include <math.h>
#include <string.h>

void vvi_sample_shift(double *x_out, double *y_out, int64_t pass)
{
    const double m = (double)(pass % 2 ? (pass + 1) / 2 : -(pass / 2));
    const double x = m * 0.75487766624669276, y = m * 0.56984029099805327;
    *x_out = x - floor(x);
    *y_out = y - floor(y);
}

static size_t block_at(const vvi_samples *s, int32_t i, int32_t j)
{
    return (size_t)j * (size_t)s->n_across + (size_t)i;
}

static bool is_active(const vvi_samples *s, int32_t i, int32_t j)
{
    return i >= 0 && j >= 0 && i < s->n_across && j < s->n_down && s->active[block_at(s, i, j)];
}

/* Rays of a pass ------------------------------------------------------------------------------------------------- */

/* The shifted picture has one column and one row more than the image: pixel (x, y) of the image lies between its pixels
 * (x, y) and (x + 1, y + 1). */
static vv_status render_part(vvi_picture *picture, const vvi_samples *s, int32_t x0, int32_t y0, int32_t x1, int32_t y1,
                             vv_render_counts *counts)
{
    const vv_pass pass = vvi_picture_pass(picture, 0.5 - s->x, 0.5 - s->y, 1, (uint64_t)picture->passes);
    const vv_tile part = {x0, y0, x1 < s->shifted->width ? x1 : s->shifted->width,
                          y1 < s->shifted->height ? y1 : s->shifted->height};
    return vvi_picture_render(picture, &pass, &part, s->shifted, counts);
}

/* A block that is not active is looked at from its active neighbours above and to the left of it. */
static vv_status render_edge(vvi_picture *picture, const vvi_samples *s, int32_t i, int32_t j, vv_render_counts *counts)
{
    const bool left = is_active(s, i - 1, j), above = is_active(s, i, j - 1);
    const int32_t x = i * VVI_BLOCK, y = j * VVI_BLOCK;
    vv_status st = VV_OK;
    if (above)
        st = render_part(picture, s, x, y, x + VVI_BLOCK, y + 1, counts);
    else if (is_active(s, i - 1, j - 1) && !left)
        st = render_part(picture, s, x, y, x + 1, y + 1, counts);
    if (st == VV_OK && left)
        st = render_part(picture, s, x, y + above, x + 1, y + VVI_BLOCK, counts);
    return st;
}

static vv_status render_blocks(vvi_picture *picture, const vvi_samples *s, const vv_tile *tile,
                               vv_render_counts *counts)
{
    for (int32_t j = tile->y0 / VVI_BLOCK; j * VVI_BLOCK < tile->y1; j++) {
        for (int32_t i = tile->x0 / VVI_BLOCK; i * VVI_BLOCK < tile->x1; i++) {
            int32_t end = i;
            while (end * VVI_BLOCK < tile->x1 && is_active(s, end, j))
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

static vv_status render_tile(vvi_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                             vv_render_counts *counts)
{
    const vvi_samples *s = user;
    if (s->n_active == s->n_across * (int64_t)s->n_down)
        return render_part(picture, s, tile->x0, tile->y0, tile->x1, tile->y1, counts);
    return render_blocks(picture, s, tile, counts);
}

/* The mean of passes --------------------------------------------------------------------------------------------- */

/* 1 / number of samples with this one, in the mean of all and in that of odd passes; 0: not one of them. */
typedef struct weights {
    float all, half;
} weights;

static void add_pixel(const vvi_samples *s, int32_t x, int32_t y, const weights *w)
{
    const size_t row = (size_t)s->shifted->width, width = (size_t)s->image->width;
    const float *p = s->shifted->rgba + 4 * ((size_t)y * row + (size_t)x), *q = p + 4 * row;
    const float fx = (float)s->x, fy = (float)s->y;
    const size_t at = (size_t)y * width + (size_t)x;
    for (size_t c = 0; c < 4; c++) {
        const float above = p[c] + fx * (p[c + 4] - p[c]), below = q[c] + fx * (q[c + 4] - q[c]);
        const float sample = above + fy * (below - above);
        s->mean[4 * at + c] += (sample - s->mean[4 * at + c]) * w->all;
        if (s->half && w->half > 0)
            s->half[4 * at + c] += (sample - s->half[4 * at + c]) * w->half;
    }
    if (s->image->samples)
        s->image->samples[at]++;
}

static void add_block(const vvi_samples *s, const vv_tile *tile, int32_t i, int32_t j, const weights *w)
{
    for (int32_t y = j; y < j + VVI_BLOCK && y < tile->y1; y++)
        for (int32_t x = i; x < i + VVI_BLOCK && x < tile->x1; x++)
            add_pixel(s, x, y, w);
}

static vv_status add_tile(vvi_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                          vv_render_counts *counts)
{
    const vvi_samples *s = user;
    const float n = (float)(picture->passes + 1);
    const weights w = {1 / n, s->half && picture->passes % 2 ? 2 / n : 0};
    for (int32_t j = tile->y0; j < tile->y1; j += VVI_BLOCK)
        for (int32_t i = tile->x0; i < tile->x1; i += VVI_BLOCK)
            if (is_active(s, i / VVI_BLOCK, j / VVI_BLOCK))
                add_block(s, tile, i, j, &w);
    return VV_OK;
}

static vv_status add_pass(vvi_picture *picture, vvi_samples *s)
{
    vvi_sample_shift(&s->x, &s->y, picture->passes);
    vvi_tiles tiles = {.width = s->shifted->width, .height = s->shifted->height, .tile = render_tile, .user = s};
    vv_status st = vvi_picture_loop(picture, &tiles);
    if (st != VV_OK)
        return st;
    tiles = (vvi_tiles){.width = s->image->width, .height = s->image->height, .tile = add_tile, .user = s};
    tiles.quiet = true;
    if ((st = vvi_picture_loop(picture, &tiles)) == VV_OK)
        picture->passes++;
    return st;
}

/* How many passes ------------------------------------------------------------------------------------------------ */

/* A pass that would not end in time is not begun: it takes as long as the last one. Tells the progress how many there
 * will be, too. */
static bool is_time_over(vvi_picture *picture, double start_s, double last_s)
{
    const double now_s = vvi_render_clock(), left_s = picture->scene->budget_s - (now_s - start_s);
    if (!(picture->scene->budget_s > 0))
        return false;
    const double passes = left_s / (now_s - last_s), tiles = (double)picture->n_done / (double)picture->passes;
    picture->n_ahead = (uint64_t)fmin((double)picture->n_ahead, fmax(passes * tiles, 0));
    return passes < 1;
}

static bool is_enough(const vv_render_options *options)
{
    return options->enough && options->enough(options->user);
}

/* After 1, 5, 9, ... passes: rarely enough to cost nothing, and there they lie evenly about the centres. */
static vv_status check_noise(vvi_picture *picture, vvi_samples *s)
{
    return picture->scene->noise > 0 && picture->passes % 4 == 1 ? vvi_noise_check(picture, s) : VV_OK;
}

static vv_status add_passes(vvi_picture *picture, vvi_samples *s, double start_s)
{
    double last_s = start_s;
    vv_status st = check_noise(picture, s);
    while (st == VV_OK) {
        picture->ended_by = s->n_active == 0                             ? VV_END_NOISE
                            : picture->passes >= picture->scene->samples ? VV_END_SAMPLES
                            : is_time_over(picture, start_s, last_s)     ? VV_END_BUDGET
                            : is_enough(picture->options)                ? VV_END_STOPPED
                                                                         : VV_END_NONE;
        if (picture->ended_by != VV_END_NONE)
            break;
        if (picture->options->on_refined) {
            if ((st = vvi_picture_show(picture, s->mean)) != VV_OK)
                return st;
            vvi_picture_tell(picture, 2, false);
        }
        last_s = vvi_render_clock();
        if ((st = add_pass(picture, s)) == VV_OK)
            st = check_noise(picture, s);
    }
    return st;
}

static vv_status begin(vvi_samples *s, vvi_picture *picture)
{
    const vv_image *image = s->image = picture->image;
    const size_t n = (size_t)image->width * (size_t)image->height;
    s->n_across = (image->width + VVI_BLOCK - 1) / VVI_BLOCK;
    s->n_down = (image->height + VVI_BLOCK - 1) / VVI_BLOCK;
    const size_t n_blocks = (size_t)s->n_across * (size_t)s->n_down;
    vv_status st = vv_image_new(&s->shifted, image->width + 1, image->height + 1, 0, picture->job);
    if (st != VV_OK)
        return st;
    /* where nobody looks at it on the way, it may stand in the image, which is without a background until the end */
    s->mean =
        picture->options->on_refined ? vvi_alloc(picture->job, n * 4 * sizeof *s->mean, VVI_MEM_IMAGE) : image->rgba;
    s->active = vvi_alloc(picture->job, n_blocks, VVI_MEM_SCRATCH);
    if (picture->scene->noise > 0)
        s->half = vvi_alloc_zeroed(picture->job, n * 4 * sizeof *s->half, VVI_MEM_IMAGE);
    if (!s->mean || !s->active || (picture->scene->noise > 0 && !s->half))
        return vv_fail_memory(n * 8 * sizeof *s->mean + n_blocks);
    if (s->mean != image->rgba)
        memcpy(s->mean, image->rgba, n * 4 * sizeof *s->mean);
    memset(s->active, 1, n_blocks);
    s->n_active = (int64_t)n_blocks;
    return VV_OK;
}

vv_status vvi_samples_add(vvi_picture *picture, double start_s)
{
    vvi_samples s = {0};
    vv_status st = begin(&s, picture);
    if (st == VV_OK && (st = add_passes(picture, &s, start_s)) == VV_OK)
        st = vvi_picture_show(picture, s.mean);
    vv_image_release(s.shifted);
    if (s.image && s.mean != s.image->rgba)
        vvi_free(s.mean);
    vvi_free(s.half);
    vvi_free(s.active);
    return st;
}
