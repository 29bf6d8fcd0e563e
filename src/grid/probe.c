/* Single places of a field. */
#include "grid/probe.h"

#include "grid/field.h"
#include "grid/label_id.h"

#include <math.h>
#include <string.h>

vv_status vvi_probe_open(vvi_probe *out, const vv_field *field, int component, bool nearest, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    const vv_box box = vv_field_box(field);
    *out = (vvi_probe){
        .component = component, .scale = info->value_scale, .offset = info->value_offset, .nearest = nearest};
    out->label = NAN;
    for (int a = 0; a < 3; a++)
        out->dims[a] = info->grid.dims[a];
    return vv_field_brick(&out->brick, field, &box, job);
}

void vvi_probe_close(vvi_probe *probe)
{
    vv_brick_release(&probe->brick);
}

static double value_at(const vvi_probe *p, const int64_t at[3], int axis)
{
    const char *data = p->brick.data;
    double stored;
    (void)axis;
    data += at[0] * p->brick.stride[0] + at[1] * p->brick.stride[1] + at[2] * p->brick.stride[2] +
            (int64_t)vv_type_bytes(p->brick.type) * p->component;
    vvi_samples_to_f64(&stored, data, p->brick.type, 1);
    const double value = stored * p->scale + p->offset;
    return isnan(p->label) ? value : value == p->label;
}

static double difference_at(const vvi_probe *p, const int64_t at[3], int axis)
{
    int64_t lo[3] = {at[0], at[1], at[2]}, hi[3] = {at[0], at[1], at[2]};
    lo[axis] -= lo[axis] > 0;
    hi[axis] += hi[axis] < p->dims[axis] - 1;
    const int64_t width = hi[axis] - lo[axis];
    return width ? (value_at(p, hi, 0) - value_at(p, lo, 0)) / (double)width : 0;
}

static int64_t clamped(double x, int64_t hi)
{
    return x > 0 ? (x < (double)hi ? (int64_t)x : hi) : 0;
}

/* The samples around a place, and their weights. */
typedef struct corners {
    int64_t at[8][3];
    double weight[8];
} corners;

static void find_corners(corners *out, const vvi_probe *p, const double x[3])
{
    int64_t first[3];
    double f[3];
    for (int a = 0; a < 3; a++) {
        const double inside = fmin(fmax(x[a], 0), (double)(p->dims[a] - 1));
        first[a] = p->nearest ? clamped(floor(x[a] + 0.5), p->dims[a] - 1)
                              : clamped(inside, p->dims[a] > 1 ? p->dims[a] - 2 : 0);
        f[a] = p->nearest ? 0 : inside - (double)first[a];
    }
    for (int corner = 0; corner < 8; corner++) {
        out->weight[corner] = 1;
        for (int a = 0; a < 3; a++) {
            out->weight[corner] *= corner >> a & 1 ? f[a] : 1 - f[a];
            out->at[corner][a] = first[a] + (corner >> a & 1);
        }
    }
}

static double interpolate(const vvi_probe *p, const double x[3], double (*fn)(const vvi_probe *, const int64_t *, int),
                          int axis)
{
    corners c;
    find_corners(&c, p, x);
    int nearest = 0;
    for (int corner = 1; corner < 8; corner++)
        nearest = c.weight[corner] > c.weight[nearest] ? corner : nearest;
    const double v = fn(p, c.at[nearest], axis), base = isfinite(v) ? v : 0;
    double sum = base;
    for (int corner = 0; corner < 8; corner++) /* differences: between equal samples the value is exactly theirs */
        if (c.weight[corner] != 0)
            sum += c.weight[corner] * (fn(p, c.at[corner], axis) - base);
    return sum;
}

