#include "measuring/figure_changes.h"
#include "core/memory.h"
#include "core/status.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SAME 1e-9 /* what another processor may make of the last digits */

static const vv_measured_figure *figure_nth(const vv_collection *figures, size_t i)
{
    return (const vv_measured_figure *)(const void *)figures->entry[i].object;
}

static const char *name_of(const vv_measured_figure *f)
{
    return f->name ? f->name : "";
}

static const vv_measured_figure *figure_of(const vv_collection *figures, const char *name)
{
    for (size_t i = 0; i < figures->n; i++)
        if (strcmp(name_of(figure_nth(figures, i)), name) == 0)
            return figure_nth(figures, i);
    return NULL;
}

const char *vvi_change_name(const vvi_change *change)
{
    return name_of(change->now ? change->now : change->was);
}

double vvi_measured_value(const vv_measured_figure *f)
{
    return f && vv_object_is_set(&f->base, "value") ? f->value : NAN;
}

double vvi_measured_error(const vv_measured_figure *f)
{
    return f && vv_object_is_set(&f->base, "error") ? f->error : NAN;
}

const char *vvi_measured_unit(const vv_measured_figure *f)
{
    return f->unit ? f->unit : "";
}

static bool same(const vv_measured_figure *a, const vv_measured_figure *b)
{
    const double x = vvi_measured_value(a), y = vvi_measured_value(b);
    if (!a || !b || isnan(x) != isnan(y) || strcmp(vvi_measured_unit(a), vvi_measured_unit(b)) != 0)
        return false;
    return isnan(x) || fabs(x - y) <= SAME * fmax(fmax(fabs(x), fabs(y)), fmax(0, vvi_measured_error(b)));
}

static void add(vvi_changes *out, const vv_measured_figure *was, const vv_measured_figure *now)
{
    const bool is_new_step = !was && strcmp(name_of(now), VVI_TIME_STEP) == 0;
    const bool changed = out->compared && !is_new_step && !same(was, now);
    out->change[out->n++] = (vvi_change){was, now, changed};
    out->n_changed += changed;
}

vv_status vvi_changes_find(vvi_changes *out, const vv_collection *then, const vv_collection *now)
{
    const size_t most = then->n + now->n + 1;
    *out = (vvi_changes){.change = vvi_calloc(most, sizeof *out->change), .compared = then->n > 0};
    if (!out->change)
        return vv_fail_memory(most * sizeof *out->change);
    for (size_t i = 0; i < now->n; i++)
        add(out, figure_of(then, name_of(figure_nth(now, i))), figure_nth(now, i));
    for (size_t i = 0; i < then->n; i++)
        if (!figure_of(now, name_of(figure_nth(then, i))))
            add(out, figure_nth(then, i), NULL);
    return VV_OK;
}

void vvi_changes_free(vvi_changes *changes)
{
    free(changes->change);
    *changes = (vvi_changes){0};
}
