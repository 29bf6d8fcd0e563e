/* A picture as a figure: triangles, lines and letters as such, everything else as a picture under them. */
#include "core/memory.h"
#include "core/status.h"
#include "core/text.h"
#include "gfx/gfx.h"
#include "render/decorate/decorate.h"
#include "render/picture.h"
#include <string.h>

/* Some 10 MB of text; what programs that show figures still open. */
#define TRIANGLES_MOST 100000

/* The light of the picture over the background, as a picture file would have it. */
static void put_over(vv_image *under, const vv_picture *picture, const vv_image *image)
{
    const float *back = picture->scene->background, *light = image->rgba;
    const size_t n = (size_t)under->width * (size_t)under->height;
    for (size_t i = 0; i < 4 * n; i++)
        under->rgba[i] = light[i] + (1 - light[i | 3]) * back[i & 3];
}

static vv_status draw(const vv_picture *picture, const vv_image *image, const vvi_gfx_target *target, vv_image *under)
{
    const vv_renderer *renderer = picture->scene->renderer;
    vvi_gfx *gfx;
    vv_status st = vvi_gfx_begin(&gfx, &vvi_gfx_svg, target, picture->job);
    if (st != VV_OK)
        return st;
    if (renderer->figure)
        st = renderer->figure(picture->state, gfx, under, picture->job);
    else
        put_over(under, picture, image);
    if (st == VV_OK && vvi_decorate_wanted(picture->scene))
        st = vvi_decorate_figure(gfx, image, picture->scene, picture->job);
    if (st == VV_OK)
        return vvi_gfx_end(gfx);
    vvi_gfx_abandon(gfx);
    return st;
}

vv_status vvi_picture_figure(char **out, const vv_picture *picture, const vv_image *image)
{
    const vv_scene *scene = picture->scene;
    const bool areas = scene->renderer->figure;
    vvi_text text = {0};
    vv_image view, *under;
    *out = NULL;
    vv_status st = vv_image_new(&under, scene->width, scene->height, VV_LAYER_DEPTH, picture->job);
    if (st != VV_OK)
        return st;
    if ((st = vvi_decorate_view(&view, image, scene, picture->job)) == VV_OK) {
        const vvi_gfx_target target = {.image = under,
                                       .hiding = &view,
                                       .triangles = areas ? TRIANGLES_MOST : 0,
                                       .paper = areas ? scene->world->background : (vv_color){0},
                                       .title = scene->view->title,
                                       .svg = &text};
        st = draw(picture, image, &target, under);
        vvi_free(view.depth);
    }
    vv_image_release(under);
    if (st == VV_OK && !(*out = vvi_text_take(&text)))
        st = vv_fail_memory(text.n);
    vvi_text_free(&text);
    return st;
}