/* Of labels with as much weight the smaller one. */
static double winning_label(const vvi_probe *p, const double x[3])
{
    corners c;
    double best = NAN, most = 0;
    find_corners(&c, p, x);
    for (int i = 0; i < 8; i++) {
        const double label = c.weight[i] != 0 ? value_at(p, c.at[i], 0) : NAN;
        double weight = 0;
        for (int j = 0; j < 8; j++)
            weight += c.weight[j] != 0 && value_at(p, c.at[j], 0) == label ? c.weight[j] : 0;
        if (weight > most || (weight == most && label < best)) {
            most = weight;
            best = label;
        }
    }
    return best;
}

/* The same numbers as interpolate() of value_at(), without its detours: pictures of slices ask for millions. */
static inline double load(const char *at, vv_type type)
{
#define LOAD(ctype)                                                                                                    \
    do {                                                                                                               \
        ctype v;                                                                                                       \
        memcpy(&v, at, sizeof v); /* mapped data has any alignment */                                                  \
        return (double)v;                                                                                              \
    } while (0)
    switch (type) {
    case VV_TYPE_U8:
        LOAD(uint8_t);
    case VV_TYPE_I8:
        LOAD(int8_t);
    case VV_TYPE_U16:
        LOAD(uint16_t);
    case VV_TYPE_I16:
        LOAD(int16_t);
    case VV_TYPE_U32:
        LOAD(uint32_t);
    case VV_TYPE_I32:
        LOAD(int32_t);
    case VV_TYPE_U64:
        LOAD(uint64_t);
    case VV_TYPE_I64:
        LOAD(int64_t);
    case VV_TYPE_F32:
        LOAD(float);
    default:
        LOAD(double);
    }
#undef LOAD
}

/* Axes along which a place lies on a sample have no second corner. */
static double value_of(const vvi_probe *p, const double x[3])
{
    const vv_brick *b = &p->brick;
    const char *first_sample = (const char *)b->data + (int64_t)vv_type_bytes(b->type) * p->component;
    const char *at[8] = {first_sample, first_sample, first_sample, first_sample,
                         first_sample, first_sample, first_sample, first_sample};
    double weight[8] = {1}, v[8] = {0};
    int n = 1, nearest = 0;
    for (int a = 0; a < 3; a++) {
        const int64_t last = p->dims[a] - 1;
        const double inside = x[a] > 0 ? (x[a] < (double)last ? x[a] : (double)last) : 0;
        const int64_t first = p->nearest ? clamped(x[a] + 0.5, last) : (int64_t)inside;
        const double f = p->nearest ? 0 : inside - (double)first;
        at[0] += first * b->stride[a];
        for (int c = 1; c < n; c++)
            at[c] += first * b->stride[a];
        for (int c = 0; f > 0 && c < n; c++) {
            at[n + c] = at[c] + b->stride[a];
            weight[n + c] = weight[c] * f;
            weight[c] *= 1 - f;
        }
        n <<= f > 0;
    }
    for (int c = 0; c < n; c++) {
        v[c] = load(at[c], b->type) * p->scale + p->offset;
        nearest = weight[c] > weight[nearest] ? c : nearest;
    }
    if (n == 1)
        return v[0];
    const double base = isfinite(v[nearest]) ? v[nearest] : 0;
    double sum = base;
    for (int c = 0; c < n; c++)
        sum += weight[c] * (v[c] - base);
    return sum;
}

double vvi_probe_value(const vvi_probe *probe, const double p[3])
{
    return probe->labels && !probe->nearest ? winning_label(probe, p) : value_of(probe, p);
}

static vv_label_id stored_label(const vvi_probe *p, const int64_t at[3])
{
    const vv_brick *b = &p->brick;
    return vvi_label_of((const char *)b->data + at[0] * b->stride[0] + at[1] * b->stride[1] + at[2] * b->stride[2] +
                            (int64_t)vv_type_bytes(b->type) * p->component,
                        b->type);
}

