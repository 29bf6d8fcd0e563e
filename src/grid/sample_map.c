#include "grid/sample_map.h"
#include "core/memory.h"
#include "core/status.h"
#include "grid/making.h"
#include <math.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 18)
#define RUN 1024

typedef struct shared {
    vvi_making making;
    vv_type in_type, out_type;
    vvi_sample_map map;
    bool checked; /* samples may be more than the type holds, and must not */
    char *table;  /* results by 8- or 16-bit pattern; NULL: each sample is worked out */
} shared;

static bool is_long(vv_type type)
{
    return type == VV_TYPE_I64 || type == VV_TYPE_U64;
}

/* Integers of 64 bits that stay what they are: doubles would round them. */
static void copy_long(char *out, const char *in, size_t n, const shared *s)
{
    const bool top = s->in_type != s->out_type; /* what one has and the other has not becomes the end that is nearer */
    for (size_t i = 0; i < n; i++) {
        int64_t v;
        memcpy(&v, in + 8 * i, sizeof v);
        if (top && v < 0)
            v = s->out_type == VV_TYPE_I64 ? INT64_MAX : 0;
        memcpy(out + 8 * i, &v, sizeof v);
    }
}

static bool keeps_long(const shared *s)
{
    return is_long(s->in_type) && is_long(s->out_type) && s->map.gain == 1 && s->map.shift == 0 && !s->map.skipped &&
           s->map.lo == -INFINITY && s->map.hi == INFINITY;
}

static void map_run(void *out, const void *in, size_t n, const shared *s)
{
    double v[RUN];
    const vvi_sample_map m = s->map;
    vvi_samples_to_f64(v, in, s->in_type, n);
    for (size_t i = 0; i < n; i++) {
        const double r = v[i] * m.gain + m.shift;
        v[i] = m.skipped && vvi_fills_have(m.skipped, v[i]) ? NAN
               : r < m.lo                                   ? m.lo
               : r > m.hi                                   ? m.hi
                                                            : r; /* NaN stays */
    }
    vvi_samples_from_f64(out, v, s->out_type, n);
}

/* A finite number that the type would clamp. */
static bool is_beyond(double r, vv_type type)
{
    return isfinite(r) && (nearbyint(r) < vvi_type_min(type) || nearbyint(r) > vvi_type_max(type));
}

static vv_status check_run(const void *in, size_t n, const shared *s)
{
    double v[RUN];
    vvi_samples_to_f64(v, in, s->in_type, n);
    for (size_t i = 0; i < n; i++) {
        const double r = v[i] * s->map.gain + s->map.shift;
        if (is_beyond(r, s->out_type))
            return vv_fail(
                VV_E_ARGUMENT,
                "a sample would be stored as %.9g, but %s holds %.20g to %.20g: choose another type or range, "
                "or let values be clamped",
                r, vv_type_name(s->out_type), vvi_type_min(s->out_type), vvi_type_max(s->out_type));
    }
    return VV_OK;
}

static vv_status check_row(const char *in, size_t n, const shared *s)
{
    vv_status st = VV_OK;
    for (size_t at = 0; at < n && s->checked && st == VV_OK; at += RUN)
        st = check_run(in + at * vv_type_bytes(s->in_type), n - at < RUN ? n - at : RUN, s);
    return st;
}

/* Types alone may say that all fits. */
static bool needs_check(const shared *s)
{
    const vvi_sample_map *m = &s->map;
    if (!m->holds || vv_type_is_float(s->out_type))
        return false;
    return vv_type_is_float(s->in_type) || is_beyond(vvi_type_min(s->in_type) * m->gain + m->shift, s->out_type) ||
           is_beyond(vvi_type_max(s->in_type) * m->gain + m->shift, s->out_type);
}

static void look_up(char *out, const char *in, size_t n, const shared *s)
{
    const bool wide = vv_type_bytes(s->in_type) == 2;
    const size_t bytes = vv_type_bytes(s->out_type);
    for (size_t i = 0; i < n; i++) {
        uint16_t pattern = 0;
        if (wide)
            memcpy(&pattern, in + 2 * i, 2);
        else
            pattern = ((const uint8_t *)in)[i];
        const char *row = s->table + pattern * bytes;
        switch (bytes) {
        case 1:
            out[i] = *row;
            break;
        case 2:
            memcpy(out + 2 * i, row, 2);
            break;
        case 4:
            memcpy(out + 4 * i, row, 4);
            break;
        default:
            memcpy(out + 8 * i, row, 8);
        }
    }
}

static vv_status make_table(shared *s, vv_job *job)
{
    const size_t in_bytes = vv_type_bytes(s->in_type), out_bytes = vv_type_bytes(s->out_type);
    if (in_bytes > 2)
        return VV_OK;
    const size_t n = in_bytes == 1 ? 256 : 65536;
    s->table = vvi_alloc(job, n * out_bytes, VVI_MEM_SCRATCH);
    if (!s->table)
        return vv_fail_memory(n * out_bytes);
    for (size_t i = 0; i < n; i++) {
        const uint8_t narrow = (uint8_t)i;
        const uint16_t wide = (uint16_t)i;
        map_run(s->table + i * out_bytes, in_bytes == 1 ? (const void *)&narrow : (const void *)&wide, 1, s);
    }
    return VV_OK;
}

static vv_status item(void *scratch, void *user, size_t index)
{
    (void)scratch;
    const shared *s = user;
    const vv_field_info *info = vv_field_get_info(s->making.in);
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const size_t each = vv_type_bytes(s->out_type), from_each = vv_type_bytes(s->in_type);
    const vv_brick brick = vvi_brick_part(&s->making.brick, &box);
    const size_t n = (size_t)box.n[0] * (size_t)info->components;
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            const int64_t first = vvi_slabs_row(&s->making.slabs, &box, j, k);
            char *out = s->making.out + (size_t)(first * info->components) * each;
            const char *in = (const char *)brick.data + j * brick.stride[1] + k * brick.stride[2];
            const vv_status st = check_row(in, n, s);
            if (st != VV_OK)
                return st;
            if (s->table) {
                look_up(out, in, n, s);
                continue;
            }
            if (keeps_long(s)) {
                copy_long(out, in, n, s);
                continue;
            }
            for (size_t at = 0; at < n; at += RUN)
                map_run(out + at * each, in + at * from_each, n - at < RUN ? n - at : RUN, s);
        }
    return VV_OK;
}

/* Of a small box the samples themselves are fewer than patterns. */
static bool needs_table(const vv_box *box, const vv_field_info *info)
{
    return vv_type_bytes(info->type) == 1 || box->n[0] * box->n[1] * box->n[2] * info->components > 65536;
}

vv_status vvi_sample_map_run(vv_field **out, const vv_field *in, const vv_field_info *info, const vv_box *box,
                             const vvi_sample_map *map, const char *stage, vv_job *job)
{
    const vvi_work work = {.stage = stage, .item = item};
    shared s = {.making = {.in = in, .slabs = vvi_slabs_of(box, ITEM_SAMPLES)},
                .in_type = vv_field_get_info(in)->type,
                .out_type = info->type,
                .map = *map};
    *out = NULL;
    s.checked = needs_check(&s);
    vv_status st = needs_table(box, vv_field_get_info(in)) ? make_table(&s, job) : VV_OK;
    if (st == VV_OK)
        st = vvi_making_run(out, &s.making, info, box, box, &work, &s, job);
    vvi_free(s.table);
    return st;
}
