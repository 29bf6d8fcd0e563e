/* The back end for figures: an SVG document. Lines, points, areas and text stay what they are. Meshes are areas, too,
 * up to the number that the target allows; where it allows none, and for areas in the world that may be hidden, the
 * software back end draws one picture under all, since a figure of a million triangles is of no use to anybody. What
 * lies behind that picture's depths is left out. */
#include "core/job.h"
#include "core/units.h"
#include "gfx/facets.h"
#include "gfx/flat.h"
#include "gfx/png.h"
#include <string.h>

/* Places that a document may have: about 50 MB of text. */
#define SPOTS_MOST 4000000

/* One element, in the order of the calls. */
typedef struct item {
    const vvi_gfx_flat *shape; /* NULL: text */
    vvi_gfx_stroke stroke;
    const char *text;
    vvi_gfx_label label;
    vvi_gfx_spot spot;
    const vvi_gfx_view *view; /* may be hidden; NULL: it is not */
    double window[4];
} item;

typedef struct document {
    vvi_gfx_list items;
    vvi_gfx_facets facets;
    vvi_gfx *inner;  /* draws the picture; NULL: nothing is in it but what it had */
    vv_image *image; /* made for it */
    size_t n_spots;
    unsigned n_ids;   /* of clip paths and gradients */
    double window[4]; /* of the clip path that was written last */
    unsigned window_id;
} document;

static vv_status begin(vvi_gfx *gfx)
{
    document *d = vvi_gfx_keep(gfx, sizeof *d);
    if (!d)
        return vv_fail_memory(sizeof *d);
    *d = (document){0};
    gfx->own = d;
    return VV_OK;
}

/* Taking down ----------------------------------------------------------------------------------------------------- */

static vv_status inner(vvi_gfx **out, vvi_gfx *gfx)
{
    document *d = gfx->own;
    vv_status st;
    if (!d->inner) {
        vvi_gfx_target target = gfx->target;
        if (!target.image &&
            (st = vv_image_new(&d->image, target.width, target.height, VV_LAYER_DEPTH, gfx->job)) != VV_OK)
            return st;
        target.image = target.image ? target.image : d->image;
        if ((st = vvi_gfx_begin(&d->inner, &vvi_gfx_software, &target, gfx->job)) != VV_OK)
            return st;
    }
    d->inner->state = gfx->state; /* whose kept parts outlive the picture */
    *out = d->inner;
    return VV_OK;
}

static vv_status mesh(vvi_gfx *gfx, const vvi_gfx_surface *surface)
{
    document *d = gfx->own;
    vvi_gfx *picture;
    if (gfx->target.triangles)
        return vvi_gfx_facets_add(&d->facets, gfx, surface);
    const vv_status st = inner(&picture, gfx);
    return st == VV_OK ? vvi_gfx_mesh(picture, surface) : st;
}

static vv_status add(vvi_gfx *gfx, const item *one)
{
    document *d = gfx->own;
    d->n_spots += one->shape ? one->shape->n_spots : 1;
    if (d->n_spots > SPOTS_MOST)
        return vv_fail(VV_E_LIMIT, "a figure with more than %d points is too large for SVG: draw an image, or less",
                       SPOTS_MOST);
    item *kept = vvi_gfx_keep(gfx, sizeof *kept);
    if (!kept)
        return vv_fail_memory(sizeof *kept);
    *kept = *one;
    kept->view = gfx->state.depth ? gfx->state.view : NULL;
    memcpy(kept->window, gfx->state.window, sizeof kept->window);
    return vvi_gfx_list_add(&d->items, kept, gfx->job);
}

static vv_status line(vvi_gfx *gfx, const vv_vec3 *points, size_t n_points, vvi_gfx_join join,
                      const vvi_gfx_stroke *stroke)
{
    vvi_gfx_flat *shape;
    const bool hides = gfx->state.view && gfx->state.depth; /* then parts are left out, and dashes are parts, too */
    const vv_status st = vvi_gfx_flat_line(&shape, gfx, points, n_points, join, stroke, !hides);
    item one = {.shape = shape, .stroke = *stroke};
    if (hides)
        one.stroke.dash = 0;
    return st == VV_OK && shape ? add(gfx, &one) : st;
}

