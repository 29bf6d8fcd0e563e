/* The stages of a picture: what each does, and which comes next. */
#include "core/memory.h"
#include "render/picture.h"
#include "scene/resolve.h"
#include <math.h>
#include <string.h>

/* What it gathers ------------------------------------------------------------------------------------------------- */

vv_status vvi_gathered_begin(vvi_gathered *got, const vv_scene *scene, vvi_stage stage, vv_job *job)
{
    const int32_t w = scene->width, h = scene->rows;
    *got = (vvi_gathered){.stage = stage, .n_tiles = vvi_picture_tiles_most(w, h)};
    vv_status st = vv_image_new(&got->image, w, h, scene->layers, job);
    if (st == VV_OK && stage <= VVI_STAGE_SQUARES)
        st = vv_image_new(&got->canvas, vvi_preview_size(w), vvi_preview_size(h), scene->layers, job);
    got->done = vvi_alloc_zeroed(job, got->n_tiles, VVI_MEM_SCRATCH);
    return st == VV_OK && !got->done ? vv_fail_memory(got->n_tiles) : st;
}

vv_status vvi_gathered_begin_passes(vvi_gathered *got, const vv_scene *scene, vv_job *job)
{
    const size_t n = (size_t)scene->width * (size_t)scene->rows, half_bytes = n * 4 * sizeof *got->half;
    got->n_across = (scene->width + VVI_BLOCK - 1) / VVI_BLOCK;
    got->n_down = (scene->rows + VVI_BLOCK - 1) / VVI_BLOCK;
    const size_t n_blocks = (size_t)got->n_across * (size_t)got->n_down;
    const vv_status st = vv_image_new(&got->shifted, scene->width + 1, scene->rows + 1, 0, job);
    if (st != VV_OK)
        return st;
    got->active = vvi_alloc(job, n_blocks, VVI_MEM_SCRATCH);
    if (scene->noise > 0)
        got->half = vvi_alloc_zeroed(job, half_bytes, VVI_MEM_IMAGE);
    if (!got->active || (scene->noise > 0 && !got->half))
        return vv_fail_memory(half_bytes + n_blocks);
    memset(got->active, 1, n_blocks);
    return VV_OK;
}

void vvi_gathered_finish_passes(vvi_gathered *got)
{
    vv_image_release(got->shifted);
    vvi_free(got->half);
    vvi_free(got->active);
    got->shifted = NULL;
    got->half = NULL;
    got->active = NULL;
}

void vvi_gathered_finish(vvi_gathered *got)
{
    vvi_gathered_finish_passes(got);
    vv_image_release(got->image);
    vv_image_release(got->canvas);
    vvi_free(got->done);
    *got = (vvi_gathered){.image = NULL};
}

/* Stages ---------------------------------------------------------------------------------------------------------- */

/* A pass of a ray for each pixel is there. */
static void end_first_pass(vv_picture *picture)
{
    vv_image_release(picture->got.canvas);
    picture->got.canvas = NULL;
    picture->got.passes = 1;
    picture->got.stage = VVI_STAGE_JUDGE;
}

static vv_status show_canvas(vv_picture *picture)
{
    const vv_status st = vvi_preview_show(picture, picture->got.image, 1);
    if (st == VV_OK)
        end_first_pass(picture);
    return st;
}

/* From coarse to fine, for who waits; and with squares filled in where that does. */
static vv_status do_grid(vv_picture *picture)
{
    vvi_gathered *got = &picture->got;
    bool whole = got->grid == VVI_GRIDS;
    vv_status st = whole ? VV_OK : vvi_preview_go_on(&whole, picture);
    if (st != VV_OK || !whole)
        return st;
    got->grid += got->grid < VVI_GRIDS;
    if (picture->scene->adaptive)
        got->stage = VVI_STAGE_SQUARES;
    return got->grid == VVI_GRIDS ? show_canvas(picture) : VV_OK;
}

static vv_status do_squares(vv_picture *picture)
{
    const vv_status st = vvi_adaptive_finish(picture);
    return st == VV_OK ? show_canvas(picture) : st;
}

static vv_status first_tile(vv_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                            vv_render_counts *counts)
{
    const vv_pass pass = vvi_picture_pass(picture, 0.5, 0.5, 1, 0);
    return vvi_picture_render(picture, &pass, tile, picture->got.image, counts);
}

static vv_status do_first(vv_picture *picture)
{
    bool whole;
    const vv_status st = vvi_picture_go_on(
        &whole, picture,
        &(vvi_tiles){.width = picture->scene->width, .height = picture->scene->rows, .tile = first_tile});
    if (st == VV_OK && whole)
        end_first_pass(picture);
    return st;
}

