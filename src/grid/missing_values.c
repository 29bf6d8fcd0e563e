/* Samples that stand for no value become NaN, which nothing shows, counts or interpolates. */
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "grid/fill_value.h"
#include <math.h>

typedef struct taking {
    const vv_field *field;
    vv_brick brick;
    int component, n_components; /* those of the result */
    const double *stored;        /* what is taken out, pairs of numbers that are the ends of a range */
    size_t n_stored;             /* pairs */
    void *to;
    vv_type type; /* of the result */
} taking;

vv_type vvi_type_without(vv_type type)
{
    return vv_type_bytes(type) <= 2 || type == VV_TYPE_F32 ? VV_TYPE_F32 : VV_TYPE_F64;
}

static bool is_taken(const taking *t, double v)
{
    for (size_t i = 0; i < t->n_stored; i++)
        if (v >= t->stored[2 * i] && v <= t->stored[2 * i + 1])
            return true;
    return false;
}

/* Item: one slice. */
static vv_status take_slice(void *scratch, void *user, size_t k)
{
    const taking *t = user;
    const vv_brick *b = &t->brick;
    const int64_t *n = b->box.n;
    const size_t n_components = (size_t)t->n_components;
    (void)scratch;
    for (int64_t j = 0; j < n[1]; j++) {
        size_t at = (k * (size_t)n[1] + (size_t)j) * (size_t)n[0] * n_components;
        const char *from = (const char *)b->data + (int64_t)k * b->stride[2] + j * b->stride[1] +
                           (int64_t)((size_t)t->component * vv_type_bytes(b->type));
        for (int64_t i = 0; i < n[0]; i++)
            for (size_t c = 0; c < n_components; c++, at++) {
                double v;
                vvi_samples_to_f64(&v, from + i * b->stride[0] + c * vv_type_bytes(b->type), b->type, 1);
                if (is_taken(t, v))
                    v = NAN;
                if (t->type == VV_TYPE_F32)
                    ((float *)t->to)[at] = (float)v;
                else
                    ((double *)t->to)[at] = v;
            }
    }
    return VV_OK;
}

static vv_status take_all(vv_field **out, taking *t, vv_job *job)
{
    static const vvi_work work = {.stage = "missing values", .item = take_slice};
    const vv_box all = vv_field_box(t->field);
    vv_field_info info = *vv_field_get_info(t->field);
    info.type = t->type = vvi_type_without(info.type);
    info.components = t->n_components;
    vv_status st = vv_field_new_empty(out, &t->to, &info, job);
    if (st != VV_OK)
        return st;
    if ((st = vv_field_brick(&t->brick, t->field, &all, job)) == VV_OK)
        st = vvi_parallel_for(job, &work, t, (size_t)all.n[2]);
    vv_brick_release(&t->brick);
    if (st == VV_OK)
        st = vv_field_health(t->field);
    if (st == VV_OK)
        return VV_OK;
    vv_field_release(*out);
    *out = NULL;
    return st;
}

static void drop(void *value)
{
    vv_field_release(value);
}

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    taking *t = user;
    vv_field *made = NULL;
    const vv_status st = take_all(&made, t, job);
    if (st != VV_OK)
        return st;
    const int64_t *n = vv_field_get_info(made)->grid.dims;
    *bytes_out = (uint64_t)(n[0] * n[1] * n[2]) * vv_type_bytes(t->type);
    *value_out = made;
    return VV_OK;
}

/* Values as they are stored; yours to vvi_free(). */
static vv_status store(double **out, const vv_field_info *info, const double *values, size_t n, vv_job *job)
{
    double *stored = *out = vvi_alloc(job, (n ? n : 1) * 2 * sizeof *stored, VVI_MEM_SCRATCH);
    if (!stored)
        return vv_fail_memory(n * sizeof *stored);
    for (size_t i = 0; i < n; i++) {
        const double v = (values[i] - info->value_offset) / info->value_scale;
        stored[2 * i] = stored[2 * i + 1] = info->type == VV_TYPE_F32      ? (float)v
                                            : vv_type_is_float(info->type) ? v
                                                                           : round(v);
    }
    return VV_OK;
}

static vv_status without(vv_field **out, const vv_field *field, int component, const double *stored, size_t n,
                         vv_job *job)
{
    taking t = {.field = field, .component = component, .n_components = 1, .stored = stored, .n_stored = n};
    const vvi_cache_key key = {"without", vv_field_identity(field),
                               vvi_hash(stored, n * 2 * sizeof *stored, (uint64_t)component)};
    vvi_cached *cached;
    const vv_status st = vvi_cache_get(&cached, &key, make, drop, &t, job);
    if (st != VV_OK)
        return st;
    *out = vv_field_retain(vvi_cached_value(cached));
    vvi_cache_release(cached);
    return VV_OK;
}

vv_status vvi_field_without(vv_field **out, const vv_field *field, int component, const double *values, size_t n,
                            vv_job *job)
{
    double *stored;
    vv_status st = store(&stored, vv_field_get_info(field), values, n, job);
    *out = NULL;
    if (st == VV_OK)
        st = without(out, field, component, stored, n, job);
    vvi_free(stored);
    return st;
}