static vv_status points(vvi_gfx *gfx, const vv_vec3 *places, size_t n_points, double diameter, vv_color color)
{
    vvi_gfx_flat *shape;
    const vv_status st = vvi_gfx_flat_points(&shape, gfx, places, n_points, diameter, color);
    return st == VV_OK && shape ? add(gfx, &(item){.shape = shape}) : st;
}

static vv_status polygon(vvi_gfx *gfx, const vv_vec3 *places, size_t n_points, const vvi_gfx_fill *fill)
{
    vvi_gfx_flat *shape;
    vvi_gfx *picture;
    vv_status st;
    if (gfx->state.view && gfx->state.depth) {
        st = inner(&picture, gfx);
        return st == VV_OK ? vvi_gfx_polygon(picture, places, n_points, fill) : st;
    }
    st = vvi_gfx_flat_polygon(&shape, gfx, places, n_points, fill);
    return st == VV_OK && shape ? add(gfx, &(item){.shape = shape}) : st;
}

static vv_status text(vvi_gfx *gfx, vv_vec3 at, const vvi_gfx_label *label, const char *utf8)
{
    const size_t n = strlen(utf8) + 1;
    char *copy = vvi_gfx_keep(gfx, n);
    item one = {.text = copy, .label = *label};
    if (!copy)
        return vv_fail_memory(n);
    memcpy(copy, utf8, n);
    return vvi_gfx_spot_at(&one.spot, &gfx->state, at) ? add(gfx, &one) : VV_OK;
}

/* Writing --------------------------------------------------------------------------------------------------------- */

/* Hundredths of a pixel are enough for everybody. */
static void number(vvi_text *out, const char *before, double value)
{
    char digits[32];
    vvi_print_unsigned_zero(digits, floor(value * 100 + 0.5) / 100);
    vvi_text_add(out, before);
    vvi_text_add(out, digits);
}

static void escaped(vvi_text *out, const char *s)
{
    for (; *s; s++) {
        if (*s == '<')
            vvi_text_add(out, "&lt;");
        else if (*s == '&')
            vvi_text_add(out, "&amp;");
        else if (*s == '>')
            vvi_text_add(out, "&gt;");
        else
            vvi_text_add_n(out, s, 1);
    }
}

static unsigned code(double linear)
{
    return (unsigned)(vv_srgb_encode(fmin(1, fmax(0, linear))) * 255 + 0.5);
}

/* name="#rrggbb" name-opacity="0.5" */
static void color(vvi_text *out, const char *name, const char *opacity, vv_color c)
{
    vvi_text_printf(out, " %s=\"#%02x%02x%02x\"", name, code(c.r), code(c.g), code(c.b));
    if (c.a < 1) {
        vvi_text_printf(out, " %s=\"", opacity);
        number(out, "", fmax(c.a, 0));
        vvi_text_add(out, "\"");
    }
}

/* Attributes of what is not drawn in the whole picture; a new window gets a path first. */
static unsigned clip_path(document *d, vvi_gfx *gfx, const double w[4])
{
    vvi_text *out = gfx->target.svg;
    if (w[0] <= 0 && w[1] <= 0 && w[2] >= gfx->target.width && w[3] >= gfx->target.height)
        return 0;
    if (d->window_id && d->window[0] == w[0] && d->window[1] == w[1] && d->window[2] == w[2] && d->window[3] == w[3])
        return d->window_id;
    memcpy(d->window, w, sizeof d->window);
    d->window_id = ++d->n_ids;
    vvi_text_printf(out, "<clipPath id=\"i%u\"><rect", d->window_id);
    number(out, " x=\"", w[0]);
    number(out, "\" y=\"", w[1]);
    number(out, "\" width=\"", fmax(0, w[2] - w[0]));
    number(out, "\" height=\"", fmax(0, w[3] - w[1]));
    vvi_text_add(out, "\"/></clipPath>\n");
    return d->window_id;
}

static void open_element(document *d, vvi_gfx *gfx, const item *i, const char *name)
{
    const unsigned clip = clip_path(d, gfx, i->window);
    vvi_text_printf(gfx->target.svg, "<%s", name);
    if (clip)
        vvi_text_printf(gfx->target.svg, " clip-path=\"url(#i%u)\"", clip);
}

