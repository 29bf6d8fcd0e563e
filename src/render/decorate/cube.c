/* How the World is turned: a small cube with letters painted on its faces. A letter is the way in which that direction
 * grows: R on the face that looks to the subject's right. */
#include "core/memory.h"
#include "render/decorate/sheet.h"
#include "scene/lens.h"
#include <math.h>

#define SIDE_EM 3.0
#define LETTER_SHARE 0.62 /* of a face: the height of capitals, or the length of a word */

/* Where it stands. */
typedef struct stand {
    const vvi_sheet *sheet;
    double x, y, half;
} stand;

/* A place on the cube, whose half side is 1, in pixels. */
static vv_vec3 place(const stand *s, vv_vec3 p)
{
    const vv_lens *lens = &s->sheet->scene->lens;
    return vvi_vec(s->x + s->half * vvi_dot(p, lens->right), s->y - s->half * vvi_dot(p, lens->up), 0);
}

static vv_vec3 along(int axis, double sign)
{
    return vvi_vec(axis == 0 ? sign : 0, axis == 1 ? sign : 0, axis == 2 ? sign : 0);
}

static const char *letter_of(const vvi_sheet *s, int face)
{
    static const char *const anatomical[] = {"L", "R", "P", "A", "I", "S"};
    static const char *const plain[] = {"\xe2\x88\x92x", "x", "\xe2\x88\x92y", "y", "\xe2\x88\x92z", "z"};
    return (vvi_sheet_is_anatomical(s) ? anatomical : plain)[face];
}

/* One of the four directions in a face that its letter may have as its top: the one that is most upright. */
static vv_vec3 upright(const vvi_sheet *s, int axis)
{
    vv_vec3 best = {0};
    double most = -INFINITY;
    for (int i = 0; i < 6; i++) {
        const vv_vec3 u = along(i / 2, i % 2 ? 1 : -1);
        /* a little for z, so that a cube that stands on an edge does not flicker */
        const double score = vvi_dot(u, s->scene->lens.up) + (i / 2 == 2 ? 1e-3 : 0);
        if (i / 2 != axis && score > most) {
            most = score;
            best = u;
        }
    }
    return best;
}

/* All contours as one polygon: from the begin of the first to each other and back, ways that cancel. */
static size_t join(vv_vec3 *out, const vvi_font_outline *o)
{
    size_t n = 0, begin = 0;
    for (size_t c = 0; c < o->n_polygons; begin = o->ends[c++]) {
        for (size_t i = begin; i < o->ends[c]; i++)
            out[n++] = o->points[i];
        out[n++] = o->points[begin];
        out[n++] = o->points[0];
    }
    return n;
}

static vv_status draw_outline(const stand *s, const vvi_font_outline *o, vv_vec3 normal, vv_vec3 up)
{
    const vv_vec3 right = vvi_cross(up, normal);
    const double capital = vvi_font_get_heights(s->sheet->font).capital;
    const double scale = 2 * fmin(LETTER_SHARE / capital, LETTER_SHARE * 1.25 / o->advance);
    const size_t room = o->n_points + 2 * o->n_polygons;
    vv_vec3 *points = vvi_alloc(s->sheet->job, room * sizeof *points, VVI_MEM_SCRATCH);
    if (!points)
        return vv_fail_memory(room * sizeof *points);
    const size_t n = join(points, o);
    for (size_t i = 0; i < n; i++) {
        const double a = (points[i].x - o->advance / 2) * scale, b = (points[i].y - capital / 2) * scale;
        points[i] = place(s, vvi_add(normal, vvi_add(vvi_scaled(right, a), vvi_scaled(up, b))));
    }
    const vv_status st =
        vvi_gfx_polygon(s->sheet->gfx, points, n, &(vvi_gfx_fill){.color = vvi_faded(s->sheet->ink, 1)});
    vvi_free(points);
    return st;
}

static vv_status draw_letter(const stand *s, int face, vv_vec3 normal)
{
    vvi_font_outline outline;
    if (!s->sheet->font)
        return VV_OK;
    vv_status st = vvi_font_trace(&outline, s->sheet->font, letter_of(s->sheet, face), 0.1 / s->half, s->sheet->job);
    if (st != VV_OK)
        return st;
    if (outline.n_polygons)
        st = draw_outline(s, &outline, normal, upright(s->sheet, face / 2));
    vvi_font_outline_finish(&outline);
    return st;
}

/* Between ink and what it stands on; faces that look up are brighter. */
static vv_color shade_of(const vvi_sheet *s, vv_vec3 normal)
{
    const vv_lens *lens = &s->scene->lens;
    const bool light = s->ink.r + s->ink.g + s->ink.b > 1;
    const vv_vec3 lamp = vvi_add(vvi_scaled(lens->up, 0.55), vvi_scaled(lens->forward, -0.8));
    const double facing = fmax(vvi_dot(normal, lamp), 0);
    const double grey = light ? 0.02 + 0.07 * facing : 0.5 + 0.42 * facing;
    return (vv_color){grey, grey, grey * 1.03, 0.92};
}

static vv_status draw_face(const stand *s, int face)
{
    const vv_vec3 n = along(face / 2, face % 2 ? 1 : -1);
    if (vvi_dot(n, s->sheet->scene->lens.forward) >= -1e-3)
        return VV_OK;
    const vv_vec3 u = along((face / 2 + 1) % 3, 1), v = along((face / 2 + 2) % 3, 1);
    vv_vec3 corner[4];
    for (int i = 0; i < 4; i++)
        corner[i] =
            place(s, vvi_add(n, vvi_add(vvi_scaled(u, i == 0 || i == 3 ? -1 : 1), vvi_scaled(v, i < 2 ? -1 : 1))));
    vv_status st = vvi_gfx_polygon(s->sheet->gfx, corner, 4, &(vvi_gfx_fill){.color = shade_of(s->sheet, n)});
    const vvi_gfx_stroke edge = {.color = vvi_faded(s->sheet->ink, 0.8), .width = s->sheet->line};
    if (st == VV_OK)
        st = vvi_gfx_line(s->sheet->gfx, corner, 4, VVI_GFX_LOOP, &edge);
    return st == VV_OK ? draw_letter(s, face, n) : st;
}

void vvi_sheet_cube_place(vvi_sheet_cube *out, vvi_sheet *sheet)
{
    const vv_lens *lens = &sheet->scene->lens;
    const double half = SIDE_EM / 2 * sheet->em;
    const double wide = fabs(lens->right.x) + fabs(lens->right.y) + fabs(lens->right.z);
    const double high = fabs(lens->up.x) + fabs(lens->up.y) + fabs(lens->up.z);
    const vvi_wish wish = {.width = 2 * half * wide + sheet->line,
                           .height = 2 * half * high + sheet->line,
                           .bottom = true,
                           .cost = vvi_sheet_hides,
                           .user = sheet};
    vvi_box b = {0};
    out->there = vvi_layout_place(&b, &sheet->layout, &wish);
    out->x = (b.x0 + b.x1) / 2;
    out->y = (b.y0 + b.y1) / 2;
    out->half = half;
    if (!out->there)
        vvi_sheet_left_out(sheet, "the orientation cube");
}

vv_status vvi_sheet_cube_draw(const vvi_sheet_cube *cube, const vvi_sheet *sheet)
{
    const stand s = {sheet, cube->x, cube->y, cube->half};
    vv_status st = VV_OK;
    for (int face = 0; cube->there && face < 6 && st == VV_OK; face++)
        st = draw_face(&s, face);
    return st;
}