/* On an image that is clear: what was drawn before a cancel is no part of it. */
static vv_status do_draw(vv_picture *picture)
{
    const vv_scene *scene = picture->scene;
    vvi_gathered *got = &picture->got;
    vv_image *image = NULL;
    vv_render_counts counts = {0};
    int64_t samples = 1;
    vv_image_release(got->image);
    got->image = NULL;
    vv_status st = vv_image_new(&image, scene->width, scene->height, scene->layers, picture->job);
    got->image = image;
    if (st != VV_OK)
        return st;
    st = scene->renderer->draw(picture->state, image, scene->samples, &samples, &counts, picture->job);
    if (st != VV_OK)
        return st;
    const size_t n = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; image->samples && i < n; i++)
        image->samples[i] = (uint32_t)samples;
    got->counts = counts;
    got->passes = samples;
    got->ended_by = VV_END_SAMPLES;
    got->stage = VVI_STAGE_END;
    return VV_OK;
}

static vv_status do_rays(vv_picture *picture)
{
    bool whole;
    const vv_status st = vvi_pass_cast(&whole, picture);
    if (st == VV_OK && whole)
        picture->got.stage = VVI_STAGE_ADD;
    return st;
}

static vv_status do_add(vv_picture *picture)
{
    bool whole;
    const vv_status st = vvi_pass_add(&whole, picture);
    if (st != VV_OK || !whole)
        return st;
    picture->got.passes++;
    picture->got.stage = VVI_STAGE_JUDGE;
    return VV_OK;
}

/* A pass that would not end in time is not begun: it takes as long as the last one. Tells the progress how many there
 * will be, too. */
static bool is_time_over(vv_picture *picture)
{
    const vvi_gathered *got = &picture->got;
    const double spent_s = vvi_picture_spent(picture), left_s = picture->scene->budget_s - spent_s;
    if (!(picture->scene->budget_s > 0))
        return false;
    const double passes = left_s / (spent_s - got->pass_began_s);
    const double tiles = (double)picture->n_done / (double)got->passes;
    picture->n_ahead = (uint64_t)fmin((double)picture->n_ahead, fmax(passes * tiles, 0));
    return passes < 1;
}

/* After 1, 5, 9, ... passes: rarely enough to cost nothing, and there they lie evenly about the centres. */
static vv_status check_noise(vv_picture *picture)
{
    return picture->scene->noise > 0 && picture->got.passes % 4 == 1 ? vvi_noise_check(picture) : VV_OK;
}

static vv_status do_judge(vv_picture *picture)
{
    const vv_scene *scene = picture->scene;
    vvi_gathered *got = &picture->got;
    vv_status st = VV_OK;
    if (scene->samples > 1 && !got->shifted) {
        vvi_gathered_finish_passes(got); /* of a try that had no memory */
        st = vvi_gathered_begin_passes(got, scene, picture->job);
    }
    if (st == VV_OK && scene->samples > 1)
        st = check_noise(picture);
    if (st != VV_OK)
        return st;
    got->ended_by = scene->samples > 1 && vvi_blocks_active(got) == 0 ? VV_END_NOISE
                    : got->passes >= scene->samples                   ? VV_END_SAMPLES
                    : is_time_over(picture)                           ? VV_END_BUDGET
                                                                      : VV_END_NONE;
    got->pass_began_s = vvi_picture_spent(picture);
    got->stage = got->ended_by == VV_END_NONE ? VVI_STAGE_RAYS : got->passes == 2 ? VVI_STAGE_WEIGH : VVI_STAGE_END;
    return VV_OK;
}

static vv_status do_weigh(vv_picture *picture)
{
    bool whole;
    const vv_status st = vvi_pass_weigh(&whole, picture);
    if (st == VV_OK && whole)
        picture->got.stage = VVI_STAGE_END;
    return st;
}

static vv_status (*const stages[])(vv_picture *picture) = {
    [VVI_STAGE_GRID] = do_grid,   [VVI_STAGE_SQUARES] = do_squares, [VVI_STAGE_FIRST] = do_first,
    [VVI_STAGE_DRAW] = do_draw,   [VVI_STAGE_RAYS] = do_rays,       [VVI_STAGE_ADD] = do_add,
    [VVI_STAGE_JUDGE] = do_judge, [VVI_STAGE_WEIGH] = do_weigh,
};

vv_status vvi_picture_do_stage(vv_picture *picture)
{
    return stages[picture->got.stage](picture);
}