static bool is_seen(const item *i, const vv_image *image, vvi_gfx_spot s)
{
    const int32_t x = (int32_t)floor(s.x), y = (int32_t)floor(s.y);
    if (!i->view || !image || !image->depth || x < 0 || y < 0 || x >= image->width || y >= image->height)
        return true;
    const double depth = vvi_gfx_depth_of(i->view, s.x, s.y, s.near);
    return vvi_gfx_is_before(i->view, depth, (double)image->depth[(size_t)y * (size_t)image->width + (size_t)x]);
}

static void place(vvi_text *out, const char *command, vvi_gfx_spot s)
{
    number(out, command, s.x);
    number(out, " ", s.y);
}

/* The seen parts of a segment, found by steps of half a pixel; *pen: where the path has come to. */
static void segment(vvi_text *out, const item *i, const vv_image *image, vvi_gfx_spot a, vvi_gfx_spot b,
                    vvi_gfx_spot *pen)
{
    const double length = hypot(b.x - a.x, b.y - a.y);
    const bool asks = i->view && image && image->depth;
    const size_t n = asks ? (size_t)fmin(1 + 2 * length, 65536) : 1;
    bool down = false;
    for (size_t k = 0; k < n; k++) {
        const double t = (double)k / (double)n, end = (double)(k + 1) / (double)n, mid = (t + end) / 2;
        const vvi_gfx_spot from = vvi_gfx_between(a, b, t), to = vvi_gfx_between(a, b, end);
        const bool seen = is_seen(i, image, vvi_gfx_between(a, b, mid));
        if (seen && !down && (pen->x != from.x || pen->y != from.y))
            place(out, "M", from);
        if (down && !seen)
            place(out, "L", from);
        if (seen && k + 1 == n)
            place(out, "L", to);
        if (seen)
            *pen = to;
        down = seen;
    }
}

static void write_line(document *d, vvi_gfx *gfx, const item *i, const vv_image *image)
{
    vvi_text *out = gfx->target.svg;
    const vvi_gfx_flat *s = i->shape;
    vvi_gfx_spot pen = {.x = NAN};
    open_element(d, gfx, i, "path");
    vvi_text_add(out, " fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\"");
    color(out, "stroke", "stroke-opacity", i->stroke.color);
    number(out, " stroke-width=\"", i->stroke.width);
    if (i->stroke.dash > 0) {
        number(out, "\" stroke-dasharray=\"", i->stroke.dash);
        number(out, " ", i->stroke.space);
    }
    vvi_text_add(out, "\" d=\"");
    for (size_t k = 0; k + 1 < s->n_spots; k += 2)
        segment(out, i, image, s->spots[k], s->spots[k + 1], &pen);
    vvi_text_add(out, "\"/>\n");
}

static void write_discs(document *d, vvi_gfx *gfx, const item *i, const vv_image *image)
{
    vvi_text *out = gfx->target.svg;
    for (size_t k = 0; k < i->shape->n_spots; k++) {
        const vvi_gfx_spot s = i->shape->spots[k];
        if (!is_seen(i, image, s))
            continue;
        open_element(d, gfx, i, "circle");
        number(out, " cx=\"", s.x);
        number(out, "\" cy=\"", s.y);
        number(out, "\" r=\"", i->shape->radius);
        vvi_text_add(out, "\"");
        color(out, "fill", "fill-opacity", i->shape->paint.color);
        vvi_text_add(out, "/>\n");
    }
}

/* SVG mixes encoded colours, premultiplied in no reader: so many stops that it does not matter. */
enum { STOPS = 32 };

