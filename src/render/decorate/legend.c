/* What colours and opacities mean: transfer functions of volumes, names of labels, or values of surfaces. A list of
 * lines, each as high as it needs; where that is too high, curves go first, then rows from the end. */
#include "core/memory.h"
#include "grid/label_id.h"
#include "model/contents.h"
#include "render/decorate/round_numbers.h"
#include "render/decorate/sheet.h"
#include "scene/lens.h"
#include "scene/resolve.h"
#include "scene/transfer.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <volvis/render.h>

/* Ems */
#define GRAPH 11.0 /* length of a strip of colours */
#define STRIP 0.8  /* its height */
#define CURVE 2.6  /* of opacity, of one volume */
#define CURVES 1.5 /* of each of several */
#define TICK 0.3
#define LINE 1.45 /* from base line to base line */
#define SWATCH 0.84
#define SIDE 1.5       /* from a swatch's left side to its text */
#define AFTER 0.35     /* below a strip's numbers */
#define MOST_WIDE 0.45 /* of the picture */
#define MOST_HIGH 0.7
#define MOST_AREA 0.1
enum { STOPS = 129, MOST_LINES = 96, TICKS = 6 };

typedef enum line_kind { HEADING, ROW, STRIP_OF_COLORS, NOTE } line_kind;

typedef struct vvi_sheet_legend_line {
    line_kind kind;
    vv_color color;            /* of a row */
    vv_classification classes; /* of a strip; what it points to is the scene's */
    const char *map;           /* of a strip: a colour map over lo to hi, in the place of classes; else NULL */
    double lo, hi, curve;      /* of a strip: values; height of the curve above it, ems */
    char text[192];
} line;

static const vv_volume *volume_of(const vv_scene *scene, const vv_actor *actor)
{
    return vvi_volume_named(scene->world, actor->id);
}

static const char *name_of(const vv_scene *scene, const vv_actor *actor)
{
    const vv_volume *volume = volume_of(scene, actor);
    return volume && volume->title ? volume->title : actor->id;
}

/* NULL when there are lines enough: what would follow is counted only. */
static line *add(vvi_sheet_legend *out, size_t *n_more, line_kind kind)
{
    if (out->n == MOST_LINES) {
        *n_more += kind == ROW;
        return NULL;
    }
    line *l = &out->line[out->n++];
    *l = (line){.kind = kind};
    return l;
}

/* "head (HU)" */
static void add_heading(vvi_sheet_legend *out, size_t *n_more, const char *name, const char *unit)
{
    line *l = add(out, n_more, HEADING);
    if (l)
        snprintf(l->text, sizeof l->text, "%.120s%s%.40s%s", name, *unit ? " (" : "", unit, *unit ? ")" : "");
}

/* Surfaces -------------------------------------------------------------------------------------------------------- */

static bool is_solid(double *lo, double *hi, const vv_scene *scene, const vv_actor *actor)
{
    if (scene->renderer->solid)
        return scene->renderer->solid(lo, hi, scene, actor);
    *lo = actor->classes.lo;
    *hi = actor->classes.hi;
    return actor->classes.kind == VV_SEGMENT_THRESHOLD;
}

static void add_solid(vvi_sheet_legend *out, size_t *n_more, const vv_scene *scene, const vv_actor *actor, double lo,
                      double hi)
{
    char from[40], to[40];
    const char *unit = vv_field_get_info(actor->field)->value_unit;
    const bool open = !(hi < actor->statistics->max);
    line *l = add(out, n_more, ROW);
    if (!l)
        return;
    vvi_print_value(from, lo);
    vvi_print_value(to, hi);
    l->color = (vv_color){(double)actor->color[0], (double)actor->color[1], (double)actor->color[2], 1};
    snprintf(l->text, sizeof l->text, "%.60s%s%s%s%s%s%.40s", name_of(scene, actor), open ? " \xe2\x89\xa5 " : ": ",
             from, open ? "" : " to ", open ? "" : to, *unit ? " " : "", unit);
}

