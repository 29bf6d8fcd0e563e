/* Samples to bits. Rows of the types that the kernels of Marching Cubes know are compared 64 at a time. */
#include "measure/object.h"

#include "core/cpu.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "grid/label_id.h"
#include "grid/same_grid.h"

#include <math.h>
#include <string.h>

#define PART 64                    /* words of a row that are compared with the upper limit at a time */
#define LONGEST (INT64_C(1) << 21) /* samples of a row that the kernels take */

static bool inside(const vvi_object *o, double stored)
{
    return stored >= o->lo && stored <= o->hi; /* NaN is not */
}

/* Of a sample. Integers of 64 bits are more than doubles tell apart. */
static bool has_label(const vvi_object *o, const char *at, vv_type type)
{
    double v;
    if (type == VV_TYPE_I64 || type == VV_TYPE_U64)
        return vvi_label_of(at, type) == o->id;
    vvi_samples_to_f64(&v, at, type, 1);
    return inside(o, v);
}

/* Of integers: the least number from x on, clamped to what the type can say. False: there is none. */
static bool integer_from(double *out, double x, vv_type type)
{
    *out = fmax(ceil(x), vvi_type_min(type));
    return *out <= vvi_type_max(type);
}

static void put_integer(char out[8], double v, vv_type type)
{
    vvi_samples_from_f64(out, &v, type, 1);
}

/* The least float from x on. */
static void put_float(char out[8], double x)
{
    float f = (float)x;
    if ((double)f < x)
        f = nextafterf(f, INFINITY);
    memcpy(out, &f, sizeof f);
}

static vvi_march_type fast_type(const vvi_object *o, const vv_field_info *info)
{
    if (info->components != 1 || o->step != 1 || o->n[0] > LONGEST)
        return VVI_MARCH_TYPES;
    return info->type == VV_TYPE_U8    ? VVI_MARCH_U8
           : info->type == VV_TYPE_U16 ? VVI_MARCH_U16
           : info->type == VV_TYPE_I16 ? VVI_MARCH_I16
           : info->type == VV_TYPE_F32 ? VVI_MARCH_F32
                                       : VVI_MARCH_TYPES;
}

/* A mask is what is not 0: two ranges, so it is compared sample by sample. */
static void find_thresholds(vvi_object *o, const vv_field_info *info)
{
    o->type = o->mask ? VVI_MARCH_TYPES : fast_type(o, info);
    o->any = true;
    if (o->type == VVI_MARCH_TYPES)
        return;
    if (o->type == VVI_MARCH_F32) {
        put_float(o->least, fmax(o->lo, -INFINITY));
        o->below_all = !(o->hi < INFINITY);
        if (!o->below_all)
            put_float(o->above, nextafter(o->hi, INFINITY));
        return;
    }
    double least, above;
    o->any = integer_from(&least, o->lo, info->type) && o->hi >= vvi_type_min(info->type);
    o->below_all = !integer_from(&above, floor(o->hi) + 1, info->type);
    put_integer(o->least, least, info->type);
    put_integer(o->above, above, info->type);
}

/* A limit as it is stored. A hair beside a whole number it is that one, if that is inside: people mean values. */
static double stored_limit(const vvi_object *o, double value, bool least)
{
    if (isinf(value))
        return value * (o->scale < 0 ? -1 : 1);
    if (o->scale == 1 && o->offset == 0)
        return value;
    const double s = (value - o->offset) / o->scale, whole = nearbyint(s), at = whole * o->scale + o->offset;
    const bool near = fabs(whole - s) <= 1e-9 * fmax(1, fabs(s));
    return near && (least ? at >= value : at <= value) ? whole : s;
}

static void set_range(vvi_object *o, double lo, double hi)
{
    const double a = stored_limit(o, lo, true), b = stored_limit(o, hi, false);
    o->lo = o->scale < 0 ? b : a;
    o->hi = o->scale < 0 ? a : b;
}

