/* A bar of a round length. In perspective lengths depend on the distance: the bar is for the middle of the data. */
#include "render/decorate/round_numbers.h"
#include "render/decorate/sheet.h"
#include "scene/lens.h"
#include <math.h>

#define MOST_SHARE 0.25 /* of the picture's width */
#define CAPITALS 0.72   /* ems */
#define SPACE 0.35
#define THICK 0.28

double vvi_scale_bar_length(double per_pixel, double pixels, double share)
{
    return vvi_nice_below(per_pixel * pixels * share);
}

void vvi_sheet_scale_bar_place(vvi_sheet_scale_bar *out, vvi_sheet *s)
{
    const vv_bounds b = vvi_sheet_bounds(s);
    const double pixel = b.hi.x >= b.lo.x ? vvi_sheet_pixel(s, vvi_scaled(vvi_add(b.lo, b.hi), 0.5)) : 0;
    const double length = vvi_scale_bar_length(pixel, fmin(s->width, 2 * s->height), MOST_SHARE);
    *out = (vvi_sheet_scale_bar){.note = s->scene->lens.parallel ? "" : "at the centre\xe2\x80\x99s depth"};
    if (!(length > 0)) {
        vvi_log(s->job, VV_LOG_WARNING, "decorations",
                "no scale bar: the middle of the data is not in front of the eye");
        return;
    }
    vvi_print_length(out->text, length, s->unit);
    out->pixels = length / pixel;
    const double wide = fmax(
        out->pixels, fmax(vvi_sheet_length(s, out->text, s->em), vvi_sheet_length(s, out->note, vvi_sheet_small(s))));
    const double high = (CAPITALS + SPACE + THICK) * s->em + (*out->note ? (0.25 + CAPITALS) * vvi_sheet_small(s) : 0);
    const double right = s->width - s->margin, bottom = s->height - s->margin;
    out->box = (vvi_box){right - wide, bottom - high, right, bottom};
    out->there = vvi_layout_take(&s->layout, out->box);
    if (!out->there)
        vvi_sheet_left_out(s, "the scale bar");
}

vv_status vvi_sheet_scale_bar_draw(const vvi_sheet_scale_bar *bar, const vvi_sheet *s)
{
    if (!bar->there)
        return VV_OK;
    const vvi_box *b = &bar->box;
    const double edge = 0.7 * s->line, right = b->x1, left = right - bar->pixels;
    const double top = b->y0 + (CAPITALS + SPACE) * s->em, bottom = top + THICK * s->em;
    vv_status st = vvi_gfx_rectangle(s->gfx, left - edge, top - edge, right + edge, bottom + edge,
                                     &(vvi_gfx_fill){.color = s->paper});
    if (st == VV_OK)
        st = vvi_gfx_rectangle(s->gfx, left, top, right, bottom, &(vvi_gfx_fill){.color = s->ink});
    const double middle = fmin((left + right) / 2, right - vvi_sheet_length(s, bar->text, s->em) / 2);
    if (st == VV_OK)
        st = vvi_sheet_text(s, middle, b->y0, s->em, VVI_GFX_MIDDLE, VVI_GFX_TOP, bar->text);
    return st == VV_OK ? vvi_sheet_text(s, right, b->y1, vvi_sheet_small(s), VVI_GFX_END, VVI_GFX_BASE_LINE, bar->note)
                       : st;
}