/* Labels ---------------------------------------------------------------------------------------------------------- */

static vv_color color_of(const vv_classification *classes, double value)
{
    double rgbk[4];
    vvi_transfer_evaluate(rgbk, classes, value);
    return (vv_color){rgbk[0], rgbk[1], rgbk[2], 1};
}

static vv_color color_on(const line *l, double value)
{
    vv_color color = {0};
    if (!l->map)
        return color_of(&l->classes, value);
    vv_colormap_sample(&color, l->map, (value - l->lo) / (l->hi - l->lo));
    return color;
}

static bool is_named(const vv_collection *names, vv_label_id label)
{
    for (size_t i = 0; i < names->n; i++)
        if (((const vv_label_name *)(const void *)names->entry[i].object)->label == label)
            return true;
    return false;
}

static void add_label(vvi_sheet_legend *out, size_t *n_more, const vv_actor *actor, vv_label_id label, const char *name)
{
    const bool is_unsigned = vvi_label_is_unsigned(vv_field_get_info(actor->field)->type);
    line *l = label ? add(out, n_more, ROW) : NULL;
    char digits[VVI_LABEL_DIGITS];
    double rgbk[4];
    if (!l)
        return;
    vvi_transfer_label(rgbk, &actor->classes, label, is_unsigned);
    l->color = (vv_color){rgbk[0], rgbk[1], rgbk[2], 1};
    if (name && *name)
        snprintf(l->text, sizeof l->text, "%.180s", name);
    else
        snprintf(l->text, sizeof l->text, "label %s", vvi_label_print(digits, label, is_unsigned));
}

/* The row of a label's colour; -1: there is none. */
static bool has_color(const vv_actor *actor, vv_label_id label, double *opacity)
{
    for (size_t i = 0; i < actor->classes.n_labels; i++)
        if (actor->classes.labels[5 * i] == (double)label) {
            *opacity = actor->classes.labels[5 * i + 4];
            return true;
        }
    return false;
}

/* Labels that the data have and nobody named: where the histogram tells one from the next. */
static void add_found(vvi_sheet_legend *out, size_t *n_more, const vv_actor *actor, const vv_collection *names)
{
    const vv_statistics *s = actor->statistics;
    const double width = s->n_bins ? (s->histogram_hi - s->histogram_lo) / s->n_bins : 0;
    for (int i = 0; i < s->n_bins; i++) {
        const double value = s->histogram_lo + (i + 0.5) * width;
        const vv_label_id label = (vv_label_id)(width > 0.5 ? floor(value) : rint(value));
        double opacity = actor->classes.label_opacity;
        if (s->histogram[i] && fabs(value) < 0x1p53 && !is_named(names, label) &&
            (!has_color(actor, label, &opacity) || opacity > 0))
            add_label(out, n_more, actor, label, NULL);
    }
}

static void add_labels(vvi_sheet_legend *out, size_t *n_more, const vv_scene *scene, const vv_actor *actor)
{
    const vv_segmentation *segmentation = (const vv_segmentation *)(const void *)volume_of(scene, actor)->segmentation;
    const vv_collection *names = ((const vv_labels *)(const void *)segmentation->labels)->names;
    add_heading(out, n_more, name_of(scene, actor), "");
    for (size_t i = 0; i < names->n; i++) {
        const vv_label_name *entry = (const vv_label_name *)(const void *)names->entry[i].object;
        add_label(out, n_more, actor, entry->label, entry->name);
    }
    if (actor->statistics->max - actor->statistics->min < actor->statistics->n_bins)
        add_found(out, n_more, actor, names);
}

/* Transfer functions ---------------------------------------------------------------------------------------------- */