static vv_status check_mask(const vv_field *field, const vv_field *mask)
{
    const vv_field_info *a = vv_field_get_info(field), *b = mask ? vv_field_get_info(mask) : NULL;
    if (!b)
        return vv_fail(VV_E_ARGUMENT, "a mask is to be measured, but there is none");
    return vvi_grid_alike(&a->grid, &b->grid, "mask");
}

static vv_status choose(vvi_object *o, const vv_field *field, const vv_measure_options *options)
{
    vv_status st;
    switch (options->object) {
    case VV_OBJECT_LABEL:
        o->label = true;
        o->id = options->label;
        o->lo = o->hi = (double)options->label;
        return VV_OK;
    case VV_OBJECT_MASK:
        o->mask = true;
        if ((st = check_mask(field, options->mask)) == VV_OK)
            o->samples = options->mask;
        o->component = 0;
        return st;
    case VV_OBJECT_RANGE:
        break;
    }
    if (!(options->lo <= options->hi))
        return vv_fail(VV_E_ARGUMENT, "values from %g to %g are not a range", options->lo, options->hi);
    set_range(o, options->lo, options->hi);
    o->value_lo = options->lo;
    o->value_hi = options->hi;
    return VV_OK;
}

vv_status vvi_object_open(vvi_object *out, const vv_field *field, const vv_measure_options *options, int64_t step,
                          vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    *out = (vvi_object){.field = field,
                        .samples = field,
                        .component = options->component,
                        .step = step,
                        .scale = info->value_scale,
                        .offset = info->value_offset,
                        .lo = -INFINITY,
                        .hi = INFINITY,
                        .job = job};
    if (options->component < 0 || options->component >= info->components)
        return vv_fail(VV_E_ARGUMENT, "channel %d does not exist; the field has %d, counted from 0", options->component,
                       info->components);
    for (int a = 0; a < 3; a++)
        out->n[a] = (info->grid.dims[a] - 1) / step + 1;
    out->words = (size_t)(out->n[0] + 63) / 64 + 1;
    out->kernels = vvi_march_kernels_for(vvi_job_cpu(job));
    out->shaped = options->region != NULL;
    vv_status st = choose(out, field, options);
    if (st == VV_OK && out->shaped)
        st = vvi_region_samples_init(&out->shape, &info->grid, options->region);
    if (st == VV_OK)
        find_thresholds(out, vv_field_get_info(out->samples));
    return st;
}

bool vvi_object_is_band(const vvi_object *object)
{
    return !object->label && !object->mask && !object->section && object->value_lo > -INFINITY &&
           object->value_hi < INFINITY;
}

vv_measure_method vvi_object_method(vv_object_kind object, vv_measure_method method)
{
    if (method != VV_MEASURE_AUTO)
        return method;
    return object == VV_OBJECT_RANGE ? VV_MEASURE_CUBES : VV_MEASURE_COUNT;
}

vvi_object vvi_object_upper(const vvi_object *band, bool above)
{
    vvi_object o = *band;
    const bool turned = o.scale < 0; /* larger values are stored as smaller numbers */
    if (above && turned)
        o.hi = nextafter(o.lo, -INFINITY);
    else if (above)
        o.lo = nextafter(o.hi, INFINITY);
    *(turned ? &o.lo : &o.hi) = turned ? -INFINITY : INFINITY;
    o.value_lo = above ? o.value_hi : o.value_lo;
    o.value_hi = INFINITY;
    find_thresholds(&o, vv_field_get_info(o.samples));
    return o;
}

void vvi_object_close(vvi_object *object)
{
    vvi_free(object->section);
    object->section = NULL;
}

/* Bits ------------------------------------------------------------------------------------------------------------ */

