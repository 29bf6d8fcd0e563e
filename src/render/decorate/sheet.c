/* Sizes, colours and places that all decorations share. */
#include "render/decorate/sheet.h"
#include "core/text.h"
#include "scene/lens.h"
#include "scene/resolve.h"
#include <math.h>
#include <string.h>

#define EM_SHARE 0.024 /* of the picture's smaller side: 6 points in a column of 85 mm */
#define USUAL_EM 9.0   /* pixels, at least, where nobody asks for smaller letters */
#define ELLIPSIS "\xe2\x80\xa6"
#define SEEN 0.02F   /* opacity */
#define COVERED 0.05 /* share of a box of text from which on it gets a plate */
enum { PROBES = 24 };
#define LEAST_EM 6.0 /* below it letters cannot be read */

/* Luminance of what decorations stand on; clear backgrounds may be anything. */
static bool is_bright(const float background[4])
{
    const double y = 0.2126 * (double)background[0] + 0.7152 * (double)background[1] + 0.0722 * (double)background[2];
    return y > 0.18 || background[3] < 0.5F; /* where black and white stand out from it alike */
}

vvi_sheet vvi_sheet_new(const vv_scene *scene, vv_job *job)
{
    const vv_decorations *wanted = (const vv_decorations *)scene->view->decorations;
    vvi_sheet s = {.scene = scene, .wanted = wanted, .job = job, .width = scene->width, .height = scene->height};
    const bool bright = is_bright(scene->background);
    const double side = fmin(s.width, s.height);
    s.em = fmax(fmax(EM_SHARE * side, USUAL_EM) * wanted->size, LEAST_EM);
    s.line = fmax(s.em / 12, 1);
    s.margin = fmin(1.2 * s.em, 0.05 * side);
    s.layout = (vvi_layout){.width = s.width, .height = s.height, .margin = s.margin, .gap = 0.35 * s.em};
    s.clear = scene->background[3] < 0.5F;
    s.projects = vvi_scene_projects(scene);
    s.ink = bright ? (vv_color){0.006, 0.006, 0.008, 1} : (vv_color){0.92, 0.92, 0.92, 1};
    if (vv_object_is_set(&wanted->base, "color"))
        s.ink = wanted->color;
    const bool light = 0.2126 * s.ink.r + 0.7152 * s.ink.g + 0.0722 * s.ink.b > 0.25;
    s.paper = light ? (vv_color){0, 0, 0, 0.8} : (vv_color){1, 1, 1, 0.85};
    s.unit = scene->world->unit ? scene->world->unit : "voxels";
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
    for (size_t i = 0; i < vvi_sheet_things(s); i++) {
        vv_vec3 c[8];
        vvi_sheet_corners(c, s, i);
        for (int k = 0; k < 8; k++) {
            b.lo = vvi_vec(fmin(b.lo.x, c[k].x), fmin(b.lo.y, c[k].y), fmin(b.lo.z, c[k].z));
            b.hi = vvi_vec(fmax(b.hi.x, c[k].x), fmax(b.hi.y, c[k].y), fmax(b.hi.z, c[k].z));
        }
    }
    return b;
}

bool vvi_sheet_is_anatomical(const vvi_sheet *s)
{
    return vvi_scene_space(s->scene) == VV_SPACE_RAS;
}

/* What is free ---------------------------------------------------------------------------------------------------- */

void vvi_sheet_mark(vvi_sheet *s, double x, double y, double weight)
{
    if (s->n_marks < VVI_MARKS)
        s->mark[s->n_marks++] = vvi_vec(x, y, weight);
}

double vvi_sheet_covered(const vvi_sheet *s, vvi_box b)
{
    const vv_image *image = s->image;
    int n = 0;
    for (int i = 0; image && i < PROBES * PROBES; i++) {
        const double x = b.x0 + (b.x1 - b.x0) * (i % PROBES + 0.5) / PROBES;
        const int row = i / PROBES;
        const double y = b.y0 + (b.y1 - b.y0) * (row + 0.5) / PROBES;
        if (x >= 0 && y >= 0 && x < image->width && y < image->height)
            n += image->rgba[4 * ((size_t)y * (size_t)image->width + (size_t)x) + 3] > SEEN;
    }
    return (double)n / (PROBES * PROBES);
}