/* The values at which something is to be seen, within the data's. */
static void find_range(line *l, const vv_statistics *s)
{
    const vv_classification *k = &l->classes;
    double lo = INFINITY, hi = -INFINITY;
    for (size_t i = 0; l->curve > 0 && i < k->n_opacity; i++) {
        const bool before = i && k->opacity[2 * i - 1] > 0, here = k->opacity[2 * i + 1] > 0;
        const bool after = i + 1 < k->n_opacity && k->opacity[2 * i + 3] > 0;
        if (before || here || after) {
            lo = fmin(lo, k->opacity[2 * i]);
            hi = fmax(hi, k->opacity[2 * i]);
        }
    }
    if (!(l->curve > 0) && k->n_color) {
        lo = k->color[0];
        hi = k->color[4 * (k->n_color - 1)];
    } else if (k->n_color) { /* the last opacity holds for all above: as far as colours change */
        hi = fmax(hi, k->color[4 * (k->n_color - 1)]);
    }
    l->lo = fmax(s->min, fmin(lo, s->max));
    l->hi = fmin(s->max, fmax(hi, l->lo));
    if (!(l->hi > l->lo)) {
        l->lo = s->min;
        l->hi = s->max > s->min ? s->max : s->min + 1;
    }
}

static double value_at(const line *l, int i)
{
    return l->lo + (l->hi - l->lo) * i / (STOPS - 1);
}

/* Of `length`, the same for all volumes. */
static double opacity_at(const line *l, double value, double length)
{
    double rgbk[4];
    vvi_transfer_evaluate(rgbk, &l->classes, value);
    return -expm1(-rgbk[3] * length);
}

static void add_strip(vvi_sheet_legend *out, size_t *n_more, const vvi_sheet *s, const vv_actor *actor, bool several)
{
    const double length = s->scene->actors[0].classes.opacity_length;
    const bool projects = vvi_actor_projects(s->scene, actor);
    if (actor->colors || actor->classes.n_regions) {
        vvi_log(s->job, VV_LOG_WARNING, "decorations", "%s of volumes.%s cannot be shown along one line of values",
                actor->colors ? "colours" : "the two-dimensional transfer function", actor->id);
        return;
    }
    add_heading(out, n_more, name_of(s->scene, actor), vv_field_get_info(actor->field)->value_unit);
    line *l = add(out, n_more, STRIP_OF_COLORS);
    if (!l)
        return;
    if (s->scene->renderer->plane && actor->slices.colors == VV_SLICE_WINDOW) {
        l->map = actor->slices.colormap;
        l->lo = actor->slices.lo;
        l->hi = fmax(actor->slices.hi, nextafter(l->lo, INFINITY));
        return;
    }
    l->classes = actor->classes;
    l->curve = projects ? 0 : several ? CURVES : CURVE;
    find_range(l, actor->statistics);
    for (int i = 0; i < STOPS && !projects; i++)
        out->top = fmax(out->top, opacity_at(l, value_at(l, i), length));
}

/* "opacity of 1 mm, 0 to 0.5": what curves mean. The top is round, and above what they reach. */
static void add_note(vvi_sheet_legend *out, size_t *n_more, const vvi_sheet *s)
{
    char length[64], top[40];
    line *l = out->top > 0 ? add(out, n_more, NOTE) : NULL;
    if (!l)
        return;
    out->top = fmin(1, vvi_nice_above(out->top));
    vvi_print_value(top, out->top);
    vvi_print_length(length, s->scene->actors[0].classes.opacity_length, s->unit);
    snprintf(l->text, sizeof l->text, "opacity of %s, 0 to %s", length, top);
}

/* Meshes ---------------------------------------------------------------------------------------------------------- */

static vv_color color_of_part(const vv_mesh_actor *shape, const vv_mesh_part *part)
{
    const float *c = shape->look.color;
    if (!shape->one_color && part && part->color.a >= 0)
        return (vv_color){part->color.r, part->color.g, part->color.b, 1};
    return (vv_color){(double)c[0], (double)c[1], (double)c[2], 1};
}

static bool is_same(const vv_mesh_part *a, const vv_mesh_part *b)
{
    return *a->name && !strcmp(a->name, b->name) && a->color.r == b->color.r && a->color.g == b->color.g &&
           a->color.b == b->color.b;
}