static void fast_row(uint64_t *bits, const vvi_object *o, const void *row)
{
    const uint16_t words = (uint16_t)(o->words - 1);
    vvi_march_span span = {0, words};
    memset(bits, 0, o->words * sizeof *bits);
    o->kernels->classify[o->type](bits, row, o->n[0], o->least, &span);
    if (o->below_all || span.begin >= span.end)
        return;
    const size_t bytes = o->type == VVI_MARCH_U8 ? 1 : o->type == VVI_MARCH_F32 ? 4 : 2;
    for (int64_t first = span.begin; first < span.end; first += PART) {
        uint64_t above[PART];
        const int64_t rest = o->n[0] - 64 * first, n = rest < 64 * PART ? rest : 64 * PART;
        vvi_march_span part = {0, (uint16_t)((n + 63) / 64)};
        o->kernels->classify[o->type](above, (const char *)row + (size_t)first * 64 * bytes, n, o->above, &part);
        for (int64_t w = part.begin; w < part.end; w++)
            bits[first + w] &= ~above[w];
    }
}

static void slow_row(uint64_t *bits, const vvi_object *o, const char *row, int64_t stride, vv_type type)
{
    memset(bits, 0, o->words * sizeof *bits);
    for (int64_t i = 0; i < o->n[0]; i++) {
        const char *at = row + i * stride;
        double v;
        vvi_samples_to_f64(&v, at, type, 1);
        const bool in = o->mask ? v != 0 && v == v : o->label ? has_label(o, at, type) : inside(o, v);
        bits[i >> 6] |= (uint64_t)in << (i & 63);
    }
}

vv_status vvi_object_brick(vv_brick *out, const vvi_object *o, int64_t k, int64_t n)
{
    const vv_box all = vv_field_box(o->samples);
    const vv_box box = {{0, 0, k * o->step}, {all.n[0], all.n[1], (n - 1) * o->step + 1}};
    const vv_status st = vv_field_brick(out, o->samples, &box, o->job);
    if (st != VV_OK)
        return st;
    out->data = (const char *)out->data + (size_t)o->component * vv_type_bytes(out->type);
    for (int a = 0; a < 3; a++)
        out->stride[a] *= o->step;
    return VV_OK;
}

vv_status vvi_object_slice(uint64_t *bits, const vvi_object *o, int64_t k)
{
    const size_t row_bytes = o->words * sizeof *bits;
    if (o->section) {
        memcpy(bits, o->section + (size_t)k * (size_t)o->n[1] * o->words, (size_t)o->n[1] * row_bytes);
        return VV_OK;
    }
    vv_brick brick;
    const vv_status st = vvi_object_brick(&brick, o, k, 1);
    if (st != VV_OK)
        return st;
    for (int64_t j = 0; j < o->n[1]; j++, bits += o->words) {
        const char *row = (const char *)brick.data + j * brick.stride[1];
        if (!o->any)
            memset(bits, 0, row_bytes);
        else if (o->type != VVI_MARCH_TYPES && brick.stride[0] == (int64_t)vv_type_bytes(brick.type))
            fast_row(bits, o, row);
        else
            slow_row(bits, o, row, brick.stride[0], brick.type);
        if (o->shaped)
            vvi_region_samples_keep_row(bits, o->words, &o->shape, j, k);
    }
    vv_brick_release(&brick);
    return VV_OK;
}

double vvi_object_depth(const vvi_object *o, const vv_brick *brick, int64_t i, int64_t j, int64_t k)
{
    const char *at = (const char *)brick->data + i * brick->stride[0] + j * brick->stride[1] + k * brick->stride[2];
    double v;
    if (o->label)
        return has_label(o, at, brick->type) ? 0.5 : -0.5;
    vvi_samples_to_f64(&v, at, brick->type, 1);
    if (o->mask)
        return v != 0 && v == v ? 0.5 : -0.5;
    v = v * o->scale + o->offset;
    const double from = v - o->value_lo, to = o->value_hi - v;
    return o->value_lo == -INFINITY ? to : o->value_hi == INFINITY ? from : from < to ? from : to;
}
