/* How long a picture will take: tiles from all over it, and where those are quick a few passes, are rendered. What they
 * find stays with the picture. */
#include "core/status.h"
#include "render/picture.h"
#include "scene/resolve.h"
#include <math.h>

/* Of tiles, and of the next passes. What would take no longer than QUICK_S is made whole. */
#define PROBE_S 0.5
#define QUICK_S 1.0

static double share_done(const vv_picture *picture, int32_t width, int32_t height)
{
    const size_t n = (size_t)((width + VVI_TILE - 1) / VVI_TILE) * (size_t)((height + VVI_TILE - 1) / VVI_TILE);
    size_t done = 0;
    for (size_t i = 0; i < n; i++)
        done += picture->got.done[i];
    return (double)done / (double)n;
}

static vv_status draw(double *out, vv_picture *picture, int64_t samples, vv_job *job)
{
    const vv_scene *scene = picture->scene;
    const double start_s = vvi_render_clock();
    vv_render_counts counts = {0};
    vv_image *image;
    vv_status st = vv_image_new(&image, scene->width, scene->rows, scene->layers, job);
    if (st != VV_OK)
        return st;
    st = scene->renderer->draw(picture->state, image, samples, &samples, &counts, job);
    vv_image_release(image);
    *out = vvi_render_clock() - start_s;
    return st;
}

/* A renderer that draws at once: more rays take at most as many times as long. */
static vv_status time_drawing(double *out, vv_picture *picture, vv_job *job)
{
    const int64_t samples = picture->scene->samples;
    const vv_status st = draw(out, picture, 1, job);
    *out *= (double)samples;
    return st == VV_OK && *out < QUICK_S ? draw(out, picture, samples, job) : st;
}

/* The first pass from the share of its tiles, all others from the next two. */
static vv_status time_passes(double *out, vv_picture *picture, vv_job *job)
{
    const vv_scene *scene = picture->scene;
    const vvi_gathered *got = &picture->got;
    vv_picture_until until;
    vv_picture_until_init(&until, sizeof until);
    until.seconds = PROBE_S;
    until.passes = 1;
    picture->scattered = true;
    vv_status st = vv_picture_step(picture, &until, job);
    picture->scattered = false;
    if (st != VV_OK)
        return st;
    double first_s = got->spent_s, each_s;
    if (got->passes == 0) {
        first_s = each_s = got->spent_s / share_done(picture, scene->width, scene->rows);
    } else {
        until.passes = 3;
        if ((st = vv_picture_step(picture, &until, job)) != VV_OK)
            return st;
        each_s = got->passes > 1 ? (got->spent_s - first_s) / (double)(got->passes - 1) : first_s;
    }
    *out = vv_picture_is_whole(picture) ? got->spent_s : first_s + each_s * (double)(scene->samples - 1);
    return VV_OK;
}

/* A sixteenth of the rays is there after the first grid. Where others are filled in, half of them have been seen to be
 * cast. */
static vv_status time_grids(double *out, vv_picture *picture, vv_job *job)
{
    vv_picture_until until;
    vv_picture_until_init(&until, sizeof until);
    until.better = true;
    vv_status st = vv_picture_step(picture, &until, job);
    const double share = picture->scene->adaptive ? 0.5 : 1, rays = VVI_COARSE * VVI_COARSE;
    *out = picture->got.spent_s * rays * share * (double)picture->scene->samples;
    if (st == VV_OK && *out < QUICK_S && (st = vv_picture_step(picture, NULL, job)) == VV_OK)
        *out = picture->got.spent_s;
    return st;
}

vv_status vv_picture_estimate(double *seconds_out, vv_picture *picture, vv_job *job)
{
    const vvi_stage stage = picture->got.stage;
    const double budget_s = picture->scene->budget_s;
    *seconds_out = 0;
    if (stage != VVI_STAGE_GRID && stage != VVI_STAGE_FIRST && stage != VVI_STAGE_DRAW)
        return vv_fail(VV_E_ARGUMENT, "the time of a picture is estimated before its first step");
    const vv_status st = stage == VVI_STAGE_DRAW   ? time_drawing(seconds_out, picture, job)
                         : stage == VVI_STAGE_GRID ? time_grids(seconds_out, picture, job)
                                                   : time_passes(seconds_out, picture, job);
    if (st == VV_OK && budget_s > 0)
        *seconds_out = fmin(*seconds_out, budget_s);
    return st;
}