/* Runs of triangles of one name and colour are one row. */
static void add_parts(vvi_sheet_legend *out, size_t *n_more, const vv_scene *scene, const vv_mesh_actor *shape)
{
    const vv_mesh_info *m = vv_mesh_get_info(shape->mesh);
    const vv_mesh_part *parts = shape->parts ? shape->parts : m->parts;
    add_heading(out, n_more, name_of(scene, &shape->look), "");
    for (size_t i = 0; i < m->n_parts; i++) {
        line *l = i && is_same(&parts[i - 1], &parts[i]) ? NULL : add(out, n_more, ROW);
        if (!l)
            continue;
        l->color = color_of_part(shape, &parts[i]);
        if (*parts[i].name)
            snprintf(l->text, sizeof l->text, "%s", parts[i].name);
        else
            snprintf(l->text, sizeof l->text, "part %zu", i + 1);
    }
}

/* One colour, those of parts, or colours by values; those of vertices speak for themselves. */
static void add_shape(vvi_sheet_legend *out, size_t *n_more, const vv_scene *scene, const vv_mesh_actor *shape)
{
    const vv_mesh_info *m = vv_mesh_get_info(shape->mesh);
    const vv_classification *k = &shape->look.classes;
    if (shape->colors && shape->look.paint.nearest) { /* labels do not lie along a line */
        char name[128];
        snprintf(name, sizeof name, "%.90s: colours of labels", name_of(scene, &shape->look));
        add_heading(out, n_more, name, "");
    } else if (shape->colors && k->n_color) {
        char name[128];
        snprintf(name, sizeof name, "%.60s%s%.60s", name_of(scene, &shape->look), *m->value_name ? ": " : "",
                 m->value_name);
        add_heading(out, n_more, name, m->value_unit);
        line *l = add(out, n_more, STRIP_OF_COLORS);
        if (!l)
            return;
        l->classes = *k;
        l->classes.kind = VV_SEGMENT_TRANSFER;
        l->classes.opacity_length = 1;
        l->lo = k->color[0];
        l->hi = k->color[4 * (k->n_color - 1)];
        l->hi = l->hi > l->lo ? l->hi : l->lo + 1;
    } else if (!shape->one_color && !m->colors && m->n_parts > 1) {
        add_parts(out, n_more, scene, shape);
    } else if (shape->one_color || !m->colors) {
        line *l = add(out, n_more, ROW);
        if (!l)
            return;
        l->color = color_of_part(shape, m->n_parts ? m->parts : NULL);
        snprintf(l->text, sizeof l->text, "%.180s", name_of(scene, &shape->look));
    }
}

/* All lines ------------------------------------------------------------------------------------------------------- */

static void list(vvi_sheet_legend *out, size_t *n_more, const vvi_sheet *s)
{
    const vv_scene *scene = s->scene;
    for (size_t i = 0; i < scene->n_actors; i++) {
        const vv_actor *actor = &scene->actors[i];
        double lo, hi;
        if (is_solid(&lo, &hi, scene, actor))
            add_solid(out, n_more, scene, actor, lo, hi);
        else if (actor->classes.kind == VV_SEGMENT_LABELS)
            add_labels(out, n_more, scene, actor);
        else
            add_strip(out, n_more, s, actor, scene->n_actors > 1);
    }
    for (size_t i = 0; i < scene->n_mesh_actors; i++)
        add_shape(out, n_more, scene, &scene->mesh_actors[i]);
    add_note(out, n_more, s);
}

static double height_of(const vvi_sheet *s, const line *l)
{
    const double small = vvi_sheet_small(s);
    if (l->kind == STRIP_OF_COLORS)
        return (l->curve + STRIP + TICK + AFTER) * s->em + small;
    return LINE * (l->kind == HEADING ? s->em : small);
}

