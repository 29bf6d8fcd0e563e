/* Samples that stand for no value: those that the volume names, else a fill that only the samples tell of. */
#include "core/job.h"
#include "grid/fill_value.h"
#include "grid/label_sense.h"
#include "render/common/resolve.h"
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

static vv_status leave_out(vv_actor *actor, const double *values, size_t n, vv_job *job)
{
    vv_field *rest;
    const vv_status st = vvi_field_without(&rest, actor->field, actor->component, values, n, job);
    if (st != VV_OK)
        return st;
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
    vvi_fill_value fill;
    size_t n_labels = 0;
    vv_status st = vvi_fill_value_find(&fill, actor->field, actor->component, actor->statistics, job);
    if (st != VV_OK || !fill.found || (fill.value >= spoken.lo && fill.value <= spoken.hi))
        return st;
    if (!vv_object_is_set(&s->base, "kind"))
        st = vvi_label_sense(&n_labels, actor->field, actor->component, job);
    if (st != VV_OK || n_labels)
        return st;
    st = leave_out(actor, &fill.value, 1, job);
    if (!path)
        return st == VV_E_MEMORY || st == VV_E_LIMIT ? VV_OK : st;
    if (st == VV_E_MEMORY || st == VV_E_LIMIT) {
        vvi_log(job, VV_LOG_WARNING, "render", "%s: no memory to leave out %.9g, which %.2g %% of the samples are",
                path, fill.value, 100 * fill.share);
        return VV_OK;
    }
    vvi_log(job, VV_LOG_WARNING, "render",
            "%s: %.2g %% of the samples are %.9g, far from all others (%.6g to %.6g): taken as missing and left out; "
            "%s.missing=[] shows them",
            path, 100 * fill.share, fill.value, fill.lo, fill.hi, path);
    return st;
}

vv_status vvi_resolve_missing(vv_actor *actor, const vv_volume *volume, const char *path, vv_job *job)
{
    const vv_numbers *missing = volume->missing;
    if (!are_amounts(actor, volume))
        return VV_OK;
    if (!vv_object_is_set(&volume->base, "missing"))
        return leave_fill_out(actor, volume, path, job);
    return missing && missing->n ? leave_out(actor, missing->v, missing->n, job) : VV_OK;
}
