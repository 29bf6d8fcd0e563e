/* Which way the borders of a picture look, and where the cross-hair is. */
#include "core/vec.h"
#include "render/decorate/sheet.h"
#include <math.h>
#include <string.h>

#define NOTED 0.35  /* of a direction: smaller components are not named */
#define EDGE_EM 1.5 /* left free at the borders, for their letters */
#define GAP_EM 0.9  /* around the cross-hair, so that it hides nothing of what it is at */

void vvi_sheet_side_text(char out[VVI_SIDE_TEXT], vv_vec3 direction, bool anatomical)
{
    static const char *const body[] = {"L", "R", "P", "A", "I", "S"};
    static const char *const plain[] = {"\xe2\x88\x92x", "x", "\xe2\x88\x92y", "y", "\xe2\x88\x92z", "z"};
    double part[3] = {direction.x, direction.y, direction.z};
    out[0] = 0;
    for (int round = 0; round < 3; round++) {
        int most = 0;
        for (int a = 1; a < 3; a++) /* of nearly equal ones the first, whatever their rounding */
            most = fabs(part[a]) > fabs(part[most]) + 1e-6 ? a : most;
        if (fabs(part[most]) >= NOTED)
            strcat(out, (anatomical ? body : plain)[2 * most + (part[most] > 0)]);
        part[most] = 0;
    }
}

void vvi_sheet_sides_place(vvi_sheet_sides *out, vvi_sheet *s)
{
    const vv_lens *lens = &s->scene->lens;
    const vv_vec3 ways[4] = {vvi_scaled(lens->right, -1), lens->right, lens->up, vvi_scaled(lens->up, -1)};
    const double half = 0.36 * s->em;
    for (int i = 0; i < 4; i++) {
        vvi_sheet_axis_label *l = &out->side[i];
        vvi_sheet_side_text(l->text, ways[i], vvi_sheet_is_anatomical(s));
        const double wide = vvi_sheet_length(s, l->text, s->em) / 2;
        l->x = i == 0 ? s->margin + wide : i == 1 ? s->width - s->margin - wide : s->width / 2;
        l->y = i == 2 ? s->margin + half : i == 3 ? s->height - s->margin - half : s->height / 2;
        l->box = (vvi_box){l->x - wide, l->y - half, l->x + wide, l->y + half};
        l->there = vvi_layout_take(&s->layout, l->box);
        if (!l->there)
            vvi_sheet_left_out(s, "a letter at the border");
    }
}

vv_status vvi_sheet_sides_draw(const vvi_sheet_sides *sides, const vvi_sheet *s)
{
    const vvi_gfx_label label = {.size = s->em, .anchor = VVI_GFX_MIDDLE, .level = VVI_GFX_CENTRE};
    vv_status st = VV_OK;
    for (int i = 0; i < 4 && st == VV_OK; i++)
        if (sides->side[i].there)
            st = vvi_sheet_label(s, sides->side[i].x, sides->side[i].y, &label, sides->side[i].text);
    return st;
}

/* The cross-hair -------------------------------------------------------------------------------------------------- */

vv_status vvi_sheet_cross_hair(const vvi_sheet *s)
{
    double x, y, depth;
    const double gap = GAP_EM * s->em;
    if (!vvi_sheet_project(&x, &y, &depth, s, s->scene->cross_hair))
        return VV_OK;
    const double edge = s->wanted->sides ? s->margin + EDGE_EM * s->em : 0, right = s->width - edge;
    const double bottom = s->height - edge;
    const vv_vec3 lines[8] = {
        {fmin(edge, x - gap), y, 0}, {x - gap, y, 0}, {x + gap, y, 0}, {fmax(right, x + gap), y, 0},
        {x, fmin(edge, y - gap), 0}, {x, y - gap, 0}, {x, y + gap, 0}, {x, fmax(bottom, y + gap), 0}};
    return vvi_sheet_line(s, lines, 8, 0.6 * s->line);
}

/* Through everything, along the World's axes. */
vv_status vvi_sheet_cross_hair_in_world(const vvi_sheet *s)
{
    const vv_bounds b = vvi_sheet_bounds(s);
    const vv_vec3 c = s->scene->cross_hair;
    if (!(b.hi.x >= b.lo.x))
        return VV_OK;
    const vv_vec3 lines[6] = {{b.lo.x, c.y, c.z}, {b.hi.x, c.y, c.z}, {c.x, b.lo.y, c.z},
                              {c.x, b.hi.y, c.z}, {c.x, c.y, b.lo.z}, {c.x, c.y, b.hi.z}};
    return vvi_sheet_line(s, lines, 6, 0.6 * s->line);
}
