/* What colours and opacities mean: the transfer function of the first volume, the names of its labels, or the values of
 * surfaces. At the right edge, halfway up. */
#include "core/memory.h"
#include "render/common/lens.h"
#include "render/common/transfer.h"
#include "render/decorate/nice.h"
#include "render/decorate/sheet.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define BAR_EM 0.95  /* width of the strip of colour */
#define CURVE_EM 3.2 /* width of opacity 1 */
#define HEIGHT_EM 15.0
#define ROW_EM 1.5 /* of labels and surfaces */
#define SMALL 0.85 /* of an em: numbers */
enum { STOPS = 129 };

static const vv_volume *volume_of(const vv_scene *scene, const vv_actor *actor)
{
    return (const vv_volume *)(const void *)vv_collection_find(scene->world->volumes, actor->id);
}

static const char *name_of(const vv_scene *scene, const vv_actor *actor)
{
    const vv_volume *volume = volume_of(scene, actor);
    return volume && volume->title ? volume->title : actor->id;
}

/* Rows of a colour and a text ------------------------------------------------------------------------------------- */

typedef struct row {
    vv_color color;
    char text[192];
} row;

static vv_status draw_rows(const vvi_sheet *s, const row *rows, size_t n, const char *heading, size_t n_more)
{
    char more[48];
    double widest = vvi_sheet_length(s, heading, s->em);
    for (size_t i = 0; i < n; i++)
        widest = fmax(widest, 1.5 * s->em + vvi_sheet_length(s, rows[i].text, SMALL * s->em));
    const double left = s->width - s->margin - widest, step = ROW_EM * s->em;
    const double lines = (double)n + (*heading != 0) + (n_more != 0);
    const bool few = lines * step < 0.2 * s->height; /* the corner is free of data more often than the side */
    double y = few ? s->margin : fmax((s->height - lines * step) / 2, s->margin);
    vv_status st = VV_OK;
    if (*heading) {
        st = vvi_sheet_text(s, left, y + step / 2, s->em, VVI_GFX_BEGIN, VVI_GFX_CENTRE, heading);
        y += step;
    }
    for (size_t i = 0; i < n && st == VV_OK; i++, y += step) {
        const double half = 0.42 * s->em, middle = y + step / 2, edge = 0.7 * s->line;
        st = vvi_gfx_rectangle(s->gfx, left - edge, middle - half - edge, left + 2 * half + edge, middle + half + edge,
                               &(vvi_gfx_fill){.color = vvi_faded(s->ink, 0.8)});
        if (st == VV_OK)
            st = vvi_gfx_rectangle(s->gfx, left, middle - half, left + 2 * half, middle + half,
                                   &(vvi_gfx_fill){.color = rows[i].color});
        if (st == VV_OK)
            st = vvi_sheet_text(s, left + 1.5 * s->em, middle, SMALL * s->em, VVI_GFX_BEGIN, VVI_GFX_CENTRE,
                                rows[i].text);
    }
    if (n_more && st == VV_OK) {
        snprintf(more, sizeof more, "and %zu more", n_more);
        st = vvi_sheet_text(s, left + 1.5 * s->em, y + step / 2, SMALL * s->em, VVI_GFX_BEGIN, VVI_GFX_CENTRE, more);
    }
    return st;
}