static double width_of(const vvi_sheet *s, const line *l)
{
    if (l->kind == STRIP_OF_COLORS)
        return GRAPH * s->em;
    return (l->kind == ROW ? SIDE * s->em : 0) +
           vvi_sheet_length(s, l->text, l->kind == HEADING ? s->em : vvi_sheet_small(s));
}

/* Too high: opacity goes, then rows from the end, which are counted. False: there is nothing to leave out. */
static bool reduce(vvi_sheet_legend *out, size_t *n_more)
{
    bool any = false;
    for (size_t i = 0; i < out->n; i++) {
        any = any || out->line[i].curve > 0;
        out->line[i].curve = 0;
    }
    if (any) {
        out->n -= out->line[out->n - 1].kind == NOTE;
        return true;
    }
    if (out->n && out->line[out->n - 1].kind == NOTE)
        out->n--;
    if (!out->n)
        return false;
    *n_more += out->line[--out->n].kind == ROW;
    while (out->n && out->line[out->n - 1].kind == HEADING) /* says nothing by itself */
        out->n--;
    return out->n > 0;
}

static void say_more(vvi_sheet_legend *out, size_t n_more)
{
    if (!n_more || out->n == MOST_LINES)
        return;
    line *l = &out->line[out->n++];
    *l = (line){.kind = NOTE};
    snprintf(l->text, sizeof l->text, "and %zu more", n_more);
}

static void measure(vvi_wish *wish, const vvi_sheet_legend *legend, const vvi_sheet *s)
{
    const double most = fmax(MOST_WIDE * s->width, fmin(GRAPH * s->em, s->width - 2 * s->margin));
    wish->width = wish->height = 0;
    for (size_t i = 0; i < legend->n; i++) {
        line *l = &legend->line[i];
        const double side = l->kind == ROW ? SIDE * s->em : 0;
        if (l->kind != STRIP_OF_COLORS)
            vvi_sheet_shorten(s, l->text, sizeof l->text, l->kind == HEADING ? s->em : vvi_sheet_small(s), most - side,
                              false);
        wish->width = fmax(wish->width, width_of(s, l));
        wish->height += height_of(s, l);
    }
}

/* The first that fits, of what is left by and by. */
static void fit(vvi_sheet_legend *out, size_t n_more, vvi_sheet *s)
{
    const double most = fmax(MOST_HIGH * s->height, fmin(5 * s->em, s->height));
    do {
        const size_t n = out->n;
        vvi_wish wish = {.right = true, .cost = vvi_sheet_hides, .user = s};
        say_more(out, n_more);
        measure(&wish, out, s);
        out->there = wish.height <= most && wish.width * wish.height <= MOST_AREA * s->width * s->height &&
                     vvi_layout_place(&out->box, &s->layout, &wish);
        if (out->there)
            return;
        out->n = n;
    } while (reduce(out, &n_more));
    vvi_sheet_left_out(s, "the legend");
}

vv_status vvi_sheet_legend_place(vvi_sheet_legend *out, vvi_sheet *s)
{
    const size_t bytes = (MOST_LINES + 1) * sizeof *out->line;
    size_t n_more = 0;
    *out = (vvi_sheet_legend){.line = vvi_alloc_zeroed(s->job, bytes, VVI_MEM_SCRATCH)};
    if (!out->line)
        return vv_fail_memory(bytes);
    list(out, &n_more, s);
    if (out->n)
        fit(out, n_more, s);
    out->plate = out->there && (s->clear || vvi_sheet_hides(s, out->box) > 0);
    return VV_OK;
}

const char *vvi_sheet_legend_text(const vvi_sheet_legend *legend, size_t i)
{
    return legend->there && i < legend->n ? legend->line[i].text : NULL;
}

void vvi_sheet_legend_finish(vvi_sheet_legend *legend)
{
    vvi_free(legend->line);
    legend->line = NULL;
}

/* Drawing --------------------------------------------------------------------------------------------------------- */

