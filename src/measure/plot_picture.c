/* A plot as a picture of its own. */
#include "core/status.h"
#include "gfx/font.h"
#include "measure/plot.h"

/* What lies under a density's plot. */
static vv_status paint(vv_image **out, const vvi_plot *plot, vv_job *job)
{
    const vv_status st = vv_image_new(out, VVI_PLOT_WIDTH, VVI_PLOT_HEIGHT, 0, job);
    if (st == VV_OK && plot->density)
        vvi_plot_paint(*out, plot);
    return st;
}

vv_status vvi_plot_svg(vvi_text *out, const vvi_plot *plot, vv_job *job)
{
    vvi_gfx_target target = {.width = VVI_PLOT_WIDTH, .height = VVI_PLOT_HEIGHT, .svg = out, .title = plot->title};
    vvi_gfx *gfx = NULL;
    vv_status st = plot->density ? paint(&target.image, plot, job) : VV_OK;
    if (st == VV_OK)
        st = vvi_gfx_begin(&gfx, &vvi_gfx_svg, &target, job);
    if (st == VV_OK && (st = vvi_plot_draw(gfx, plot, job)) == VV_OK)
        st = vvi_gfx_end(gfx);
    else
        vvi_gfx_abandon(gfx);
    vv_image_release(target.image);
    return st == VV_OK && out->bad ? vv_fail_memory(out->n) : st;
}

vv_status vvi_plot_image(vv_image **out, bool *lettered_out, const vvi_plot *plot, vv_job *job)
{
    vvi_plot shown = *plot;
    vvi_font *font = NULL;
    vvi_gfx *gfx = NULL;
    vv_status st = paint(out, plot, job);
    if (st != VV_OK)
        return st;
    st = vvi_font_open(&font, NULL);
    const vvi_gfx_font letters = {vvi_font_draw, font};
    shown.no_letters = st == VV_E_NOT_FOUND || st == VV_E_UNSUPPORTED;
    *lettered_out = !shown.no_letters;
    const vvi_gfx_target target = {.image = *out, .font = shown.no_letters ? NULL : &letters};
    if (shown.no_letters) /* without a font the curve is still worth seeing */
        st = VV_OK;
    if (st == VV_OK && (st = vvi_gfx_begin(&gfx, &vvi_gfx_software, &target, job)) == VV_OK &&
        (st = vvi_plot_draw(gfx, &shown, job)) == VV_OK)
        st = vvi_gfx_end(gfx);
    else
        vvi_gfx_abandon(gfx);
    vvi_font_close(font);
    return st;
}
