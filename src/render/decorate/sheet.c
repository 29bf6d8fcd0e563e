/* Sizes, colours and places that all decorations share. */
#include "render/decorate/sheet.h"
#include "render/common/lens.h"
#include "render/common/resolve.h"
#include <math.h>
#include <string.h>

#define EM_SHARE 0.0215 /* of the picture's smaller side */
#define USUAL_EM 9.0    /* pixels, at least, where nobody asks for smaller letters */
#define LEAST_EM 6.0    /* below it letters cannot be read */

/* Luminance of what decorations stand on; clear backgrounds may be anything. */
static bool is_bright(const float background[4])
{
    const double y = 0.2126 * (double)background[0] + 0.7152 * (double)background[1] + 0.0722 * (double)background[2];
    return y > 0.25 || background[3] < 0.5F;
}

vvi_sheet vvi_sheet_new(const vv_scene *scene, vv_job *job)
{
    const vv_decorations *wanted = (const vv_decorations *)scene->view->decorations;
    vvi_sheet s = {.scene = scene, .wanted = wanted, .job = job, .width = scene->width, .height = scene->height};
    const bool bright = is_bright(scene->background);
    const double side = fmin(s.width, s.height);
    s.em = fmax(fmax(EM_SHARE * side, USUAL_EM) * wanted->size, LEAST_EM);
    s.line = fmax(s.em / 12, 1);
    s.margin = fmax(1.5 * s.em, 0.03 * side);
    s.ink = bright ? (vv_color){0.006, 0.006, 0.008, 1} : (vv_color){0.92, 0.92, 0.92, 1};
    if (vv_object_is_set(&wanted->base, "color"))
        s.ink = wanted->color;
    const bool light = 0.2126 * s.ink.r + 0.7152 * s.ink.g + 0.0722 * s.ink.b > 0.25;
    s.paper = light ? (vv_color){0, 0, 0, 0.7} : (vv_color){1, 1, 1, 0.8};
    s.unit = scene->world->unit ? scene->world->unit : "voxels";
    s.top = s.margin;
    return s;
}

bool vvi_sheet_project(double *x, double *y, double *depth, const vvi_sheet *s, vv_vec3 world)
{
    const vv_lens *lens = &s->scene->lens;
    const vv_vec3 p = vvi_sub(world, lens->eye);
    const double z = vvi_dot(p, lens->forward), w = lens->parallel ? 1 : z;
    *depth = z;
    if (!(w > 1e-9 * vvi_length(p)) || !isfinite(z))
        return false;
    *x = (vvi_dot(p, lens->right) / (w * lens->half_width) + 1) / 2 * s->width;
    *y = (1 - vvi_dot(p, lens->up) / (w * lens->half_height)) / 2 * s->height;
    return isfinite(*x) && isfinite(*y);
}

double vvi_sheet_pixel(const vvi_sheet *s, vv_vec3 world)
{
    const vv_lens *lens = &s->scene->lens;
    const double z = vvi_dot(vvi_sub(world, lens->eye), lens->forward);
    const double size = 2 * lens->half_height / s->height * (lens->parallel ? 1 : z);
    return size > 0 && isfinite(size) ? size : 0;
}

vv_bounds vvi_sheet_bounds(const vvi_sheet *s)
{
    vv_bounds b = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (size_t i = 0; i < s->scene->n_actors; i++) {
        vv_vec3 c[8];
        vvi_actor_corners(c, &s->scene->actors[i]);
        for (int k = 0; k < 8; k++) {
            b.lo = vvi_vec(fmin(b.lo.x, c[k].x), fmin(b.lo.y, c[k].y), fmin(b.lo.z, c[k].z));
            b.hi = vvi_vec(fmax(b.hi.x, c[k].x), fmax(b.hi.y, c[k].y), fmax(b.hi.z, c[k].z));
        }
    }
    return b;
}

vv_status vvi_sheet_text(const vvi_sheet *s, double x, double y, double size, int anchor, int level, const char *text)
{
    const vvi_gfx_label label = {.size = size, .anchor = anchor, .level = level, .color = s->ink, .halo = s->paper};
    return s->font && *text ? vvi_gfx_text(s->gfx, vvi_vec(x, y, 0), &label, text) : VV_OK;
}

double vvi_sheet_length(const vvi_sheet *s, const char *text, double size)
{
    return s->font ? vvi_font_length(s->font, text, size) : 0.55 * size * (double)strlen(text);
}

vv_status vvi_sheet_line(const vvi_sheet *s, const vv_vec3 *points, size_t n, int join, double width)
{
    const vvi_gfx_stroke edge = {.color = vvi_faded(s->paper, 0.6), .width = width + 1.2 * s->line};
    const vvi_gfx_stroke line = {.color = s->ink, .width = width};
    const vv_status st = vvi_gfx_line(s->gfx, points, n, join, &edge);
    return st == VV_OK ? vvi_gfx_line(s->gfx, points, n, join, &line) : st;
}