double vvi_sheet_hides(const void *user, vvi_box b)
{
    const vvi_sheet *s = user;
    double cost = vvi_sheet_covered(s, b);
    for (size_t i = 0; i < s->n_marks; i++)
        if (s->mark[i].x > b.x0 && s->mark[i].x < b.x1 && s->mark[i].y > b.y0 && s->mark[i].y < b.y1)
            cost += s->mark[i].z;
    return cost;
}

void vvi_sheet_left_out(const vvi_sheet *s, const char *what)
{
    vvi_log(s->job, VV_LOG_WARNING, "decorations",
            "no room for %s: make the picture larger, or the letters smaller (%s)", what, "decorations.size");
}

/* Text ------------------------------------------------------------------------------------------------------------ */

double vvi_sheet_small(const vvi_sheet *s)
{
    return fmax(0.85 * s->em, fmin(s->em, USUAL_EM));
}

static vvi_box box_of(double x, double y, const vvi_gfx_label *l, double length)
{
    static const double above[] = {
        [VVI_GFX_BASE_LINE] = 0.72, [VVI_GFX_CENTRE] = 0.36, [VVI_GFX_TOP] = 0, [VVI_GFX_BOTTOM] = 0.94};
    const double pad = 0.2 * l->size, left = l->anchor == VVI_GFX_BEGIN    ? 0
                                             : l->anchor == VVI_GFX_MIDDLE ? length / 2
                                                                           : length;
    const double x0 = -left - pad, x1 = length - left + pad;
    const double y0 = -above[l->level] * l->size - pad, y1 = (0.94 - above[l->level]) * l->size + pad / 2;
    return l->quarters & 1 ? (vvi_box){x + y0, y - x1, x + y1, y - x0} : (vvi_box){x + x0, y + y0, x + x1, y + y1};
}

vv_status vvi_sheet_label(const vvi_sheet *s, double x, double y, const vvi_gfx_label *wanted, const char *text)
{
    vvi_gfx_label label = *wanted;
    vv_status st = VV_OK;
    if (!s->font || !*text)
        return VV_OK;
    const vvi_box b = box_of(x, y, &label, vvi_sheet_length(s, text, label.size));
    label.color = s->ink;
    label.halo = s->paper;
    if (s->clear || vvi_sheet_covered(s, b) > COVERED) {
        label.halo.a = 0;
        st = vvi_gfx_rectangle(s->gfx, b.x0, b.y0, b.x1, b.y1, &(vvi_gfx_fill){.color = s->paper});
    }
    return st == VV_OK ? vvi_gfx_text(s->gfx, vvi_vec(x, y, 0), &label, text) : st;
}

vv_status vvi_sheet_text(const vvi_sheet *s, double x, double y, double size, int anchor, int level, const char *text)
{
    return vvi_sheet_label(s, x, y, &(vvi_gfx_label){.size = size, .anchor = anchor, .level = level}, text);
}

double vvi_sheet_length(const vvi_sheet *s, const char *text, double size)
{
    return s->font ? vvi_font_length(s->font, text, size) : 0.55 * size * (double)strlen(text);
}

size_t vvi_sheet_fitting(const vvi_sheet *s, const char *text, double size, double room)
{
    char part[64];
    size_t n = 0;
    double length = 0;
    while (text[n]) { /* sign by sign: kerning is not worth a second look */
        const size_t bytes = vvi_utf8_length(text + n) ? vvi_utf8_length(text + n) : 1;
        memcpy(part, text + n, bytes);
        part[bytes] = 0;
        length += vvi_sheet_length(s, part, size);
        if (length > room)
            break;
        n += bytes;
    }
    return n;
}

void vvi_sheet_shorten(const vvi_sheet *s, char *text, size_t bytes, double size, double room, bool more)
{
    if (!more && vvi_sheet_length(s, text, size) <= room + 0.02 * size)
        return;
    size_t n = vvi_sheet_fitting(s, text, size, room - vvi_sheet_length(s, ELLIPSIS, size));
    while (n && (n + sizeof ELLIPSIS > bytes || text[n - 1] == ' ' || (text[n] & 0xc0) == 0x80))
        n--;
    memcpy(text + n, ELLIPSIS, bytes - n < sizeof ELLIPSIS ? bytes - n : sizeof ELLIPSIS);
}
