/* Samples that stand for no value: those that the volume names, else a fill that only the samples tell of. */
#include "core/job.h"
#include "grid/fill_value.h"
#include "grid/label_sense.h"
#include "scene/resolve.h"
#include <math.h>

typedef struct span {
    double lo, hi;
} span;

static void widen(span *s, const vv_object *object, const char *name, double value)
{
    if (!vv_object_is_set(object, name))
        return;
    s->lo = fmin(s->lo, value);
    s->hi = fmax(s->hi, value);
}

static void widen_rows(span *s, const vv_object *object, const char *name, const vv_numbers *rows, size_t columns)
{
    for (size_t i = 0; rows && i < rows->n; i += columns)
        widen(s, object, name, rows->v[i]);
}

/* Values that somebody speaks of: what lies among them is to be seen as they say. */
static span spoken_of(const vv_volume *volume)
{
    const vv_segmentation *s = (const vv_segmentation *)volume->segmentation;
    const vv_transfer *t = (const vv_transfer *)s->transfer;
    const vv_threshold *threshold = (const vv_threshold *)s->threshold;
    const vv_volume_slices *slices = (const vv_volume_slices *)volume->slices;
    span out = {INFINITY, -INFINITY};
    widen(&out, &t->base, "range_lo", t->range_lo);
    widen(&out, &t->base, "range_hi", t->range_hi);
    widen_rows(&out, &t->base, "opacity", t->opacity, 2);
    widen_rows(&out, &t->base, "color", t->color, 4);
    widen(&out, &threshold->base, "lo", threshold->lo);
    widen(&out, &threshold->base, "hi", threshold->hi);
    widen(&out, &slices->base, "window_lo", slices->window_lo);
    widen(&out, &slices->base, "window_hi", slices->window_hi);
    for (size_t i = 0; i < t->regions->n; i++) {
        const vv_transfer_region *r = (const vv_transfer_region *)t->regions->entry[i].object;
        widen(&out, &r->base, "value_lo", r->value_lo);
        widen(&out, &r->base, "value_hi", r->value_hi);
    }
    return out;
}

static bool are_amounts(const vv_actor *actor, const vv_volume *volume)
{
    const vv_segmentation *s = (const vv_segmentation *)volume->segmentation;
    return !actor->colors && vv_field_get_info(actor->field)->meaning != VV_MEANING_LABEL &&
           !(vv_object_is_set(&s->base, "kind") && s->kind == VV_SEGMENT_LABELS);
}

static vv_status show_rest(vv_actor *actor, vv_field *rest, vv_job *job)
{
    vv_field_release((vv_field *)actor->field);
    actor->field = rest;
    actor->component = 0;
    return vv_field_statistics(actor->statistics, rest, 0, job);
}

/* What nobody says. Integers that look like labels have no fill: each of them is a region. */
static vv_status leave_fill_out(vv_actor *actor, const vv_volume *volume, const char *path, vv_job *job)
{
    const vv_segmentation *s = (const vv_segmentation *)volume->segmentation;
    const span spoken = spoken_of(volume);
    vvi_fills fills;
    vv_field *rest;
    char text[VVI_FILL_TEXT];
    size_t n_labels = 0;
    vv_status st = vvi_fills_find(&fills, actor->field, actor->component, actor->statistics, job);
    if (st != VV_OK)
        return st;
    vvi_fills_keep(&fills, spoken.lo, spoken.hi);
    if (fills.n && !vv_object_is_set(&s->base, "kind"))
        st = vvi_label_sense(&n_labels, actor->field, actor->component, job);
    if (st != VV_OK || n_labels || fills.n == 0)
        return st;
    vvi_fills_print(text, &fills);
    st = vvi_field_without_fills(&rest, actor->field, actor->component, &fills, job);
    const bool no_room = st == VV_E_MEMORY || st == VV_E_LIMIT;
    if (st == VV_OK)
        st = show_rest(actor, rest, job);
    if (no_room && path)
        vvi_log(job, VV_LOG_WARNING, "render", "%s: %s: no memory to leave them out", path, text);
    else if (path)
        vvi_log(job, VV_LOG_WARNING, "render", "%s: %s: taken as missing and left out; %s.missing=[] shows them", path,
                text, path);
    return no_room ? VV_OK : st;
}

vv_status vvi_resolve_missing(vv_actor *actor, const vv_volume *volume, const char *path, vv_job *job)
{
    const vv_numbers *missing = volume->missing;
    if (!are_amounts(actor, volume))
        return VV_OK;
    if (!vv_object_is_set(&volume->base, "missing"))
        return leave_fill_out(actor, volume, path, job);
    if (!missing || missing->n == 0)
        return VV_OK;
    vv_field *rest;
    const vv_status st = vvi_field_without(&rest, actor->field, actor->component, missing->v, missing->n, job);
    return st == VV_OK ? show_rest(actor, rest, job) : st;
}