/* winning_label() of ids, which doubles may take for one another. */
static vv_label_id winning_id(const vvi_probe *p, const double x[3])
{
    corners c;
    vv_label_id best = 0, id[8] = {0};
    double most = 0;
    find_corners(&c, p, x);
    for (int i = 0; i < 8; i++)
        id[i] = c.weight[i] != 0 ? stored_label(p, c.at[i]) : 0;
    for (int i = 0; i < 8; i++) {
        double weight = 0;
        for (int j = 0; j < 8; j++)
            weight += c.weight[i] != 0 && id[j] == id[i] ? c.weight[j] : 0;
        if (weight > most || (weight == most && weight > 0 &&
                              vvi_label_compare(id[i], best, vvi_label_is_unsigned(p->brick.type)) < 0)) {
            most = weight;
            best = id[i];
        }
    }
    return best;
}

bool vvi_probe_label(vv_label_id *out, const vvi_probe *probe, const double p[3])
{
    const bool wide = probe->brick.type == VV_TYPE_I64 || probe->brick.type == VV_TYPE_U64;
    if (wide && probe->scale == 1 && probe->offset == 0) {
        *out = winning_id(probe, p);
        return true;
    }
    const double value = vvi_probe_value(probe, p);
    if (!(fabs(value) < 0x1p62))
        return false;
    *out = (vv_label_id)floor(value + 0.5);
    return true;
}

vv_vec3 vvi_probe_gradient(const vvi_probe *probe, const double p[3])
{
    vvi_probe of = *probe;
    if (of.labels && !of.nearest)
        of.label = winning_label(probe, p);
    return (vv_vec3){interpolate(&of, p, difference_at, 0), interpolate(&of, p, difference_at, 1),
                     interpolate(&of, p, difference_at, 2)};
}

/* Error ----------------------------------------------------------------------------------------------------------- */

#define SHORT_WAVES 1.25 /* (x / sin x)^2 is 1.234 for waves of 4 voxels, x = pi / 4 */

static double second_difference_at(const vvi_probe *p, const int64_t at[3], int axis)
{
    int64_t lo[3] = {at[0], at[1], at[2]}, mid[3] = {at[0], at[1], at[2]}, hi[3] = {at[0], at[1], at[2]};
    mid[axis] += (at[axis] == 0) - (at[axis] == p->dims[axis] - 1);
    lo[axis] = mid[axis] - 1;
    hi[axis] = mid[axis] + 1;
    return value_at(p, lo, 0) - 2 * value_at(p, mid, 0) + value_at(p, hi, 0);
}

/* The largest at the samples that a value is made of; NaN where one of them is. */
static double largest_around(const vvi_probe *p, const corners *c,
                             double (*fn)(const vvi_probe *, const int64_t *, int), int axis)
{
    double largest = 0;
    for (int corner = 0; corner < 8; corner++) {
        const double size = c->weight[corner] != 0 ? fabs(fn(p, c->at[corner], axis)) : 0;
        largest = size > largest || isnan(size) ? size : largest; /* nothing is above NaN */
    }
    return largest;
}

static double error_along(const vvi_probe *p, const corners *c, double x, int axis)
{
    const double inside = fmin(fmax(x, 0), (double)(p->dims[axis] - 1));
    const double out = fabs(x - inside), f = inside - floor(inside);
    if (out == 0 && f == 0)
        return 0;
    if (p->dims[axis] < 3)
        return NAN;
    const double bend = SHORT_WAVES * largest_around(p, c, second_difference_at, axis);
    return out > 0 ? out * largest_around(p, c, difference_at, axis) + out * (1 + out) / 2 * bend
                   : f * (1 - f) / 2 * bend;
}

double vvi_probe_error(const vvi_probe *probe, const double p[3])
{
    corners c;
    double sum = 0;
    if (probe->nearest || probe->labels)
        return NAN;
    find_corners(&c, probe, p);
    for (int a = 0; a < 3; a++)
        sum += error_along(probe, &c, p[a], a);
    return sum;
}
