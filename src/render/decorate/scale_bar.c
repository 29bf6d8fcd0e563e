/* A bar of a round length. In perspective lengths depend on the distance: the bar is for the middle of the data. */
#include "render/common/lens.h"
#include "render/decorate/nice.h"
#include "render/decorate/sheet.h"
#include <math.h>

#define MOST_SHARE 0.25 /* of the picture's width */

double vvi_scale_bar_length(double per_pixel, double pixels, double share)
{
    return vvi_nice_below(per_pixel * pixels * share);
}

vv_status vvi_sheet_scale_bar(const vvi_sheet *s)
{
    const vv_bounds b = vvi_sheet_bounds(s);
    const double pixel = b.hi.x >= b.lo.x ? vvi_sheet_pixel(s, vvi_scaled(vvi_add(b.lo, b.hi), 0.5)) : 0;
    const double length = vvi_scale_bar_length(pixel, s->width, MOST_SHARE);
    if (!(length > 0)) {
        vvi_log(s->job, VV_LOG_WARNING, "decorations", "no scale bar: the middle of the data is not before the eye");
        return VV_OK;
    }
    char text[64];
    const bool near = !s->scene->lens.parallel;
    const double thick = 0.28 * s->em, right = s->width - s->margin, left = right - length / pixel;
    const double y = s->height - s->margin - (near ? 1.15 * s->em : 0) - thick / 2, middle = (left + right) / 2;
    const vv_vec3 ends[2] = {{left, y, 0}, {right, y, 0}};
    const double edge = 0.6 * s->line;
    vv_status st = vvi_gfx_rectangle(s->gfx, ends[0].x - edge, y - thick / 2 - edge, ends[1].x + edge,
                                     y + thick / 2 + edge, &(vvi_gfx_fill){.color = vvi_faded(s->paper, 0.6)});
    if (st == VV_OK)
        st = vvi_gfx_rectangle(s->gfx, ends[0].x, y - thick / 2, ends[1].x, y + thick / 2,
                               &(vvi_gfx_fill){.color = s->ink});
    vvi_print_length(text, length, s->unit);
    if (st == VV_OK)
        st = vvi_sheet_text(s, middle, y - thick / 2 - 0.45 * s->em, s->em, VVI_GFX_MIDDLE, VVI_GFX_BASE_LINE, text);
    if (st == VV_OK && near)
        st = vvi_sheet_text(s, right, s->height - s->margin, 0.78 * s->em, VVI_GFX_END, VVI_GFX_BASE_LINE,
                            "at the centre\xe2\x80\x99s depth");
    return st;
}
