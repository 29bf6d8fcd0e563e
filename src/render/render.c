/* One frame at a call: a picture, stepped to its end. */
#include "render/picture.h"
#include <string.h>

void vv_render_options_init(vv_render_options *options, size_t size)
{
    const vv_render_options all = {.size = size};
    memcpy(options, &all, size < sizeof all ? size : sizeof all);
}

const char *vv_render_end_name(vv_render_end end)
{
    static const char *const names[] = {"", "samples", "noise", "budget", "stop"};
    return names[end];
}

static vv_status show(vv_picture *picture, const vv_render_options *options, vv_job *job)
{
    vv_image *image;
    const vv_status st = vv_picture_look(&image, picture, job);
    if (st != VV_OK)
        return st;
    options->on_refined(
        options->user,
        &(vv_refinement){.image = image, .level = vv_picture_level(picture), .passes = picture->got.passes});
    vv_image_release(image);
    return VV_OK;
}

static vv_status step_to_end(vv_picture *picture, const vv_render_options *options, vv_job *job)
{
    vv_picture_until until;
    vv_picture_until_init(&until, sizeof until);
    until.better = true;
    vv_status st;
    while ((st = vv_picture_step(picture, &until, job)) == VV_OK && !vv_picture_is_whole(picture)) {
        if (picture->got.passes > 0 && options->enough && options->enough(options->user)) {
            picture->got.ended_by = VV_END_STOPPED;
            return VV_OK;
        }
        if (options->on_refined && (st = show(picture, options, job)) != VV_OK)
            return st;
    }
    return st;
}

vv_status vv_render(vv_image **out, vv_render_report *report, vv_world *world, const char *view,
                    const vv_render_options *options, vv_job *job)
{
    vv_render_options all;
    vv_picture *picture;
    *out = NULL;
    vv_render_options_init(&all, sizeof all);
    if (options)
        memcpy(&all, options, options->size < sizeof all ? options->size : sizeof all);
    vv_status st = vv_picture_new(&picture, world, view, all.on_refined, job);
    if (st != VV_OK)
        return st;
    if ((st = step_to_end(picture, &all, job)) == VV_OK &&
        (st = vvi_picture_take(out, all.figure_out, picture, job)) == VV_OK) {
        if (report)
            vv_picture_report(report, picture);
        if (all.on_refined)
            all.on_refined(all.user,
                           &(vv_refinement){.image = *out, .level = 2, .passes = picture->got.passes, .final = true});
    }
    vv_picture_free(picture);
    return st;
}
