/* Figures then and now, and which of them changed: for people, in a table and in JSON. */
#include "core/units.h"
#include "measure.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static void print_figure(char out[VVI_FIGURE_TEXT], const vv_measured_figure *f, const char *unit)
{
    vvi_figure_print(out, vvi_measured_value(f), vvi_measured_error(f), 0, unit);
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

static void put_row(vvi_text *out, const char *id, const vvi_change *c)
{
    char number[3][32] = {"", "", ""};
    const double v[3] = {vvi_measured_value(c->now), vvi_measured_error(c->now), vvi_measured_value(c->was)};
    for (int i = 0; i < 3; i++)
        if (isfinite(v[i]))
            vvi_print_number(number[i], v[i]);
    vvi_text_printf(out, "%s,%s,%s,%s,%s,%s,%s\n", id, vvi_change_name(c), number[0], number[1],
                    vvi_measured_unit(c->now ? c->now : c->was), number[2],
                    !c->now      ? "gone"
                    : !c->was    ? "new"
                    : c->changed ? "yes"
                                 : "no");
}

/* Three numbers of a place, all as they were, as one line where its first one, `name`_x, stands; false: they are told
 * one by one. */
static bool put_place(vvi_text *out, const vvi_changes *all, const char *name)
{
    char text[3][VVI_FIGURE_TEXT];
    const char *unit = "";
    const size_t n = strlen(name);
    unsigned found = 0;
    if (n < 3 || name[n - 2] != '_' || !strchr("xyz", name[n - 1]) || !is_told(name))
        return false;
    for (size_t i = 0; i < all->n; i++) {
        const vvi_change *c = &all->change[i];
        const char *other = vvi_change_name(c), *axis = other + n - 1;
        if (strlen(other) != n || memcmp(other, name, n - 1) != 0 || !strchr("xyz", *axis) || !c->now || c->changed)
            continue;
        print_figure(text[*axis - 'x'], c->now, "");
        found |= 1U << (*axis - 'x');
        unit = *axis == 'x' ? vvi_measured_unit(c->now) : unit;
    }
    if (found == 7 && name[n - 1] == 'x')
        vvi_text_printf(out, "  %-16.*s %s, %s, %s %s\n", (int)(n - 2), name, text[0], text[1], text[2], unit);
    return found == 7;
}

static void put_line(vvi_text *out, const vvi_change *c)
{
    const char *name = vvi_change_name(c);
    char now[VVI_FIGURE_TEXT], was[VVI_FIGURE_TEXT] = "";
    if (c->now)
        print_figure(now, c->now, vvi_measured_unit(c->now));
    if (c->was)
        print_figure(was, c->was, vvi_measured_unit(c->was));
    if (!c->changed && is_told(name))
        vvi_text_printf(out, "  %-16s %s\n", name, now);
    else if (c->changed)
        vvi_text_printf(out, "  %-16s %s; %s%s\n", name, c->now ? now : "gone", c->was ? "it was " : "new", was);
}

void cli_changes_json(vvi_result *json, const vvi_changes *all)
{
    vvi_result_open(json, "changes", '[');
    for (size_t i = 0; i < all->n; i++) {
        const vvi_change *c = &all->change[i];
        if (!c->changed)
            continue;
        vvi_result_open(json, NULL, '{');
        vvi_result_string(json, "name", vvi_change_name(c));
        vvi_result_number(json, "was", vvi_measured_value(c->was));
        vvi_result_number(json, "is", vvi_measured_value(c->now));
        vvi_result_close(json, '}');
    }
    vvi_result_close(json, ']');
    vvi_result_bool(json, "changed", all->n_changed > 0);
}

void cli_changes_put(vvi_text *out, bool csv, const char *id, const vvi_changes *all)
{
    for (size_t i = 0; i < all->n; i++) {
        const vvi_change *c = &all->change[i];
        if (csv)
            put_row(out, id, c);
        else if (!c->now || !put_place(out, all, vvi_change_name(c)))
            put_line(out, c);
    }
}