/* Rows that fit between title and scale bar. */
static size_t rows_that_fit(const vvi_sheet *s)
{
    const double room = s->height - 2 * s->margin - 6 * s->em;
    return room > 2 * ROW_EM * s->em ? (size_t)(room / (ROW_EM * s->em)) : 2;
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

static void print_value(char out[40], double value)
{
    vvi_print_tick(out, value, fmax(vvi_nice_below(fabs(value)) * 1e-3, 1e-5 * fabs(value)));
    if (strchr(out, '.')) /* 45.000 */
        for (size_t n = strlen(out); n && (out[n - 1] == '0' || out[n - 1] == '.'); n--) {
            const bool point = out[n - 1] == '.';
            out[n - 1] = 0;
            if (point)
                break;
        }
}

static void describe_solid(row *out, const vv_scene *scene, const vv_actor *actor, double lo, double hi)
{
    char from[40], to[40];
    const char *unit = vv_field_get_info(actor->field)->value_unit;
    const bool open = !(hi < actor->statistics->max);
    print_value(from, lo);
    print_value(to, hi);
    out->color = (vv_color){(double)actor->color[0], (double)actor->color[1], (double)actor->color[2], 1};
    snprintf(out->text, sizeof out->text, "%.40s %s %s%s%s%s%s", name_of(scene, actor), open ? "\xe2\x89\xa5" : ":",
             from, open ? "" : "\xe2\x80\x93", open ? "" : to, *unit ? " " : "", unit);
}

static vv_status draw_solids(bool *any_out, const vvi_sheet *s)
{
    row rows[32];
    size_t n = 0;
    for (size_t i = 0; i < s->scene->n_actors && n < 32; i++) {
        double lo, hi;
        if (is_solid(&lo, &hi, s->scene, &s->scene->actors[i]))
            describe_solid(&rows[n++], s->scene, &s->scene->actors[i], lo, hi);
    }
    *any_out = n > 0;
    return n ? draw_rows(s, rows, n, "", 0) : VV_OK;
}

/* Labels ---------------------------------------------------------------------------------------------------------- */

static vv_color color_of(const vv_actor *actor, double value)
{
    double rgbk[4];
    vvi_transfer_evaluate(rgbk, &actor->classes, value);
    return (vv_color){rgbk[0], rgbk[1], rgbk[2], 1};
}

static bool is_named(const vv_collection *names, int64_t label)
{
    for (size_t i = 0; i < names->n; i++)
        if (((const vv_label_name *)(const void *)names->entry[i].object)->label == label)
            return true;
    return false;
}

/* Labels with a name, then those that have a colour only. */
static size_t list_labels(row *rows, size_t most, const vv_actor *actor, const vv_collection *names)
{
    size_t n = 0;
    for (size_t i = 0; i < names->n; i++) {
        const vv_label_name *entry = (const vv_label_name *)(const void *)names->entry[i].object;
        if (entry->label != 0 && n++ < most) {
            rows[n - 1].color = color_of(actor, (double)entry->label);
            snprintf(rows[n - 1].text, sizeof rows->text, "%.60s", entry->name ? entry->name : "");
        }
    }
    for (size_t i = 0; i < actor->classes.n_labels; i++) {
        const double *label = actor->classes.labels + 5 * i;
        if (label[0] != 0 && label[4] > 0 && !is_named(names, (int64_t)label[0]) && n++ < most) {
            rows[n - 1].color = color_of(actor, label[0]);
            snprintf(rows[n - 1].text, sizeof rows->text, "label %lld", (long long)label[0]);
        }
    }
    return n;
}

static vv_status draw_labels(const vvi_sheet *s, const vv_actor *actor)
{
    const vv_segmentation *segmentation =
        (const vv_segmentation *)(const void *)volume_of(s->scene, actor)->segmentation;
    const vv_collection *names = ((const vv_labels *)(const void *)segmentation->labels)->names;
    const size_t fit = rows_that_fit(s);
    row *rows = vvi_alloc(s->job, fit * sizeof *rows, VVI_MEM_SCRATCH);
    if (!rows)
        return vv_fail_memory(fit * sizeof *rows);
    const size_t n = list_labels(rows, fit, actor, names), shown = n > fit ? fit - 2 : n;
    if (!n)
        vvi_log(s->job, VV_LOG_WARNING, "decorations",
                "no legend: no label has a name or a colour that was chosen (volumes.%s.segmentation.labels.names)",
                actor->id);
    const vv_status st = n ? draw_rows(s, rows, shown, name_of(s->scene, actor), n - shown) : VV_OK;
    vvi_free(rows);
    return st;
}

/* Transfer functions ---------------------------------------------------------------------------------------------- */

typedef struct scale {
    const vvi_sheet *sheet;
    const vv_actor *actor;
    double lo, hi;      /* values */
    double left, right; /* of the strip of colours */
    double top, bottom;
    bool curve;
} scale;

/* The values at which something is to be seen, within the data's. */
static void find_range(scale *c)
{
    const vv_classification *k = &c->actor->classes;
    const vv_statistics *s = c->actor->statistics;
    double lo = INFINITY, hi = -INFINITY;
    for (size_t i = 0; c->curve && i < k->n_opacity; i++) {
        const bool before = i && k->opacity[2 * i - 1] > 0, here = k->opacity[2 * i + 1] > 0;
        const bool after = i + 1 < k->n_opacity && k->opacity[2 * i + 3] > 0;
        if (before || here || after) {
            lo = fmin(lo, k->opacity[2 * i]);
            hi = fmax(hi, k->opacity[2 * i]);
        }
    }
    if (!c->curve && k->n_color) {
        lo = k->color[0];
        hi = k->color[4 * (k->n_color - 1)];
    } else if (k->n_color) { /* the last opacity holds for all above: as far as colours change */
        hi = fmax(hi, k->color[4 * (k->n_color - 1)]);
    }
    c->lo = fmax(s->min, fmin(lo, s->max));
    c->hi = fmin(s->max, fmax(hi, c->lo));
    if (!(c->hi > c->lo)) {
        c->lo = s->min;
        c->hi = s->max > s->min ? s->max : s->min + 1;
    }
}

static double value_at(const scale *c, int i)
{
    return c->lo + (c->hi - c->lo) * i / (STOPS - 1);
}

static double opacity_at(const scale *c, double value)
{
    double rgbk[4];
    vvi_transfer_evaluate(rgbk, &c->actor->classes, value);
    return -expm1(-rgbk[3] * c->actor->classes.opacity_length);
}

static vv_status draw_strip(const scale *c)
{
    const vvi_sheet *s = c->sheet;
    const double edge = 0.7 * s->line;
    vvi_gfx_stop stops[STOPS];
    for (int i = 0; i < STOPS; i++)
        stops[i] = (vvi_gfx_stop){(double)i / (STOPS - 1), color_of(c->actor, value_at(c, i))};
    const vvi_gfx_fill fill = {
        .stops = stops, .n_stops = STOPS, .from = {c->left, c->bottom, 0}, .to = {c->left, c->top, 0}};
    const vv_status st = vvi_gfx_rectangle(s->gfx, c->left - edge, c->top - edge, c->right + edge, c->bottom + edge,
                                           &(vvi_gfx_fill){.color = vvi_faded(s->ink, 0.8)});
    return st == VV_OK ? vvi_gfx_rectangle(s->gfx, c->left, c->top, c->right, c->bottom, &fill) : st;
}

/* To the left of the strip: how far it reaches is the opacity. */
static vv_status draw_curve(const scale *c)
{
    const vvi_sheet *s = c->sheet;
    const double base = c->left - 0.35 * s->em, width = CURVE_EM * s->em;
    vv_vec3 points[STOPS + 2];
    for (int i = 0; i < STOPS; i++) {
        const double y = c->bottom + (c->top - c->bottom) * i / (STOPS - 1);
        points[i] = vvi_vec(base - width * opacity_at(c, value_at(c, i)), y, 0);
    }
    points[STOPS] = vvi_vec(base, c->top, 0);
    points[STOPS + 1] = vvi_vec(base, c->bottom, 0);
    const vv_vec3 frame[4] = {
        {base, c->bottom, 0}, {base, c->top, 0}, {base - width, c->top, 0}, {base - width, c->bottom, 0}};
    vv_status st = vvi_gfx_polygon(s->gfx, frame, 4, &(vvi_gfx_fill){.color = vvi_faded(s->paper, 0.35)});
    if (st == VV_OK)
        st = vvi_gfx_polygon(s->gfx, points, STOPS + 2, &(vvi_gfx_fill){.color = vvi_faded(s->ink, 0.25)});
    const vvi_gfx_stroke line = {.color = s->ink, .width = s->line};
    const vvi_gfx_stroke thin = {.color = vvi_faded(s->ink, 0.5), .width = 0.6 * s->line};
    if (st == VV_OK)
        st = vvi_gfx_line(s->gfx, frame, 4, VVI_GFX_LOOP, &thin);
    return st == VV_OK ? vvi_gfx_line(s->gfx, points, STOPS, VVI_GFX_STRIP, &line) : st;
}

static vv_status draw_ticks(const scale *c, const vvi_ticks *ticks)
{
    const vvi_sheet *s = c->sheet;
    vv_status st = VV_OK;
    for (int i = 0; i < ticks->n && st == VV_OK; i++) {
        char text[40];
        const double value = vvi_tick_at(ticks, i);
        const double y = c->bottom + (c->top - c->bottom) * (value - c->lo) / (c->hi - c->lo);
        const vv_vec3 mark[2] = {{c->right, y, 0}, {c->right + 0.35 * s->em, y, 0}};
        vvi_print_tick(text, value, ticks->step);
        if ((st = vvi_sheet_line(s, mark, 2, VVI_GFX_STRIP, s->line)) == VV_OK)
            st = vvi_sheet_text(s, c->right + 0.65 * s->em, y, SMALL * s->em, VVI_GFX_BEGIN, VVI_GFX_CENTRE, text);
    }
    return st;
}

/* "head (HU)" above, and below the curve what opacity is for. */
static vv_status draw_words(const scale *c)
{
    const vvi_sheet *s = c->sheet;
    const vv_field_info *info = vv_field_get_info(c->actor->field);
    char heading[128], length[64], words[96];
    snprintf(heading, sizeof heading, "%.60s%s%s%s", name_of(s->scene, c->actor), *info->value_unit ? " (" : "",
             info->value_unit, *info->value_unit ? ")" : "");
    vv_status st =
        vvi_sheet_text(s, s->width - s->margin, c->top - 1.0 * s->em, s->em, VVI_GFX_END, VVI_GFX_BASE_LINE, heading);
    if (st != VV_OK || !c->curve)
        return st;
    const double base = c->left - 0.35 * s->em, width = CURVE_EM * s->em, y = c->bottom + 0.95 * SMALL * s->em;
    vvi_print_length(length, c->actor->classes.opacity_length, s->unit);
    snprintf(words, sizeof words, "opacity of %s", length);
    if ((st = vvi_sheet_text(s, base - width, y, 0.75 * s->em, VVI_GFX_MIDDLE, VVI_GFX_BASE_LINE, "1")) == VV_OK &&
        (st = vvi_sheet_text(s, base, y, 0.75 * s->em, VVI_GFX_MIDDLE, VVI_GFX_BASE_LINE, "0")) == VV_OK)
        st = vvi_sheet_text(s, base - width, y + 1.15 * SMALL * s->em, 0.75 * s->em, VVI_GFX_BEGIN, VVI_GFX_BASE_LINE,
                            words);
    return st;
}

static vv_status draw_transfer(const vvi_sheet *s, const vv_actor *actor)
{
    const vv_object *params = s->scene->params;
    const bool projects =
        params && s->scene->renderer->projects && s->scene->renderer->projects(params) != VV_PROJECTS_NOTHING;
    scale c = {.sheet = s, .actor = actor, .curve = !projects};
    const double height = fmin(HEIGHT_EM * s->em, 0.5 * s->height);
    double widest = 0;
    find_range(&c);
    const vvi_ticks ticks = vvi_nice_ticks(c.lo, c.hi, (int)fmax(2, height / (2 * s->em)));
    for (int i = 0; i < ticks.n; i++) {
        char text[40];
        vvi_print_tick(text, vvi_tick_at(&ticks, i), ticks.step);
        widest = fmax(widest, vvi_sheet_length(s, text, SMALL * s->em));
    }
    c.right = s->width - s->margin - widest - 0.65 * s->em;
    c.left = c.right - BAR_EM * s->em;
    c.top = (s->height - height) / 2;
    c.bottom = c.top + height;
    vv_status st = VV_OK;
    if (c.curve)
        st = draw_curve(&c);
    if (st == VV_OK)
        st = draw_strip(&c);
    if (st == VV_OK)
        st = draw_ticks(&c, &ticks);
    return st == VV_OK ? draw_words(&c) : st;
}

vv_status vvi_sheet_legend(const vvi_sheet *s)
{
    bool any = false;
    if (!s->scene->n_actors)
        return VV_OK;
    const vv_actor *actor = &s->scene->actors[0];
    const vv_status st = draw_solids(&any, s);
    if (st != VV_OK || any)
        return st;
    if (actor->classes.kind == VV_SEGMENT_LABELS)
        return draw_labels(s, actor);
    if (actor->colors || actor->classes.n_regions) {
        vvi_log(s->job, VV_LOG_WARNING, "decorations",
                "no legend: %s of volumes.%s cannot be shown along one line of values",
                actor->colors ? "colours" : "the two-dimensional transfer function", actor->id);
        return VV_OK;
    }
    return draw_transfer(s, actor);
}