static vv_status draw_swatch(const vvi_sheet *s, double x0, double y0, double x1, double y1, const vvi_gfx_fill *fill)
{
    const double edge = 0.7 * s->line;
    const vv_status st = vvi_gfx_rectangle(s->gfx, x0 - edge, y0 - edge, x1 + edge, y1 + edge,
                                           &(vvi_gfx_fill){.color = vvi_faded(s->ink, 0.8)});
    return st == VV_OK ? vvi_gfx_rectangle(s->gfx, x0, y0, x1, y1, fill) : st;
}

static vv_status draw_words(const vvi_sheet *s, const line *l, double x, double y)
{
    const double size = l->kind == HEADING ? s->em : vvi_sheet_small(s), middle = y + LINE * size / 2;
    const double half = SWATCH * s->em / 2;
    vv_status st = VV_OK;
    if (l->kind == ROW) {
        st = draw_swatch(s, x, middle - half, x + 2 * half, middle + half, &(vvi_gfx_fill){.color = l->color});
        x += SIDE * s->em;
    }
    return st == VV_OK ? vvi_sheet_text(s, x, middle, size, VVI_GFX_BEGIN, VVI_GFX_CENTRE, l->text) : st;
}

/* A strip on the picture. */
typedef struct graph {
    const vvi_sheet *sheet;
    const line *line;
    double left, right, top, base, bottom; /* top and base of the curve */
    double full;                           /* opacity at its top */
} graph;

static double x_at(const graph *g, double value)
{
    return g->left + (g->right - g->left) * (value - g->line->lo) / (g->line->hi - g->line->lo);
}

static vv_status draw_curve(const graph *g)
{
    const vvi_sheet *s = g->sheet;
    const double length = s->scene->actors[0].classes.opacity_length;
    vv_vec3 points[STOPS + 2];
    for (int i = 0; i < STOPS; i++) {
        const double value = value_at(g->line, i), share = fmin(opacity_at(g->line, value, length) / g->full, 1);
        points[i] = vvi_vec(x_at(g, value), g->base - (g->base - g->top) * share, 0);
    }
    points[STOPS] = vvi_vec(g->right, g->base, 0);
    points[STOPS + 1] = vvi_vec(g->left, g->base, 0);
    vv_status st = vvi_gfx_rectangle(s->gfx, g->left, g->top, g->right, g->base,
                                     &(vvi_gfx_fill){.color = vvi_faded(s->paper, 0.4)});
    if (st == VV_OK)
        st = vvi_gfx_polygon(s->gfx, points, STOPS + 2, &(vvi_gfx_fill){.color = vvi_faded(s->ink, 0.3)});
    const vvi_gfx_stroke stroke = {.color = s->ink, .width = s->line};
    const vvi_gfx_stroke thin = {.color = vvi_faded(s->ink, 0.45), .width = 0.7 * s->line};
    const vv_vec3 frame[4] = {
        {g->left, g->base, 0}, {g->left, g->top, 0}, {g->right, g->top, 0}, {g->right, g->base, 0}};
    if (st == VV_OK)
        st = vvi_gfx_line(s->gfx, frame, 4, VVI_GFX_STRIP, &thin);
    return st == VV_OK ? vvi_gfx_line(s->gfx, points, STOPS, VVI_GFX_STRIP, &stroke) : st;
}

static double width_at(const graph *g, const vvi_ticks *ticks, int i)
{
    char text[40];
    vvi_print_tick(text, vvi_tick_at(ticks, i), ticks->step);
    return vvi_sheet_length(g->sheet, text, vvi_sheet_small(g->sheet));
}

/* As many as leave room between their numbers. */
static vvi_ticks choose_ticks(const graph *g)
{
    const double room = 0.8 * vvi_sheet_small(g->sheet);
    vvi_ticks ticks = {0};
    for (int most = TICKS; most > 0; most--) {
        bool fits = true;
        ticks = vvi_nice_ticks(g->line->lo, g->line->hi, most);
        for (int i = 1; i < ticks.n; i++)
            fits = fits && x_at(g, vvi_tick_at(&ticks, i)) - x_at(g, vvi_tick_at(&ticks, i - 1)) >
                               (width_at(g, &ticks, i - 1) + width_at(g, &ticks, i)) / 2 + room;
        if (ticks.n && fits)
            break;
    }
    return ticks;
}

