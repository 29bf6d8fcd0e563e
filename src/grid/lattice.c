/* From a field to what kernels sample: the mapped or allocated samples themselves where they are contiguous scalars of
 * a type that kernels know, else a converted copy of one component, made once and kept in the cache. */
#include "grid/lattice.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include <float.h>
#include <math.h>
#include <string.h>

enum { NEEDED_GUARD = 8, CHUNK = 1024 };
#define LEAST_RANGE 0x1p-64 /* the rows of a transfer function within it are counted in floats */
#define MOST_FLOAT 0x1p104  /* the sum along the longest ray is a float */

int vvi_lattice_type(vv_type type)
{
    switch (type) {
    case VV_TYPE_U8:
        return VVI_SAMPLE_U8;
    case VV_TYPE_U16:
        return VVI_SAMPLE_U16;
    case VV_TYPE_I16:
        return VVI_SAMPLE_I16;
    case VV_TYPE_F32:
        return VVI_SAMPLE_F32;
    default:
        return -1;
    }
}

/* What one component becomes when it cannot be sampled where it lies. Scale and offset stay with the field's info. */
static vv_type converted_type(vv_type type)
{
    return type == VV_TYPE_I8 ? VV_TYPE_I16 : vvi_lattice_type(type) < 0 ? VV_TYPE_F32 : type;
}

static bool usable_as_it_is(const vv_brick *b)
{
    const int64_t bytes = (int64_t)vv_type_bytes(b->type);
    return vvi_lattice_type(b->type) >= 0 && b->components == 1 && b->stride[0] == bytes &&
           b->stride[1] == bytes * b->box.n[0] && b->stride[2] == b->stride[1] * b->box.n[1] &&
           b->guard_bytes >= NEEDED_GUARD;
}

double vvi_lattice_zero(const vv_field_info *info, const vv_statistics *s)
{
    if (info->type == VV_TYPE_F32 || converted_type(info->type) != VV_TYPE_F32)
        return info->value_offset;
    return fmin(fmax(s->min, 0), s->max);
}

static void read_samples(double *out, const char *in, vv_type type, int64_t stride, size_t n)
{
    if (stride == (int64_t)vv_type_bytes(type)) {
        vvi_samples_to_f64(out, in, type, n);
        return;
    }
    for (size_t i = 0; i < n; i++)
        vvi_samples_to_f64(&out[i], in + (int64_t)i * stride, type, 1);
}

void vvi_lattice_convert_row(void *out, const vvi_lattice_numbers *numbers, const void *in, int64_t stride, size_t n)
{
    const size_t in_bytes = vv_type_bytes(numbers->from), out_bytes = vv_type_bytes(numbers->to);
    const char *from = (const char *)in + (size_t)numbers->component * in_bytes;
    double chunk[CHUNK];
    if (numbers->from == numbers->to && numbers->factor == 1 && numbers->shift == 0 && stride == (int64_t)in_bytes) {
        memcpy(out, from, n * out_bytes);
        return;
    }
    for (size_t i = 0; i < n; i += CHUNK) {
        const size_t here = n - i < CHUNK ? n - i : CHUNK;
        read_samples(chunk, from + (int64_t)i * stride, numbers->from, stride, here);
        for (size_t l = 0; l < here; l++)
            chunk[l] = chunk[l] * numbers->factor + numbers->shift;
        vvi_samples_from_f64((char *)out + i * out_bytes, chunk, numbers->to, here);
    }
}

typedef struct conversion {
    const vv_field *field;
    const vv_brick *from;
    char *to;
    vvi_lattice_numbers numbers;
} conversion;

/* Item: one slice. */
static vv_status convert_slice(void *scratch, void *shared, size_t k)
{
    const conversion *c = shared;
    const vv_brick *b = c->from;
    const size_t row = (size_t)b->box.n[0], row_bytes = row * vv_type_bytes(c->numbers.to);
    (void)scratch;
    for (int64_t j = 0; j < b->box.n[1]; j++)
        vvi_lattice_convert_row(c->to + (k * (size_t)b->box.n[1] + (size_t)j) * row_bytes, &c->numbers,
                                (const char *)b->data + (int64_t)k * b->stride[2] + j * b->stride[1], b->stride[0],
                                row);
    return VV_OK;
}

static vv_status make_converted(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    conversion *c = user;
    vv_field_info info = *vv_field_get_info(c->field);
    info.type = c->numbers.to;
    info.components = 1;
    if (info.meaning != VV_MEANING_LABEL || vv_type_is_float(info.type)) /* of wide types their values go there */
        info.meaning = VV_MEANING_SCALAR;
    vv_field *field = NULL;
    void *data = NULL;
    vv_status st = vv_field_info_bytes(bytes_out, &info);
    if (st != VV_OK || (st = vv_field_new_empty(&field, &data, &info, job)) != VV_OK)
        return st;
    c->to = data;
    const vvi_work work = {.stage = "convert", .item = convert_slice};
    st = vvi_parallel_for(job, &work, c, (size_t)info.grid.dims[2]);
    if (st != VV_OK) {
        vv_field_release(field);
        return st;
    }
    *value_out = field;
    return VV_OK;
}

