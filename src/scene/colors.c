#include "scene/colors.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include <math.h>
#include <volvis/image.h>

enum { ENTRIES = 65536 };

typedef struct conversion {
    const vv_field *field;
    vv_brick brick;
    bool encoded, scalar;
    double full;   /* the number that is 1 */
    double *light; /* ENTRIES: linear light of every number of 0 to `full`, where those are so few; else NULL */
    vv_type to_type;
    char *to;
} conversion;

static double full_scale(vv_type type)
{
    switch (type) {
    case VV_TYPE_U8:
        return UINT8_MAX;
    case VV_TYPE_I8:
        return INT8_MAX;
    case VV_TYPE_U16:
        return UINT16_MAX;
    case VV_TYPE_I16:
        return INT16_MAX;
    case VV_TYPE_U32:
        return UINT32_MAX;
    case VV_TYPE_I32:
        return INT32_MAX;
    default:
        return 1;
    }
}

static double clamped(double v)
{
    return v > 0 ? fmin(v, 1) : 0; /* NaN is none */
}

static double light_of(const conversion *c, double stored)
{
    if (c->light && stored >= 0 && stored < ENTRIES)
        return c->light[(size_t)stored];
    const double v = clamped(stored / c->full);
    return c->encoded ? vv_srgb_decode(v) : v;
}

/* Not by lrint(), which is a call. */
static uint16_t to_16(double v)
{
    return (uint16_t)(v * UINT16_MAX + 0.5);
}

static void store_scalar(const conversion *c, size_t at, const double rgba[4], int components)
{
    const double v = components == 4 ? rgba[3] : 0.2126 * rgba[0] + 0.7152 * rgba[1] + 0.0722 * rgba[2];
    if (c->to_type == VV_TYPE_U8)
        ((uint8_t *)c->to)[at] = (uint8_t)(v * UINT8_MAX + 0.5);
    else if (c->to_type == VV_TYPE_U16)
        ((uint16_t *)c->to)[at] = to_16(v);
    else
        ((float *)c->to)[at] = (float)v;
}

static void store_colors(const conversion *c, size_t at, const double rgba[4])
{
    uint16_t *to = (uint16_t *)c->to + 4 * at;
    for (int i = 0; i < 3; i++)
        to[i] = to_16(rgba[i] * rgba[3]);
    to[3] = to_16(rgba[3]);
}

/* One sample, of bytes or of numbers of any type. */
static void find_color(double rgba[4], const conversion *c, const char *sample)
{
    const vv_brick *b = &c->brick;
    double stored[4] = {0};
    if (b->type == VV_TYPE_U8) { /* most: by the table, without a call for each */
        const uint8_t *bytes = (const uint8_t *)sample;
        for (int x = 0; x < 3; x++)
            rgba[x] = c->light[bytes[x]];
        rgba[3] = b->components == 4 ? bytes[3] / c->full : 1;
        return;
    }
    vvi_samples_to_f64(stored, sample, b->type, (size_t)b->components);
    for (int x = 0; x < 3; x++)
        rgba[x] = light_of(c, stored[x]);
    rgba[3] = b->components == 4 ? clamped(stored[3] / c->full) : 1;
}

/* Item: one slice. */
static vv_status convert_slice(void *scratch, void *shared, size_t k)
{
    const conversion *c = shared;
    const vv_brick *b = &c->brick;
    size_t at = k * (size_t)b->box.n[0] * (size_t)b->box.n[1];
    (void)scratch;
    for (int64_t j = 0; j < b->box.n[1]; j++) {
        const char *row = (const char *)b->data + (int64_t)k * b->stride[2] + j * b->stride[1];
        for (int64_t i = 0; i < b->box.n[0]; i++, at++) {
            double rgba[4];
            find_color(rgba, c, row + i * b->stride[0]);
            if (c->scalar)
                store_scalar(c, at, rgba, b->components);
            else
                store_colors(c, at, rgba);
        }
    }
    return VV_OK;
}

static vv_status fill_light(conversion *c, vv_job *job)
{
    if (vv_type_is_float(c->brick.type) || c->full >= ENTRIES)
        return VV_OK;
    c->light = vvi_alloc_zeroed(job, ENTRIES * sizeof *c->light, VVI_MEM_SCRATCH);
    if (!c->light)
        return vv_fail_memory(ENTRIES * sizeof *c->light);
    for (int i = 0; i <= (int)c->full; i++)
        c->light[i] = c->encoded ? vv_srgb_decode(i / c->full) : i / c->full;
    return VV_OK;
}

static vv_field_info info_of(const conversion *c)
{
    vv_field_info info = *vv_field_get_info(c->field);
    info.type = c->to_type;
    info.components = c->scalar ? 1 : 4;
    info.meaning = c->scalar ? VV_MEANING_SCALAR : VV_MEANING_RGBA;
    info.value_scale = vv_type_is_float(c->to_type) ? 1 : 1 / full_scale(c->to_type);
    info.value_offset = 0;
    info.value_unit[0] = 0;
    return info;
}

static vv_status convert(vv_field **out, uint64_t *bytes_out, conversion *c, vv_job *job)
{
    const vv_box box = vv_field_box(c->field);
    const vv_field_info info = info_of(c);
    void *data = NULL;
    vv_status st = vv_field_brick(&c->brick, c->field, &box, job);
    if (st != VV_OK)
        return st;
    c->full = full_scale(c->brick.type);
    if ((st = fill_light(c, job)) == VV_OK && (st = vv_field_info_bytes(bytes_out, &info)) == VV_OK &&
        (st = vv_field_new_empty(out, &data, &info, job)) == VV_OK) {
        const vvi_work work = {.stage = "convert", .item = convert_slice};
        c->to = data;
        st = vvi_parallel_for(job, &work, c, (size_t)box.n[2]);
        if (st != VV_OK) {
            vv_field_release(*out);
            *out = NULL;
        }
    }
    vvi_free(c->light);
    vv_brick_release(&c->brick);
    return st;
}

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    vv_field *field = NULL;
    const vv_status st = convert(&field, bytes_out, user, job);
    *value_out = field;
    return st;
}

static void drop(void *value)
{
    vv_field_release(value);
}

/* Alpha of 8 bits is what it was; luminance of linear light needs more. */
static vv_type scalar_type(const vv_field_info *info)
{
    if (vv_type_is_float(info->type))
        return VV_TYPE_F32;
    return info->type == VV_TYPE_U8 && info->components == 4 ? VV_TYPE_U8 : VV_TYPE_U16;
}

vv_status vvi_colors_scalar(vv_field **out, const vv_field *colors, bool encoded, vv_job *job)
{
    conversion c = {.field = colors, .encoded = encoded, .scalar = true};
    const vvi_cache_key key = {"color scalar", vv_field_identity(colors), encoded};
    vvi_cached *cached = NULL;
    *out = NULL;
    c.to_type = scalar_type(vv_field_get_info(colors));
    const vv_status st = vvi_cache_get(&cached, &key, make, drop, &c, job);
    if (st != VV_OK)
        return st;
    *out = vv_field_retain(vvi_cached_value(cached));
    vvi_cache_release(cached);
    return VV_OK;
}

vv_status vvi_colors_open(vvi_cached **out, const vv_field *colors, bool encoded, vv_job *job)
{
    conversion c = {.field = colors, .encoded = encoded, .to_type = VV_TYPE_U16};
    const vvi_cache_key key = {"colors", vv_field_identity(colors), encoded};
    return vvi_cache_get(out, &key, make, drop, &c, job);
}