/* Numbers at its ends may not reach beyond it. */
static void narrow(graph *g, const vvi_ticks *ticks)
{
    if (!ticks->n)
        return;
    const int last = ticks->n - 1;
    const double left = g->left, right = g->right;
    g->left += fmax(0, width_at(g, ticks, 0) / 2 - (x_at(g, vvi_tick_at(ticks, 0)) - left));
    g->right -= fmax(0, width_at(g, ticks, last) / 2 - (right - x_at(g, vvi_tick_at(ticks, last))));
}

static vv_status draw_ticks(const graph *g, const vvi_ticks *ticks)
{
    const vvi_sheet *s = g->sheet;
    vv_status st = VV_OK;
    for (int i = 0; i < ticks->n && st == VV_OK; i++) {
        char text[40];
        const double value = vvi_tick_at(ticks, i), x = x_at(g, value);
        const vv_vec3 mark[2] = {{x, g->bottom, 0}, {x, g->bottom + TICK * s->em, 0}};
        vvi_print_tick(text, value, ticks->step);
        st = vvi_gfx_line(s->gfx, mark, 2, VVI_GFX_STRIP, &(vvi_gfx_stroke){.color = s->ink, .width = s->line});
        if (st == VV_OK)
            st = vvi_sheet_text(s, x, g->bottom + (TICK + 0.15) * s->em, vvi_sheet_small(s), VVI_GFX_MIDDLE,
                                VVI_GFX_TOP, text);
    }
    return st;
}

static vv_status draw_strip(const vvi_sheet_legend *legend, const vvi_sheet *s, const line *l, double x, double y)
{
    graph g = {.sheet = s, .line = l, .left = x, .right = x + GRAPH * s->em, .top = y, .full = legend->top};
    vvi_gfx_stop stops[STOPS];
    vv_status st = VV_OK;
    g.base = y + l->curve * s->em;
    g.bottom = g.base + STRIP * s->em;
    vvi_ticks ticks = choose_ticks(&g);
    narrow(&g, &ticks);
    ticks = choose_ticks(&g);
    for (int i = 0; i < STOPS; i++)
        stops[i] = (vvi_gfx_stop){(double)i / (STOPS - 1), color_on(l, value_at(l, i))};
    if (l->curve > 0 && g.full > 0)
        st = draw_curve(&g);
    if (st == VV_OK)
        st = draw_swatch(
            s, g.left, g.base + s->line, g.right, g.bottom,
            &(vvi_gfx_fill){
                .stops = stops, .n_stops = STOPS, .from = {g.left, g.bottom, 0}, .to = {g.right, g.bottom, 0}});
    return st == VV_OK ? draw_ticks(&g, &ticks) : st;
}

vv_status vvi_sheet_legend_draw(const vvi_sheet_legend *legend, const vvi_sheet *s)
{
    const vvi_box *b = &legend->box;
    const double pad = legend->plate ? s->layout.gap : 0;
    double y = b->y0;
    vv_status st = VV_OK;
    if (!legend->there)
        return VV_OK;
    if (legend->plate)
        st = vvi_gfx_rectangle(s->gfx, b->x0 - pad, b->y0 - pad, b->x1 + pad, b->y1 + pad,
                               &(vvi_gfx_fill){.color = s->paper});
    for (size_t i = 0; i < legend->n && st == VV_OK; i++) {
        const line *l = &legend->line[i];
        st = l->kind == STRIP_OF_COLORS ? draw_strip(legend, s, l, b->x0, y) : draw_words(s, l, b->x0, y);
        y += height_of(s, l);
    }
    return st;
}
