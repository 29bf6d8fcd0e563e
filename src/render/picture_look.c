/* Looking at a picture: what it has gathered, with layers, under the view's decorations and over the background. */
#include "core/job.h"
#include "core/memory.h"
#include "image/image_layer.h"
#include "render/decorate/decorate.h"
#include "render/picture.h"
#include "render/pixel_value.h"
#include "scene/resolve.h"
#include <string.h>

static vv_status over_background(vv_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                                 vv_render_counts *counts)
{
    const float *back = picture->scene->background;
    const vv_image *image = user;
    for (int32_t y = tile->y0; y < tile->y1; y++) {
        for (int32_t x = tile->x0; x < tile->x1; x++) {
            float *light = image->rgba + 4 * ((size_t)y * (size_t)image->width + (size_t)x);
            const float through = 1 - light[3];
            for (size_t c = 0; c < 4; c++) /* premultiplied and linear; a transparent one changes nothing */
                light[c] += through * back[c];
        }
    }
    return VV_OK;
}

/* An image that has the light. */
static vv_status decorate(vv_picture *picture, vv_image *image)
{
    const vvi_tiles tiles = {
        .width = image->width, .height = image->height, .tile = over_background, .user = image, .quiet = true};
    vv_status st = VV_OK;
    if (vvi_decorate_wanted(picture->scene))
        st = vvi_decorate(image, picture->scene, picture->job);
    return st == VV_OK ? vvi_picture_loop(picture, &tiles) : st;
}

static void copy_image(vv_image *to, const vv_image *from)
{
    const size_t n = (size_t)to->width * (size_t)to->height;
    memcpy(to->rgba, from->rgba, 4 * n * sizeof *to->rgba);
    for (size_t i = 0; i < VV_LAYER_COUNT; i++)
        if (vvi_image_layer(to, i))
            memcpy(vvi_image_layer(to, i), vvi_image_layer(from, i), n * vvi_layer_nth(i)->channels * sizeof(float));
}

static vv_status copy_light(vv_picture *picture, vv_image *image)
{
    const vvi_gathered *got = &picture->got;
    if (got->stage <= VVI_STAGE_SQUARES && got->grid > 0)
        return vvi_preview_show(picture, image, vvi_preview_stride(got->grid));
    if (got->stage > VVI_STAGE_SQUARES)
        copy_image(image, got->image);
    return got->passes ? vvi_layers_fill(image, picture->scene, picture->job) : VV_OK;
}

vv_status vv_picture_look(vv_image **out, vv_picture *picture, vv_job *job)
{
    const vv_scene *scene = picture->scene;
    const double start_s = vvi_render_clock();
    vv_image *image = NULL;
    *out = NULL;
    picture->job = job;
    vv_status st = vv_image_new(&image, scene->width, scene->rows, scene->layers, job);
    if (st == VV_OK && (st = copy_light(picture, image)) == VV_OK)
        st = decorate(picture, image);
    picture->got.spent_s += vvi_render_clock() - start_s;
    if (st == VV_OK)
        *out = image;
    else
        vv_image_release(image);
    return st;
}

vv_status vvi_picture_take(vv_image **out, char **figure_out, vv_picture *picture, vv_job *job)
{
    const double start_s = vvi_render_clock();
    vv_image *image = picture->got.image;
    *out = NULL;
    picture->job = job;
    vv_status st = figure_out ? VV_OK : decorate(picture, image);
    if (st == VV_OK)
        st = vvi_layers_fill(image, picture->scene, job);
    if (st == VV_OK && figure_out)
        st = vvi_picture_figure(figure_out, picture, image);
    picture->got.spent_s += vvi_render_clock() - start_s;
    if (st != VV_OK)
        return st;
    *out = image;
    picture->got.image = NULL;
    return VV_OK;
}