vv_status vvi_field_without_fills(vv_field **out, const vv_field *field, int component, const vvi_fills *fills,
                                  vv_job *job)
{
    double stored[2 * VVI_FILLS_MOST];
    *out = NULL;
    for (int i = 0; i < fills->n; i++) {
        stored[2 * i] = fills->fill[i].lo;
        stored[2 * i + 1] = fills->fill[i].hi;
    }
    return without(out, field, component, stored, (size_t)fills->n, job);
}

vv_status vvi_field_all_without(vv_field **out, const vv_field *field, const double *values, size_t n, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    double *stored;
    vv_status st = store(&stored, info, values, n, job);
    *out = NULL;
    if (st == VV_OK)
        st = take_all(out, &(taking){.field = field, .n_components = info->components, .stored = stored, .n_stored = n},
                      job);
    vvi_free(stored);
    return st;
}

/* Who asks for values in the gap, or beyond it, means the fill as well. */
static void keep_asked(vvi_fills *fills, const double *asked, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        if (isfinite(asked[i]) && asked[i] <= fills->lo)
            vvi_fills_keep(fills, -INFINITY, fills->lo);
        if (isfinite(asked[i]) && asked[i] > fills->hi)
            vvi_fills_keep(fills, fills->hi, INFINITY);
    }
}

vv_status vvi_fills_of(vvi_fills *out, const vv_field *field, int component, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    vv_statistics *s;
    double padding[2];
    *out = (vvi_fills){0};
    if (info->meaning == VV_MEANING_LABEL || (vv_type_bytes(info->type) < 2 && !vvi_field_padding(padding, field)))
        return VV_OK; /* none is one, or no gap is wide enough */
    if (!(s = vvi_alloc(job, sizeof *s, VVI_MEM_SCRATCH)))
        return vv_fail_memory(sizeof *s);
    vv_status st = vv_field_statistics(s, field, component, job);
    if (st == VV_OK)
        st = vvi_fills_find(out, field, component, s, job);
    vvi_free(s);
    return st == VV_E_MEMORY || st == VV_E_LIMIT ? VV_OK : st;
}

vv_status vvi_field_take_missing(vv_field **field, int *component, const vvi_missing *missing, const char *who,
                                 vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(*field);
    const vv_numbers *named = missing->named;
    vvi_fills fills = {0};
    vv_field *rest = NULL;
    char text[VVI_FILL_TEXT];
    vv_status st = VV_OK;
    if (info->meaning == VV_MEANING_LABEL || *component < 0 || *component >= info->components)
        return VV_OK;
    if (!missing->is_named && (st = vvi_fills_of(&fills, *field, *component, job)) == VV_OK)
        keep_asked(&fills, missing->asked, missing->n_asked);
    if (st != VV_OK || (missing->is_named ? !named || named->n == 0 : fills.n == 0))
        return st;
    vvi_fills_print(text, &fills);
    st = missing->is_named ? vvi_field_without(&rest, *field, *component, named->v, named->n, job)
                           : vvi_field_without_fills(&rest, *field, *component, &fills, job);
    if (fills.n && (st == VV_E_MEMORY || st == VV_E_LIMIT)) {
        if (who)
            vvi_log(job, VV_LOG_WARNING, who, "%s: no memory to leave them out", text);
        return VV_OK;
    }
    if (st != VV_OK)
        return st;
    vv_field_release(*field);
    *field = rest;
    *component = 0;
    if (fills.n && who)
        vvi_log(job, VV_LOG_WARNING, who, "%s: taken as missing and left out%s", text,
                missing->keep ? missing->keep : "");
    return VV_OK;
}

vv_status vvi_fit_without_fill(vvi_value_fit *out, vvi_fills *fills, const vv_field *field, int component,
                               const vv_statistics *s, const char *who, vv_job *job)
{
    vv_field *rest = NULL;
    vv_statistics *others = NULL;
    char text[VVI_FILL_TEXT];
    vvi_fit_values(out, s, NULL);
    vv_status st = vvi_fills_find(fills, field, component, s, job);
    if (st != VV_OK || fills->n == 0)
        return st;
    if (!(others = vvi_alloc(job, sizeof *others, VVI_MEM_SCRATCH)))
        return vv_fail_memory(sizeof *others);
    if ((st = vvi_field_without_fills(&rest, field, component, fills, job)) == VV_OK)
        st = vv_field_statistics(others, rest, 0, job);
    if (st == VV_OK) {
        vvi_fit_values(out, others, NULL);
        vvi_fills_print(text, fills);
        vvi_log(job, VV_LOG_WARNING, who, "%s: left out when a value is chosen", text);
    } else if (st == VV_E_MEMORY || st == VV_E_LIMIT) {
        st = VV_OK; /* data that go through slab by slab are fitted with it */
    }
    vv_field_release(rest);
    vvi_free(others);
    return st;
}
