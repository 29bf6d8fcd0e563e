/* What a percentile is, and those of fields. */
#include "grid/percentile.h"

#include "core/cache.h"
#include "core/memory.h"

#include <math.h>
#include <string.h>

/* Fields that go through a selection pass by pass. */
typedef struct work {
    const vv_field_series *series;
    int component;
    vvi_selection selection;
    double scale, offset; /* of the first field */
} work;

static vv_status check_alike(const work *w, const vv_field_info *info)
{
    if (info->type != w->selection.type || info->value_scale != w->scale || info->value_offset != w->offset)
        return vv_fail(VV_E_UNSUPPORTED,
                       "time steps differ in type or scale; no percentiles can be taken over all of them");
    return VV_OK;
}

static vv_status begin(work *w, const vv_field_info *info, vv_job *job)
{
    w->scale = info->value_scale;
    w->offset = info->value_offset;
    return vvi_selection_begin(&w->selection, info->type, job);
}

static vv_status pass_field(work *w, size_t index, vv_job *job)
{
    const bool first = w->selection.total == NULL;
    vv_field *field = NULL;
    vv_status st = w->series->open(&field, w->series->user, index, job);
    if (st == VV_OK && first)
        st = begin(w, vv_field_get_info(field), job);
    if (st == VV_OK && (st = check_alike(w, vv_field_get_info(field))) == VV_OK) {
        const vvi_pass pass = vvi_selection_pass(&w->selection);
        if ((st = vvi_pass_run(&pass, field, w->component, job)) == VV_OK)
            st = vv_field_health(field);
    }
    vv_field_release(field);
    return st;
}

static vv_status pass_all(work *w, vv_job *job)
{
    vv_status st = VV_OK;
    for (size_t f = 0; f < w->series->n && st == VV_OK; f++)
        st = pass_field(w, f, job);
    return st;
}

static vv_status open_alone(vv_field **out, void *user, size_t index, vv_job *job)
{
    (void)index;
    (void)job;
    *out = vv_field_retain(user);
    return VV_OK;
}

vv_field_series vvi_field_alone(const vv_field *field)
{
    return (vv_field_series){open_alone, (void *)(uintptr_t)field, 1};
}

vvi_quantile vvi_quantile_at(double percent, uint64_t count)
{
    const double last = (double)(count - 1), at = percent / 100 * last;
    if (!(at > 0) || at >= last)
        return at > 0 ? (vvi_quantile){count - 1, count - 1, 0} : (vvi_quantile){0, 0, 0};
    const uint64_t low = (uint64_t)at;
    return (vvi_quantile){low, low + 1, at - floor(at)};
}

double vvi_quantile_between(const vvi_quantile *q, double low, double high)
{
    return low == high ? low : low * (1 - q->part) + high * q->part; /* the difference of huge doubles is no double */
}

void vvi_quantile_ranks(uint64_t *ranks, const double *percents, int n, uint64_t count)
{
    for (int i = 0; i < n; i++) {
        const vvi_quantile q = vvi_quantile_at(percents[i], count);
        ranks[2 * i] = q.low;
        ranks[2 * i + 1] = q.high;
    }
}

double vvi_selection_percentile(const vvi_selection *s, int i, double percent, uint64_t count)
{
    const vvi_quantile q = vvi_quantile_at(percent, count);
    return vvi_quantile_between(&q, vvi_selection_number(s, 2 * i), vvi_selection_number(s, 2 * i + 1));
}

/* After the first pass. */
static vv_status select_percents(double *values, const double *percents, int n, work *w, vv_job *job)
{
    vvi_selection *s = &w->selection;
    const uint64_t count = vvi_selection_count(s);
    double along[VVI_RANKS_MOST / 2];
    uint64_t ranks[VVI_RANKS_MOST];
    vv_status st;
    bool done = false;
    for (int i = 0; i < n; i++) { /* a negative scale turns the order of values round */
        along[i] = w->scale < 0 ? 100 - percents[i] : percents[i];
        values[i] = NAN;
    }
    if (count == 0)
        return VV_OK;
    vvi_quantile_ranks(ranks, along, n, count);
    vvi_selection_set_ranks(s, ranks, 2 * n);
    while ((st = vvi_selection_descend(s, &done, job)) == VV_OK && !done)
        if ((st = pass_all(w, job)) != VV_OK)
            return st;
    for (int i = 0; i < n && st == VV_OK; i++)
        values[i] = vvi_selection_percentile(s, i, along[i], count) * w->scale + w->offset;
    return st;
}

vv_status vvi_percentiles(double *values, const double *percents, int n, const vv_field_series *series, int component,
                          vv_job *job)
{
    work w = {.series = series, .component = component};
    vv_status st = pass_all(&w, job);
    if (st == VV_OK)
        st = select_percents(values, percents, n, &w, job);
    vvi_selection_end(&w.selection);
    return st;
}

typedef struct request {
    const vv_field *field;
    int component;
    double percents[2];
} request;

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    const vv_field_series alone = vvi_field_alone(r->field);
    double *values = vvi_alloc(job, 2 * sizeof *values, VVI_MEM_DERIVED);
    if (!values)
        return vv_fail_memory(2 * sizeof *values);
    const vv_status st = vvi_percentiles(values, r->percents, 2, &alone, r->component, job);
    if (st != VV_OK) {
        vvi_free(values);
        return st;
    }
    *value_out = values;
    *bytes_out = 2 * sizeof *values;
    return VV_OK;
}

vv_status vvi_field_percentiles(double values[2], const double percents[2], const vv_field *field, int component,
                                vv_job *job)
{
    request r = {field, component, {percents[0], percents[1]}};
    const uint64_t hash = vvi_hash(r.percents, sizeof r.percents, (uint64_t)component);
    const vvi_cache_key key = {"percentiles", vv_field_identity(field), hash};
    vvi_cached *cached;
    const vv_status st = vvi_cache_get(&cached, &key, make, vvi_free, &r, job);
    if (st != VV_OK)
        return st;
    memcpy(values, vvi_cached_value(cached), 2 * sizeof *values);
    vvi_cache_release(cached);
    return VV_OK;
}