static unsigned gradient(document *d, vvi_text *out, const vvi_gfx_paint *p)
{
    vvi_text_printf(out, "<linearGradient id=\"i%u\" gradientUnits=\"userSpaceOnUse\"", ++d->n_ids);
    number(out, " x1=\"", p->from.x);
    number(out, "\" y1=\"", p->from.y);
    number(out, "\" x2=\"", p->to.x);
    number(out, "\" y2=\"", p->to.y);
    vvi_text_add(out, "\">");
    for (size_t k = 0; k < p->n_stops; k++) {
        const vvi_gfx_stop a = p->stops[k], b = p->stops[k + 1 < p->n_stops ? k + 1 : k];
        for (int step = 0; step < (k + 1 < p->n_stops && b.at > a.at ? STOPS : 1); step++) {
            const double at = a.at + (b.at - a.at) * step / STOPS;
            char digits[32];
            vvi_print_unsigned_zero(digits, floor(at * 1e5 + 0.5) / 1e5);
            vvi_text_printf(out, "<stop offset=\"%s\"", digits);
            color(out, "stop-color", "stop-opacity", vvi_gfx_stop_color(p->stops, p->n_stops, at));
            vvi_text_add(out, "/>");
        }
    }
    vvi_text_add(out, "</linearGradient>\n");
    return d->n_ids;
}

static void write_area(document *d, vvi_gfx *gfx, const item *i)
{
    vvi_text *out = gfx->target.svg;
    const vvi_gfx_flat *s = i->shape;
    const unsigned fill = s->paint.n_stops ? gradient(d, out, &s->paint) : 0;
    open_element(d, gfx, i, "path");
    vvi_text_add(out, " fill-rule=\"evenodd\"");
    if (fill)
        vvi_text_printf(out, " fill=\"url(#i%u)\"", fill);
    else
        color(out, "fill", "fill-opacity", s->paint.color);
    vvi_text_add(out, " d=\"");
    for (size_t k = 0; k < s->n_spots; k++)
        place(out, k ? "L" : "M", s->spots[k]);
    vvi_text_add(out, "Z\"/>\n");
}

/* Of the widths that layouts are made with. */
#define FONTS "Liberation Sans, Arimo, Arial, Helvetica, sans-serif"

/* One <text>; halo: what is around the letters, else they themselves. */
static void write_letters(document *d, vvi_gfx *gfx, const item *i, bool halo)
{
    static const char *const anchors[] = {"start", "middle", "end"};
    vvi_text *out = gfx->target.svg;
    const vvi_gfx_label *label = &i->label;
    open_element(d, gfx, i, "text");
    number(out, " x=\"", i->spot.x);
    number(out, "\" y=\"", i->spot.y + vvi_gfx_base_line(label));
    number(out, "\" font-family=\"" FONTS "\" font-size=\"", label->size);
    vvi_text_printf(out, "\" text-anchor=\"%s\" xml:space=\"preserve\"", anchors[label->anchor]);
    if (label->quarters & 3) {
        vvi_text_printf(out, " transform=\"rotate(%d", -90 * (label->quarters & 3));
        place(out, " ", i->spot);
        vvi_text_add(out, ")\"");
    }
    if (halo) {
        color(out, "stroke", "stroke-opacity", label->halo);
        number(out, " fill=\"none\" stroke-linejoin=\"round\" stroke-width=\"", 2 * vvi_gfx_halo(label));
        vvi_text_add(out, "\"");
    } else {
        color(out, "fill", "fill-opacity", label->color);
    }
    vvi_text_add(out, ">");
    escaped(out, i->text);
    vvi_text_add(out, "</text>\n");
}

static void write_item(document *d, vvi_gfx *gfx, const item *i, const vv_image *image)
{
    if (i->shape && i->shape->kind == VVI_GFX_SEGMENTS)
        write_line(d, gfx, i, image);
    else if (i->shape && i->shape->kind == VVI_GFX_DISCS)
        write_discs(d, gfx, i, image);
    else if (i->shape)
        write_area(d, gfx, i);
    else if (is_seen(i, image, i->spot)) {
        if (i->label.halo.a > 0)
            write_letters(d, gfx, i, true);
        write_letters(d, gfx, i, false);
    }
}

/* Edges of its own colour close the hair-lines that readers leave between areas side by side. */
#define SEAM "0.6"