static void drop_field(void *value)
{
    vv_field_release(value);
}

/* What floats are divided by where they are too large or differ by too little: a power of two, so none is rounded. */
static double unit_of_floats(const vv_field_info *info, const vv_statistics *s)
{
    const double scale = fabs(info->value_scale), range = (s->max - s->min) / scale;
    const double most = fmax(fabs(s->min - info->value_offset), fabs(s->max - info->value_offset)) / scale;
    int exponent = 0;
    if (most > MOST_FLOAT && isfinite(most))
        exponent = ilogb(most) - ilogb(MOST_FLOAT); /* no more: what is small beside one fill stays a float */
    else if (range > 0 && range < LEAST_RANGE)
        exponent = ilogb(range);
    return ldexp(1, exponent);
}

/* Where floats go: those of wide types over the range of all. */
static vv_status find_unit(vvi_lattice_hold *h, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(h->field);
    vvi_lattice_numbers *c = &h->numbers;
    vv_statistics *s = vvi_alloc(job, sizeof *s, VVI_MEM_SCRATCH);
    if (!s)
        return vv_fail_memory(sizeof *s);
    const vv_status st = vv_field_statistics(s, h->field, c->component, job);
    const double range = st == VV_OK && s->max > s->min ? fmin(s->max - s->min, DBL_MAX) : 1;
    if (st == VV_OK && info->type == VV_TYPE_F32) {
        const double unit = s->count ? unit_of_floats(info, s) : 1;
        h->value_scale = info->value_scale * unit;
        c->factor = 1 / unit;
    } else if (st == VV_OK) {
        h->value_scale = range;
        h->value_offset = vvi_lattice_zero(info, s);
        c->factor = info->value_scale / range;
        c->shift = (info->value_offset - h->value_offset) / range;
    }
    vvi_free(s);
    return st;
}

vv_status vvi_lattice_hold_begin(vvi_lattice_hold *out, const vv_field *field, int component, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    *out = (vvi_lattice_hold){
        .field = vv_field_retain(field),
        .numbers = {.from = info->type, .to = converted_type(info->type), .component = component, .factor = 1},
        .value_scale = info->value_scale,
        .value_offset = info->value_offset};
    for (int a = 0; a < 3; a++)
        if (info->grid.dims[a] > 1 << 23) /* positions along a ray are floats */
            return vv_fail(VV_E_UNSUPPORTED,
                           "axis %c has %lld samples; ray casting takes at most %d, so crop or resample", "xyz"[a],
                           (long long)info -> grid.dims[a], 1 << 23);
    return out->numbers.to == VV_TYPE_F32 ? find_unit(out, job) : VV_OK;
}

static vv_status open_usable(vvi_lattice_hold *h, vv_job *job)
{
    conversion c = {.field = h->field, .from = &h->brick, .numbers = h->numbers};
    if (usable_as_it_is(&h->brick) && h->numbers.factor == 1)
        return VV_OK;
    const vvi_cache_key key = {"lattice", vv_field_identity(h->field), (uint64_t)h->numbers.component};
    vv_status st = vvi_cache_get(&h->cached, &key, make_converted, drop_field, &c, job);
    if (st != VV_OK)
        return st;
    vv_brick_release(&h->brick);
    h->brick = (vv_brick){0};
    const vv_field *converted = vvi_cached_value(h->cached);
    const vv_box box = vv_field_box(converted);
    return vv_field_brick(&h->brick, converted, &box, job);
}

vv_status vvi_lattice_open(vvi_lattice_hold *out, const vv_field *field, int component, vv_job *job)
{
    const vv_box box = vv_field_box(field);
    vv_status st = vvi_lattice_hold_begin(out, field, component, job);
    if (st == VV_OK)
        st = vv_field_brick(&out->brick, field, &box, job);
    if (st == VV_OK)
        st = open_usable(out, job);
    if (st != VV_OK) {
        vvi_lattice_close(out);
        return st;
    }
    vvi_lattice *g = &out->lattice;
    g->data = out->brick.data;
    g->sample_type = vvi_lattice_type(out->brick.type);
    for (int a = 0; a < 3; a++)
        g->n[a] = (int32_t)box.n[a];
    g->row = g->n[0];
    g->slice = (int64_t)g->n[0] * g->n[1];
    g->fetch = g->slice > INT32_MAX / g->n[2] ? VVI_FETCH_WIDE : VVI_FETCH_LINEAR;
    if (g->slice > INT32_MAX) {
        vvi_lattice_close(out);
        return vv_fail(VV_E_UNSUPPORTED, "a slice of %d x %d samples is too large to ray cast; crop or resample",
                       g->n[0], g->n[1]);
    }
    return VV_OK;
}

void vvi_lattice_close(vvi_lattice_hold *hold)
{
    vv_brick_release(&hold->brick);
    vvi_cache_release(hold->cached);
    vv_field_release(hold->field);
    *hold = (vvi_lattice_hold){0};
}
