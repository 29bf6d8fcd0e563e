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
    const double *stored;        /* what is taken out */
    size_t n_stored;
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
        if (v == t->stored[i])
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
    double *stored = *out = vvi_alloc(job, (n ? n : 1) * sizeof *stored, VVI_MEM_SCRATCH);
    if (!stored)
        return vv_fail_memory(n * sizeof *stored);
    for (size_t i = 0; i < n; i++) {
        const double v = (values[i] - info->value_offset) / info->value_scale;
        stored[i] = info->type == VV_TYPE_F32 ? (float)v : vv_type_is_float(info->type) ? v : round(v);
    }
    return VV_OK;
}

vv_status vvi_field_without(vv_field **out, const vv_field *field, int component, const double *values, size_t n,
                            vv_job *job)
{
    double *stored;
    vv_status st = store(&stored, vv_field_get_info(field), values, n, job);
    *out = NULL;
    if (st != VV_OK)
        return st;
    taking t = {.field = field, .component = component, .n_components = 1, .stored = stored, .n_stored = n};
    const vvi_cache_key key = {"without", vv_field_identity(field),
                               vvi_hash(stored, n * sizeof *stored, (uint64_t)component)};
    vvi_cached *cached;
    st = vvi_cache_get(&cached, &key, make, drop, &t, job);
    vvi_free(stored);
    if (st != VV_OK)
        return st;
    *out = vv_field_retain(vvi_cached_value(cached));
    vvi_cache_release(cached);
    return VV_OK;
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

static bool reaches(const vvi_fill_value *fill, const double *asked, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (isfinite(asked[i]) && (fill->value < fill->lo ? asked[i] <= fill->lo : asked[i] > fill->hi))
            return true;
    return false;
}

vv_status vvi_fill_value_of(vvi_fill_value *out, const vv_field *field, int component, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    vv_statistics *s;
    *out = (vvi_fill_value){0};
    if (vv_type_bytes(info->type) < 2 || info->meaning == VV_MEANING_LABEL)
        return VV_OK; /* no gap is wide enough, or none is one */
    if (!(s = vvi_alloc(job, sizeof *s, VVI_MEM_SCRATCH)))
        return vv_fail_memory(sizeof *s);
    vv_status st = vv_field_statistics(s, field, component, job);
    if (st == VV_OK)
        st = vvi_fill_value_find(out, field, component, s, job);
    vvi_free(s);
    return st == VV_E_MEMORY || st == VV_E_LIMIT ? VV_OK : st;
}

/* *n_out: 0 where all samples are to stay. */
static vv_status find(vvi_fill_value *fill, size_t *n_out, const vv_field *field, int component,
                      const vvi_missing *missing, vv_job *job)
{
    const vv_status st = vvi_fill_value_of(fill, field, component, job);
    *n_out = st == VV_OK && fill->found && !reaches(fill, missing->asked, missing->n_asked);
    return st;
}

vv_status vvi_field_take_missing(vv_field **field, int *component, const vvi_missing *missing, const char *who,
                                 vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(*field);
    const vv_numbers *named = missing->named;
    vvi_fill_value fill = {0};
    vv_field *rest = NULL;
    size_t n = named ? named->n : 0;
    if (info->meaning == VV_MEANING_LABEL || *component < 0 || *component >= info->components)
        return VV_OK;
    vv_status st = missing->is_named ? VV_OK : find(&fill, &n, *field, *component, missing, job);
    if (st != VV_OK || n == 0)
        return st;
    st = vvi_field_without(&rest, *field, *component, fill.found ? &fill.value : named->v, n, job);
    if (fill.found && (st == VV_E_MEMORY || st == VV_E_LIMIT)) {
        if (who)
            vvi_log(job, VV_LOG_WARNING, who, "no memory to leave out %.9g, which %.2g %% of the samples are",
                    fill.value, 100 * fill.share);
        return VV_OK;
    }
    if (st != VV_OK)
        return st;
    vv_field_release(*field);
    *field = rest;
    *component = 0;
    if (fill.found && who)
        vvi_log(job, VV_LOG_WARNING, who,
                "%.2g %% of the samples are %.9g, far from all others (%.6g to %.6g): taken as missing and left out%s",
                100 * fill.share, fill.value, fill.lo, fill.hi, missing->keep ? missing->keep : "");
    return VV_OK;
}

vv_status vvi_fit_without_fill(vvi_value_fit *out, vvi_fill_value *fill, const vv_field *field, int component,
                               const vv_statistics *s, const char *who, vv_job *job)
{
    vv_field *rest = NULL;
    vv_statistics *others = NULL;
    vvi_fit_values(out, s, NULL);
    vv_status st = vvi_fill_value_find(fill, field, component, s, job);
    if (st != VV_OK || !fill->found)
        return st;
    if (!(others = vvi_alloc(job, sizeof *others, VVI_MEM_SCRATCH)))
        return vv_fail_memory(sizeof *others);
    if ((st = vvi_field_without(&rest, field, component, &fill->value, 1, job)) == VV_OK)
        st = vv_field_statistics(others, rest, 0, job);
    if (st == VV_OK) {
        vvi_fit_values(out, others, NULL);
        vvi_log(job, VV_LOG_WARNING, who,
                "%.2g %% of the samples are %.9g, far from all others (%.6g to %.6g): left out when a value is chosen",
                100 * fill->share, fill->value, fill->lo, fill->hi);
    } else if (st == VV_E_MEMORY || st == VV_E_LIMIT) {
        st = VV_OK; /* data that go through slab by slab are fitted with it */
    }
    vv_field_release(rest);
    vvi_free(others);
    return st;
}