static void write_facets(vvi_gfx *gfx, const vvi_gfx_facets *all, bool behind)
{
    vvi_text *out = gfx->target.svg;
    size_t n = 0;
    for (size_t i = 0; i < all->n; i++)
        n += all->facet[i].behind == behind;
    if (!n)
        return;
    vvi_text_add(out, "<g stroke-width=\"" SEAM "\" stroke-linejoin=\"round\">\n");
    for (size_t i = 0; i < all->n; i++) {
        const vvi_gfx_facet *f = &all->facet[i];
        if (f->behind != behind)
            continue;
        vvi_text_add(out, "<path");
        color(out, "fill", "fill-opacity", f->color);
        if (!(f->color.a < 1))
            color(out, "stroke", "stroke-opacity", f->color);
        vvi_text_add(out, " d=\"");
        for (size_t k = 0; k < f->n; k++)
            place(out, k ? "L" : "M", f->spot[k]);
        vvi_text_add(out, "Z\"/>\n");
    }
    vvi_text_add(out, "</g>\n");
}

static void write_paper(vvi_gfx *gfx)
{
    vvi_text *out = gfx->target.svg;
    if (!(gfx->target.paper.a > 0))
        return;
    vvi_text_add(out, "<rect width=\"100%\" height=\"100%\"");
    color(out, "fill", "fill-opacity", gfx->target.paper);
    vvi_text_add(out, "/>\n");
}

static void write_head(vvi_gfx *gfx)
{
    vvi_text *out = gfx->target.svg;
    const double mm = 25.4 / (gfx->target.dpi > 0 ? gfx->target.dpi : 96);
    vvi_text_add(out, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" "
                      "xmlns:xlink=\"http://www.w3.org/1999/xlink\" version=\"1.1\"");
    number(out, " width=\"", gfx->target.width * mm);
    number(out, "mm\" height=\"", gfx->target.height * mm);
    vvi_text_printf(out, "mm\" viewBox=\"0 0 %d %d\">\n", gfx->target.width, gfx->target.height);
    if (gfx->target.title) {
        vvi_text_add(out, "<title>");
        escaped(out, gfx->target.title);
        vvi_text_add(out, "</title>\n");
    }
}

static bool is_clear(const vv_image *image)
{
    const size_t n = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < n; i++)
        if (image->rgba[4 * i + 3] > 0)
            return false;
    return true;
}

static vv_status write_picture(vvi_gfx *gfx, const vv_image *image)
{
    vvi_text *out = gfx->target.svg;
    if (!image || is_clear(image))
        return VV_OK;
    vvi_text_printf(out, "<image width=\"%d\" height=\"%d\" xlink:href=\"data:image/png;base64,", image->width,
                    image->height);
    const vv_status st = vvi_gfx_png_base64(out, image, gfx->job);
    vvi_text_add(out, "\"/>\n");
    return st;
}

static vv_status end(vvi_gfx *gfx)
{
    document *d = gfx->own;
    const vv_image *image = gfx->target.image ? gfx->target.image : d->image;
    vv_status st = vvi_gfx_end(d->inner);
    d->inner = NULL;
    if (st != VV_OK)
        return st;
    if ((st = vvi_gfx_facets_finish(&d->facets, gfx)) != VV_OK)
        return st;
    const vv_image *hiding = gfx->target.hiding ? gfx->target.hiding : image;
    write_head(gfx);
    write_paper(gfx);
    write_facets(gfx, &d->facets, true);
    st = write_picture(gfx, image);
    write_facets(gfx, &d->facets, false);
    for (size_t k = 0; k < d->items.n && st == VV_OK; k++) {
        write_item(d, gfx, d->items.item[k], hiding);
        st = vvi_job_poll(gfx->job);
    }
    vvi_text_add(gfx->target.svg, "</svg>\n");
    return st == VV_OK && gfx->target.svg->bad ? vv_fail_memory(gfx->target.svg->n) : st;
}

static void close_document(vvi_gfx *gfx)
{
    document *d = gfx->own;
    if (!d)
        return;
    vvi_gfx_abandon(d->inner);
    vv_image_release(d->image);
    vvi_gfx_list_free(&d->items);
    vvi_gfx_facets_free(&d->facets);
}

const vvi_gfx_backend vvi_gfx_svg = {
    .name = "svg",
    .doc = "a figure: lines, areas and text as vectors, meshes as areas or as an image under them",
    .begin = begin,
    .mesh = mesh,
    .line = line,
    .points = points,
    .polygon = polygon,
    .text = text,
    .end = end,
    .close = close_document,
};
