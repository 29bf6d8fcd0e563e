/* Figures then and now: which of them changed, for people, in a table and in JSON. */
#include "core/units.h"
#include "measure.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define SAME 1e-9 /* what another processor may make of the last digits */

static const vv_measured_figure *figure_nth(const vv_collection *figures, size_t i)
{
    return (const vv_measured_figure *)(const void *)figures->entry[i].object;
}

static const vv_measured_figure *figure_of(const vv_collection *figures, const char *name)
{
    for (size_t i = 0; i < figures->n; i++)
        if (strcmp(figure_nth(figures, i)->name ? figure_nth(figures, i)->name : "", name) == 0)
            return figure_nth(figures, i);
    return NULL;
}

static double value_of(const vv_measured_figure *f)
{
    return f && vv_object_is_set(&f->base, "value") ? f->value : NAN;
}

static double error_of(const vv_measured_figure *f)
{
    return f && vv_object_is_set(&f->base, "error") ? f->error : NAN;
}

static bool same(const vv_measured_figure *a, const vv_measured_figure *b)
{
    const double x = value_of(a), y = value_of(b);
    if (!a || !b || isnan(x) != isnan(y) || strcmp(a->unit ? a->unit : "", b->unit ? b->unit : "") != 0)
        return false;
    return isnan(x) || fabs(x - y) <= SAME * fmax(fmax(fabs(x), fabs(y)), fmax(0, error_of(b)));
}

static void print_figure(char out[VVI_FIGURE_TEXT], const vv_measured_figure *f)
{
    vvi_figure_print(out, value_of(f), error_of(f), 0, f->unit ? f->unit : "");
}

/* Of many figures a few are told; the others only when they change. */
static bool is_told(const char *name)
{
    static const char *const quiet[] = {"percentile_", "label_"};
    for (size_t i = 0; i < sizeof quiet / sizeof *quiet; i++)
        if (strncmp(name, quiet[i], strlen(quiet[i])) == 0)
            return false;
    return true;
}

static void put_row(vvi_text *out, const char *id, const vv_measured_figure *now, const vv_measured_figure *was)
{
    char number[3][32] = {"", "", ""};
    const double v[3] = {value_of(now), error_of(now), value_of(was)};
    for (int i = 0; i < 3; i++)
        if (isfinite(v[i]))
            vvi_print_number(number[i], v[i]);
    vvi_text_printf(out, "%s,%s,%s,%s,%s,%s,%s\n", id, now->name, number[0], number[1], now->unit ? now->unit : "",
                    number[2],
                    !was             ? "new"
                    : same(was, now) ? "no"
                                     : "yes");
}

/* The figure of the same place along another axis, when both are as they were; NULL: it is not. */
static const vv_measured_figure *along(const vv_collection *now, const vv_collection *then, const char *base, char axis)
{
    char name[208];
    snprintf(name, sizeof name, "%s_%c", base, axis);
    const vv_measured_figure *f = figure_of(now, name), *was = figure_of(then, name);
    return then->n && !same(was, f) ? NULL : f;
}

/* Three numbers of a place as one line, with `name`_x; false: they are told one by one. */
static bool put_place(vvi_text *out, const char *name, const vv_collection *now, const vv_collection *then)
{
    char text[3][VVI_FIGURE_TEXT], base[192];
    const size_t n = strlen(name);
    if (n < 3 || n >= sizeof base || name[n - 2] != '_' || !strchr("xyz", name[n - 1]) || !is_told(name))
        return false;
    snprintf(base, sizeof base, "%.*s", (int)(n - 2), name);
    for (int a = 0; a < 3; a++) {
        const vv_measured_figure *f = along(now, then, base, "xyz"[a]);
        if (!f)
            return false;
        vvi_figure_print(text[a], value_of(f), error_of(f), 0, "");
    }
    if (name[n - 1] != 'x')
        return true;
    const char *unit = figure_of(now, name)->unit;
    vvi_text_printf(out, "  %-16s %s, %s, %s %s\n", base, text[0], text[1], text[2], unit ? unit : "");
    return true;
}

/* compared: there were figures before. */
static void put_line(vvi_text *out, const vv_measured_figure *now, const vv_measured_figure *was, bool compared)
{
    char text[VVI_FIGURE_TEXT], before[VVI_FIGURE_TEXT] = "";
    print_figure(text, now);
    const bool changed = was && !same(was, now), is_new = compared && !was;
    if (changed)
        print_figure(before, was);
    if (changed || is_new || is_told(now->name))
        vvi_text_printf(out, "  %-16s %s%s%s\n", now->name, text,
                        changed  ? "; it was "
                        : is_new ? "; new"
                                 : "",
                        before);
}

static void put_gone(vvi_text *out, bool csv, const char *id, const vv_measured_figure *was)
{
    char text[VVI_FIGURE_TEXT], number[32] = "";
    print_figure(text, was);
    if (isfinite(value_of(was)))
        vvi_print_number(number, value_of(was));
    if (csv)
        vvi_text_printf(out, "%s,%s,,,%s,%s,gone\n", id, was->name, was->unit ? was->unit : "", number);
    else
        vvi_text_printf(out, "  %-16s gone; it was %s\n", was->name, text);
}

static void put_change_json(vvi_result *json, const char *name, const vv_measured_figure *was,
                            const vv_measured_figure *now)
{
    vvi_result_open(json, NULL, '{');
    vvi_result_string(json, "name", name);
    vvi_result_number(json, "was", value_of(was));
    vvi_result_number(json, "is", value_of(now));
    vvi_result_close(json, '}');
}

size_t cli_changes_json(vvi_result *json, const vv_collection *then, const vv_collection *now)
{
    size_t n = 0;
    vvi_result_open(json, "changes", '[');
    for (size_t i = 0; i < now->n && then->n; i++) {
        const vv_measured_figure *f = figure_nth(now, i), *was = figure_of(then, f->name);
        if (same(was, f))
            continue;
        n++;
        put_change_json(json, f->name, was, f);
    }
    for (size_t i = 0; i < then->n; i++)
        if (!figure_of(now, figure_nth(then, i)->name)) {
            n++;
            put_change_json(json, figure_nth(then, i)->name, figure_nth(then, i), NULL);
        }
    vvi_result_close(json, ']');
    vvi_result_bool(json, "changed", n > 0);
    return n;
}

static void put_now(vvi_text *out, bool csv, const char *id, const vv_collection *now, const vv_collection *then)
{
    for (size_t i = 0; i < now->n; i++) {
        const vv_measured_figure *f = figure_nth(now, i), *was = figure_of(then, f->name);
        if (csv)
            put_row(out, id, f, was);
        else if (!put_place(out, f->name, now, then))
            put_line(out, f, was, then->n > 0);
    }
}

void cli_changes_put(vvi_text *out, bool csv, const char *id, const vv_collection *then, const vv_collection *now)
{
    put_now(out, csv, id, now, then);
    for (size_t i = 0; i < then->n; i++)
        if (!figure_of(now, figure_nth(then, i)->name))
            put_gone(out, csv, id, figure_nth(then, i));
}
