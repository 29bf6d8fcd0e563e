/* Single places of a field. */
#include "grid/probe.h"

#include "grid/field.h"

#include <math.h>

vv_status vvi_probe_open(vvi_probe *out, const vv_field *field, int component, bool nearest, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    const vv_box box = vv_field_box(field);
    *out = (vvi_probe){
        .component = component, .scale = info->value_scale, .offset = info->value_offset, .nearest = nearest};
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
    return stored * p->scale + p->offset;
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

static double interpolate(const vvi_probe *p, const double x[3], double (*fn)(const vvi_probe *, const int64_t *, int),
                          int axis)
{
    int64_t first[3];
    double f[3], sum = 0;
    for (int a = 0; a < 3; a++) {
        const double inside = fmin(fmax(x[a], 0), (double)(p->dims[a] - 1));
        first[a] = p->nearest ? clamped(floor(x[a] + 0.5), p->dims[a] - 1)
                              : clamped(inside, p->dims[a] > 1 ? p->dims[a] - 2 : 0);
        f[a] = p->nearest ? 0 : inside - (double)first[a];
    }
    for (int corner = 0; corner < 8; corner++) {
        double weight = 1;
        for (int a = 0; a < 3; a++)
            weight *= corner >> a & 1 ? f[a] : 1 - f[a];
        const int64_t at[3] = {first[0] + (corner & 1), first[1] + (corner >> 1 & 1), first[2] + (corner >> 2)};
        if (weight != 0)
            sum += weight * fn(p, at, axis);
    }
    return sum;
}

double vvi_probe_value(const vvi_probe *probe, const double p[3])
{
    return interpolate(probe, p, value_at, 0);
}

vv_vec3 vvi_probe_gradient(const vvi_probe *probe, const double p[3])
{
    return (vv_vec3){interpolate(probe, p, difference_at, 0), interpolate(probe, p, difference_at, 1),
                     interpolate(probe, p, difference_at, 2)};
}
